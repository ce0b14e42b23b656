//! The journal of a run while it is written: what plans print and what is told, and checkpoints now and then.
//!
//! When a checkpoint is made depends on how long things take (`cadence`), and the run cannot tell. The run is copied,
//! which is cheap, and a thread writes the copy down while the run goes on.

use super::cadence::{Cadence, by_thread};
use super::changes::{self, CHANGES, Change};
use super::checkpoints;
use super::driver_state::DriverState;
use super::end::JournalEnd;
use super::head::{KeptRun, RUN};
use super::ledgers::{LOG, Ledgers, OUTPUT};
use super::outside::Outside;
use anyhow::{Context, Result, bail};
use rpl_link::journal::folder::{FolderFault, JournalFolder, write_whole};
use rpl_link::journal::ledger::{Ledger, Written};
use rpl_link::journal::{checkpoint, inputs};
use rpl_link::recording::Recorder;
use rpl_mission::robot::Robot;
use rpl_runtime::run::system::System;
use rpl_shell::arguments::journal::SyncArgument;
use rpl_shell::files::outputs::OutputFile;
use rpl_shell::files::shown::Shown;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What is there of a journal before it has its [`RUN`].
const BEGINNINGS: [&str; 5] = ["lock", OUTPUT, LOG, "inputs-000000", "run.new"];

/// A journal that is written.
#[derive(Debug)]
pub struct RunJournal {
    folder: JournalFolder,
    /// The checksum of the run.
    run: u32,
    output: Ledger,
    log: Ledger,
    /// What comes from other processes, if there are any.
    outside: Option<Outside>,
    sync: SyncArgument,
    /// When lines were brought to the disk last, and whether there are new ones.
    synced: Instant,
    has_new_lines: bool,
    /// The thread that does so.
    syncing: Option<JoinHandle<io::Result<()>>>,
    must: bool,
    /// Of the next checkpoint.
    number: u64,
    cadence: Cadence,
    /// New definitions, and how many have taken effect.
    changes: Vec<Change>,
    changes_taken: usize,
    /// The checkpoint that is being written.
    writing: Option<JoinHandle<io::Result<Duration>>>,
    trouble: Trouble,
}

/// How the disk has taken what was written.
#[derive(Debug, Default)]
struct Trouble {
    /// What it does not take, why, and since when in the run.
    now: BTreeMap<Part, (String, u64)>,
    /// What is to be told.
    untold: Option<String>,
    /// How often it began.
    times: u32,
}

/// What is written of a journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    /// What grows.
    Ledgers,
    /// What comes from other processes.
    Inputs,
    /// The saved runs.
    Checkpoints,
    /// How it ended.
    End,
}

/// Takes a folder for a journal.
///
/// # Errors
/// Another process has it, or it cannot be written.
pub fn take(path: &Path) -> Result<JournalFolder> {
    let shown = path.shown();
    JournalFolder::take(path).map_err(|fault| match fault {
        FolderFault::Taken(_) => anyhow::anyhow!("the journal `{shown}` is being written: {fault}"),
        FolderFault::Disk(error) => anyhow::anyhow!("cannot write the journal `{shown}`: {error}"),
    })
}

/// # Errors
/// A folder has more in it than what is left of a journal that could not be begun.
fn refuse_foreign(path: &Path) -> Result<()> {
    let is_left = |entry: io::Result<fs::DirEntry>| {
        let name = entry.map(|entry| entry.file_name());
        name.is_ok_and(|name| BEGINNINGS.iter().any(|known| name == *known))
    };
    // What cannot be read cannot be locked, which says why.
    let foreign = fs::read_dir(path).is_ok_and(|mut entries| !entries.all(is_left));
    let shown = path.shown();
    if foreign {
        bail!("the folder `{shown}` has files that are none of a journal; name one that is empty or not there");
    }
    Ok(())
}

/// A folder for a new journal.
///
/// # Errors
/// It has something in it, or cannot be written.
pub fn begin_folder(path: &Path) -> Result<JournalFolder> {
    let shown = path.shown();
    if path.join(RUN).exists() {
        bail!("`{shown}` has a journal already: `rpl resume {shown}` goes on with it; or name another folder");
    }
    refuse_foreign(path)?;
    let folder = take(path)?;
    // Between the look and the lock somebody may have begun one.
    refuse_foreign(path)?;
    Ok(folder)
}

