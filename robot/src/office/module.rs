//! Modules: what each part of the robot that plans see is, what it offers, and what it does in a step.

use super::model::OfficeModel;
use super::position::Position;
use super::saved_bytes::taken;
use crate::foresight::act_model::ActModel;
use crate::geometry::Velocity;
use crate::navigation::NavigationInput;
use crate::sensors::{LaserScan, SonarScan};
use crate::simulator::{Commands, Percept};
use crate::world::TravelMode;
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{BehaviourSpec, Ending, FluentSpec, Outbox, RobotEvent, StopReason};
use rpl_runtime::run::save::append;
use rpl_runtime::state::activation::Phase;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::Native;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::any::{Any, TypeId};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

/// What a module offers to plans. Its behaviours and its fluents are known by their places here.
#[derive(Clone, Default)]
pub struct ModuleSpec {
    /// Its name, as messages call it.
    pub name: Cow<'static, str>,
    /// Its behaviours.
    pub behaviours: Vec<BehaviourSpec>,
    /// Its fluents.
    pub fluents: Vec<FluentSpec>,
    /// The valves that guard what it moves.
    pub valves: Vec<Cow<'static, str>>,
    /// Its functions. They find its state with [`Call::part`](rpl_runtime::step::native::Call::part).
    pub functions: Vec<Native>,
    /// Plans that belong to it.
    pub plans: Vec<PlanText>,
    /// How its behaviours go in projections, by their places; those of which nothing is said are not projected.
    pub models: BTreeMap<usize, ActModel>,
}

/// A text of plans in a library.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlanText {
    /// The name by which messages call it.
    pub name: Cow<'static, str>,
    /// The text.
    pub text: Cow<'static, str>,
}

/// A part of the robot that plans see, with its state: behaviours, fluents, valves, functions and plans
/// that belong together. A run can be copied and saved at any moment, so the state is a plain value.
///
/// Modules are put together by [`modules!`](crate::modules), which makes of a list of them one module again.
/// In each step all of them are asked in the order of the list: first what they command, then, when the
/// percept has come, what they make of it, and at last what they tell plans. A module writes nothing that
/// others read: it answers, or tells. A projection may be made with a copy of it on another thread.
pub trait Module: Clone + Serialize + DeserializeOwned + Send + Sync + 'static {
    /// What is set before any run and shared by all; `()` for most.
    type Settings: Default + Send + Sync + 'static;

    /// What it offers, in one place or, if it is made of several modules, in as many.
    fn specs(settings: &Self::Settings) -> Vec<ModuleSpec>;

    /// Its state at the start of a run. What it leaves to chance follows from the seed.
    fn new(settings: &Self::Settings, model: &OfficeModel, seed: u64) -> Self;

    /// Adds its state to the bytes of a saved run.
    fn save(&self, bytes: Vec<u8>) -> Vec<u8> {
        append(bytes, self)
    }

    /// The state that [`Module::save`] has added, and the bytes behind it.
    ///
    /// # Errors
    /// One sentence on why there is none.
    fn load(bytes: &[u8]) -> Result<(Self, &[u8]), String> {
        taken(bytes)
    }

    /// Takes back what is no part of a saved state, after that was loaded, from the same module at the start of
    /// a run.
    ///
    /// # Errors
    /// The state does not belong to these settings, or cannot be gone on with.
    fn resume(&mut self, _at_start: &Self) -> Result<(), String> {
        Ok(())
    }

    /// The process of the run had ended, and another one goes on with it. What was done outside the run is not
    /// gone on with: it is told as interrupted. Whether there is such a thing.
    fn renew(&mut self, _tell: &mut Telling<'_>) -> bool {
        false
    }

    /// From here on it is a module of a projected run, which asks nobody outside.
    fn foresee(&mut self) {}

    /// Starts one of its behaviours.
    ///
    /// # Errors
    /// What is wrong with the arguments, or why it cannot start.
    fn start(
        &mut self,
        _behaviour: usize,
        _start: &Start<'_>,
        _position: &mut Position,
        _tell: &mut Telling<'_>,
    ) -> Result<(), Raise> {
        Ok(())
    }

    /// Stops one of its behaviours.
    fn stop(&mut self, _behaviour: usize, _why: StopReason, _tell: &mut Telling<'_>) {}

    /// Adds to what the robot is to do in the next step; the wheels are not its business.
    fn command(&mut self, _mode: TravelMode, _phases: &[Phase], _commands: &mut Commands) {}

    /// One step, after the percept has come. Answers what it wants of the wheels: the last module of the
    /// list that wants anything is obeyed.
    fn step(&mut self, _now: &Moment<'_>, _position: &mut Position, _tell: &mut Telling<'_>) -> Option<Velocity> {
        None
    }

    /// Tells plans how things stand, after all have made their step.
    fn publish(&mut self, _now: &Moment<'_>, _position: &Position, _tell: &mut Telling<'_>) {}

    /// Tells plans at once that the belief about the position was given up between two steps.
    fn publish_position(&mut self, _model: &OfficeModel, _position: &Position, _tell: &mut Telling<'_>) {}

    /// Bytes of its state that an earlier state does not share: what it costs to keep both.
    fn bytes_apart(&self, _earlier: &Self) -> usize {
        0
    }

    /// Itself, if it is of a type: what its functions work on.
    fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        (of == TypeId::of::<Self>()).then_some(self)
    }
}

