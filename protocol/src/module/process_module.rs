//! A module in another process, as the run sees it: a value that asks and is answered turn by turn, and
//! judges what it hears. What it cannot understand loses the module: everything it was doing fails.

use super::manifest::Manifest;
use super::message::{Drive, FromModule, Greeting, Loss, MOST_BYTES, ModuleAnswer, ModuleWords, Pace, ToModule};
use crate::host::PerceptMessage;
use crate::line::{Conversation, LineFault};
use crate::value::{Spoken, is_name};
use rpl_lang::suggest::suggest;
use rpl_lang::symbol::{Symbol, fold_name};
use rpl_lang::visible::clause;
use rpl_robot::geometry::Velocity;
use rpl_robot::localization::Estimate;
use rpl_robot::simulator::Percept;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{BehaviourSpec, Ending, RobotEvent, StopReason};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The valve of a behaviour whose `drive` reaches the wheels.
const WHEELS: &str = "wheels";

/// The class of what becomes of behaviours whose module is lost.
const MODULE_FAILURE: &str = "module-failure";

/// No robot drives or turns faster, in m/s and rad/s.
const FASTEST: f64 = 100.0;

/// A module in another process. A copy shares the line to it.
#[derive(Clone, Debug)]
pub struct ProcessModule {
    manifest: Arc<Manifest>,
    greeting: Greeting,
    conversation: Conversation<ModuleWords, ModuleAnswer>,
    /// What was said between two ticks, beside the answers to questions: it takes effect with the next one.
    heard: ModuleAnswer,
    /// Starts and stops since the last tick.
    unsaid: Vec<ToModule>,
    /// The last activation of each behaviour.
    activations: Vec<Activation>,
    next_id: u64,
    /// What it wants of the wheels.
    drive: Option<Drive>,
    /// The time of the last tick that was answered; none before the first.
    answered_us: Option<u64>,
    /// Why it is not asked any more.
    lost: Option<String>,
    /// How often it may be started again.
    restarts_left: u32,
}

/// What changes of a module: the rest is what it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SavedModule {
    /// Turns that are over.
    turn: u64,
    /// What was not yet said, as JSON.
    unsaid: String,
    /// What was heard and has not taken effect, as JSON.
    heard: String,
    activations: Vec<Activation>,
    next_id: u64,
    drive: Option<Drive>,
    answered_us: Option<u64>,
    lost: Option<String>,
    restarts_left: u32,
}

/// The last activation of a behaviour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Activation {
    #[default]
    Never,
    Active(u64),
    /// The plan has stopped it: the module may have ended it at the same time.
    Stopped(u64),
    /// The module has ended it.
    Ended(u64),
}

/// What came of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct News {
    /// New values of fluents, by their place in the manifest.
    pub fluents: BTreeMap<usize, Reading>,
    /// Behaviours that ended, by their place in the manifest.
    pub endings: Vec<(usize, Ending)>,
    /// Things worth a line in the trace.
    pub events: Vec<RobotEvent>,
    /// What it wants of the wheels.
    pub velocity: Option<Velocity>,
}

impl ProcessModule {
    /// A module at the start of a run, which was greeted.
    pub fn new(
        manifest: Arc<Manifest>,
        greeting: Greeting,
        conversation: Conversation<ModuleWords, ModuleAnswer>,
    ) -> Self {
        let activations = vec![Activation::Never; manifest.behaviours.len()];
        Self {
            restarts_left: manifest.restart,
            manifest,
            greeting,
            conversation,
            heard: ModuleAnswer::default(),
            unsaid: Vec::new(),
            activations,
            next_id: 1,
            drive: None,
            answered_us: None,
            lost: None,
        }
    }

    /// What a saved run has of it.
    pub fn saved(&self) -> SavedModule {
        SavedModule {
            turn: self.conversation.turn(),
            unsaid: written(&self.unsaid),
            heard: written(&self.heard),
            restarts_left: self.restarts_left,
            activations: self.activations.clone(),
            next_id: self.next_id,
            drive: self.drive,
            answered_us: self.answered_us,
            lost: self.lost.clone(),
        }
    }

