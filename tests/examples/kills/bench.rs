//! Folders in which the command runs, several at once, and what it leaves there.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// The plan of short runs, and how they are begun.
pub const SHORT: &str =
    "(defvar n 0)\n(while (< n 150) (setq n (+ n 1)) (print (list n (random 100))) (log \"on\") (wait-time 0.05))\n";

/// Begins a short run.
pub const BEGIN: [&str; 6] = ["run", "plan.rpl", "--journal", "j", "--trace", "t.jsonl"];

/// Which command is tried, and how.
pub struct Bench {
    /// The command.
    pub command: PathBuf,
    /// Where its folders are.
    pub folder: PathBuf,
    /// What chance follows from.
    pub seed: u64,
    /// How many work at once.
    pub jobs: usize,
}

impl Bench {
    /// A folder of this name, empty.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn place(&self, name: &str) -> io::Result<Place> {
        let place = Place { command: self.command.clone(), folder: self.folder.join(name), chance: Chance(self.seed) };
        place.clear()?;
        Ok(place)
    }

    /// Does something for each number below an end, several at once, each in a folder that was prepared; how many
    /// findings that made, which are printed. What is done with a number follows from it, and so does its chance.
    ///
    /// # Errors
    /// The disk is full.
    pub fn each<S>(
        &self,
        end: usize,
        prepare: impl Fn(&mut Place) -> io::Result<S> + Sync,
        work: impl Fn(&mut Place, &S, usize) -> io::Result<Option<String>> + Sync,
    ) -> io::Result<u64> {
        let next = AtomicUsize::new(0);
        let worker = |job: usize| -> io::Result<u64> {
            let mut place = self.place(&job.to_string())?;
            let (prepared, mut findings) = (prepare(&mut place)?, 0);
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= end {
                    return Ok(findings);
                }
                place.chance = Chance(self.seed.wrapping_mul(0x1_0000_0000).wrapping_add(number as u64));
                if let Some(finding) = work(&mut place, &prepared, number)? {
                    println!("{number}: {finding}");
                    findings += 1;
                }
            }
        };
        let counts: Vec<_> = thread::scope(|scope| {
            let worker = &worker;
            let jobs: Vec<_> = (0..self.jobs.max(1)).map(|job| scope.spawn(move || worker(job))).collect();
            jobs.into_iter().map(thread::ScopedJoinHandle::join).collect()
        });
        let panicked = |_| io::Error::other("one of those who work has panicked");
        let findings = counts.into_iter().map(|count| count.map_err(panicked)?).sum::<io::Result<u64>>()?;
        fs::remove_dir_all(&self.folder)?;
        Ok(findings)
    }
}

/// Numbers that follow from the seed (splitmix64).
pub struct Chance(u64);

impl Chance {
    /// The next one, below an end.
    pub fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) % end.max(1)
    }
}

/// A folder in which the command runs.
pub struct Place {
    /// The command.
    pub command: PathBuf,
    /// The folder.
    pub folder: PathBuf,
    /// Its own.
    pub chance: Chance,
}

impl Place {
    /// The command with these arguments.
    pub fn rpl(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.command);
        command.args(arguments).current_dir(&self.folder).env("NO_COLOR", "1").env("RUST_BACKTRACE", "0");
        command
    }

    /// Starts it, and listens to nothing it says.
    pub fn start(&self, arguments: &[&str]) -> io::Result<Child> {
        self.rpl(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()
    }

    /// Empties the folder.
    pub fn clear(&self) -> io::Result<()> {
        if self.folder.exists() {
            fs::remove_dir_all(&self.folder)?;
        }
        fs::create_dir_all(&self.folder)
    }

    /// Where its journal is.
    pub fn journal(&self) -> PathBuf {
        self.folder.join("j")
    }

    /// The files of the journal and its trace, with what is in them; without the lock.
    pub fn files(&self) -> io::Result<Files> {
        let mut paths = vec![self.folder.join("t.jsonl")];
        if self.journal().exists() {
            paths.extend(fs::read_dir(self.journal())?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>()?);
        }
        paths.retain(|path| !path.ends_with("lock") && path.exists());
        paths.sort();
        let read = |path: PathBuf| fs::read(&path).map(|bytes| (path, bytes));
        paths.into_iter().map(read).collect::<io::Result<Vec<_>>>().map(Files)
    }
}

/// Files as they were.
pub struct Files(pub Vec<(PathBuf, Vec<u8>)>);

impl Files {
    /// Puts them where they were, in a place that had the same run, and nothing beside them.
    pub fn put_back(&self, place: &Place) -> io::Result<()> {
        if place.journal().exists() {
            fs::remove_dir_all(place.journal())?;
        }
        if self.0.iter().any(|(path, _)| path.parent() == Some(&place.journal())) {
            fs::create_dir_all(place.journal())?;
        }
        self.0.iter().try_for_each(|(path, bytes)| fs::write(path, bytes))
    }
}

/// What a run leaves: printed, told, traced.
#[derive(Clone, PartialEq, Eq)]
pub struct Left([Vec<u8>; 3]);

impl Left {
    /// What one has left.
    pub fn by(place: &Place) -> io::Result<Self> {
        let read = |name: &str| {
            let path = place.folder.join(name);
            fs::read(&path)
                .map_err(|error| io::Error::new(error.kind(), format!("`{}`: {error}", path.to_string_lossy())))
        };
        Ok(Self([read("j/output.txt")?, read("j/log.txt")?, read("t.jsonl")?]))
    }

    /// Where what is in a place now differs from it.
    pub fn difference(&self, place: &Place) -> Option<String> {
        let now = match Self::by(place) {
            Ok(now) => now,
            Err(error) => return Some(error.to_string()),
        };
        let names = ["what was printed", "what was told", "the trace"];
        let at = (0..names.len()).find(|&at| self.0[at] != now.0[at])?;
        let (then, now) = (&self.0[at], &now.0[at]);
        let same = then.iter().zip(now).take_while(|(then, now)| then == now).count();
        Some(format!("{} differs from byte {same} on, of {} and {}", names[at], then.len(), now.len()))
    }
}

/// The bytes of all files in a folder; those that are gone meanwhile do not count.
pub fn bytes_in(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.metadata().ok()).map(|known| known.len()).sum()
}
