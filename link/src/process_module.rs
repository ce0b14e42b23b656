//! A module in a process of its own: greeted, asked turn by turn, and lost for whatever it does that it
//! may not.

use crate::process::{Heard, Process};
use crate::transcript::Live;
use rpl_lang::visible::clause;
use rpl_protocol::line::LineFault;
use rpl_protocol::module::manifest::Manifest;
use rpl_protocol::module::message::{
    FromModule, Greeting, Loss, MOST_BYTES, MOST_BYTES_A_TURN, MOST_MESSAGES, ModuleAnswer, ModuleWords, Pace,
    ToModule, VERSION,
};
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a module has to end by itself after `bye`.
const PARTING: Duration = Duration::from_secs(1);

/// A module that does not start: what it did, and what it said on its standard error.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the module `{name}` ({file}) {why}{}", told(.last_words))]
pub struct StartError {
    /// The module.
    pub name: String,
    /// Its manifest.
    pub file: String,
    /// As the rest of a sentence.
    pub why: String,
    /// The last lines that it wrote to its standard error, if it wrote any.
    pub last_words: String,
}

fn told(last_words: &str) -> String {
    if last_words.is_empty() { String::new() } else { format!("; the last it wrote to standard error:\n{last_words}") }
}

/// A module that runs and has been greeted.
#[derive(Debug)]
pub struct ModuleProcess {
    manifest: Arc<Manifest>,
    process: Process,
    /// The tick that a live module has not answered, and when it was told.
    unanswered: Option<(u64, Instant)>,
    is_lost: bool,
}

impl ModuleProcess {
    /// Starts the command of a manifest, in the folder of the manifest, and waits for its greeting.
    ///
    /// # Errors
    /// There is no such program, or it does not greet as it should.
    pub fn start(manifest: Arc<Manifest>, folder: &Path, greeting: Greeting) -> Result<Self, StartError> {
        let refused = |why: String, last_words: String| {
            let Manifest { name, file, .. } = &*manifest;
            StartError { name: name.clone(), file: file.clone(), why, last_words }
        };
        let process = Process::start(&manifest.command, folder, MOST_BYTES)
            .map_err(|error| refused(not_started(&manifest.command[0], &error), String::new()))?;
        let mut module = Self { manifest: manifest.clone(), process, unanswered: None, is_lost: false };
        match module.greet(greeting) {
            Ok(()) => {
                module.process.pass_errors_on(&manifest.name);
                Ok(module)
            }
            Err(why) => {
                module.process.end(Duration::ZERO);
                Err(refused(why, module.process.last_words()))
            }
        }
    }

    /// The number of its process.
    pub fn number(&self) -> u32 {
        self.process.number()
    }

    /// # Errors
    /// What it did instead of greeting, as a clause.
    fn greet(&mut self, greeting: Greeting) -> Result<(), String> {
        self.tell(&hello(&self.manifest, greeting));
        let patience = Duration::from_micros(self.manifest.start_within_us);
        let heard = self.process.listen(Instant::now() + patience);
        let message = match heard {
            Ok(Heard::Nothing) => Err(format!("did not answer `hello` within {patience:?}")),
            heard => self.message(heard),
        };
        greeted(&self.manifest, &message?)
    }

    fn tell(&mut self, message: &ToModule) {
        match serde_json::to_vec(message) {
            Ok(line) => self.process.tell(&line),
            Err(error) => unreachable!("what is said was made of what can be said: {error}"),
        }
    }

    /// The message in what was heard.
    ///
    /// # Errors
    /// What it did instead, as a clause.
    fn message(&mut self, heard: io::Result<Heard>) -> Result<FromModule, String> {
        match heard {
            Ok(Heard::Line(line)) => FromModule::read(&line),
            Ok(Heard::TooLong) => Err(format!("said a line of more than {} MiB", MOST_BYTES >> 20)),
            Ok(Heard::Nothing) => Err("did not answer".to_string()),
            Ok(Heard::Closed(rest)) => {
                let how = self.process.autopsy();
                let rest = String::from_utf8_lossy(&rest);
                Err(if rest.is_empty() { how } else { format!("{how} in the middle of a line: {}", clause(&rest)) })
            }
            Err(error) => Err(format!("cannot be heard: {error}")),
        }
    }