    /// Goes on where it stood when it was saved.
    ///
    /// # Errors
    /// What was saved is none of this module.
    pub fn restore(&mut self, saved: SavedModule) -> Result<(), String> {
        let name = &self.manifest.name;
        let damaged = |error| format!("what the module `{name}` was to be told, or has said, is damaged: {error}");
        let unsaid = serde_json::from_str(&saved.unsaid).map_err(damaged)?;
        let heard = serde_json::from_str(&saved.heard).map_err(damaged)?;
        if saved.activations.len() != self.activations.len() {
            return Err(format!("the run was saved with other behaviours of the module `{name}`"));
        }
        self.conversation.go_on_at(saved.turn);
        (self.unsaid, self.heard, self.restarts_left) = (unsaid, heard, saved.restarts_left);
        (self.activations, self.next_id) = (saved.activations, saved.next_id);
        (self.drive, self.answered_us, self.lost) = (saved.drive, saved.answered_us, saved.lost);
        Ok(())
    }

    /// Its process was started anew, and knows nothing of what it was told before: behaviours that were at work
    /// are not gone on with, by their place in the manifest. If it was lost, it is there again.
    pub fn renew(&mut self) -> Vec<usize> {
        let mut interrupted = Vec::new();
        for (behaviour, activation) in self.activations.iter_mut().enumerate() {
            match *activation {
                Activation::Active(id) => {
                    *activation = Activation::Ended(id);
                    interrupted.push(behaviour);
                }
                Activation::Never | Activation::Stopped(_) | Activation::Ended(_) => {}
            }
        }
        self.begin_anew();
        self.restarts_left = self.manifest.restart;
        interrupted
    }

    /// Its process knows nothing of what was said before.
    fn begin_anew(&mut self) {
        self.unsaid.clear();
        self.heard = ModuleAnswer::default();
        (self.drive, self.answered_us, self.lost) = (None, None, None);
    }

    /// What it offers.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// Starts a behaviour, by its place in the manifest; it hears of it with the next tick. The ending is
    /// there at once if the module is lost.
    ///
    /// # Errors
    /// The behaviour has no such parameter, or an argument cannot be said.
    pub fn start(
        &mut self,
        machine: &Machine,
        behaviour: usize,
        arguments: &[(Symbol, Value)],
        time_us: u64,
    ) -> Result<Option<Ending>, Raise> {
        let spec = &self.manifest.behaviours[behaviour];
        let said = arguments_said(spec, machine, arguments)?;
        if let Some(reason) = &self.lost {
            return Ok(Some(self.failure(reason)));
        }
        if spec.valve.as_deref() == Some(WHEELS) {
            // What an activation before this one wanted is not what this one wants.
            self.drive = None;
        }
        let id = self.next_id;
        self.next_id += 1;
        self.activations[behaviour] = Activation::Active(id);
        self.unsaid.push(ToModule::Start { id, behaviour: spec.name.to_string(), arguments: said, time_us });
        Ok(None)
    }

    /// Stops a behaviour, by its place in the manifest; it hears of it with the next tick.
    pub fn stop(&mut self, behaviour: usize, why: StopReason) {
        let Activation::Active(id) = self.activations[behaviour] else { return };
        self.activations[behaviour] = Activation::Stopped(id);
        let name = self.manifest.behaviours[behaviour].name.to_string();
        self.unsaid.push(ToModule::Stop { id, behaviour: name, reason: why.into() });
    }

