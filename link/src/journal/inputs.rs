//! Inputs: what came to a run from outside since a checkpoint, and where in the run. With it a run whose host or
//! modules are in other processes can be repeated up to where it died.
//!
//! One file stands between every two checkpoints, and has the number of the later one. It is [`frames`]: a turn
//! of a line as a recording has it, the mark of an instant that the run has gone on to, and the mark of a
//! resumption. What stands behind the last mark belongs to an instant that was never reached: nothing followed
//! from it.

use super::frames;
use super::ledger::{Ledger, LedgerFault, LedgerMark};
use super::own_file;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

const PREFIX: &str = "inputs-";

/// The most old bytes, needed by no checkpoint any more, that are kept so that a run can be repeated from its start:
/// about an hour of a robot with sonars.
const MOST_OLD_BYTES: u64 = 32 << 20;

/// The first byte of a frame says what it is.
const TURN: u8 = b't';
const INSTANT: u8 = b'i';
const RESUMPTION: u8 = b'r';

/// The inputs that are being written.
#[derive(Debug)]
pub struct Inputs {
    folder: PathBuf,
    number: u64,
    ledger: Ledger,
    /// The run was told to stop, or has come to its end: what comes now is not to be heard again.
    is_closed: bool,
}

/// What came to a run behind a checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PastInputs {
    /// Turns, each as a line of a recording.
    pub turns: Vec<String>,
    /// How often the run was gone on with at the checkpoint, and after each instant behind it.
    pub resumptions: Vec<u32>,
    /// The instants, by their numbers, at which the run was gone on with.
    pub resumed_at: Vec<u32>,
    /// The time of the last mark, if there is one.
    pub reached_us: Option<u64>,
    /// The number of the last file, and how much of it is whole.
    last: Option<(u64, LedgerMark)>,
}

/// Why inputs cannot be gone on with.
#[derive(Debug, thiserror::Error)]
pub enum InputsFault {
    /// A file is missing, or is not whole although others follow it.
    #[error("what came from outside is not all there: the file `{0}` is missing, was changed or cut off")]
    Gap(String),
    /// A file has what no run has written.
    #[error("the file `{0}` is damaged")]
    Damaged(String),
    /// It cannot be read or written.
    #[error(transparent)]
    Disk(#[from] io::Error),
}

/// The name of the file before a checkpoint.
fn name(number: u64) -> String {
    format!("{PREFIX}{number:06}")
}

/// The numbers of the files in a folder, in order.
fn numbers(folder: &Path) -> io::Result<Vec<u64>> {
    let mut numbers = Vec::new();
    for entry in fs::read_dir(folder)? {
        let file = entry?.file_name();
        let number = file.to_str().and_then(|file| file.strip_prefix(PREFIX)?.parse().ok());
        numbers.extend(number.filter(|&number| file == *name(number)));
    }
    numbers.sort_unstable();
    Ok(numbers)
}

fn opened(folder: &Path, number: u64) -> io::Result<Ledger> {
    let path = folder.join(name(number));
    let file = own_file::open(&path, File::options().read(true).write(true).create(true).truncate(true))?;
    Ledger::begin(file).map_err(of_disk)
}

/// A fault of a file that has nothing to be compared with.
fn of_disk(fault: LedgerFault) -> io::Error {
    match fault {
        LedgerFault::Disk(error) => error,
        LedgerFault::Taken | LedgerFault::Changed(_) => io::Error::other(fault),
    }
}

impl Inputs {
    /// The inputs of a run at its start, before its first checkpoint.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn begin(folder: &Path) -> io::Result<Self> {
        Ok(Self { folder: folder.to_path_buf(), number: 0, ledger: opened(folder, 0)?, is_closed: false })
    }

