//! What the robot is composed of: the one list of its modules, and what follows from it, the order of
//! their steps, the tables that plans see, and the numbers of behaviours and fluents.

pub(super) mod active_localization;
pub(super) mod body;
mod gripper;
mod look_around;
pub(super) mod navigation;
pub(super) mod position_tracking;

use self::active_localization::Localizing;
use self::body::Body;
use self::gripper::Gripping;
use self::look_around::LookingAround;
use self::navigation::Navigating;
use self::position_tracking::{Position, PositionTracking};
use super::OfficeModel;
use crate::geometry::Velocity;
use crate::navigation::NavigationInput;
use crate::simulator::{Commands, Percept};
use crate::world::TravelMode;
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::{BehaviourSpec, Ending, FluentSpec, Outbox, RobotEvent, RobotTables, Stop};
use rpl_runtime::state::activation::Phase;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::sync::LazyLock;

/// What a module offers to plans.
pub(super) struct ModuleSpec {
    /// Its behaviour, if it has one.
    pub behaviour: Option<BehaviourSpec>,
    /// Its fluents.
    pub fluents: &'static [FluentSpec],
    /// The valves that guard what it moves.
    pub valves: &'static [Cow<'static, str>],
}

/// A behaviour, or another part of the robot that tells plans something, with its state. It writes
/// nothing that others read but through what it is given to write or what it answers.
pub(super) trait Module {
    /// Starts its behaviour.
    ///
    /// # Errors
    /// What is wrong with the arguments, or why it cannot start.
    fn start(&mut self, _start: &Start<'_>, _position: &mut Position, _outbox: &mut Outbox) -> Result<(), Raise> {
        Ok(())
    }

    /// Stops its behaviour.
    fn stop(&mut self, _how: Stop, _outbox: &mut Outbox) {}

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
pub(super) struct Start<'a> {
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
pub(super) struct Moment<'a> {
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
    fn input(&self) -> NavigationInput<'a> {
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
pub(super) struct Work {
    /// What it wants of the wheels.
    pub velocity: Option<Velocity>,
    /// How its behaviour ended, if it did.
    pub ending: Option<Ending>,
}

/// Makes of a list of modules their states, the array to go through them, and what they offer.
macro_rules! compose {
    ($($name:ident: $module:ty,)+) => {
        const SPECS: &[&ModuleSpec] = &[$(&<$module>::SPEC),+];

        /// The states of all modules. They step, and tell, in this order.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub struct Modules {
            $(pub(super) $name: $module,)+
        }

        impl Modules {
            pub(super) fn new(model: &OfficeModel, seed: u64) -> Self {
                Self { $($name: <$module>::new(model, seed),)+ }
            }

            fn all(&mut self) -> [&mut dyn Module; SPECS.len()] {
                [$(&mut self.$name),+]
            }
        }
    };
}

compose! {
    position_tracking: PositionTracking,
    body: Body,
    active_localization: Localizing,
    navigation: Navigating,
    gripper: Gripping,
    look_around: LookingAround,
}

impl Modules {
    /// Each module in its order, with the number of its behaviour.
    pub(super) fn numbered(&mut self) -> impl Iterator<Item = (Option<u16>, &mut dyn Module)> {
        let mut next = 0;
        self.all().into_iter().zip(SPECS).map(move |(module, spec)| {
            let number = spec.behaviour.is_some().then_some(next);
            next += u16::from(number.is_some());
            (number, module)
        })
    }

    /// The module with the behaviour of a number.
    pub(super) fn of(&mut self, behaviour: u16) -> Option<&mut dyn Module> {
        self.numbered().find(|(number, _)| *number == Some(behaviour)).map(|(_, module)| module)
    }
}

/// What plans see of the robot.
pub fn tables() -> &'static RobotTables {
    static TABLES: LazyLock<RobotTables> = LazyLock::new(|| RobotTables {
        behaviours: SPECS.iter().filter_map(|spec| spec.behaviour.clone()).collect(),
        fluents: SPECS.iter().flat_map(|spec| spec.fluents).cloned().collect(),
        valves: SPECS.iter().flat_map(|spec| spec.valves).cloned().collect(),
    });
    &TABLES
}

/// The number of a behaviour; an unknown name is refused by the compiler.
const fn behaviour_number(name: &str) -> u16 {
    let (mut at, mut number) = (0, 0);
    while at < SPECS.len() {
        if let Some(behaviour) = &SPECS[at].behaviour {
            if is_name(&behaviour.name, name) {
                return number;
            }
            number += 1;
        }
        at += 1;
    }
    panic!("no module has this behaviour")
}

/// The number of a fluent; an unknown name is refused by the compiler.
const fn fluent_number(name: &str) -> usize {
    let (mut at, mut number) = (0, 0);
    while at < SPECS.len() {
        let fluents = SPECS[at].fluents;
        let mut inside = 0;
        while inside < fluents.len() {
            if is_name(&fluents[inside].name, name) {
                return number;
            }
            number += 1;
            inside += 1;
        }
        at += 1;
    }
    panic!("no module has this fluent")
}

/// Whether a name is this one; those of the tables here are all borrowed.
const fn is_name(known: &Cow<'static, str>, name: &str) -> bool {
    let Cow::Borrowed(known) = known else { return false };
    let (known, name) = (known.as_bytes(), name.as_bytes());
    let mut at = 0;
    while at < known.len() && at < name.len() && known[at] == name[at] {
        at += 1;
    }
    at == known.len() && at == name.len()
}

/// A fluent that changes now and then.
const fn fluent(name: &'static str, doc: &'static str) -> FluentSpec {
    FluentSpec { name: Cow::Borrowed(name), doc: Cow::Borrowed(doc), continuous: false }
}

/// A fluent that changes with every step.
const fn continuous(name: &'static str, doc: &'static str) -> FluentSpec {
    FluentSpec { name: Cow::Borrowed(name), doc: Cow::Borrowed(doc), continuous: true }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_numbers_are_places_in_the_tables() {
        let tables = tables();
        assert_eq!(tables.behaviours[usize::from(navigation::NUMBER)].name, "navigation");
        let fluents = [position_tracking::X, position_tracking::Y, position_tracking::POS_CERTAINTY];
        assert_eq!(fluents.map(|at| &*tables.fluents[at].name), ["x*", "y*", "pos-certainty*"]);
    }

    #[test]
    fn the_valve_of_each_behaviour_is_there_and_no_name_is_given_twice() {
        let tables = tables();
        for behaviour in &tables.behaviours {
            assert!(behaviour.valve.iter().all(|valve| tables.valves.contains(valve)), "{}", behaviour.name);
        }
        let names: BTreeSet<&str> = tables.names().collect();
        assert_eq!(names.len(), tables.names().count());
    }
}
