//! Runs with a journal that are killed at any moment, and journals that are damaged:
//! `cargo build --release -p rpl && cargo run --release -p rpl-tests --example kills -- --kills 1000 --seed 1`.
//!
//! An office hour is run once undisturbed and then with a journal, killed again and again, and gone on with. What it
//! printed, told and traced must be the same, byte for byte. `--damages 10000` flips bits and cuts ends off in the
//! journal of a short run: going on with it must give the same or be refused. The command is the one beside the
//! examples, or `--command PATH`.

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Output, Stdio};
use std::time::{Duration, Instant};

/// An hour of the office, without its seed.
const OFFICE: [&str; 7] =
    ["office.rpl", "--world", "dept-staffed", "--scenario", "experiments/office-day.rpl", "--until", "60min"];

/// A run whose journal is small enough to be damaged ten thousand times.
const SHORT: &str = "(defvar n 0)\n(while (< n 150) (setq n (+ n 1)) (print (list n (random 100))) (wait-time 0.05))\n";

/// How often a file that grows is looked at.
const LOOK: Duration = Duration::from_millis(2);

/// Bytes of the end of a file that are cut off one by one.
const END: usize = 4096;

fn option(name: &str) -> Option<String> {
    let arguments: Vec<String> = std::env::args().collect();
    let place = arguments.iter().position(|argument| argument == name)?;
    arguments.get(place + 1).cloned()
}

fn number(name: &str, default: u64) -> u64 {
    option(name).and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// `target/release/rpl` for `target/release/examples/kills`.
fn command() -> Option<PathBuf> {
    let beside = || std::env::current_exe().ok()?.parent()?.parent().map(|folder| folder.join("rpl"));
    option("--command").map(PathBuf::from).or_else(beside)?.canonicalize().ok()
}

/// Numbers that follow from the seed (splitmix64).
struct Chance(u64);

impl Chance {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) % end.max(1)
    }
}

fn main() -> ExitCode {
    let Some(command) = command() else {
        eprintln!(
            "there is no `rpl` to run; build it with `cargo build --release -p rpl`, or name it with `--command`"
        );
        return ExitCode::FAILURE;
    };
    let folder = std::env::temp_dir().join(format!("rpl-kills-{}", std::process::id()));
    let bench = Bench { command, folder, chance: Chance(number("--seed", 1)) };
    let done = match option("--damages") {
        Some(_) => bench.damages(number("--damages", 1000)),
        None => bench.kills(number("--kills", 100)),
    };
    match done {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

struct Bench {
    command: PathBuf,
    folder: PathBuf,
    chance: Chance,
}

/// What a run leaves: printed, told, traced.
#[derive(PartialEq, Eq)]
struct Left([Vec<u8>; 3]);

impl Left {
    fn by(folder: &Path) -> io::Result<Self> {
        let read = |name: &str| fs::read(folder.join(name));
        Ok(Self([read("j/output.txt")?, read("j/log.txt")?, read("t.jsonl")?]))
    }

    fn difference(&self, other: &Self) -> Option<String> {
        let names = ["what was printed", "what was told", "the trace"];
        let at = (0..names.len()).find(|&at| self.0[at] != other.0[at])?;
        let (then, now) = (&self.0[at], &other.0[at]);
        let same = then.iter().zip(now).take_while(|(then, now)| then == now).count();
        Some(format!("{} differs from byte {same} on, of {} and {}", names[at], then.len(), now.len()))
    }
}

/// What came of kills.
#[derive(Default)]
struct Count {
    kills: u64,
    findings: u64,
    /// Work since the last checkpoint that was lost with each.
    lost: Vec<Duration>,
    /// How long it took to read a journal and stand where its last checkpoint was.
    starts: Vec<Duration>,
    most_bytes: u64,
}

impl fmt::Display for Count {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kills, findings, most_bytes, .. } = self;
        let shown = |times: &[Duration]| {
            let mut sorted = times.to_vec();
            sorted.sort();
            let at =
                |share: f64| sorted.get(((sorted.len() as f64 - 1.0) * share) as usize).copied().unwrap_or_default();
            format!(
                "{:.2} s in the median, {:.2} s in 95 %, {:.2} s at most",
                at(0.5).as_secs_f64(),
                at(0.95).as_secs_f64(),
                at(1.0).as_secs_f64()
            )
        };
        writeln!(out, "{kills} kills, {findings} findings, at most {:.1} MB on the disk", *most_bytes as f64 / 1e6)?;
        writeln!(out, "work to be done again: {}", shown(&self.lost))?;
        write!(out, "a journal is read within {}", shown(&self.starts))
    }
}

