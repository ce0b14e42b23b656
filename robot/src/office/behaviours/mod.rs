//! What the robot is composed of: the one list of its modules, and what follows from it, the order of
//! their steps, the tables that plans see, and the numbers of behaviours and fluents.
//!
//! One circle, on purpose: the list imports the modules, and a module asks the list for the number of
//! its fluents and its behaviour, so that no number is written by hand.

pub(super) mod active_localization;
pub(super) mod body;
mod gripper;
mod look_around;
pub(super) mod module;
pub(super) mod navigation;
pub(super) mod position;
pub(super) mod position_tracking;

use self::active_localization::Localizing;
use self::body::Body;
use self::gripper::Gripping;
use self::look_around::LookingAround;
use self::module::{Module, ModuleSpec};
use self::navigation::Navigating;
use self::position_tracking::PositionTracking;
use crate::office::model::OfficeModel;
use rpl_runtime::robot::RobotTables;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::sync::LazyLock;

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