    /// Asks it a question, in the middle of an instant. It has heard before of all that was started and stopped.
    ///
    /// # Errors
    /// The failure that it answers with, or that of a lost module.
    pub fn ask(&mut self, query: &str, arguments: Vec<Spoken>, time_us: u64) -> Result<Reading, Ending> {
        if let Some(reason) = self.lost.as_ref().or(self.heard.loss.as_ref().map(|loss| &loss.why)) {
            return Err(self.failure(reason));
        }
        let id = self.next_id;
        self.next_id += 1;
        let mut words = std::mem::take(&mut self.unsaid);
        words.push(ToModule::Query { id, query: query.to_string(), arguments, time_us });
        let answer = self.conversation.say(&ModuleWords(words)).unwrap_or_else(unasked);
        let mut found = None;
        for message in answer.messages {
            match message {
                FromModule::Success { id: of, value } if of == id => {
                    found = Some(Ok(value.map_or(Reading::Truth(false), |value| value.0)));
                }
                FromModule::Failure { id: of, class, message, slots } if of == id => {
                    found = Some(Err(failed(class, message, slots)));
                }
                message => self.heard.messages.push(message),
            }
        }
        self.heard.loss = answer.loss;
        match (found, &self.heard.loss) {
            (Some(Ok(reading)), _) => Ok(reading),
            (Some(Err(Ok(failure))), _) => Err(failure),
            (Some(Err(Err(why))), _) => Err(self.failure(&why)),
            (None, Some(loss)) => Err(self.failure(&loss.why)),
            (None, None) => Err(self.failure("did not answer")),
        }
    }

    /// A module that was lost is started again, as often as its manifest allows. Whether it works.
    fn starts_again(&mut self, news: &mut News) -> bool {
        let Some(left) = self.restarts_left.checked_sub(1) else { return false };
        self.restarts_left = left;
        let hello = self.greeting.hello(&self.manifest.name, self.manifest.pace);
        let answer = self.conversation.say(&ModuleWords(vec![hello])).unwrap_or_else(unasked);
        if let Some(loss) = answer.loss {
            self.lose(loss, news);
            return false;
        }
        self.begin_anew();
        news.events.push(RobotEvent {
            what: "module started again".into(),
            details: vec![("module".into(), self.manifest.name.clone()), ("left".into(), left.to_string())],
        });
        true
    }

    /// One step: the module hears of it, and of what it wants of the robot if there is one, and answers.
    pub fn step(&mut self, time_us: u64, robot: Option<(Estimate, &Percept)>) -> News {
        let mut news = News::default();
        let heard = std::mem::take(&mut self.heard);
        self.take_early(heard, time_us, &mut news);
        if self.lost.is_some() && !self.starts_again(&mut news) {
            return news;
        }
        let Manifest { wants_position, wants_percept, .. } = *self.manifest;
        let mut words = std::mem::take(&mut self.unsaid);
        words.push(ToModule::Tick {
            time_us,
            position: robot.filter(|_| wants_position).map(|(estimate, _)| estimate.into()),
            percept: robot
                .filter(|_| wants_percept)
                .map(|(_, percept)| Box::new(PerceptMessage::new(self.conversation.turn(), None, percept))),
        });
        let answer = self.conversation.say(&ModuleWords(words)).unwrap_or_else(unasked);
        self.take(answer, time_us, &mut news);
        news.velocity = self.velocity();
        news
    }

    /// Takes in what was said since the last tick.
    fn take_early(&mut self, heard: ModuleAnswer, time_us: u64, news: &mut News) {
        for message in heard.messages {
            if let Err(why) = self.hear(message, time_us, news) {
                // It may have said more about it on its standard error.
                let end = self.conversation.say(&ModuleWords(vec![ToModule::Bye]));
                let last_words = end.ok().and_then(|end| end.loss).map(|loss| loss.last_words).unwrap_or_default();
                return self.lose(Loss { why, last_words }, news);
            }
        }
        if let Some(loss) = heard.loss {
            self.lose(loss, news);
        }
    }

    /// Takes in what was answered to the tick of a time.
    fn take(&mut self, answer: ModuleAnswer, time_us: u64, news: &mut News) {
        self.take_early(answer, time_us, news);
        match self.lost {
            Some(_) => {}
            None if self.manifest.pace == Pace::LockStep && self.answered_us != Some(time_us) => {
                self.lose(Loss { why: "did not answer the tick".to_string(), last_words: String::new() }, news);
            }
            None => {}
        }
    }

