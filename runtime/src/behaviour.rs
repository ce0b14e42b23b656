//! Behaviours: continuous processes outside the plan, and the seam to the robot that runs them.

use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::task::{Waiting, Wake};
use crate::state::value::{TaskRef, Value};
use crate::step::native::Surroundings;
use rpl_lang::check::BehaviourSignature;
use rpl_lang::code::Program;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::any::Any;

/// A behaviour, as plans see it.
#[derive(Clone, Copy, Debug)]
pub struct BehaviourSpec {
    /// Its name.
    pub name: &'static str,
    /// What it does.
    pub doc: &'static str,
    /// The valve it needs, if it drives.
    pub valve: Option<&'static str>,
    /// Its keyword arguments.
    pub parameters: &'static str,
}

impl BehaviourSpec {
    /// What a check of a plan needs to know.
    pub fn signature(&self) -> BehaviourSignature {
        let parameters = self.parameters.split_whitespace().map(|key| key.trim_start_matches(':').to_string());
        BehaviourSignature { parameters: parameters.collect(), valve: self.valve.map(str::to_string) }
    }
}

/// A fluent the robot sets.
#[derive(Clone, Copy, Debug)]
pub struct FluentSpec {
    /// Its name.
    pub name: &'static str,
    /// What it holds, with its unit.
    pub doc: &'static str,
}

/// A value the robot gives to a fluent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reading {
    /// `nil` or `t`.
    Truth(bool),
    /// An integer.
    Int(i64),
    /// A float.
    Float(f64),
    /// A symbol.
    Symbol(String),
}

/// Why a behaviour stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stop {
    /// A plan deactivates it.
    Deactivated,
    /// Its valve is lent to somebody else, or its goals are removed: it commands nothing more.
    Interrupted,
}

/// How a behaviour ended by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Ending {
    /// It has done what it was asked to.
    Success,
    /// It cannot.
    Failure {
        /// The class of failure.
        class: String,
        /// One sentence.
        message: String,
        /// Slots by name.
        slots: Vec<(String, Reading)>,
    },
}

impl Ending {
    /// A failure without slots: its class and one sentence.
    pub fn failure(class: &str, message: impl Into<String>) -> Self {
        Ending::Failure { class: class.to_string(), message: message.into(), slots: Vec::new() }
    }
}

/// What the robot has to tell after a step, a start or a stop.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outbox {
    /// New values of fluents, by their number in [`Outside::fluents`]; applied as one.
    pub fluents: Vec<(usize, Reading)>,
    /// Behaviours that ended.
    pub endings: Vec<(u16, Ending)>,
    /// Things worth a line in the trace: what happened, and details by name.
    pub events: Vec<(String, Vec<(String, String)>)>,
}

/// The robot, as the machine sees it.
pub trait Outside: Any {
    /// Its behaviours; their number is their place here.
    fn behaviours(&self) -> &'static [BehaviourSpec];

    /// Its fluents.
    fn fluents(&self) -> &'static [FluentSpec];

    /// Its valves.
    fn valves(&self) -> &'static [&'static str];

    /// Starts a behaviour.
    ///
    /// # Errors
    /// What is wrong with the arguments, or why it cannot start.
    fn start(
        &mut self,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise>;

    /// Stops a behaviour.
    fn stop(&mut self, behaviour: u16, how: Stop, outbox: &mut Outbox);

    /// The name of the stream of random numbers that plans draw from in front of this.
    fn stream(&self) -> &'static str {
        "plan"
    }

    /// Microseconds between two steps; none if there is no robot.
    fn period_us(&self) -> Option<u64> {
        None
    }

    /// One step: commands go out, percepts come in, behaviours work.
    fn step(&mut self, _outbox: &mut Outbox) {}

    /// For native functions of the robot itself.
    fn as_any(&mut self) -> &mut dyn Any;
}

/// No robot: nothing to activate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NoRobot;