impl RunJournal {
    /// A journal of a run at its start, and the trace that belongs to it.
    ///
    /// # Errors
    /// The folder has something in it, or cannot be written.
    pub fn begin(path: &Path, kept: &KeptRun, trace: Option<OutputFile>) -> Result<(Self, Option<Ledger>)> {
        let shown = path.shown();
        let folder = begin_folder(path)?;
        let ledgers = Ledgers::begin(path, trace)?;
        let outlives_power = kept.head.sync != SyncArgument::Never;
        let bytes = kept.bytes()?;
        let unwritten = || format!("cannot write the journal `{shown}`");
        let outside = kept.head.has_outside().then(|| Outside::begin(path)).transpose().with_context(unwritten)?;
        folder.write(RUN, &bytes, outlives_power).with_context(unwritten)?;
        Ok(Self::of(folder, kept, ledgers, outside, 0))
    }

    /// The journal of a run that goes on.
    pub fn of(
        folder: JournalFolder,
        kept: &KeptRun,
        ledgers: Ledgers,
        outside: Option<Outside>,
        number: u64,
    ) -> (Self, Option<Ledger>) {
        let number = outside.as_ref().map_or(number, |outside| number.max(outside.number()));
        let Ledgers { output, log, trace } = ledgers;
        let journal = Self {
            folder,
            run: kept.checksum,
            output,
            log,
            outside,
            sync: kept.head.sync,
            synced: Instant::now(),
            has_new_lines: false,
            syncing: None,
            must: kept.head.must,
            number,
            cadence: Cadence::new(),
            changes: Vec::new(),
            changes_taken: 0,
            writing: None,
            trouble: Trouble::default(),
        };
        (journal, trace)
    }

    fn outlives_power(&self) -> bool {
        self.sync != SyncArgument::Never
    }

    /// What writes down what other processes say, if there are any.
    pub fn recorder(&self) -> Option<Arc<Recorder>> {
        self.outside.as_ref().map(Outside::recorder)
    }

    /// The run has gone on to its next instant.
    pub fn instant_begun(&mut self, system: &System<Robot>) {
        if let Some(outside) = &mut self.outside {
            let time_us = system.machine.now_us;
            let written = outside.instant_begun(time_us);
            self.has_new_lines = true;
            self.take_in(Part::Inputs, written, time_us);
        }
    }

    /// Whether the run is gone on with, at the end of this instant, after its process has died.
    pub fn resumes(&mut self, system: &System<Robot>) -> bool {
        let Some(outside) = &mut self.outside else { return false };
        let (resumes, written) = outside.resumes(system.machine.instant);
        self.take_in(Part::Inputs, written, system.machine.now_us);
        resumes
    }

    /// Whether the run hears again what it had heard before its process died.
    pub fn is_past(&self) -> bool {
        self.outside.as_ref().is_some_and(Outside::is_past)
    }

    /// The run was told to stop: what its clean-ups hear is not heard again.
    pub fn stopped(&mut self) {
        if let Some(outside) = &mut self.outside {
            outside.close();
        }
    }

    /// A line that a plan prints.
    pub fn printed(&mut self, line: &str) -> Written {
        self.has_new_lines = true;
        push_line(&mut self.output, line)
    }

    /// A line that is told.
    pub fn told(&mut self, line: &str) -> Written {
        self.has_new_lines = true;
        push_line(&mut self.log, line)
    }

    /// Brings new lines to the disk, if it is time. Once a second a thread does it: a robot does not wait for a disk.
    fn bring_to_disk(&mut self) -> io::Result<()> {
        let is_busy = self.syncing.as_ref().is_some_and(|syncing| !syncing.is_finished());
        let is_time = match self.sync {
            SyncArgument::Always => true,
            SyncArgument::Second => !is_busy && self.synced.elapsed() >= Duration::from_secs(1),
            SyncArgument::Never => false,
        };
        if !is_time || !self.has_new_lines {
            return Ok(());
        }
        // What follows from inputs may not outlive them.
        let inputs = self.outside.as_ref().map(Outside::handle).transpose()?;
        let files: Vec<File> = inputs.into_iter().chain([self.output.handle()?, self.log.handle()?]).collect();
        let bring = move || files.iter().try_for_each(File::sync_data);
        (self.synced, self.has_new_lines) = (Instant::now(), false);
        if self.sync == SyncArgument::Always {
            return bring();
        }
        let before = self.syncing.replace(std::thread::spawn(bring));
        before.map_or(Ok(()), joined)
    }

