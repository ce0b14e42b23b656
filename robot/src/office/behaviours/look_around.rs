//! Looking around: it turns a little to both sides, so that the sensors see more.

use super::body::WHEELS;
use crate::geometry::Velocity;
use crate::navigation::LookAround;
use crate::office::model::OfficeModel;
use crate::office::module::{Module, ModuleSpec, Moment, Start, Telling};
use crate::office::position::Position;
use rpl_runtime::robot::{BehaviourSpec, Ending, StopReason};
use rpl_runtime::state::failure::Raise;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Its name.
pub(in crate::office) const NAME: &str = "look-around";

/// The state of looking around: the turns still to make, while it is at work.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LookingAround {
    look: Option<LookAround>,
}

impl Module for LookingAround {
    type Settings = ();

    fn specs((): &()) -> Vec<ModuleSpec> {
        vec![ModuleSpec {
            name: NAME.into(),
            behaviours: vec![BehaviourSpec {
                name: Cow::Borrowed(NAME),
                doc: Cow::Borrowed(
                    "Turns a little to the left, to the right, and back, so that the sensors see more. Succeeds after that.",
                ),
                valve: Some(WHEELS),
                parameters: Cow::Borrowed(""),
            }],
            ..ModuleSpec::default()
        }]
    }

    fn new((): &(), _: &OfficeModel, _: u64) -> Self {
        Self::default()
    }

    fn start(&mut self, _: usize, _: &Start<'_>, position: &mut Position, _: &mut Telling<'_>) -> Result<(), Raise> {
        self.look = Some(LookAround::from(position.odometry_in_odom()));
        Ok(())
    }

    fn stop(&mut self, _: usize, _: StopReason, _: &mut Telling<'_>) {
        self.look = None;
    }

    fn step(&mut self, now: &Moment<'_>, _: &mut Position, tell: &mut Telling<'_>) -> Option<Velocity> {
        let look = self.look.as_mut()?;
        let velocity = look.step(&now.model.limits, now.percept.odometry_in_odom, now.input().velocity);
        if velocity.is_none() {
            self.look = None;
            tell.end(0, Ending::DONE);
        }
        velocity
    }
}
