//! How a run of a journal ended: once that stands there, it is over.

use crate::observed::RunEnd;
use anyhow::{Result, bail};
use rpl_link::journal::folder::JournalFolder;
use rpl_link::journal::{frames, own_file};
use rpl_runtime::run::system::Outcome;
use rpl_shell::files::shown::Shown;
use rpl_shell::status::Status;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The file that has it.
const END: &str = "end";

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JournalEnd {
    /// In a word.
    pub how: EndKind,
    /// The time of the run.
    pub time_us: u64,
    /// As `--json` writes it.
    pub summary: serde_json::Value,
}

/// How a run ended, in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EndKind {
    /// By itself, with a value.
    Succeeded,
    /// By itself, with a failure; or it ended itself.
    Failed,
    /// It can go on.
    Until,
    /// It was told to stop, and its clean-ups have run.
    Interrupted,
}

/// The file that says how a run goes on.
const GOES_ON: &str = "goes-on";

/// How a run goes on.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoingOn {
    /// Up to when; to its end without.
    pub until_us: Option<u64>,
    /// Where its trace is now, if it has one.
    pub trace: Option<PathBuf>,
}

/// A run goes on: nothing tells of an end any more.
///
/// # Errors
/// The folder cannot be written.
pub fn go_on(folder: &JournalFolder, how: &GoingOn, outlives_power: bool) -> io::Result<()> {
    folder.write(GOES_ON, &in_frame(how)?, outlives_power)?;
    match fs::remove_file(folder.path().join(END)) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        Ok(()) | Err(_) => Ok(()),
    }
}

/// How a run was to go on when it did so last; none if it never did.
///
/// # Errors
/// It cannot be read.
pub fn went_on(journal: &Path) -> Result<Option<GoingOn>> {
    read_frame(journal, GOES_ON)
}

/// # Errors
/// It cannot be read, or was changed.
fn read_frame<T: DeserializeOwned>(journal: &Path, name: &str) -> Result<Option<T>> {
    let shown = journal.shown();
    let bytes = match own_file::read(&journal.join(name)) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => bail!("cannot read `{name}` of the journal `{shown}`: {error}"),
    };
    let found = frames::read(&bytes);
    match found.whole[..] {
        [content] if found.torn(&bytes) == 0 => Ok(Some(serde_json::from_slice(content)?)),
        _ => bail!("the file `{name}` of the journal `{shown}` was changed or cut off; the run can go on without it"),
    }
}

/// A value as it stands in its file.
///
/// # Errors
/// A fault of its type.
fn in_frame(value: &impl Serialize) -> serde_json::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    frames::push(&mut bytes, &serde_json::to_vec(value)?);
    Ok(bytes)
}

impl EndKind {
    /// What an end is in a journal.
    pub fn of(end: RunEnd) -> Self {
        match end {
            RunEnd::Outcome(Outcome::Succeeded(_)) => EndKind::Succeeded,
            RunEnd::Outcome(Outcome::Failed(_) | Outcome::Evaporated) => EndKind::Failed,
            RunEnd::TimeUp => EndKind::Until,
            RunEnd::Interrupted | RunEnd::GivenUp => EndKind::Interrupted,
        }
    }

    /// The exit status of a command that finds the run so.
    pub fn status(self) -> Status {
        match self {
            EndKind::Succeeded => Status::Succeeded,
            EndKind::Failed => Status::Failed,
            EndKind::Until => Status::TimeUp,
            EndKind::Interrupted => Status::Interrupted,
        }
    }

    /// For a person.
    pub fn told(self) -> &'static str {
        match self {
            EndKind::Succeeded => "succeeded",
            EndKind::Failed => "failed",
            EndKind::Until => "was cut off by --until",
            EndKind::Interrupted => "was interrupted, and its clean-ups have run",
        }
    }
}

impl JournalEnd {
    /// Tells of the end in a journal.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, folder: &JournalFolder, outlives_power: bool) -> io::Result<()> {
        folder.write(END, &in_frame(self)?, outlives_power)
    }

    /// The end that a journal tells of; none of a run that goes on, or was killed.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn read(journal: &Path) -> Result<Option<Self>> {
        read_frame(journal, END)
    }
}
