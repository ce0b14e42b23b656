//! Looking around: it turns a little to both sides, so that the sensors see more.

use super::body::WHEELS;
use super::module::{Module, ModuleSpec, Moment, Start, Work};
use super::position::Position;
use crate::navigation::LookAround;
use crate::office::model::OfficeModel;
use rpl_runtime::robot::{BehaviourSpec, Ending, Outbox, RobotEvent, StopReason};
use rpl_runtime::state::failure::Raise;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The state of looking around: the turns still to make, while it is at work.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LookingAround {
    look: Option<LookAround>,
}

impl LookingAround {
    pub(super) const SPEC: ModuleSpec = ModuleSpec {
        behaviour: Some(BehaviourSpec {
            name: Cow::Borrowed("look-around"),
            doc: Cow::Borrowed(
                "Turns a little to the left, to the right, and back, so that the sensors see more. Succeeds after that.",
            ),
            valve: Some(WHEELS),
            parameters: Cow::Borrowed(""),
        }),
        fluents: &[],
        valves: &[],
    };

    pub(super) fn new(_: &OfficeModel, _: u64) -> Self {
        Self::default()
    }
}

impl Module for LookingAround {
    fn start(&mut self, _: &Start<'_>, position: &mut Position, _: &mut Outbox) -> Result<(), Raise> {
        self.look = Some(LookAround::from(position.odometry_in_odom()));
        Ok(())
    }

    fn stop(&mut self, _: StopReason, _: &mut Outbox) {
        self.look = None;
    }

    fn step(&mut self, now: &Moment<'_>, _: &mut Position, _: &mut Vec<RobotEvent>) -> Work {
        let Some(look) = &mut self.look else { return Work::default() };
        let velocity = look.step(&now.model.limits, now.percept.odometry_in_odom, now.input().velocity);
        let ending = velocity.is_none().then(|| {
            self.look = None;
            Ending::Success
        });
        Work { velocity, ending }
    }
}
