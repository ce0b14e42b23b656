//! The seam to the robot: what plans see of it, and what it has to tell.
//!
//! A robot implements [`Outside`]: tables of behaviours, fluents and valves, which may be made at run time; a step; and
//! an outbox of readings (truths, numbers, symbols, texts, lists), endings and events. Where its names stand in a
//! program is found once, when the library is compiled.

pub mod reading;
pub mod thinking;

use self::reading::Reading;
use self::thinking::{Insight, Thought, Ticket};
use crate::state::activation::Phases;
use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::projected::Grain;
use crate::state::value::Value;
use rpl_lang::check::BehaviourSignature;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::any::{Any, TypeId};
use std::borrow::Cow;
use std::sync::Arc;

/// A behaviour, as plans see it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BehaviourSpec {
    /// Its name.
    pub name: Cow<'static, str>,
    /// What it does.
    pub doc: Cow<'static, str>,
    /// The valve it needs, if it drives.
    pub valve: Option<Cow<'static, str>>,
    /// Its keyword arguments.
    pub parameters: Cow<'static, str>,
}

impl BehaviourSpec {
    /// What a check of a plan needs to know.
    pub fn signature(&self) -> BehaviourSignature {
        let parameters = self.parameters.split_whitespace().map(|key| key.trim_start_matches(':').to_string());
        BehaviourSignature { parameters: parameters.collect(), valve: self.valve.as_deref().map(str::to_string) }
    }
}

/// A fluent the robot sets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FluentSpec {
    /// Its name.
    pub name: Cow<'static, str>,
    /// What it holds, with its unit.
    pub doc: Cow<'static, str>,
    /// Whether it changes with every step of the robot: a trace that told each change would tell
    /// nothing else.
    pub continuous: bool,
    /// The number it holds before the robot tells one: what counts something counts from the start. The
    /// others hold nil.
    pub first: Option<i64>,
}

/// What plans see of a robot. A behaviour, a fluent and a valve are known by their place here.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RobotTables {
    /// Its behaviours.
    pub behaviours: Vec<BehaviourSpec>,
    /// Its fluents.
    pub fluents: Vec<FluentSpec>,
    /// Names of its valves.
    pub valves: Vec<Cow<'static, str>>,
}

impl RobotTables {
    /// What no robot offers: nothing.
    pub const EMPTY: &'static Self = &Self { behaviours: Vec::new(), fluents: Vec::new(), valves: Vec::new() };

    /// The names of everything in them.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        let behaviours = self.behaviours.iter().map(|behaviour| &behaviour.name);
        let fluents = self.fluents.iter().map(|fluent| &fluent.name);
        behaviours.chain(&self.valves).chain(fluents).map(|name| &**name)
    }

    /// Names of the fluents that change with every step.
    pub fn continuous_fluents(&self) -> impl Iterator<Item = &str> {
        self.fluents.iter().filter(|fluent| fluent.continuous).map(|fluent| &*fluent.name)
    }
}

/// Where a robot's names stand among the globals of a program: found once, when the library is
/// compiled.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RobotGlobals {
    /// Of each fluent, by its number.
    pub fluents: Vec<u32>,
    /// Of the valve of each behaviour that has one.
    pub valves: Vec<Option<u32>>,
}

impl RobotGlobals {
    /// Without a robot.
    pub(crate) const NONE: &'static Self = &Self { fluents: Vec::new(), valves: Vec::new() };
}

/// Why a behaviour stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum StopReason {
    /// A plan deactivates it.
    Deactivated,
    /// Its valve is lent to somebody else, or its goals are removed: it commands nothing more.
    Interrupted,
}

/// How a behaviour ended by itself.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// It has done what it was asked to. The reading is the value of its signal.
    Success(Reading),
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
    /// It has done what it was asked to, and there is no more to say of it.
    pub const DONE: Self = Ending::Success(Reading::Truth(true));

    /// A failure without slots: its class and one sentence.
    pub fn failure(class: &str, message: impl Into<String>) -> Self {
        Ending::Failure { class: class.to_string(), message: message.into(), slots: Vec::new() }
    }
}

