//! The files of a journal that grow: what plans printed, what was told, and the trace.

use super::driver_state::DriverState;
use anyhow::{Context, Result};
use rpl_link::journal::ledger::{Ledger, LedgerFault, LedgerMark};
use rpl_link::journal::own_file;
use rpl_shell::files::outputs::OutputFile;
use rpl_shell::files::shown::Shown;
use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

/// What plans printed.
pub const OUTPUT: &str = "output.txt";

/// What was told on the way: what happened, and what plans logged.
pub const LOG: &str = "log.txt";

/// How a file is opened.
type Opening = fn(&Path, &mut OpenOptions) -> io::Result<File>;

/// The files that a run writes on and on.
#[derive(Debug)]
pub struct Ledgers {
    /// What plans printed.
    pub output: Ledger,
    /// What was told.
    pub log: Ledger,
    /// The trace, if there is one; it belongs to whoever writes events.
    pub trace: Option<Ledger>,
}

impl Ledgers {
    /// Those of a run at its start. The trace is a file that was opened for it.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn begin(journal: &Path, trace: Option<OutputFile>) -> Result<Self> {
        let begin = |name: &str| -> Result<Ledger> {
            let path = journal.join(name);
            let opened = own_file::open(&path, File::options().read(true).write(true).create(true).truncate(true));
            let begun = opened.map_err(LedgerFault::from).and_then(Ledger::begin);
            begun.with_context(|| format!("cannot write `{}`", path.shown()))
        };
        // What it held stays until nobody else writes it.
        let trace = trace.map(|file| Ledger::begin(file.into_file()?).context("the trace cannot be written"));
        Ok(Self { output: begin(OUTPUT)?, log: begin(LOG)?, trace: trace.transpose()? })
    }

    /// Those of a run that goes on from where its driver stood, or from its start.
    ///
    /// # Errors
    /// They are not what they were, or cannot be written.
    pub fn go_on(journal: &Path, trace: Option<&Path>, state: Option<&DriverState>) -> Result<Self> {
        let go_on = |path: &Path, open: Opening, mark: Option<LedgerMark>| {
            let mark = mark.unwrap_or_default();
            let mut options = File::options();
            let opened = match open(path, options.read(true).write(true)) {
                // Made only where there is nothing at all: a link that leads nowhere is no place for a file.
                Err(error) if error.kind() == io::ErrorKind::NotFound && mark.length == 0 => {
                    open(path, options.create_new(true))
                }
                opened => opened,
            };
            opened.map_err(LedgerFault::from).and_then(|file| Ledger::go_on(file, mark)).map_err(|fault| match fault {
                LedgerFault::Disk(error) if error.kind() == io::ErrorKind::NotFound => {
                    anyhow::anyhow!("`{}` is not there any more", path.shown())
                }
                fault => anyhow::Error::from(fault).context(format!("`{}`", path.shown())),
            })
        };
        Ok(Self {
            output: go_on(&journal.join(OUTPUT), own_file::open, state.map(|state| state.output))?,
            log: go_on(&journal.join(LOG), own_file::open, state.map(|state| state.log))?,
            trace: trace
                .map(|path| go_on(path, own_file::open_named, state.and_then(|state| state.trace)))
                .transpose()?,
        })
    }
}
