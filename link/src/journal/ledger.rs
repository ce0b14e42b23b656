//! Ledgers: files that a run writes on and on, and that hold every byte once however often the run died.
//!
//! A run that is gone on with from an earlier state writes again what it wrote after that state. A ledger
//! compares that with what it has, and says so; only what is new is added. Where the two differ – the disk
//! lost the end, or what followed came of something that is not repeated – the old end is cut off.

use serde::{Deserialize, Serialize};
use std::fs::{File, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};

/// Bytes that are kept in memory before they are written, unless somebody wants them written.
const BUFFER_BYTES: usize = 64 << 10;

/// The most bytes kept in memory while the disk does not take them; then the ledger gives up.
const MOST_UNWRITTEN: usize = 32 << 20;

/// A place in a ledger, and what stands before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LedgerMark {
    /// Bytes.
    pub length: u64,
    /// Their CRC-32.
    pub checksum: u32,
}

/// Whether something that is written had been written by an earlier life of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written {
    /// All of it.
    Before,
    /// Not all of it.
    Now,
}

/// A file that holds every byte once.
#[derive(Debug)]
pub struct Ledger {
    file: File,
    /// Bytes that the file has of this life and those before, without what is unwritten.
    length: u64,
    hasher: crc32fast::Hasher,
    unwritten: Vec<u8>,
    /// What an earlier life wrote behind the place where this one began, and how much of it has come again.
    earlier: (Vec<u8>, usize),
    /// Whether the file may have bytes behind `length` that are nobody's.
    has_old_end: bool,
    /// It has lost bytes, and takes no more.
    is_given_up: bool,
}

/// Why a ledger cannot be gone on with from a place.
#[derive(Debug, thiserror::Error)]
pub enum LedgerFault {
    /// Another process writes it.
    #[error("another process writes it, and only one can")]
    Taken,
    /// It has not what it had.
    #[error("its first {0} bytes are not those that were written")]
    Changed(u64),
    /// It cannot be read or written.
    #[error(transparent)]
    Disk(#[from] io::Error),
}

impl Ledger {
    /// A ledger in a file that is emptied. Pipes and devices cannot be gone on with, and are refused.
    ///
    /// # Errors
    /// Another process writes it, or it cannot be emptied.
    pub fn begin(file: File) -> Result<Self, LedgerFault> {
        take(&file)?;
        file.set_len(0)?;
        Ok(Self::behind(file, LedgerMark::default(), Vec::new()))
    }

    /// The ledger of a file that was opened to be read and written, from a place in it on.
    ///
    /// # Errors
    /// Another process writes it, or it is not what it was up to there.
    pub fn go_on(mut file: File, mark: LedgerMark) -> Result<Self, LedgerFault> {
        take(&file)?;
        let mut hasher = crc32fast::Hasher::new();
        let (mut left, mut stretch) = (mark.length, vec![0; BUFFER_BYTES]);
        while left > 0 {
            let wanted = usize::try_from(left).unwrap_or(usize::MAX).min(BUFFER_BYTES);
            let read = file.read(&mut stretch[..wanted])?;
            if read == 0 {
                return Err(LedgerFault::Changed(mark.length));
            }
            hasher.update(&stretch[..read]);
            left -= read as u64;
        }
        if hasher.finalize() != mark.checksum {
            return Err(LedgerFault::Changed(mark.length));
        }
        let mut earlier = Vec::new();
        file.read_to_end(&mut earlier)?;
        file.seek(SeekFrom::Start(mark.length))?;
        Ok(Self::behind(file, mark, earlier))
    }

    fn behind(file: File, mark: LedgerMark, earlier: Vec<u8>) -> Self {
        let hasher = crc32fast::Hasher::new_with_initial_len(mark.checksum, mark.length);
        Self {
            file,
            length: mark.length,
            hasher,
            unwritten: Vec::new(),
            earlier: (earlier, 0),
            has_old_end: false,
            is_given_up: false,
        }
    }