impl Outside for NoRobot {
    fn behaviours(&self) -> &'static [BehaviourSpec] {
        &[]
    }

    fn fluents(&self) -> &'static [FluentSpec] {
        &[]
    }

    fn valves(&self) -> &'static [&'static str] {
        &[]
    }

    fn start(&mut self, _: &Machine, _: u16, _: &[(Symbol, Value)], _: &mut Outbox) -> Result<(), Raise> {
        Err(Raise::new("no-robot", "there is no robot; add `--world dept`"))
    }

    fn stop(&mut self, _: u16, _: Stop, _: &mut Outbox) {}

    fn as_any(&mut self) -> &mut dyn Any {
        self
    }
}

/// Where a behaviour stands, seen from the plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Not activated.
    #[default]
    Inactive,
    /// At work.
    Active,
    /// It has lost its valve or its goals.
    Interrupted,
    /// It has ended by itself.
    Done,
}

/// One behaviour's activation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Activation {
    /// Where it stands.
    pub phase: Phase,
    /// Who activated it.
    pub task: Option<TaskRef>,
    /// A signal nobody has taken yet: success, or a failure.
    pub signal: Option<Result<(), Value>>,
    /// Signals that activations before this one left to their tasks, which have not run since.
    pub kept: Vec<(TaskRef, Result<(), Value>)>,
}

impl Activation {
    /// The failures in the signals nobody has taken yet.
    pub(crate) fn failures(&self) -> impl Iterator<Item = Value> {
        let signals = self.signal.iter().chain(self.kept.iter().map(|(_, signal)| signal));
        signals.filter_map(|signal| signal.err())
    }
}

impl Machine {
    /// Lets the robot's news take effect: all fluents as one assignment, then signals.
    pub fn apply_outbox(&mut self, around: &mut Surroundings<'_>, outbox: Outbox) {
        for (what, details) in &outbox.events {
            self.trace_robot(what, details);
        }
        let specs = around.outside.fluents();
        let mut values = Vec::new();
        for (number, reading) in outbox.fluents {
            let Some(spec) = specs.get(number) else { continue };
            let value = self.reading_value(reading);
            if let Some(fluent) = self.system_fluent(around.program, spec.name) {
                values.push((fluent, value));
            }
        }
        self.assign_all(around, &values);
        for (behaviour, ending) in outbox.endings {
            self.behaviour_ended(around, behaviour, ending);
        }
    }

    fn reading_value(&mut self, reading: Reading) -> Value {
        match reading {
            Reading::Truth(truth) => Value::truth(truth),
            Reading::Int(value) => Value::Int(value),
            Reading::Float(value) => Value::Float(value),
            Reading::Symbol(name) => Value::Symbol(self.symbols.intern(&name)),
        }
    }

    fn system_fluent(&mut self, program: &Program, name: &str) -> Option<u32> {
        let symbol = self.symbols.find(name)?;
        let global = *program.names.get(&symbol)?;
        match self.globals.get(global as usize) {
            Some(Value::Fluent(fluent)) => Some(*fluent),
            _ => None,
        }
    }

    fn behaviour_ended(&mut self, around: &mut Surroundings<'_>, behaviour: u16, ending: Ending) {
        let signal = match ending {
            Ending::Success => Ok(()),
            Ending::Failure { class, message, slots } => Err(self.behaviour_failure(behaviour, &class, message, slots)),
        };
        self.activation(behaviour).phase = Phase::Done;
        self.signal(around, behaviour, signal);
        let owner = self.activation(behaviour).task;
        self.release_activation(around, behaviour, owner);
    }