/// What the robot has to tell after a step, a start or a stop.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outbox {
    /// New values of fluents, by their place in [`RobotTables::fluents`]; applied as one.
    pub fluents: Vec<(usize, Reading)>,
    /// Behaviours that ended.
    pub endings: Vec<(u16, Ending)>,
    /// Behaviours that are not gone on with: what did them was started anew.
    pub interrupted: Vec<u16>,
    /// Things worth a line in the trace.
    pub events: Vec<RobotEvent>,
    /// Questions that were answered ([`Outside::think`]); without an answer they are to be asked again.
    pub answers: Vec<(Ticket, Option<Insight>)>,
    /// The robot is gone, told once: one sentence that says why. It makes no step any more
    /// ([`Outside::next_event_us`]), and the main task fails.
    pub lost: Option<String>,
}

/// Something that happened to the robot or around it, as the trace tells it. What can happen is the
/// robot's own business.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotEvent {
    /// What happened.
    pub what: Cow<'static, str>,
    /// Details by name.
    pub details: Vec<(Cow<'static, str>, String)>,
}

/// When what never happens by itself happens: after the end of the clock.
pub const NEVER_US: u64 = u64::MAX;

/// The robot, as the machine sees it.
pub trait Outside: 'static {
    /// What plans see of it: always the same.
    fn tables(&self) -> &RobotTables;

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
    fn stop(&mut self, behaviour: u16, why: StopReason, outbox: &mut Outbox);

    /// The name of the stream that `random` draws from in a run with this outside. A scenario has one of
    /// its own, so that it and its plan draw different numbers.
    fn stream(&self) -> &'static str {
        "plan"
    }

    /// When it makes its next step, if it made the last one at `stepped_us`: [`NEVER_US`] if nothing will
    /// happen to it by itself; none if there is no robot, or if it is gone.
    fn next_event_us(&self, _stepped_us: u64) -> Option<u64> {
        None
    }

    /// Whether it makes a step in an instant that the run has come to, for whatever reason. A robot whose
    /// readings follow time between its events says so in every instant.
    fn steps_at(&self, stepped_us: u64, now_us: u64) -> bool {
        self.next_event_us(stepped_us).is_some_and(|next_us| next_us <= now_us)
    }

    /// The charge of its battery, in thousandths; none if it has no battery that it knows of.
    fn charge_permille(&self) -> Option<u16> {
        None
    }

    /// What lies outside the run was started anew, between two steps, because the process of the run had ended:
    /// what it was doing is not gone on with, and what was known of the world may not hold any more. Whether
    /// there is such a thing; a run whose world is a part of it has none.
    fn renew(&mut self, _outbox: &mut Outbox) -> bool {
        false
    }

    /// One step: commands go out, percepts come in, behaviours work. Which of them do is told by
    /// their phases.
    fn step(&mut self, _now_us: u64, _phases: Phases<'_>, _outbox: &mut Outbox) {}

    /// The robot as projected runs have it from here on, in this grain: made of what it knows and believes, and of
    /// nothing else. The phases say what its behaviours are doing.
    ///
    /// # Errors
    /// There is no model to project it by; one sentence that says what is missing.
    fn foresee(&self, _now_us: u64, _phases: Phases<'_>, _grain: Grain) -> Result<ForeseenRobot, Raise> {
        Err(Raise::new("projection-failure", "there is no model of this robot to project it by"))
    }

    /// Takes a question that is to be thought about beside the run, because the world goes on while the run
    /// computes; or gives it back, and it is answered at once.
    ///
    /// # Errors
    /// There are too many.
    fn think(&mut self, _ticket: Ticket, thought: Arc<dyn Thought>) -> Result<Option<Arc<dyn Thought>>, Raise> {
        Ok(Some(thought))
    }

    /// Tells which of the questions that were taken are answered now. Those that nobody waits for any more are
    /// given up.
    fn answers(&mut self, _is_awaited: &dyn Fn(Ticket) -> bool, _outbox: &mut Outbox) {}

    /// The part of the robot that is of a type, if it has one: what native functions of that part work
    /// on ([`Call::part`](crate::step::native::Call::part)).
    fn part(&mut self, _of: TypeId) -> Option<&mut dyn Any> {
        None
    }
}