    /// Adds bytes. They are in the file after a [`Ledger::flush`] at the latest.
    pub fn push(&mut self, bytes: &[u8]) -> Written {
        if self.is_given_up {
            return Written::Now;
        }
        self.hasher.update(bytes);
        let (earlier, at) = &mut self.earlier;
        let rest = &earlier[*at..];
        let same = rest.iter().zip(bytes).take_while(|(then, now)| then == now).count();
        if same == bytes.len() {
            *at += same;
            self.length += same as u64;
            return Written::Before;
        }
        // What follows is new, or not what followed then.
        self.has_old_end |= same < rest.len();
        self.length += same as u64;
        self.earlier = (Vec::new(), 0);
        self.unwritten.extend_from_slice(&bytes[same..]);
        if self.unwritten.len() > MOST_UNWRITTEN {
            self.is_given_up = true;
            self.unwritten = Vec::new();
        }
        Written::Now
    }

    /// Whether all that an earlier life has written has come again.
    pub fn is_level(&self) -> bool {
        self.earlier.1 == self.earlier.0.len()
    }

    /// Whether there is so much to write that it should be.
    pub fn is_full(&self) -> bool {
        self.unwritten.len() >= BUFFER_BYTES
    }

    /// Writes what is unwritten. What cannot be written stays, and is tried again with the next call.
    ///
    /// # Errors
    /// The disk is full or gone; or was, for so long that bytes were lost.
    pub fn flush(&mut self) -> io::Result<()> {
        if self.is_given_up {
            return Err(io::Error::other("the disk took nothing for so long that it was given up"));
        }
        if self.unwritten.is_empty() {
            return Ok(());
        }
        // What failed may have written a part.
        self.file.seek(SeekFrom::Start(self.length))?;
        if std::mem::replace(&mut self.has_old_end, true) {
            self.file.set_len(self.length)?;
        }
        self.file.write_all(&self.unwritten)?;
        self.has_old_end = false;
        self.length += self.unwritten.len() as u64;
        self.unwritten.clear();
        Ok(())
    }

    /// The place behind all that is written.
    ///
    /// # Errors
    /// As for [`Ledger::flush`].
    pub fn mark(&mut self) -> io::Result<LedgerMark> {
        self.flush()?;
        Ok(LedgerMark { length: self.length, checksum: self.hasher.clone().finalize() })
    }

    /// The run has ended here: what an earlier life wrote behind it is cut off.
    ///
    /// # Errors
    /// As for [`Ledger::flush`].
    pub fn finish(&mut self) -> io::Result<()> {
        self.flush()?;
        let (earlier, at) = std::mem::take(&mut self.earlier);
        if at < earlier.len() || self.has_old_end {
            self.file.set_len(self.length)?;
        }
        Ok(())
    }

    /// Brings what is written to the disk.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub fn sync(&self) -> io::Result<()> {
        self.file.sync_data()
    }

    /// The file, to bring it to the disk while the ledger is written on.
    ///
    /// # Errors
    /// There is no further handle.
    pub fn handle(&self) -> io::Result<File> {
        self.file.try_clone()
    }
}