    fn behaviour_failure(
        &mut self,
        behaviour: u16,
        class: &str,
        message: String,
        slots: Vec<(String, Reading)>,
    ) -> Value {
        let class = self.symbols.intern(class);
        let mut values = vec![(self.symbols.intern("behaviour"), Value::Behaviour(behaviour))];
        for (name, reading) in slots {
            values.push((self.symbols.intern(&name), self.reading_value(reading)));
        }
        let task = self.activation(behaviour).task.and_then(|task| self.tasks.find(task));
        self.new_failure(task.unwrap_or(self.current), class, message, values)
    }

    /// Keeps a signal until somebody takes it, and wakes who waits for it.
    fn signal(&mut self, around: &mut Surroundings<'_>, behaviour: u16, signal: Result<(), Value>) {
        self.trace_signal(around, behaviour, &signal);
        let waiting =
            self.living_tasks().into_iter().find(|&task| self.tasks[task].waiting == Waiting::Signal(behaviour));
        match waiting {
            Some(task) => {
                let wake = match signal {
                    Ok(()) => Wake::Value(Value::True),
                    Err(failure) => Wake::Raise(failure),
                };
                self.wake(task, wake);
            }
            None => self.activation(behaviour).signal = Some(signal),
        }
    }

    pub(crate) fn activation(&mut self, behaviour: u16) -> &mut Activation {
        let at = usize::from(behaviour);
        if self.activations.len() <= at {
            self.activations.resize(at + 1, Activation::default());
        }
        &mut self.activations[at]
    }

    /// `(activate B :key V...)` by the current task.
    pub(crate) fn activate(
        &mut self,
        around: &mut Surroundings<'_>,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
    ) -> Result<(), Raise> {
        let spec = around.outside.behaviours()[usize::from(behaviour)];
        let task = self.current;
        let me = self.tasks.reference(task);
        let entry = self.activation(behaviour).clone();
        let other = entry.task.and_then(|owner| self.tasks.find_alive(owner)).filter(|&owner| owner != task);
        if let (Phase::Active, Some(owner)) = (entry.phase, other) {
            let path = self.path(owner);
            return Err(Raise::new("behaviour-failure", format!("`{}` is already activated by {path}", spec.name)));
        }
        let valve = spec.valve.and_then(|name| self.valve_named(around.program, name));
        if let Some(valve) = valve
            && !self.holds_valve(task, valve)
        {
            let name = spec.valve.unwrap_or_default();
            return Err(Raise::new(
                "valve-error",
                format!(
                    "`{}` drives with the valve `{name}`, and this task does not hold it; wrap it in `(with-valve {name} …)`",
                    spec.name
                ),
            ));
        }
        if entry.phase == Phase::Active {
            self.stop_behaviour(around, behaviour, Stop::Deactivated);
        }
        let mut outbox = Outbox::default();
        around.outside.start(self, behaviour, arguments, &mut outbox)?;
        let mut kept = entry.kept;
        kept.retain(|(owner, _)| *owner != me);
        if let (Some(owner), Some(signal)) = (other, entry.signal) {
            kept.push((self.tasks.reference(owner), signal));
        }
        *self.activation(behaviour) = Activation { phase: Phase::Active, task: Some(me), signal: None, kept };
        if let Some(valve) = valve {
            self.hold_for_activation(task, valve, behaviour);
        }
        self.trace_behaviour(around, behaviour, "activated");
        self.apply_outbox(around, outbox);
        Ok(())
    }

    fn valve_named(&self, program: &Program, name: &str) -> Option<u32> {
        let global = *program.names.get(&self.symbols.find(name)?)?;
        match self.globals.get(global as usize) {
            Some(Value::Valve(valve)) => Some(*valve),
            _ => None,
        }
    }

    /// `(deactivate B)` by the current task: touches only what it or a descendant activated.
    pub(crate) fn deactivate(&mut self, around: &mut Surroundings<'_>, behaviour: u16) {
        let mut kept = std::mem::take(&mut self.activation(behaviour).kept);
        kept.retain(|(owner, _)| !self.tasks.find(*owner).is_some_and(|owner| self.is_within(owner, self.current)));
        self.activation(behaviour).kept = kept;
        let entry = self.activation(behaviour);
        let (phase, owner) = (entry.phase, entry.task);
        let owner = owner.and_then(|owner| self.tasks.find(owner));
        if phase == Phase::Inactive || !owner.is_some_and(|owner| self.is_within(owner, self.current)) {
            return;
        }
        self.stop_behaviour(around, behaviour, Stop::Deactivated);
    }

