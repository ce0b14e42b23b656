//! A module in a process of its own: greeted, asked turn by turn, and lost for whatever it does that it
//! may not.

use crate::process::{Heard, Process};
use crate::transcript::Live;
use rpl_lang::visible::clause;
use rpl_protocol::line::LineFault;
use rpl_protocol::module::manifest::{Manifest, Spokesman};
use rpl_protocol::module::message::{
    FromModule, Greeting, Loss, MOST_BYTES, MOST_BYTES_A_TURN, MOST_MESSAGES, ModuleAnswer, ModuleWords, Pace,
    ToModule, VERSION,
};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What the author of a module of an older version is told.
const CHANGES: &str = "; a module in Python needs `rpl_module` of this rpl, and any other one says \
                       `\"protocol\":2` and answers `query`, if its manifest has a [[query]]";

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
    if last_words.is_empty() {
        return String::new();
    }
    let is_missing = |name: &&str| last_words.contains(&format!("No module named '{name}'"));
    let hint = ["rpl_module", "rpl_host"].into_iter().find(is_missing).map(|name| {
        format!("\n`{name}` is installed by `pip install ./python`; or `PYTHONPATH` names the folder `python`")
    });
    format!("; the last it wrote to standard error:\n{last_words}{}", hint.unwrap_or_default())
}

/// A module that runs and has been greeted.
#[derive(Debug)]
pub struct ModuleProcess {
    manifest: Arc<Manifest>,
    folder: PathBuf,
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
        let hello = greeting.hello(&manifest.name, manifest.pace);
        let refused = |Loss { why, last_words }: Loss| {
            let Manifest { name, file, .. } = &*manifest;
            StartError { name: name.clone(), file: file.clone(), why, last_words }
        };
        let process = greeted_process(&manifest, folder, &hello).map_err(refused)?;
        Ok(Self { folder: folder.to_path_buf(), process, unanswered: None, is_lost: false, manifest })
    }

    /// Once it was lost: it is started again, and greeted.
    fn start_again(&mut self, hello: &ToModule) -> ModuleAnswer {
        // Where it is connected to it may have room for one only.
        self.process.end(Duration::ZERO);
        match greeted_process(&self.manifest, &self.folder, hello) {
            Ok(process) => {
                (self.process, self.unanswered, self.is_lost) = (process, None, false);
                ModuleAnswer::default()
            }
            Err(loss) => ModuleAnswer { messages: Vec::new(), loss: Some(loss) },
        }
    }

    /// The number of its process; none if it was not started by us.
    pub fn number(&self) -> Option<u32> {
        self.process.number()
    }

    /// Says the words and gathers what is answered.
    ///
    /// # Errors
    /// What it did instead, as a clause; what it had said before is in `messages`.
    fn turn(&mut self, words: &[ToModule], messages: &mut Vec<FromModule>) -> Result<(), String> {
        let patience = Duration::from_micros(self.manifest.answer_within_us);
        let now = Instant::now();
        let mut question = None;
        for message in words {
            match message {
                ToModule::Tick { .. } if self.unanswered.is_some() => continue,
                ToModule::Tick { time_us, .. } => self.unanswered = Some((*time_us, now)),
                ToModule::Query { id, query, .. } => question = Some((*id, query)),
                ToModule::Hello { .. } | ToModule::Start { .. } | ToModule::Stop { .. } | ToModule::Bye => {}
            }
            tell(&mut self.process, message);
        }
        if self.process.untaken() > 2 * MOST_BYTES_A_TURN {
            return Err("does not read what it is told".to_string());
        }
        // A plan that asks waits for the answer, whatever the pace.
        let until = match (self.manifest.pace, question) {
            (Pace::LockStep, _) | (Pace::Live, Some(_)) => now + patience,
            (Pace::Live, None) => now,
        };
        let mut bytes = 0;
        loop {
            let heard = self.process.listen(until);
            if let Ok(Heard::Nothing) = heard {
                if let Some((_, query)) = question {
                    return Err(format!("did not answer the query `{query}` within {patience:?}"));
                }
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
            let message = message(&mut self.process, heard)?;
            let is_done = matches!(message, FromModule::Done { .. });
            let answers = |id: u64| question.is_some_and(|(asked, _)| asked == id);
            let is_answered = match &message {
                FromModule::Success { id, .. } | FromModule::Failure { id, .. } => answers(*id),
                FromModule::Done { .. } => question.is_none() && self.manifest.pace == Pace::LockStep,
                FromModule::Hello { .. } | FromModule::Fluents { .. } | FromModule::Event { .. } => false,
            };
            messages.push(message);
            if messages.len() > MOST_MESSAGES || bytes > MOST_BYTES_A_TURN {
                return Err(format!(
                    "said more than {MOST_MESSAGES} messages or {} MiB in one turn",
                    MOST_BYTES_A_TURN >> 20
                ));
            }
            if is_done {
                self.unanswered = None;
            }
            if is_answered {
                return Ok(());
            }
        }
    }

    /// Tells it that the run is over, and waits for its end, but not long.
    fn part(&mut self) {
        if !std::mem::replace(&mut self.is_lost, true) {
            tell(&mut self.process, &ToModule::Bye);
            self.process.end(PARTING);
        }
    }
}