    /// Takes in one message.
    ///
    /// # Errors
    /// What is wrong with it, as a clause.
    fn hear(&mut self, message: FromModule, time_us: u64, news: &mut News) -> Result<(), String> {
        match message {
            FromModule::Hello { .. } => Err("said `hello` again".to_string()),
            FromModule::Fluents { values } => {
                for (name, value) in values {
                    let (fluent, reading) = self.fluent(&name, value)?;
                    news.fluents.insert(fluent, reading);
                }
                Ok(())
            }
            FromModule::Success { id, value } => {
                let value = value.map_or(Ending::DONE, |value| Ending::Success(value.0));
                self.end(id, value, news)
            }
            FromModule::Failure { id, class, message, slots } => {
                let ending = failed(class, message, slots)?;
                self.end(id, ending, news)
            }
            FromModule::Event { what, details } => {
                let what = format!("{}: {what}", self.manifest.name);
                let details = details.into_iter().map(|(name, value)| (name.into(), shown(&value))).collect();
                news.events.push(RobotEvent { what: what.into(), details });
                Ok(())
            }
            FromModule::Done { time_us: answered_us, drive } => {
                self.answered(answered_us, time_us)?;
                let speeds = drive.iter().flat_map(|drive| [drive.translation_mps, drive.rotation_radps]);
                if let Some(speed) = speeds.into_iter().find(|speed| speed.abs() > FASTEST) {
                    return Err(format!(
                        "wants the wheels to go at {speed:e}, and {FASTEST} m/s and rad/s are the most"
                    ));
                }
                self.drive = drive;
                Ok(())
            }
        }
    }

    /// # Errors
    /// That tick was answered before, or has not been.
    fn answered(&mut self, answered_us: u64, time_us: u64) -> Result<(), String> {
        let told = |what: &str| Err(format!("said `done` for the tick at {answered_us} us, {what}"));
        match self.answered_us {
            _ if answered_us > time_us => told(&format!("and it is {time_us} us")),
            Some(before_us) if answered_us <= before_us => told("which it had answered"),
            _ if self.manifest.pace == Pace::LockStep && answered_us < time_us => {
                told(&format!("and was asked at {time_us} us"))
            }
            Some(_) | None => {
                self.answered_us = Some(answered_us);
                Ok(())
            }
        }
    }

    /// A fluent's place in the manifest, and a value for it.
    fn fluent(&self, name: &str, value: Spoken) -> Result<(usize, Reading), String> {
        let fluents = &self.manifest.fluents;
        let folded = fold_name(name);
        let Some(place) = fluents.iter().position(|fluent| fluent.spec.name == folded) else {
            let known = fluents.iter().map(|fluent| &*fluent.spec.name);
            let meant = suggest(&folded, known).map(|meant| format!("; did it mean `{meant}`?")).unwrap_or_default();
            let name = clause(name);
            return Err(format!("set the fluent `{name}`, which its manifest does not have{meant}"));
        };
        let kind = fluents[place].kind;
        let found = shown(&value);
        let reading = kind.held(value.0);
        let reading =
            reading.ok_or_else(|| format!("set `{name}` to {found}, and its manifest says: {}", kind.name()))?;
        Ok((place, reading))
    }

    /// An activation ended by itself.
    fn end(&mut self, id: u64, ending: Ending, news: &mut News) -> Result<(), String> {
        if id == 0 || id >= self.next_id {
            return Err(format!("ended the activation {id}, which there is not"));
        }
        for (behaviour, activation) in self.activations.iter_mut().enumerate() {
            match *activation {
                Activation::Active(active) if active == id => {
                    *activation = Activation::Ended(id);
                    news.endings.push((behaviour, ending));
                    return Ok(());
                }
                Activation::Ended(ended) if ended == id => {
                    let name = &self.manifest.behaviours[behaviour].name;
                    return Err(format!("ended the activation {id} of `{name}` twice"));
                }
                Activation::Never | Activation::Active(_) | Activation::Stopped(_) | Activation::Ended(_) => {}
            }
        }
        // It was stopped, and the module has not heard of it in time.
        Ok(())
    }

