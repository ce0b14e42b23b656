//! Opens lines to a module, each to a process of its own: the first before its run begins, so that a module
//! that does not start is told before anything else happens.

use crate::process_module::{ModuleProcess, StartError};
use crate::recording::{Recorder, Stretch};
use crate::transcript::{Kept, Live, Transcript};
use rpl_protocol::line::{Line, LineFault};
use rpl_protocol::module::manifest::Manifest;
use rpl_protocol::module::message::{Greeting, Loss, ModuleAnswer, ModuleWords};
use std::fmt;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Opens lines to a module.
pub struct Opener {
    /// What the module is.
    pub manifest: Arc<Manifest>,
    /// The folder of its manifest.
    pub folder: PathBuf,
    /// How much of each conversation stays in memory.
    pub kept: Kept,
    /// A process that was started ahead, and what writes down each of its turns.
    ahead: Mutex<Option<Ahead>>,
    /// The line to that process, once it was asked for.
    first: Mutex<Option<Arc<ModuleTranscript>>>,
}

/// A line to a module.
pub type ModuleTranscript = Transcript<ModuleWords, ModuleAnswer>;

struct Ahead {
    of: Greeting,
    process: ModuleProcess,
    recorder: Option<Arc<Recorder>>,
}

/// What recordings call the line to a module of a name.
pub fn line_name(module: &str) -> String {
    format!("module {module}")
}

impl fmt::Debug for Opener {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Opener").field("module", &self.manifest.name).finish_non_exhaustive()
    }
}

impl Opener {
    /// For a module whose manifest lies in a folder.
    pub fn new(manifest: Arc<Manifest>, folder: PathBuf, kept: Kept) -> Self {
        Self { manifest, folder, kept, ahead: Mutex::new(None), first: Mutex::new(None) }
    }

    /// Starts the module for the run that is about to begin; the recorder is handed what is said.
    ///
    /// # Errors
    /// It does not start, or does not greet.
    pub fn start_ahead(&self, of: Greeting, recorder: Option<Arc<Recorder>>) -> Result<(), StartError> {
        let process = ModuleProcess::start(self.manifest.clone(), &self.folder, of)?;
        *self.ahead.lock().unwrap_or_else(PoisonError::into_inner) = Some(Ahead { of, process, recorder });
        Ok(())
    }

    /// A line for a run: to the process that was started ahead for it, or else to a new one. If that does
    /// not start, its loss is the first answer.
    pub fn open(&self, greeting: Greeting) -> Arc<dyn Line<ModuleWords, ModuleAnswer>> {
        let ahead = self.ahead.lock().unwrap_or_else(PoisonError::into_inner).take_if(|ahead| ahead.of == greeting);
        let is_first = ahead.is_some();
        let (process, recorder) = match ahead {
            Some(Ahead { process, recorder, .. }) => (Ok(process), recorder),
            None => (ModuleProcess::start(self.manifest.clone(), &self.folder, greeting), None),
        };
        let live: Box<dyn Live<ModuleWords, ModuleAnswer>> = match process {
            Ok(process) => Box::new(process),
            Err(StartError { why, last_words, .. }) => Box::new(Refused(Loss { why, last_words })),
        };
        let line = Arc::new(Transcript::live(&line_name(&self.manifest.name), live, self.kept, recorder));
        if is_first {
            *self.first.lock().unwrap_or_else(PoisonError::into_inner) = Some(line.clone());
        }
        line
    }

    /// The line to the process that was started ahead goes on where an earlier process was heard last.
    pub fn go_on(&self, past: Stretch<ModuleWords, ModuleAnswer>, recorder: Option<Arc<Recorder>>) {
        if let Some(line) = &*self.first.lock().unwrap_or_else(PoisonError::into_inner) {
            line.go_on(past, recorder);
        }
    }
}

/// A module that did not start.
#[derive(Debug)]
struct Refused(Loss);

impl Live<ModuleWords, ModuleAnswer> for Refused {
    fn answer(&mut self, _: &ModuleWords) -> Result<ModuleAnswer, LineFault> {
        Ok(ModuleAnswer { messages: Vec::new(), loss: Some(self.0.clone()) })
    }
}
