//! What comes to a run from a host or modules in other processes, as its journal has it: written as it comes, and
//! heard again up to where the run died. From there on it is gone on with.

use anyhow::{Context, Result};
use rpl_link::journal::inputs::{Inputs, PastInputs};
use rpl_link::recording::Recorder;
use rpl_shell::files::shown::Shown;
use std::collections::VecDeque;
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// What came from other processes since the start of a run.
///
/// # Errors
/// The journal does not have all of it any more.
pub fn inputs_from_start(path: &Path) -> Result<PastInputs> {
    PastInputs::read(path, None).with_context(|| {
        let shown = path.shown();
        format!(
            "the run of `{shown}` cannot be repeated from its start: a journal keeps what comes from other processes \
             for about an hour; `rpl resume {shown}` goes on with it"
        )
    })
}

/// The inputs of a run.
#[derive(Debug)]
pub struct Outside {
    inputs: Arc<Mutex<Inputs>>,
    /// How often the run was gone on with at the instant where it stands and at those that it has still to come
    /// to; none when it has come to where it died, and goes on.
    past: Option<VecDeque<u32>>,
}

impl Outside {
    /// Those of a run at its start.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn begin(journal: &Path) -> io::Result<Self> {
        Ok(Self { inputs: Arc::new(Mutex::new(Inputs::begin(journal)?)), past: None })
    }

    /// Those of a run that goes on from a checkpoint, or from its start.
    ///
    /// # Errors
    /// They cannot be written.
    pub fn go_on(journal: &Path, past: &PastInputs, checkpoint: Option<u64>) -> Result<Self> {
        let inputs = Inputs::go_on(journal, past, checkpoint)
            .with_context(|| format!("cannot go on with the journal `{}`", journal.shown()))?;
        Ok(Self { inputs: Arc::new(Mutex::new(inputs)), past: Some(past.resumptions.iter().copied().collect()) })
    }

    /// What writes down what comes.
    pub fn recorder(&self) -> Arc<Recorder> {
        Arc::new(Recorder::of_journal(self.inputs.clone()))
    }

    /// Nobody who panicked with them has left half of anything: a frame is pushed whole.
    fn inputs(&self) -> MutexGuard<'_, Inputs> {
        self.inputs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The number of the next checkpoint, if it is to fit to these.
    pub fn number(&self) -> u64 {
        self.inputs().number()
    }

    /// Whether the run has still to come to where it died.
    pub fn is_past(&self) -> bool {
        self.past.is_some()
    }

    /// The run has gone on to its next instant.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn instant_begun(&mut self, time_us: u64) -> io::Result<()> {
        if let Some(past) = &mut self.past {
            past.pop_front();
            if !past.is_empty() {
                return Ok(());
            }
            // It had died before its first instant was written.
            past.push_back(0);
        }
        self.inputs().instant(time_us)
    }

    /// Whether the run is gone on with at the end of this instant: as it was before, or now; and whether the latter
    /// could be written.
    pub fn resumes(&mut self, instant: u32) -> (bool, io::Result<()>) {
        let Some(past) = &mut self.past else { return (false, Ok(())) };
        let is_last = past.len() <= 1;
        match past.front_mut() {
            Some(resumptions) if *resumptions > 0 => {
                *resumptions -= 1;
                (true, Ok(()))
            }
            Some(_) if !is_last => (false, Ok(())),
            Some(_) | None => {
                self.past = None;
                (true, self.inputs().resumption(instant))
            }
        }
    }

    /// A checkpoint is made here.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn checkpoint(&mut self, number: u64) -> io::Result<()> {
        self.inputs().next_file(number)
    }

    /// The run was told to stop: what comes from now on is not heard again.
    pub fn close(&mut self) {
        self.inputs().close();
    }

    /// The file, to bring it to the disk.
    ///
    /// # Errors
    /// There is no further handle.
    pub fn handle(&self) -> io::Result<File> {
        self.inputs().handle()
    }
}
