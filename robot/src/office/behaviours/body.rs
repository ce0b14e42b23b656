//! The robot's body: what its sensors and its radio say for themselves, when its sonars fire, and the
//! valves of what it moves. It has no behaviour.

use super::fluent_number;
use super::module::{Module, ModuleSpec, Moment, continuous, fluent};
use super::position::Position;
use crate::office::model::OfficeModel;
use crate::office::words::mode_name;
use crate::simulator::Commands;
use crate::world::TravelMode;
use rpl_runtime::robot::Outbox;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::state::activation::Phase;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The valve of what drives.
pub(in crate::office) const WHEELS: Cow<'static, str> = Cow::Borrowed("wheels");

/// The valve of what grasps.
pub(super) const ARM: Cow<'static, str> = Cow::Borrowed("arm");

const TRAVEL_MODE: usize = fluent_number("travel-mode*");
const REGION: usize = fluent_number("region*");
const SPEED: usize = fluent_number("speed*");
const BUMPED: usize = fluent_number("bumped?*");
const HOLDING: usize = fluent_number("holding*");
const BATTERY: usize = fluent_number("battery*");
const MESSAGES: usize = fluent_number("messages*");

/// In doorways the sonars fire in one step of so many.
///
/// # Deviation
/// Beetz et al. (§3.1) switch the sonars off in doorways, because in a narrow opening they hear one
/// another. Then a robot that is turned by hand inside a door drives into its frame unseen. Fired
/// seldom, they do not disturb one another either, and 0.2 s at doorway speed are 6 cm.
const DOORWAY_SONAR_STEPS: u32 = 4;

/// The state of the body: how many steps there were, for the sonars.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Body {
    steps: u32,
}

impl Body {
    pub(super) const SPEC: ModuleSpec = ModuleSpec {
        behaviour: None,
        fluents: &[
            fluent("travel-mode*", "How the robot drives: hallway, office or doorway."),
            fluent("region*", "The travel mode of the region the robot believes itself to be in, or nil."),
            continuous("speed*", "Measured speed ahead, in metres a second."),
            fluent("bumped?*", "Whether something touches the robot."),
            fluent("holding*", "The thing in the gripper, or nil."),
            continuous("battery*", "Charge of the battery, from 0 to 1, in thousandths."),
            fluent("messages*", "How many messages have not been read."),
        ],
        valves: &[WHEELS, ARM],
    };

    pub(super) fn new(_: &OfficeModel, _: u64) -> Self {
        Self::default()
    }
}

impl Module for Body {
    fn command(&mut self, mode: TravelMode, _: Phase, commands: &mut Commands) {
        self.steps = self.steps.wrapping_add(1);
        commands.sonars_on |= mode != TravelMode::Doorway || self.steps.is_multiple_of(DOORWAY_SONAR_STEPS);
    }

    fn publish(&mut self, now: &Moment<'_>, position: &Position, outbox: &mut Outbox) {
        let Moment { model, percept, .. } = now;
        let mode = |mode: TravelMode| Reading::Symbol(mode_name(mode).to_string());
        let here = || position.estimate(model.map.as_ref()).pose_in_map.point();
        let region = model.map.as_ref().and_then(|_| model.world.mode_at(here()));
        outbox.fluents.extend([
            (TRAVEL_MODE, mode(now.mode)),
            (REGION, region.map_or(Reading::Truth(false), mode)),
            (SPEED, Reading::Float(percept.translation_mps)),
            (BUMPED, Reading::Truth(percept.bumped)),
            (HOLDING, percept.gripper.holding.clone().map_or(Reading::Truth(false), Reading::Symbol)),
            (BATTERY, Reading::Float(libm::round(percept.battery * 1000.0) / 1000.0)),
            (MESSAGES, Reading::Int(now.unread as i64)),
        ]);
    }
}