/// Who speaks for a module, reached and greeted.
///
/// # Errors
/// It cannot be reached, or does not greet as it should.
fn greeted_process(manifest: &Manifest, folder: &Path, hello: &ToModule) -> Result<Process, Loss> {
    let mut process = reached(manifest, folder).map_err(|why| Loss { why, last_words: String::new() })?;
    match greet(manifest, &mut process, hello) {
        Ok(()) => {
            process.pass_errors_on(&manifest.name);
            Ok(process)
        }
        Err(why) => {
            process.end(Duration::ZERO);
            Err(Loss { why, last_words: process.last_words() })
        }
    }
}

/// # Errors
/// Why it cannot be started or connected to, as a clause.
fn reached(manifest: &Manifest, folder: &Path) -> Result<Process, String> {
    match &manifest.spokesman {
        Spokesman::Command(command) => {
            Process::start(command, folder, MOST_BYTES).map_err(|error| not_started(&command[0], &error))
        }
        Spokesman::Address(address) => {
            let patience = Duration::from_micros(manifest.start_within_us);
            Process::connect(address, patience, MOST_BYTES)
                .map_err(|error| format!("cannot be connected to at `{address}`: {}; start its program first", error))
        }
    }
}

/// # Errors
/// What it did instead of greeting, as a clause.
fn greet(manifest: &Manifest, process: &mut Process, hello: &ToModule) -> Result<(), String> {
    tell(process, hello);
    let patience = Duration::from_micros(manifest.start_within_us);
    let message = match process.listen(Instant::now() + patience) {
        Ok(Heard::Nothing) => Err(format!("did not answer `hello` within {patience:?}")),
        heard => message(process, heard),
    };
    greeted(manifest, &message?)
}

fn tell(process: &mut Process, message: &ToModule) {
    match serde_json::to_vec(message) {
        Ok(line) => process.tell(&line),
        Err(error) => unreachable!("what is said was made of what can be said: {error}"),
    }
}

/// The message in what was heard.
///
/// # Errors
/// What it did instead, as a clause.
fn message(process: &mut Process, heard: io::Result<Heard>) -> Result<FromModule, String> {
    match heard {
        Ok(Heard::Line(line)) => FromModule::read(&line),
        Ok(Heard::TooLong) => Err(format!("said a line of more than {} MiB", MOST_BYTES >> 20)),
        Ok(Heard::Nothing) => Err("did not answer".to_string()),
        Ok(Heard::Closed(rest)) => {
            let how = process.autopsy();
            let rest = String::from_utf8_lossy(&rest);
            Err(if rest.is_empty() { how } else { format!("{how} in the middle of a line: {}", clause(&rest)) })
        }
        Err(error) => Err(format!("cannot be heard: {error}")),
    }
}

/// Whether a module greets as the one of a manifest.
///
/// # Errors
/// What it did instead, as a clause.
pub fn greeted(manifest: &Manifest, message: &FromModule) -> Result<(), String> {
    match message {
        FromModule::Hello { protocol, .. } if *protocol != VERSION => Err(format!(
            "speaks version {protocol} of the protocol, and rpl speaks version {VERSION}{}",
            if *protocol < VERSION { CHANGES } else { "; take a newer rpl" }
        )),
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
            [hello @ ToModule::Hello { .. }] => return Ok(self.start_again(hello)),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_the_package_for_python_is_missing_its_installation_is_told() {
        let missing = told("Traceback\nModuleNotFoundError: No module named 'rpl_module'");
        assert!(missing.ends_with(
            "`rpl_module` is installed by `pip install ./python`; or `PYTHONPATH` names the folder `python`"
        ));
        assert!(!told("ModuleNotFoundError: No module named 'numpy'").contains("pip install"));
        assert_eq!(told(""), "");
    }
}
