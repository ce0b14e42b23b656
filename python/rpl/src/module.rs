//! Modules in the same process: Python that is called turn by turn.

use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use rpl_command::embedded::{self, Speaker};
use rpl_link::process_module::greeted;
use rpl_link::transcript::Live;
use rpl_protocol::line::LineFault;
use rpl_protocol::module::manifest::Manifest;
use rpl_protocol::module::message::{FromModule, Greeting, Loss, MOST_MESSAGES, ModuleAnswer, ModuleWords, ToModule};
use rpl_protocol::module::process_modules::ModuleSource;
use std::sync::{Arc, Mutex, PoisonError};

/// What somebody meant for the mission who interrupted a module.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<Mutex<Option<PyErr>>>);

impl Interrupt {
    /// What is to be raised, once.
    pub fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Whether there is something to be raised.
    pub fn is_there(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// How a module is lost that raises an exception. What it says goes where exceptions go that nobody catches; but
    /// whoever interrupts it means the mission.
    fn loss(&self, py: Python<'_>, error: PyErr) -> Loss {
        let loss = lost(format!("raised {error}"));
        if error.is_instance_of::<PyException>(py) {
            error.display(py);
        } else {
            *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
        }
        loss
    }
}

/// A module with the manifest in a file; `opened` is called for each run, and what it gives, for each turn, with the
/// messages as lines of JSON, of which it answers some.
pub fn source(file: &str, opened: Py<PyAny>, interrupt: Interrupt) -> anyhow::Result<ModuleSource> {
    let speaker: Arc<Speaker> = Arc::new(move |manifest: Arc<Manifest>, greeting: Greeting| {
        let interrupt = interrupt.clone();
        let hear = Python::attach(|py| opened.call0(py).map_err(|error| interrupt.loss(py, error)));
        let mut module = PythonModule { hear, interrupt };
        if let Err(loss) = module.greet(&manifest, greeting) {
            module.hear = Err(loss);
        }
        Box::new(module)
    });
    embedded::module_within(file, speaker)
}

/// A module that is called, until it is lost.
#[derive(Debug)]
struct PythonModule {
    hear: Result<Py<PyAny>, Loss>,
    interrupt: Interrupt,
}

impl PythonModule {
    fn greet(&self, manifest: &Manifest, greeting: Greeting) -> Result<(), Loss> {
        match self.turn(&[greeting.hello(&manifest.name, manifest.pace)])?.as_slice() {
            [message] => greeted(manifest, message).map_err(lost),
            _ => Err(lost("did not answer `hello` with one message".to_string())),
        }
    }

    /// Says the words and gathers what is answered.
    fn turn(&self, words: &[ToModule]) -> Result<Vec<FromModule>, Loss> {
        let hear = self.hear.as_ref().map_err(Loss::clone)?;
        let lines: Result<Vec<String>, _> = words.iter().map(serde_json::to_string).collect();
        let lines = lines.map_err(|error| lost(error.to_string()))?;
        let said = Python::attach(|py| {
            let said = hear.call1(py, (lines.join("\n"),)).and_then(|said| said.extract::<String>(py));
            said.map_err(|error| self.interrupt.loss(py, error))
        })?;
        let messages: Vec<FromModule> =
            said.lines().map(|line| FromModule::read(line.as_bytes())).collect::<Result<_, _>>().map_err(lost)?;
        if messages.len() > MOST_MESSAGES {
            return Err(lost(format!("said more than {MOST_MESSAGES} messages in one turn")));
        }
        Ok(messages)
    }
}

impl Live<ModuleWords, ModuleAnswer> for PythonModule {
    fn answer(&mut self, ModuleWords(words): &ModuleWords) -> Result<ModuleAnswer, LineFault> {
        Ok(match self.turn(words) {
            Ok(messages) => ModuleAnswer { messages, loss: None },
            Err(loss) => {
                self.hear = Err(loss.clone());
                ModuleAnswer { messages: Vec::new(), loss: Some(loss) }
            }
        })
    }
}

fn lost(why: String) -> Loss {
    Loss { why, last_words: String::new() }
}