    /// Says the words and gathers what is answered.
    ///
    /// # Errors
    /// What it did instead, as a clause; what it had said before is in `messages`.
    fn turn(&mut self, words: &[ToModule], messages: &mut Vec<FromModule>) -> Result<(), String> {
        let patience = Duration::from_micros(self.manifest.answer_within_us);
        let now = Instant::now();
        for message in words {
            match message {
                ToModule::Tick { .. } if self.unanswered.is_some() => continue,
                ToModule::Tick { time_us, .. } => self.unanswered = Some((*time_us, now)),
                ToModule::Hello { .. } | ToModule::Start { .. } | ToModule::Stop { .. } | ToModule::Bye => {}
            }
            self.tell(message);
        }
        if self.process.untaken() > 2 * MOST_BYTES_A_TURN {
            return Err("does not read what it is told".to_string());
        }
        let until = match self.manifest.pace {
            Pace::LockStep => now + patience,
            Pace::Live => now,
        };
        let mut bytes = 0;
        loop {
            let heard = self.process.listen(until);
            if let Ok(Heard::Nothing) = heard {
                return match (self.manifest.pace, self.unanswered) {
                    (Pace::Live, Some((_, told))) if told.elapsed() <= patience => Ok(()),
                    (Pace::Live, None) => Ok(()),
                    (Pace::Live, Some((time_us, _))) | (Pace::LockStep, Some((time_us, _))) => {
                        Err(format!("did not answer the tick at {time_us} us within {patience:?}"))
                    }
                    (Pace::LockStep, None) => unreachable!("it is listened to until it has answered"),
                };
            }
            bytes += if let Ok(Heard::Line(line)) = &heard { line.len() } else { 0 };
            let message = self.message(heard)?;
            let is_answered = matches!(message, FromModule::Done { .. });
            messages.push(message);
            if messages.len() > MOST_MESSAGES || bytes > MOST_BYTES_A_TURN {
                return Err(format!(
                    "said more than {MOST_MESSAGES} messages or {} MiB in one turn",
                    MOST_BYTES_A_TURN >> 20
                ));
            }
            if is_answered {
                self.unanswered = None;
                if self.manifest.pace == Pace::LockStep {
                    return Ok(());
                }
            }
        }
    }

    /// Tells it that the run is over, and waits for its end, but not long.
    fn part(&mut self) {
        if !std::mem::replace(&mut self.is_lost, true) {
            self.tell(&ToModule::Bye);
            self.process.end(PARTING);
        }
    }
}

/// How a module is greeted.
pub fn hello(manifest: &Manifest, Greeting { period_us, seed }: Greeting) -> ToModule {
    ToModule::Hello {
        protocol: VERSION,
        rpl: env!("CARGO_PKG_VERSION").to_string(),
        module: manifest.name.clone(),
        period_us,
        pace: manifest.pace,
        seed,
    }
}

/// Whether a module greets as the one of a manifest.
///
/// # Errors
/// What it did instead, as a clause.
pub fn greeted(manifest: &Manifest, message: &FromModule) -> Result<(), String> {
    match message {
        FromModule::Hello { protocol, .. } if *protocol != VERSION => {
            Err(format!("speaks version {protocol} of the protocol, and rpl speaks version {VERSION}"))
        }
        FromModule::Hello { module, .. } if *module != manifest.name => {
            Err(format!("calls itself `{}`, which is not its name in the manifest", clause(module)))
        }
        FromModule::Hello { .. } => Ok(()),
        FromModule::Fluents { .. }
        | FromModule::Success { .. }
        | FromModule::Failure { .. }
        | FromModule::Event { .. }
        | FromModule::Done { .. } => Err("did not say `hello` first".to_string()),
    }
}

/// Why a program does not start, as a clause about its module.
fn not_started(program: &str, error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound if program.contains('/') => {
            format!("cannot be started: there is no file `{program}` in the folder of its manifest")
        }
        io::ErrorKind::NotFound => format!("cannot be started: there is no program `{program}`"),
        io::ErrorKind::PermissionDenied => format!("cannot be started: `{program}` may not be executed"),
        _ => format!("cannot be started: `{program}`: {error}"),
    }
}

impl Live<ModuleWords, ModuleAnswer> for ModuleProcess {
    fn answer(&mut self, words: &ModuleWords) -> Result<ModuleAnswer, LineFault> {
        let mut messages = Vec::new();
        let ended = match words.0.as_slice() {
            [ToModule::Bye] => {
                self.part();
                Err("was told to end".to_string())
            }
            _ if self.is_lost => Err("was lost before".to_string()),
            words => self.turn(words, &mut messages),
        };
        let loss = ended.err().map(|why| {
            self.is_lost = true;
            // What it writes about its fault may be under way, and nothing else is of interest any more.
            self.process.end(Duration::ZERO);
            Loss { why, last_words: self.process.last_words() }
        });
        Ok(ModuleAnswer { messages, loss })
    }
}

impl Drop for ModuleProcess {
    fn drop(&mut self) {
        self.part();
    }
}