    /// The module is asked no more, and all that it was doing fails.
    fn lose(&mut self, loss: Loss, news: &mut News) {
        let Loss { why, last_words } = loss;
        let last_words = if last_words.is_empty() {
            String::new()
        } else {
            format!("; the last it wrote to standard error:\n{last_words}")
        };
        let reason = format!("{why}{last_words}");
        news.events.push(RobotEvent {
            what: "module lost".into(),
            details: vec![("module".into(), self.manifest.name.clone()), ("why".into(), reason.clone())],
        });
        let failure = self.failure(&reason);
        for (behaviour, activation) in self.activations.iter_mut().enumerate() {
            if let Activation::Active(id) = *activation {
                *activation = Activation::Ended(id);
                news.endings.push((behaviour, failure.clone()));
            }
        }
        self.lost = Some(reason);
    }

    fn failure(&self, reason: &str) -> Ending {
        let name = &self.manifest.name;
        let slots = [("module", name.as_str()), ("reason", reason)];
        Ending::Failure {
            class: MODULE_FAILURE.to_string(),
            message: format!("the module `{name}` {reason}"),
            slots: slots.map(|(slot, text)| (slot.to_string(), Reading::Text(text.to_string()))).to_vec(),
        }
    }

    /// What it wants of the wheels, if a behaviour of it that holds them is at work.
    fn velocity(&self) -> Option<Velocity> {
        let drives = |(spec, activation): (&BehaviourSpec, &Activation)| {
            spec.valve.as_deref() == Some(WHEELS) && matches!(activation, Activation::Active(_))
        };
        let is_driving = self.manifest.behaviours.iter().zip(&self.activations).any(drives);
        let Drive { translation_mps, rotation_radps } = self.drive.filter(|_| is_driving && self.lost.is_none())?;
        Some(Velocity { translation_mps, rotation_radps })
    }
}

/// The failure that a module says.
///
/// # Errors
/// Its class or a slot is no name, as a clause.
fn failed(class: String, message: String, slots: BTreeMap<String, Spoken>) -> Result<Ending, String> {
    let class = fold_name(&class).into_owned();
    if let Some(name) = [&class].into_iter().chain(slots.keys()).find(|name| !is_name(name)) {
        return Err(format!("said a failure with \"{}\", which is no name", clause(name)));
    }
    let slots = slots.into_iter().map(|(name, value)| (fold_name(&name).into_owned(), value.0)).collect();
    Ok(Ending::Failure { class, message, slots })
}

/// The answer of a module to which nothing can be said.
fn unasked(fault: LineFault) -> ModuleAnswer {
    let loss = Loss { why: format!("cannot be asked: {}", fault.0), last_words: String::new() };
    ModuleAnswer { messages: Vec::new(), loss: Some(loss) }
}

/// A part of a saved module.
fn written(value: &impl Serialize) -> String {
    match serde_json::to_string(value) {
        Ok(text) => text,
        Err(error) => unreachable!("what is said and heard can be written: {error}"),
    }
}

/// The arguments of a behaviour as they are said.
///
/// # Errors
/// It has no such parameter, or they cannot be said.
fn arguments_said(
    spec: &BehaviourSpec,
    machine: &Machine,
    arguments: &[(Symbol, Value)],
) -> Result<BTreeMap<String, Spoken>, Raise> {
    let mut said = BTreeMap::new();
    for &(key, value) in arguments {
        let key = machine.symbols.name(key);
        if !spec.parameters.split_whitespace().any(|known| known.strip_prefix(':') == Some(key)) {
            let known = if spec.parameters.is_empty() { "none" } else { &*spec.parameters };
            let message = format!("`{}` has no parameter `:{key}`; it has {known}", spec.name);
            return Err(Raise::type_error(message));
        }
        let value = Spoken::of(machine, value).map_err(|reason| {
            Raise::type_error(format!("`:{key}` of `{}` cannot be told to its module: {reason}", spec.name))
        })?;
        said.insert(key.to_string(), value);
    }
    let bytes = serde_json::to_vec(&said).map_or(usize::MAX, |text| text.len());
    if bytes > MOST_BYTES / 2 {
        let message = format!("the arguments of `{}` are too long to be told to its module: {bytes} bytes", spec.name);
        return Err(Raise::type_error(message));
    }
    Ok(said)
}

/// A value as it is shown in messages.
fn shown(value: &Spoken) -> String {
    match serde_json::to_string(value) {
        Ok(text) => clause(&text),
        Err(error) => unreachable!("what was heard can be said again: {error}"),
    }
}