impl Bench {
    fn rpl(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.command);
        command.args(arguments).current_dir(&self.folder).env("NO_COLOR", "1").env("RUST_BACKTRACE", "0");
        command
    }

    fn start(&self, arguments: &[&str]) -> io::Result<Child> {
        self.rpl(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()
    }

    fn clear(&self) -> io::Result<()> {
        if self.folder.exists() {
            fs::remove_dir_all(&self.folder)?;
        }
        fs::create_dir_all(&self.folder)
    }

    /// How many runs did not come to what they should.
    fn kills(mut self, kills: u64) -> io::Result<u64> {
        let mut count = Count::default();
        let mut seed = number("--seed", 1);
        while count.kills < kills {
            if let Some(difference) = self.hour(seed, kills, &mut count)? {
                println!("seed {seed}: {difference}");
                count.findings += 1;
            }
            seed += 1;
        }
        println!("{count}");
        fs::remove_dir_all(&self.folder)?;
        Ok(count.findings)
    }

    /// One hour of the office, which dies some ten times; how it differs from one that does not.
    fn hour(&mut self, seed: u64, kills: u64, count: &mut Count) -> io::Result<Option<String>> {
        let seed = seed.to_string();
        let run = [&["run"][..], &OFFICE, &["--seed", &seed, "--journal", "j", "--trace", "t.jsonl"]].concat();
        self.clear()?;
        let began = Instant::now();
        self.start(&run)?.wait()?;
        let (took, whole) = (began.elapsed(), Left::by(&self.folder)?);
        self.clear()?;
        let mut arguments = run;
        while count.kills < kills {
            let mut child = self.start(&arguments)?;
            let began = Instant::now();
            let end = Duration::from_nanos(self.chance.below(took.as_nanos() as u64 / 5));
            let mut is_over = false;
            while began.elapsed() < end && !is_over {
                std::thread::sleep(LOOK.min(end.saturating_sub(began.elapsed())));
                count.most_bytes = count.most_bytes.max(self.journal_bytes());
                is_over = child.try_wait()?.is_some();
            }
            if is_over {
                break;
            }
            child.kill()?;
            child.wait()?;
            count.kills += 1;
            if self.folder.join("j/run").exists() {
                count.lost.push(self.newest_checkpoint().map_or(began.elapsed(), |age| age.min(began.elapsed())));
                arguments = vec!["resume", "j"];
            }
        }
        if arguments[0] == "resume" && !self.folder.join("j/end").exists() {
            // Where it stands, without going on.
            let began = Instant::now();
            self.rpl(&["resume", "j", "--until", "1ms"]).output()?;
            count.starts.push(began.elapsed());
        }
        self.rpl(&arguments).output()?;
        Ok(Left::by(&self.folder).map_or_else(|error| Some(error.to_string()), |left| whole.difference(&left)))
    }

    /// How long ago the newest checkpoint was there.
    fn newest_checkpoint(&self) -> Option<Duration> {
        let entries = fs::read_dir(self.folder.join("j")).ok()?.flatten();
        let files = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with("checkpoint-"));
        files.filter_map(|entry| entry.metadata().ok()?.modified().ok()?.elapsed().ok()).min()
    }

    fn journal_bytes(&self) -> u64 {
        let entries = fs::read_dir(self.folder.join("j")).into_iter().flatten().flatten();
        entries.filter_map(|entry| entry.metadata().ok()).map(|known| known.len()).sum()
    }

    /// How many damaged journals were gone on with wrongly.
    fn damages(mut self, damages: u64) -> io::Result<u64> {
        self.clear()?;
        fs::write(self.folder.join("plan.rpl"), SHORT)?;
        let run = ["run", "plan.rpl", "--journal", "j", "--trace", "t.jsonl"];
        self.rpl(&run).output()?;
        let whole = Left::by(&self.folder)?;
        fs::remove_dir_all(self.folder.join("j"))?;
        self.rpl(&[&run[..], &["--until", "2s"]].concat()).output()?;
        self.rpl(&["resume", "j", "--until", "5s"]).output()?;
        let files = self.files()?;
        let (mut findings, mut refused) = (0, 0);
        for number in 0..damages {
            for (path, bytes) in &files {
                fs::write(path, bytes)?;
            }
            let names: Vec<PathBuf> = files.iter().map(|(path, _)| path.clone()).collect();
            self.others(&names)?;
            let what = self.damage(number, &files)?;
            let Output { status, stderr, .. } = self.rpl(&["resume", "j"]).output()?;
            let told = String::from_utf8_lossy(&stderr);
            let finding = match status.code() {
                Some(0) => whole.difference(&Left::by(&self.folder)?),
                Some(2) if told.contains("the journal") || told.contains("is no journal") => {
                    refused += 1;
                    None
                }
                other => Some(format!("exit status {other:?}: {told}")),
            };
            if let Some(finding) = finding {
                println!("damage {number}, {what}: {finding}");
                findings += 1;
            }
        }
        println!("{damages} damages, {refused} refused, {findings} findings");
        fs::remove_dir_all(&self.folder)?;
        Ok(findings)
    }

    /// The files of the journal and its trace, with what is in them.
    fn files(&self) -> io::Result<Vec<(PathBuf, Vec<u8>)>> {
        let mut files = vec![self.folder.join("t.jsonl")];
        for entry in fs::read_dir(self.folder.join("j"))? {
            files.push(entry?.path());
        }
        files.retain(|path| !path.ends_with("lock"));
        files.sort();
        files.into_iter().map(|path| fs::read(&path).map(|bytes| (path, bytes))).collect()
    }

    /// What another run has left in the journal is gone.
    fn others(&self, names: &[PathBuf]) -> io::Result<()> {
        for entry in fs::read_dir(self.folder.join("j"))? {
            let path = entry?.path();
            if !names.contains(&path) && !path.ends_with("lock") {
                fs::remove_file(path)?;
            }
        }
        Ok(())
    }

    /// Cuts off the end of a file, every length up to [`END`] in turn, or flips a bit.
    fn damage(&mut self, number: u64, files: &[(PathBuf, Vec<u8>)]) -> io::Result<String> {
        let (path, bytes) = &files[number as usize % files.len()];
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let turn = number as usize / files.len();
        if turn.is_multiple_of(2) {
            let cut = (turn / 2) % bytes.len().clamp(1, END) + 1;
            fs::write(path, &bytes[..bytes.len().saturating_sub(cut)])?;
            return Ok(format!("{cut} bytes cut off `{name}`"));
        }
        let mut bytes = bytes.clone();
        if bytes.is_empty() {
            return Ok(format!("`{name}` is empty"));
        }
        let bit = self.chance.below(bytes.len() as u64 * 8) as usize;
        bytes[bit / 8] ^= 1 << (bit % 8);
        fs::write(path, &bytes)?;
        Ok(format!("bit {bit} of `{name}` flipped"))
    }
}