/// A ledger outside of a journal's folder, such as a trace, has no other lock. The kernel releases it with the process.
fn take(file: &File) -> Result<(), LedgerFault> {
    file.try_lock().map_err(|fault| match fault {
        TryLockError::WouldBlock => LedgerFault::Taken,
        TryLockError::Error(error) => error.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::{Path, PathBuf};

    /// A file of the test's own, by a name that no other test has.
    fn path(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("rpl-ledger-{}-{name}", std::process::id()));
        fs::remove_file(&path).ok();
        path
    }

    fn begin(path: &Path) -> Ledger {
        let file = File::options().read(true).write(true).create(true).truncate(false).open(path);
        Ledger::begin(file.expect("it can be made")).expect("it can be emptied")
    }

    fn go_on(path: &Path, mark: LedgerMark) -> Result<Ledger, LedgerFault> {
        Ledger::go_on(File::options().read(true).write(true).open(path)?, mark)
    }

    const LINES: [&str; 5] = ["one\n", "two\n", "three\n", "four\n", "five\n"];

    #[test]
    fn a_ledger_that_was_cut_anywhere_holds_every_line_once_in_the_end() {
        let path = path("cut");
        let whole: String = LINES.concat();
        for lines in 0..=LINES.len() {
            let mut first = begin(&path);
            LINES[..lines].iter().for_each(|line| _ = first.push(line.as_bytes()));
            let mark = first.mark().expect("it is written");
            LINES[lines..].iter().for_each(|line| _ = first.push(line.as_bytes()));
            first.flush().expect("it is written");
            drop(first);
            let length = fs::metadata(&path).expect("it is there").len();
            assert_eq!(length, whole.len() as u64);
            for cut in mark.length..=length {
                fs::write(&path, &whole[..cut as usize]).expect("it can be written");
                let mut next = go_on(&path, mark).expect("it is what it was");
                let mut end = mark.length;
                for line in &LINES[lines..] {
                    end += line.len() as u64;
                    let expected = if end <= cut { Written::Before } else { Written::Now };
                    assert_eq!(next.push(line.as_bytes()), expected, "{line:?} of a file cut at {cut}");
                }
                let end = next.mark().expect("it is written");
                next.finish().expect("it is written");
                assert_eq!(fs::read_to_string(&path).expect("it is there"), whole);
                assert_eq!((end.length, end.checksum), (length, crc32fast::hash(whole.as_bytes())));
            }
        }
        fs::remove_file(&path).ok();
    }

    #[test]
    fn what_is_not_repeated_is_cut_off() {
        let path = path("other");
        fs::write(&path, "one\nleft by a clean-up that never was\n").expect("it can be written");
        let mut ledger = go_on(&path, LedgerMark::default()).expect("it is there");
        assert_eq!(ledger.push(b"one\n"), Written::Before);
        assert_eq!(ledger.push(b"less\n"), Written::Now);
        ledger.flush().expect("it is written");
        drop(ledger);
        assert_eq!(fs::read_to_string(&path).expect("it is there"), "one\nless\n");
        let mut shorter = go_on(&path, LedgerMark::default()).expect("it is there");
        assert_eq!(shorter.push(b"one\n"), Written::Before);
        shorter.finish().expect("it can be cut");
        assert_eq!(fs::read_to_string(&path).expect("it is there"), "one\n");
        fs::remove_file(&path).ok();
    }

    #[test]
    fn a_ledger_has_one_writer() {
        let path = path("taken");
        let first = begin(&path);
        let second = File::options().read(true).write(true).open(&path).expect("it is there");
        assert!(matches!(Ledger::begin(second), Err(LedgerFault::Taken)));
        assert!(matches!(go_on(&path, LedgerMark::default()), Err(LedgerFault::Taken)));
        drop(first);
        assert!(go_on(&path, LedgerMark::default()).is_ok());
        fs::remove_file(&path).ok();
    }

    #[test]
    fn a_changed_beginning_is_no_place_to_go_on_from() {
        let path = path("changed");
        let mut ledger = begin(&path);
        ledger.push(b"one\ntwo\n");
        let mark = ledger.mark().expect("it is written");
        drop(ledger);
        for changed in [&b"one\ntwp\n"[..], b"one\ntwo", b""] {
            fs::write(&path, changed).expect("it can be written");
            assert!(matches!(go_on(&path, mark), Err(LedgerFault::Changed(8))), "{changed:?}");
        }
        fs::remove_file(&path).ok();
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_tried_again_and_given_up_in_the_end() {
        let full = File::options().write(true).open("/dev/full").expect("Linux has it");
        let mut ledger = Ledger::behind(full, LedgerMark::default(), Vec::new());
        ledger.push(b"one\n");
        for _ in 0..2 {
            assert!(ledger.flush().is_err());
        }
        let path = path("full");
        ledger.file = File::create(&path).expect("it can be made");
        ledger.flush().expect("there is room now");
        assert_eq!(fs::read_to_string(&path).expect("it is there"), "one\n");
        ledger.push(&vec![b'x'; MOST_UNWRITTEN + 1]);
        assert!(ledger.flush().expect_err("bytes are lost").to_string().contains("given up"));
        fs::remove_file(&path).ok();
    }
}
