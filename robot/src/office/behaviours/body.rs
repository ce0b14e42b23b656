//! The robot's body: what its sensors and its radio say for themselves, when its sonars fire, and the
//! valves of what it moves. It has no behaviour.

use crate::office::functions::{act, board};
use crate::office::model::OfficeModel;
use crate::office::module::{Module, ModuleSpec, Moment, Telling, continuous, fluent, fluent_number};
use crate::office::position::Position;
use crate::office::words::mode_name;
use crate::simulator::Commands;
use crate::world::TravelMode;
use rpl_runtime::robot::FluentSpec;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::state::activation::Phase;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Reply};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The valve of what drives.
pub(in crate::office) const WHEELS: Cow<'static, str> = Cow::Borrowed("wheels");

/// The valve of what grasps.
pub(super) const ARM: Cow<'static, str> = Cow::Borrowed("arm");

const FLUENTS: &[FluentSpec] = &[
    fluent("travel-mode*", "How the robot drives: hallway, office or doorway."),
    fluent("region*", "The travel mode of the region the robot believes itself to be in, or nil."),
    continuous("speed*", "Measured speed ahead, in metres a second."),
    fluent("bumped?*", "Whether something touches the robot."),
    fluent("holding*", "The thing in the gripper, or nil."),
    continuous("battery*", "Charge of the battery, from 0 to 1, in thousandths."),
    fluent("messages*", "How many messages have not been read."),
];

const TRAVEL_MODE: usize = fluent_number(FLUENTS, "travel-mode*");
const REGION: usize = fluent_number(FLUENTS, "region*");
const SPEED: usize = fluent_number(FLUENTS, "speed*");
const BUMPED: usize = fluent_number(FLUENTS, "bumped?*");
const HOLDING: usize = fluent_number(FLUENTS, "holding*");
const BATTERY: usize = fluent_number(FLUENTS, "battery*");
const MESSAGES: usize = fluent_number(FLUENTS, "messages*");

/// In doorways the sonars fire in one step of this many.
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

impl Module for Body {
    type Settings = ();

    fn specs((): &()) -> Vec<ModuleSpec> {
        vec![ModuleSpec {
            name: "body".into(),
            fluents: FLUENTS.to_vec(),
            valves: vec![WHEELS, ARM],
            functions: vec![
                act("read-message", "", "The oldest message nobody has read, a list of symbols, or nil.", read_message),
                act(
                    "set-travel-mode",
                    "mode",
                    "Sets how the robot drives: hallway, office or doorway.",
                    set_travel_mode,
                ),
            ],
            ..ModuleSpec::default()
        }]
    }

    fn new((): &(), _: &OfficeModel, _: u64) -> Self {
        Self::default()
    }

    fn command(&mut self, mode: TravelMode, _: &[Phase], commands: &mut Commands) {
        self.steps = self.steps.wrapping_add(1);
        commands.sonars_on |= mode != TravelMode::Doorway || self.steps.is_multiple_of(DOORWAY_SONAR_STEPS);
    }

    fn publish(&mut self, now: &Moment<'_>, position: &Position, tell: &mut Telling<'_>) {
        let Moment { model, percept, .. } = now;
        let mode = |mode: TravelMode| Reading::Symbol(mode_name(mode).to_string());
        let here = || position.estimate(model.map.as_ref()).pose_in_map.point();
        let region = model.map.as_ref().and_then(|_| model.world.mode_at(here()));
        tell.fluent(TRAVEL_MODE, mode(now.mode));
        tell.fluent(REGION, region.map_or(Reading::Truth(false), mode));
        tell.fluent(SPEED, Reading::Float(percept.translation_mps));
        tell.fluent(BUMPED, Reading::Truth(percept.bumped));
        tell.fluent(HOLDING, percept.gripper.holding.clone().map_or(Reading::Truth(false), Reading::Symbol));
        tell.fluent(BATTERY, Reading::Float(libm::round(percept.battery * 1000.0) / 1000.0));
        tell.fluent(MESSAGES, Reading::Int(now.unread as i64));
    }
}

fn read_message(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let inbox = &mut board(call)?.inbox;
    if inbox.is_empty() {
        return Ok(Reply::Value(Value::Nil));
    }
    let words = inbox.remove(0);
    let unread = Reading::Int(inbox.len() as i64);
    // Who waits for the next message in the same instant must not see this one again.
    call.tell(&FLUENTS[MESSAGES].name, &unread);
    let symbols: Vec<Value> = words.iter().map(|word| Value::Symbol(call.machine.symbols.intern(word))).collect();
    Ok(Reply::Value(call.machine.heap.list(&symbols)))
}

fn set_travel_mode(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let name = call.name(0)?;
    let mode = [TravelMode::Hallway, TravelMode::Office, TravelMode::Doorway]
        .into_iter()
        .find(|&mode| mode_name(mode) == name)
        .ok_or_else(|| {
            Raise::type_error(format!("`{name}` is no travel mode; there are hallway, office and doorway"))
        })?;
    board(call)?.mode = mode;
    Ok(Reply::Value(Value::Nil))
}