    /// The inputs of a run that goes on behind others. What was written of an instant that was never reached is
    /// cut off.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn go_on(folder: &Path, past: &PastInputs, checkpoint: Option<u64>) -> Result<Self, InputsFault> {
        let (number, mark) = past.last.unwrap_or((checkpoint.map_or(0, |number| number + 1), LedgerMark::default()));
        let path = folder.join(name(number));
        let file =
            own_file::open(&path, File::options().read(true).write(true).create(mark.length == 0).truncate(false))?;
        let mut ledger = Ledger::go_on(file, mark).map_err(|fault| match fault {
            LedgerFault::Changed(_) => InputsFault::Damaged(name(number)),
            LedgerFault::Disk(_) | LedgerFault::Taken => InputsFault::Disk(of_disk(fault)),
        })?;
        ledger.finish()?;
        Ok(Self { folder: folder.to_path_buf(), number, ledger, is_closed: false })
    }

    /// The number of the checkpoint that comes next.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// A turn of a line is over; it counts when the instant does.
    pub fn turn(&mut self, line: &[u8]) {
        self.push(TURN, line);
    }

    /// The run has gone on to its next instant, at this time: all that came with it is written.
    ///
    /// # Errors
    /// It cannot be written now, and is tried again.
    pub fn instant(&mut self, time_us: u64) -> io::Result<()> {
        self.push(INSTANT, &time_us.to_le_bytes());
        self.ledger.flush()
    }

    /// The run was gone on with at the end of the instant of a number, after its process had died.
    ///
    /// # Errors
    /// It cannot be written now, and is tried again.
    pub fn resumption(&mut self, number: u32) -> io::Result<()> {
        self.push(RESUMPTION, &number.to_le_bytes());
        self.ledger.flush()
    }

    /// Nothing that comes from now on is written.
    pub fn close(&mut self) {
        self.is_closed = true;
    }

    fn push(&mut self, what: u8, content: &[u8]) {
        if self.is_closed {
            return;
        }
        let mut bytes = Vec::new();
        frames::push(&mut bytes, &[&[what], content].concat());
        self.ledger.push(&bytes);
    }

    /// A checkpoint of this number is made here: what comes now stands in the next file.
    ///
    /// # Errors
    /// It cannot be written; then nothing has changed.
    pub fn next_file(&mut self, checkpoint: u64) -> io::Result<()> {
        self.ledger.flush()?;
        let ledger = opened(&self.folder, checkpoint + 1)?;
        (self.ledger, self.number) = (ledger, checkpoint + 1);
        Ok(())
    }

    /// The file, to bring it to the disk.
    ///
    /// # Errors
    /// There is no further handle.
    pub fn handle(&self) -> io::Result<File> {
        self.ledger.handle()
    }
}

/// Drops files that no checkpoint needs any more, the oldest of which has this number, if they are long.
///
/// # Errors
/// The folder cannot be written.
pub fn drop_before(folder: &Path, oldest_checkpoint: u64) -> io::Result<()> {
    let old = numbers(folder)?.into_iter().filter(|&number| number <= oldest_checkpoint);
    let old: Vec<PathBuf> = old.map(|number| folder.join(name(number))).collect();
    let bytes: u64 = old.iter().map(|path| Ok(path.metadata()?.len())).sum::<io::Result<u64>>()?;
    // A start without what follows is of no use: all of them go.
    if bytes > MOST_OLD_BYTES { old.iter().try_for_each(fs::remove_file) } else { Ok(()) }
}

impl PastInputs {
    /// What came behind a checkpoint, or from the start on.
    ///
    /// # Errors
    /// Something between is missing or damaged, or cannot be read.
    pub fn read(folder: &Path, checkpoint: Option<u64>) -> Result<Self, InputsFault> {
        let first = checkpoint.map_or(0, |checkpoint| checkpoint + 1);
        let numbers: Vec<u64> = numbers(folder)?.into_iter().filter(|&number| number >= first).collect();
        // A checkpoint that has no file behind it was written by a process that died before it had one.
        if checkpoint.is_none() && numbers.first() != Some(&0) {
            return Err(InputsFault::Gap(name(0)));
        }
        let mut past = Self { resumptions: vec![0], ..Self::default() };
        for (at, &number) in numbers.iter().enumerate() {
            let bytes = own_file::read(&folder.join(name(number)))?;
            let found = frames::read(&bytes);
            let is_last = at + 1 == numbers.len();
            if number != first + at as u64 || (!is_last && found.torn(&bytes) > 0) {
                return Err(InputsFault::Gap(name(if is_last { first + at as u64 } else { number })));
            }
            let length = past.take(&found.whole).ok_or_else(|| InputsFault::Damaged(name(number)))?;
            let checksum = crc32fast::hash(&bytes[..length]);
            past.last = Some((number, LedgerMark { length: length as u64, checksum }));
        }
        Ok(past)
    }