    /// An instant is over, and what it printed was handed out.
    pub fn flush(&mut self, trace: Option<&mut Ledger>, time_us: u64) {
        let trace = trace.filter(|trace| trace.is_full()).map_or(Ok(()), Ledger::flush);
        let flushed = trace.and_then(|()| self.output.flush()).and_then(|()| self.log.flush());
        let flushed = flushed.and_then(|()| self.bring_to_disk());
        self.take_in(Part::Ledgers, flushed, time_us);
    }

    /// Whether it is time for a checkpoint.
    pub fn is_due(&mut self, time_us: u64) -> bool {
        if let Some(writing) = self.writing.take_if(|writing| writing.is_finished()) {
            let written = joined(writing);
            if let Ok(cost) = &written {
                self.cadence.add(*cost);
            }
            self.take_in(Part::Checkpoints, written.map(|_| ()), time_us);
        }
        self.writing.is_none() && self.cadence.is_due()
    }

    /// Writes a checkpoint of a run all of whose tasks are blocked and whose output was handed out.
    pub fn checkpoint(
        &mut self,
        system: &System<Robot>,
        trace: Option<&mut Ledger>,
        pose_due_us: u64,
        relocalizations: u64,
    ) {
        let computed_before = by_thread();
        let time_us = system.machine.now_us;
        match self.prepared(system, trace, pose_due_us, relocalizations) {
            Ok(writing) => {
                self.number += 1;
                self.writing = Some(std::thread::spawn(move || writing.write().map(|()| by_thread())));
            }
            Err(error) => self.take_in(Part::Checkpoints, Err(error), time_us),
        }
        self.cadence.begin(by_thread().saturating_sub(computed_before));
    }

    fn prepared(
        &mut self,
        system: &System<Robot>,
        trace: Option<&mut Ledger>,
        pose_due_us: u64,
        relocalizations: u64,
    ) -> io::Result<CheckpointWriting> {
        let mut files = vec![(OUTPUT, self.output.handle()?), (LOG, self.log.handle()?)];
        let trace = match trace {
            Some(trace) => {
                files.push(("", trace.handle()?));
                Some(trace.mark()?)
            }
            None => None,
        };
        let state = DriverState {
            run: self.run,
            time_us: system.machine.now_us,
            output: self.output.mark()?,
            log: self.log.mark()?,
            trace,
            pose_due_us,
            relocalizations,
            changes: self.changes_taken,
        };
        let (folder, number) = (self.folder.path().to_path_buf(), self.number);
        if let Some(outside) = &mut self.outside {
            outside.checkpoint(number)?;
        }
        Ok(CheckpointWriting {
            folder,
            number,
            files,
            state,
            system: system.clone(),
            outlives_power: self.outlives_power(),
        })
    }

    /// New definitions that the run has been given, of which `taken` had taken effect where it goes on.
    pub fn with_changes(mut self, changes: Vec<Change>, taken: usize) -> Self {
        (self.changes, self.changes_taken) = (changes, taken);
        self
    }

    /// Gives the run the definitions that take effect at the end of this instant: those that did when the instant
    /// was first gone through, and new ones where the run has come to what it had written.
    ///
    /// # Errors
    /// New ones do not compile, or cannot be written down.
    pub fn take_changes(&mut self, system: &mut System<Robot>, trace: Option<&mut Ledger>) -> Result<()> {
        let is_level = self.output.is_level() && self.log.is_level() && trace.is_none_or(|trace| trace.is_level());
        let is_level = is_level && !self.is_past();
        while let Some(change) = self.changes.get_mut(self.changes_taken) {
            let is_new = change.instant.is_none();
            match change.instant {
                Some(instant) if instant > system.machine.instant => break,
                Some(_) => {}
                None if !is_level => break,
                None => change.instant = Some(system.machine.instant),
            }
            change.apply(system)?;
            self.changes_taken += 1;
            if is_new {
                // Nothing follows from it before it is written.
                let bytes = changes::written(&self.changes)?;
                let written = self.folder.write(CHANGES, &bytes, self.outlives_power());
                written.with_context(|| format!("cannot write the journal `{}`", self.folder.path().shown()))?;
            }
        }
        Ok(())
    }

