//! The journal of a session at the prompt: what was typed, and the texts that it has loaded. With the same site
//! and seed that is all of it.

use super::head::{KeptRun, KeptText, RUN};
use super::run_journal::{begin_folder, take};
use anyhow::{Context, Result, bail};
use rpl_link::journal::folder::JournalFolder;
use rpl_link::journal::{frames, own_file};
use rpl_link::recording::Typed;
use rpl_shell::arguments::journal::SyncArgument;
use rpl_shell::files::plans::{self, KeptLoad, PlanText};
use rpl_shell::files::shown::Shown;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// The file that has it.
const TYPED: &str = "typed";

/// One frame of that file.
#[derive(Debug, Serialize, Deserialize)]
enum Entry {
    /// What was typed; an empty text tells how far the session had come.
    Typed(Typed),
    /// The text that it loads.
    Plan(KeptText),
    /// What a text has loaded.
    Load(KeptLoad),
}

/// What was typed in a session, and what it loaded.
#[derive(Debug, Default)]
pub struct PastSession {
    /// What was typed, in order.
    pub typed: Vec<Typed>,
    /// Texts that were loaded by name, in order.
    pub plans: VecDeque<KeptText>,
    /// What texts have loaded, in order, with the number of lines that were typed by then.
    pub loads: Vec<(usize, KeptLoad)>,
    /// Bytes of the file that are whole.
    length: u64,
}

/// The journal of a session while it is written.
#[derive(Debug)]
pub struct SessionJournal {
    /// Held as long as it is written.
    _folder: JournalFolder,
    file: File,
    /// What stands in the file of what was loaded.
    loads: usize,
    /// The time of the last entry.
    time_us: u64,
    /// It could not be written, and nothing more is.
    is_given_up: bool,
}

impl PastSession {
    /// What was typed, by a recording, which has nothing of what was loaded.
    pub fn recorded(typed: Vec<Typed>) -> Self {
        Self { typed, ..Self::default() }
    }

    /// What the journal of a session has.
    ///
    /// # Errors
    /// It cannot be read, or has what no session has written.
    pub fn read(journal: &Path) -> Result<Self> {
        let shown = journal.shown();
        let bytes =
            own_file::read(&journal.join(TYPED)).with_context(|| format!("cannot read the journal `{shown}`"))?;
        let found = frames::read(&bytes);
        let mut past = Self { length: found.length as u64, ..Self::default() };
        for frame in found.whole {
            let entry = serde_json::from_slice(frame)
                .with_context(|| format!("the file `{TYPED}` of the journal `{shown}` cannot be read"))?;
            match entry {
                Entry::Typed(typed) => past.typed.push(typed),
                Entry::Plan(plan) => past.plans.push_back(plan),
                Entry::Load(load) => past.loads.push((past.typed.len(), load)),
            }
        }
        Ok(past)
    }

    /// What can be loaded when `lines` lines have been typed, the newest first.
    pub fn loads_at(&self, lines: usize) -> Vec<KeptLoad> {
        let known = self.loads.iter().rev().filter(|(typed, _)| *typed <= lines);
        known.map(|(_, load)| load.clone()).collect()
    }
}

impl SessionJournal {
    /// The journal of a session at its start.
    ///
    /// # Errors
    /// The folder has something in it, or cannot be written.
    pub fn begin(path: &Path, kept: &KeptRun) -> Result<Self> {
        let shown = path.shown();
        let folder = begin_folder(path)?;
        let unwritten = || format!("cannot write the journal `{shown}`");
        let file = File::create_new(path.join(TYPED)).with_context(unwritten)?;
        folder.write(RUN, &kept.bytes()?, kept.head.sync != SyncArgument::Never).with_context(unwritten)?;
        Ok(Self { _folder: folder, file, loads: 0, time_us: 0, is_given_up: false })
    }

    /// The journal of a session that goes on, and what it has.
    ///
    /// # Errors
    /// Another process has it, or it cannot be read or written.
    pub fn go_on(path: &Path) -> Result<(Self, PastSession)> {
        let folder = take(path)?;
        let past = PastSession::read(path)?;
        let opened = own_file::open(&path.join(TYPED), File::options().append(true));
        let cut = opened.and_then(|file| file.set_len(past.length).map(|()| file));
        let file = cut.with_context(|| format!("cannot write the journal `{}`", path.shown()))?;
        let time_us = past.typed.last().map_or(0, |last| last.time_us);
        Ok((Self { _folder: folder, file, loads: 0, time_us, is_given_up: false }, past))
    }

    /// A line that takes effect now.
    ///
    /// # Errors
    /// It cannot be written; that is told once.
    pub fn typed(&mut self, typed: &str, time_us: u64) -> io::Result<()> {
        self.time_us = time_us;
        self.write(&Entry::Typed(Typed { typed: typed.to_string(), time_us }), true)
    }

    /// The text that the line loads.
    ///
    /// # Errors
    /// As for [`SessionJournal::typed`].
    pub fn plan(&mut self, plan: &PlanText) -> io::Result<()> {
        self.write(&Entry::Plan(KeptText::of(plan)), true)
    }

    /// How far the session has come, and what it has loaded on the way.
    ///
    /// # Errors
    /// As for [`SessionJournal::typed`].
    pub fn reached(&mut self, time_us: u64) -> io::Result<()> {
        for load in plans::loaded_after(self.loads) {
            self.write(&Entry::Load(load), true)?;
            self.loads += 1;
        }
        if time_us > self.time_us {
            self.time_us = time_us;
            self.write(&Entry::Typed(Typed { typed: String::new(), time_us }), false)?;
        }
        Ok(())
    }

    /// What was loaded before is known.
    pub fn knows_loads(&mut self) {
        self.loads += plans::loaded_after(self.loads).len();
    }

    fn write(&mut self, entry: &Entry, outlives_power: bool) -> io::Result<()> {
        if self.is_given_up {
            return Ok(());
        }
        let mut bytes = Vec::new();
        frames::push(&mut bytes, &serde_json::to_vec(entry)?);
        let written = self.file.write_all(&bytes);
        let written = written.and_then(|()| if outlives_power { self.file.sync_data() } else { Ok(()) });
        // What follows would have a gap before it.
        self.is_given_up = written.is_err();
        written
    }
}

/// Whether a folder has a journal.
pub fn is_there(path: &Path) -> bool {
    path.join(RUN).exists()
}

/// # Errors
/// The journal is not that of a session.
pub fn refuse_run(path: &Path, kept: &KeptRun) -> Result<()> {
    let shown = path.shown();
    if !kept.is_session() {
        bail!(
            "`{shown}` is the journal of a run: `rpl resume {shown}` goes on with it, `rpl repl {shown}` looks into it"
        );
    }
    Ok(())
}