impl Raise {
    /// Something of a robot is asked for, and there is none.
    pub fn no_robot() -> Self {
        Raise::new("no-robot", "there is no robot; add `--world dept`")
    }

    /// The robot is gone, and this is why.
    pub fn robot_lost(why: impl Into<String>) -> Self {
        Raise::new("host-failure", why)
    }
}

/// No robot: nothing to activate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NoRobot;

impl Outside for NoRobot {
    fn tables(&self) -> &RobotTables {
        RobotTables::EMPTY
    }

    fn start(&mut self, _: &Machine, _: u16, _: &[(Symbol, Value)], _: &mut Outbox) -> Result<(), Raise> {
        Err(Raise::no_robot())
    }

    fn stop(&mut self, _: u16, _: StopReason, _: &mut Outbox) {}

    fn foresee(&self, _: u64, _: Phases<'_>, _: Grain) -> Result<ForeseenRobot, Raise> {
        Ok(ForeseenRobot::of(Self))
    }
}

/// A robot that is foreseen. It may be projected on another thread.
pub trait Foreseen: Outside + Send + Sync {
    /// A copy, for one run.
    fn copied(&self) -> Box<dyn Foreseen>;

    /// Draws what the robot does not know and what it leaves to chance, before a run begins.
    fn begin_run(&mut self, seed: u64);

    /// What the run has come to need for which there is no model, if it has: one sentence.
    fn unforeseen(&self) -> Option<&str>;

    /// Whether something in the run was left to chance, so that another one may go otherwise.
    fn has_drawn(&self) -> bool;
}

/// A robot of projected runs, whatever it is.
pub struct ForeseenRobot(Box<dyn Foreseen>);

impl ForeseenRobot {
    /// That robot.
    pub fn of(robot: impl Foreseen) -> Self {
        Self(Box::new(robot))
    }

    /// As for [`Foreseen::begin_run`]. Projected runs begin by themselves; one that is a world of its own is begun.
    pub fn begin_run(&mut self, seed: u64) {
        self.0.begin_run(seed);
    }

    /// As for [`Foreseen::unforeseen`].
    pub(crate) fn unforeseen(&self) -> Option<&str> {
        self.0.unforeseen()
    }

    /// As for [`Foreseen::has_drawn`].
    pub(crate) fn has_drawn(&self) -> bool {
        self.0.has_drawn()
    }
}

impl Clone for ForeseenRobot {
    fn clone(&self) -> Self {
        Self(self.0.copied())
    }
}

impl Foreseen for NoRobot {
    fn copied(&self) -> Box<dyn Foreseen> {
        Box::new(*self)
    }

    fn begin_run(&mut self, _: u64) {}

    fn unforeseen(&self) -> Option<&str> {
        None
    }

    fn has_drawn(&self) -> bool {
        false
    }
}

impl Outside for ForeseenRobot {
    fn tables(&self) -> &RobotTables {
        self.0.tables()
    }

    fn start(
        &mut self,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise> {
        self.0.start(machine, behaviour, arguments, outbox)
    }

    fn stop(&mut self, behaviour: u16, why: StopReason, outbox: &mut Outbox) {
        self.0.stop(behaviour, why, outbox);
    }

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        self.0.next_event_us(stepped_us)
    }

    fn steps_at(&self, stepped_us: u64, now_us: u64) -> bool {
        self.0.steps_at(stepped_us, now_us)
    }

    fn step(&mut self, now_us: u64, phases: Phases<'_>, outbox: &mut Outbox) {
        self.0.step(now_us, phases, outbox);
    }

    fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        self.0.part(of)
    }
}