    /// The run stands still here, and can go on: its last checkpoint is written to the end.
    pub fn stand_still(
        &mut self,
        system: &System<Robot>,
        trace: Option<&mut Ledger>,
        pose_due_us: u64,
        relocalizations: u64,
    ) {
        let time_us = system.machine.now_us;
        self.wait(time_us);
        self.checkpoint(system, trace, pose_due_us, relocalizations);
        self.wait(time_us);
    }

    /// The run is over, or stands still: how, if the journal is to tell.
    pub fn finish(&mut self, trace: Option<&mut Ledger>, end: &JournalEnd) {
        self.wait(end.time_us);
        let finished = trace.map_or(Ok(()), Ledger::finish);
        let finished = finished.and_then(|()| self.output.finish()).and_then(|()| self.log.finish());
        let written = finished.and_then(|()| end.write(&self.folder, self.outlives_power()));
        self.take_in(Part::End, written, end.time_us);
    }

    fn wait(&mut self, time_us: u64) {
        if let Some(writing) = self.writing.take() {
            let written = joined(writing).map(|_| ());
            self.take_in(Part::Checkpoints, written, time_us);
        }
    }

    /// How the disk has taken something.
    fn take_in(&mut self, part: Part, written: io::Result<()>, time_us: u64) {
        let trouble = &mut self.trouble;
        let Err(error) = written else {
            trouble.now.remove(&part);
            return;
        };
        if trouble.times == 0 {
            let folder = self.folder.path().shown();
            let then = if self.must { "the run is stopped" } else { "the run goes on, and it is tried again" };
            trouble.untold = Some(format!("the journal `{folder}` cannot be written: {error}; {then}"));
        }
        trouble.times += u32::from(trouble.now.is_empty());
        trouble.now.entry(part).or_insert_with(|| (error.to_string(), time_us));
    }

    /// What is to be told now about the journal.
    pub fn take_note(&mut self) -> Option<String> {
        self.trouble.untold.take()
    }

    /// Whether the run must not go on without it.
    pub fn stops_run(&self) -> bool {
        self.must && self.trouble.times > 0
    }

    /// What there is to say about it at the end; nothing if all was written.
    pub fn told_at_end(&self) -> Option<String> {
        let folder = self.folder.path().shown();
        match self.trouble.now.values().min_by_key(|(_, since_us)| since_us) {
            Some((why, since_us)) => {
                let since_s = *since_us as f64 / 1e6;
                Some(format!("the journal `{folder}` could not be written from {since_s:.1} s on: {why}"))
            }
            None if self.trouble.times > 0 => {
                let times = self.trouble.times;
                Some(format!("the journal `{folder}` could not be written {times} time(s) in between, and is whole"))
            }
            None => None,
        }
    }
}

fn push_line(ledger: &mut Ledger, line: &str) -> Written {
    ledger.push(format!("{line}\n").as_bytes())
}

fn joined<T>(writing: JoinHandle<io::Result<T>>) -> io::Result<T> {
    writing.join().unwrap_or_else(|_| Err(io::Error::other("the thread that writes it has a fault")))
}

/// A checkpoint that is to be written.
struct CheckpointWriting {
    folder: PathBuf,
    number: u64,
    /// What must be on the disk before it, by the name in the folder; the trace has none.
    files: Vec<(&'static str, File)>,
    state: DriverState,
    system: System<Robot>,
    outlives_power: bool,
}

impl CheckpointWriting {
    fn write(self) -> io::Result<()> {
        let Self { folder, number, files, state, system, outlives_power } = self;
        // A folder that was taken away, or put in the place of this one, holds no journal.
        for name in [RUN].into_iter().chain(files.iter().map(|(name, _)| *name)).filter(|name| !name.is_empty()) {
            if !folder.join(name).exists() {
                return Err(io::Error::new(io::ErrorKind::NotFound, format!("its file `{name}` is gone")));
            }
        }
        checkpoints::drop_old(&folder)?;
        let run = system.save();
        let before = checkpoint::before(&state, &run)?;
        if outlives_power {
            files.iter().try_for_each(|(_, file)| file.sync_data())?;
        }
        write_whole(&folder, &checkpoints::name(number), &[&before, &run], outlives_power)?;
        match checkpoints::numbers(&folder)?[..] {
            [_, .., oldest] => inputs::drop_before(&folder, oldest),
            // If the only one is damaged, the run goes on from its start.
            [_] | [] => Ok(()),
        }
    }
}