    /// Takes in the frames of a file up to its last mark, and tells how many bytes they are.
    fn take(&mut self, frames: &[&[u8]]) -> Option<usize> {
        let is_mark = |frame: &&[u8]| frame.first().is_some_and(|&what| what != TURN);
        let count = frames.iter().rposition(is_mark).map_or(0, |last| last + 1);
        let mut length = 0;
        for frame in &frames[..count] {
            length += frames::HEAD + frame.len();
            match frame.split_first()? {
                (&TURN, line) => self.turns.push(String::from_utf8(line.to_vec()).ok()?),
                (&INSTANT, time_us) => {
                    self.resumptions.push(0);
                    self.reached_us = Some(u64::from_le_bytes(time_us.try_into().ok()?));
                }
                (&RESUMPTION, number) => {
                    *self.resumptions.last_mut()? += 1;
                    self.resumed_at.push(u32::from_le_bytes(number.try_into().ok()?));
                }
                _ => return None,
            }
        }
        Some(length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of the test's own, by a name that no other test has.
    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("rpl-inputs-{}-{name}", std::process::id()));
        fs::remove_dir_all(&folder).ok();
        fs::create_dir_all(&folder).expect("it can be made");
        folder
    }

    /// Two instants, a checkpoint, an instant, and a turn of one that was never reached.
    fn written(folder: &Path) {
        let mut inputs = Inputs::begin(folder).expect("it can be made");
        for (turn, instant) in [(&b"zero"[..], 0), (b"one", 1)] {
            inputs.turn(turn);
            inputs.instant(instant).expect("it is written");
        }
        inputs.next_file(0).expect("it can be made");
        inputs.turn(b"two");
        inputs.instant(2).expect("it is written");
        inputs.turn(b"three");
        inputs.ledger.flush().expect("it is written");
    }

    fn turns(folder: &Path, checkpoint: Option<u64>) -> Vec<String> {
        PastInputs::read(folder, checkpoint).expect("it is whole").turns
    }

    #[test]
    fn what_led_to_an_instant_is_heard_again_and_what_did_not_is_cut_off() {
        let folder = folder("cut");
        written(&folder);
        assert_eq!(turns(&folder, None), ["zero", "one", "two"]);
        let past = PastInputs::read(&folder, Some(0)).expect("it is whole");
        assert_eq!(
            (&past.turns[..], &past.resumptions[..], past.reached_us),
            (&["two".to_string()][..], &[0, 0][..], Some(2))
        );
        let mut inputs = Inputs::go_on(&folder, &past, Some(0)).expect("it can be gone on with");
        assert_eq!(inputs.number(), 1);
        inputs.resumption(2).expect("it is written");
        inputs.turn(b"other");
        inputs.instant(3).expect("it is written");
        inputs.close();
        inputs.turn(b"of a clean-up");
        inputs.instant(4).expect("nothing is written");
        let past = PastInputs::read(&folder, None).expect("it is whole");
        assert_eq!(past.turns, ["zero", "one", "two", "other"]);
        assert_eq!((past.resumptions, past.resumed_at), (vec![0, 0, 0, 1, 0], vec![2]));
        fs::remove_dir_all(folder).ok();
    }

    #[test]
    fn cut_at_any_byte_it_is_whole_up_to_an_instant_or_refused() {
        let folder = folder("torn");
        written(&folder);
        let whole = fs::read(folder.join(name(1))).expect("it is there");
        for cut in 0..=whole.len() {
            fs::write(folder.join(name(1)), &whole[..cut]).expect("it can be written");
            let past = PastInputs::read(&folder, Some(0)).expect("only the end is missing");
            assert_eq!(past.turns.len(), past.resumptions.len() - 1, "cut at {cut}");
        }
        let first = fs::read(folder.join(name(0))).expect("it is there");
        fs::write(folder.join(name(0)), &first[..first.len() - 1]).expect("it can be written");
        assert!(matches!(PastInputs::read(&folder, None), Err(InputsFault::Gap(file)) if file == name(0)));
        fs::remove_file(folder.join(name(0))).expect("it is there");
        assert!(matches!(PastInputs::read(&folder, None), Err(InputsFault::Gap(file)) if file == name(0)));
        fs::remove_dir_all(folder).ok();
    }

    #[test]
    fn what_no_checkpoint_needs_is_dropped_when_it_is_long() {
        let folder = folder("old");
        written(&folder);
        drop_before(&folder, 0).expect("it can be written");
        assert_eq!(numbers(&folder).expect("it can be read"), [0, 1]);
        File::create(folder.join(name(0))).and_then(|file| file.set_len(MOST_OLD_BYTES + 1)).expect("it can be made");
        drop_before(&folder, 0).expect("it can be written");
        assert_eq!(numbers(&folder).expect("it can be read"), [1]);
        fs::remove_dir_all(folder).ok();
    }
}
