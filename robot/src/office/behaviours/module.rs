//! What each part of the robot that plans see is: what it offers, and what it does in a step.

use super::position::Position;
use crate::geometry::Velocity;
use crate::navigation::NavigationInput;
use crate::office::model::OfficeModel;
use crate::simulator::{Commands, Percept};
use crate::world::TravelMode;
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::{BehaviourSpec, Ending, FluentSpec, Outbox, RobotEvent, StopReason};
use rpl_runtime::state::activation::Phase;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::borrow::Cow;

/// What a module offers to plans.
pub(in crate::office) struct ModuleSpec {
    /// Its behaviour, if it has one.
    pub behaviour: Option<BehaviourSpec>,
    /// Its fluents.
    pub fluents: &'static [FluentSpec],
    /// The valves that guard what it moves.
    pub valves: &'static [Cow<'static, str>],
}

/// A behaviour, or another part of the robot that tells plans something, with its state. It writes
/// nothing that others read but through what it is given to write or what it answers.
pub(in crate::office) trait Module {
    /// Starts its behaviour.
    ///
    /// # Errors
    /// What is wrong with the arguments, or why it cannot start.
    fn start(&mut self, _start: &Start<'_>, _position: &mut Position, _outbox: &mut Outbox) -> Result<(), Raise> {
        Ok(())
    }

    /// Stops its behaviour.
    fn stop(&mut self, _how: StopReason, _outbox: &mut Outbox) {}

    /// Adds to what the robot is to do in the next step; the wheels are not its business.
    fn command(&mut self, _mode: TravelMode, _phase: Phase, _commands: &mut Commands) {}

    /// One step, after the percept has come.
    fn step(&mut self, _now: &Moment<'_>, _position: &mut Position, _events: &mut Vec<RobotEvent>) -> Work {
        Work::default()
    }

    /// Tells plans how things stand, after all have made their step.
    fn publish(&mut self, _now: &Moment<'_>, _position: &Position, _outbox: &mut Outbox) {}
}

/// What a behaviour is started with.
pub(in crate::office) struct Start<'a> {
    /// What does not change.
    pub model: &'a OfficeModel,
    /// For its symbols and lists.
    pub machine: &'a Machine,
    /// By the names of its parameters.
    pub arguments: &'a [(Symbol, Value)],
    /// When the last percept came.
    pub time_us: u64,
}

/// What a module sees in a step.
pub(in crate::office) struct Moment<'a> {
    /// What does not change.
    pub model: &'a OfficeModel,
    /// The percept of this step.
    pub percept: &'a Percept,
    /// How the robot is to drive.
    pub mode: TravelMode,
    /// Messages that no plan has read.
    pub unread: usize,
    /// Where the module's behaviour stands.
    pub phase: Phase,
}

impl<'a> Moment<'a> {
    /// What navigation and active localization drive by.
    pub(in crate::office) fn input(&self) -> NavigationInput<'a> {
        let percept = self.percept;
        NavigationInput {
            odometry_in_odom: percept.odometry_in_odom,
            velocity: Velocity { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps },
            sonar_m: percept.sonar_m.as_ref(),
            laser_m: percept.laser_m.as_deref(),
            bumped: percept.bumped,
        }
    }
}

/// What came of a module's step.
#[derive(Default)]
pub(in crate::office) struct Work {
    /// What it wants of the wheels.
    pub velocity: Option<Velocity>,
    /// How its behaviour ended, if it did.
    pub ending: Option<Ending>,
}

/// A fluent that changes now and then.
pub(in crate::office) const fn fluent(name: &'static str, doc: &'static str) -> FluentSpec {
    FluentSpec { name: Cow::Borrowed(name), doc: Cow::Borrowed(doc), continuous: false }
}

/// A fluent that changes with every step.
pub(in crate::office) const fn continuous(name: &'static str, doc: &'static str) -> FluentSpec {
    FluentSpec { name: Cow::Borrowed(name), doc: Cow::Borrowed(doc), continuous: true }
}