/// What a behaviour is started with.
pub struct Start<'a> {
    /// What does not change.
    pub model: &'a OfficeModel,
    /// For its symbols and lists.
    pub machine: &'a Machine,
    /// By the names of its parameters.
    pub arguments: &'a [(Symbol, Value)],
    /// When the last percept came.
    pub time_us: u64,
}

impl Start<'_> {
    /// The argument for a parameter, named without its colon.
    pub fn argument(&self, parameter: &str) -> Option<Value> {
        let symbols = &self.machine.symbols;
        self.arguments.iter().find(|(key, _)| symbols.name(*key) == parameter).map(|&(_, value)| value)
    }
}

/// What a module sees in a step.
#[derive(Clone, Copy)]
pub struct Moment<'a> {
    /// What does not change.
    pub model: &'a OfficeModel,
    /// The percept of this step.
    pub percept: &'a Percept,
    /// How the robot is to drive.
    pub mode: TravelMode,
    /// Messages that no plan has read.
    pub unread: usize,
    /// Where each of the module's behaviours stands.
    pub phases: &'a [Phase],
}

impl<'a> Moment<'a> {
    /// The same for one module of several.
    #[doc(hidden)]
    pub fn of(&self, part: &Part) -> Self {
        Self { phases: &self.phases[part.behaviours.clone()], ..*self }
    }

    /// What a module drives by that keeps off what its sensors see.
    pub fn input(&self) -> NavigationInput<'a> {
        let (percept, sensors) = (self.percept, &self.model.sensors);
        let sonar = sensors.sonars.as_ref().zip(percept.sonar_m.as_deref());
        let laser = sensors.laser.as_ref().zip(percept.laser_m.as_deref());
        NavigationInput {
            odometry_in_odom: percept.odometry_in_odom,
            velocity: Velocity { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps },
            sonar: sonar.map(|(sonars, ranges_m)| SonarScan { sonars, ranges_m }),
            laser: laser.map(|(laser, ranges_m)| LaserScan { laser, ranges_m }),
            bumped: percept.bumped,
        }
    }
}

/// Through which a module tells plans something.
pub struct Telling<'a> {
    outbox: &'a mut Outbox,
    first_behaviour: usize,
    first_fluent: usize,
}

impl<'a> Telling<'a> {
    /// For the whole robot.
    pub fn of_all(outbox: &'a mut Outbox) -> Self {
        Self { outbox, first_behaviour: 0, first_fluent: 0 }
    }