    fn stop_behaviour(&mut self, around: &mut Surroundings<'_>, behaviour: u16, how: Stop) {
        let mut outbox = Outbox::default();
        around.outside.stop(behaviour, how, &mut outbox);
        match how {
            Stop::Deactivated => {
                self.trace_behaviour(around, behaviour, "deactivated");
                let before = std::mem::take(self.activation(behaviour));
                self.activation(behaviour).kept = before.kept;
                self.release_activation(around, behaviour, before.task);
                self.apply_outbox(around, outbox);
            }
            Stop::Interrupted => {
                self.trace_behaviour(around, behaviour, "interrupted");
                self.activation(behaviour).phase = Phase::Interrupted;
                self.apply_outbox(around, outbox);
                let message = "the behaviour was interrupted".to_string();
                let failure = self.behaviour_failure(behaviour, "interrupted", message, Vec::new());
                self.signal(around, behaviour, Err(failure));
            }
        }
    }

    /// A behaviour loses its valve.
    pub(crate) fn interrupt_behaviour(&mut self, around: &mut Surroundings<'_>, behaviour: u16) {
        if self.activation(behaviour).phase == Phase::Active {
            self.stop_behaviour(around, behaviour, Stop::Interrupted);
        }
    }

    /// A behaviour loses its goals, if the current task or a descendant activated it.
    pub fn remove_goals(&mut self, around: &mut Surroundings<'_>, behaviour: u16) {
        let entry = self.activation(behaviour).clone();
        let owner = entry.task.and_then(|owner| self.tasks.find(owner));
        if entry.phase == Phase::Active && owner.is_some_and(|owner| self.is_within(owner, self.current)) {
            self.stop_behaviour(around, behaviour, Stop::Interrupted);
            self.release_activation(around, behaviour, entry.task);
        }
    }

    /// What a dead task had activated stops.
    pub(crate) fn end_activations_of(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let me = self.tasks.reference(task);
        for behaviour in 0..self.activations.len() as u16 {
            let entry = &mut self.activations[usize::from(behaviour)];
            entry.kept.retain(|(owner, _)| *owner != me);
            if entry.task == Some(me) && entry.phase != Phase::Inactive {
                self.stop_behaviour(around, behaviour, Stop::Deactivated);
            }
        }
    }

    /// `(await-signal B)`: takes the signal, or waits for it.
    pub(crate) fn await_signal(&mut self, behaviour: u16) -> Result<bool, Raise> {
        match self.take_signal(behaviour) {
            Some(Ok(())) => Ok(true),
            Some(Err(failure)) => Err(Raise::Again(failure)),
            None => {
                let task = self.current;
                self.tasks[task].waiting = Waiting::Signal(behaviour);
                Ok(false)
            }
        }
    }

    /// The signal that an earlier activation left to a task above or below the current one, or the
    /// signal of the activation of now.
    fn take_signal(&mut self, behaviour: u16) -> Option<Result<(), Value>> {
        let (current, tasks) = (self.current, &self.tasks);
        let kept = self.activations.get(usize::from(behaviour)).map_or(&[][..], |entry| &entry.kept);
        let own = kept.iter().position(|(owner, _)| {
            let owner = tasks.find(*owner);
            owner.is_some_and(|owner| self.is_within(owner, current) || self.is_within(current, owner))
        });
        let entry = self.activation(behaviour);
        match own {
            Some(at) => Some(entry.kept.remove(at).1),
            None => entry.signal.take(),
        }
    }
}