    /// For a module with these first places among the behaviours and fluents of the whole robot.
    pub(super) fn at(outbox: &'a mut Outbox, first_behaviour: usize, first_fluent: usize) -> Self {
        Self { outbox, first_behaviour, first_fluent }
    }

    /// The same for one module of several.
    #[doc(hidden)]
    pub fn of(&mut self, part: &Part) -> Telling<'_> {
        Telling {
            first_behaviour: self.first_behaviour + part.behaviours.start,
            first_fluent: self.first_fluent + part.fluents.start,
            outbox: self.outbox,
        }
    }

    /// The new value of one of the module's fluents.
    pub fn fluent(&mut self, fluent: usize, reading: Reading) {
        self.outbox.fluents.push((self.first_fluent + fluent, reading));
    }

    /// How one of its behaviours ended by itself.
    pub fn end(&mut self, behaviour: usize, ending: Ending) {
        self.outbox.endings.push(((self.first_behaviour + behaviour) as u16, ending));
    }

    /// One of its behaviours is not gone on with.
    pub fn interrupt(&mut self, behaviour: usize) {
        self.outbox.interrupted.push((self.first_behaviour + behaviour) as u16);
    }

    /// Something worth a line in the trace.
    pub fn event(&mut self, event: impl Into<RobotEvent>) {
        self.outbox.events.push(event.into());
    }
}

/// The places of one module among several.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Of its behaviours.
    pub behaviours: Range<usize>,
    /// Of its fluents.
    pub fluents: Range<usize>,
}

/// Where the behaviours and fluents of several modules stand, one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    parts: Vec<Part>,
}

impl Layout {
    /// Puts a module behind those that are there.
    pub fn push(&mut self, specs: &[ModuleSpec]) {
        let (behaviours, fluents) = self.parts.last().map_or((0, 0), |last| (last.behaviours.end, last.fluents.end));
        self.parts.push(Part {
            behaviours: behaviours..behaviours + specs.iter().map(|spec| spec.behaviours.len()).sum::<usize>(),
            fluents: fluents..fluents + specs.iter().map(|spec| spec.fluents.len()).sum::<usize>(),
        });
    }

    /// The places of each module, in order.
    pub fn parts(&self) -> impl Iterator<Item = &Part> {
        self.parts.iter()
    }
}

/// A fluent that changes now and then.
pub const fn fluent(name: &'static str, doc: &'static str) -> FluentSpec {
    FluentSpec { name: Cow::Borrowed(name), doc: Cow::Borrowed(doc), continuous: false, first: None }
}

/// A fluent that counts, from 0 on.
pub const fn counter(name: &'static str, doc: &'static str) -> FluentSpec {
    FluentSpec { name: Cow::Borrowed(name), doc: Cow::Borrowed(doc), continuous: false, first: Some(0) }
}

/// A fluent that changes with every step.
pub const fn continuous(name: &'static str, doc: &'static str) -> FluentSpec {
    FluentSpec { name: Cow::Borrowed(name), doc: Cow::Borrowed(doc), continuous: true, first: None }
}

/// The place of a fluent in a module's table; an unknown name is refused by the compiler.
pub const fn fluent_number(fluents: &[FluentSpec], name: &str) -> usize {
    let mut at = 0;
    while at < fluents.len() {
        if is_name(&fluents[at].name, name) {
            return at;
        }
        at += 1;
    }
    panic!("the module has no fluent of this name")
}

/// Whether a name is this one; those of a constant table are all borrowed.
#[expect(clippy::ptr_arg, reason = "a constant cannot be made a text by the trait")]
const fn is_name(known: &Cow<'static, str>, name: &str) -> bool {
    let Cow::Borrowed(known) = known else { return false };
    let (known, name) = (known.as_bytes(), name.as_bytes());
    let mut at = 0;
    while at < known.len() && at < name.len() && known[at] == name[at] {
        at += 1;
    }
    at == known.len() && at == name.len()
}
