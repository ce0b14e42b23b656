//! Position tracking: it takes each percept into the belief, and tells where the robot is and whether
//! that is known.

use super::fluent_number;
use super::module::{Module, ModuleSpec, Moment, Work, continuous};
use super::position::Position;
use crate::localization::Estimate;
use crate::office::model::OfficeModel;
use crate::office::report::Report;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{BehaviourSpec, Outbox, RobotEvent};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The number of the estimated x.
pub const X: usize = fluent_number("x*");

/// The number of the estimated y.
pub const Y: usize = fluent_number("y*");

const O: usize = fluent_number("o*");

/// The number of the certainty.
pub(super) const POS_CERTAINTY: usize = fluent_number("pos-certainty*");

/// The state of position tracking.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PositionTracking {
    /// Whether the position counted as known in the last step.
    was_certain: bool,
}

impl PositionTracking {
    pub(super) const SPEC: ModuleSpec = ModuleSpec {
        behaviour: Some(BehaviourSpec {
            name: Cow::Borrowed("position-tracking"),
            doc: Cow::Borrowed(
                "Keeps the belief about the position up to date; active from the start, needs no valve.",
            ),
            valve: None,
            parameters: Cow::Borrowed(""),
        }),
        fluents: &[
            continuous("x*", "Estimated x, in metres, map frame."),
            continuous("y*", "Estimated y, in metres, map frame."),
            continuous("o*", "Estimated heading, in radians counter-clockwise from the map's x axis."),
            continuous(
                "pos-certainty*",
                "Probability that the position is within 0.5 m and 15° of the estimate; calibrated, so that 0.8 is right four times in five.",
            ),
        ],
        valves: &[],
    };

    pub(super) fn new(model: &OfficeModel, _: u64) -> Self {
        Self { was_certain: model.settings.start_known || model.map.is_none() }
    }
}

impl Module for PositionTracking {
    /// A doubt comes after the percept: otherwise one scan that fits could make the robot certain
    /// again before anybody has seen it uncertain.
    fn step(&mut self, now: &Moment<'_>, position: &mut Position, events: &mut Vec<RobotEvent>) -> Work {
        let (Some(map), Some(localization)) = (&now.model.map, &mut position.localization) else {
            return Work::default();
        };
        let ranges_m = now.percept.sonar_m.as_ref().map(|ranges_m| ranges_m.as_slice());
        localization.observe(&map.localization, now.percept.odometry_in_odom, ranges_m);
        if std::mem::take(&mut position.is_doubted) {
            localization.refute(&map.localization);
            events.push(Report::PositionDoubted.into());
        }
        Work::default()
    }

    fn publish(&mut self, now: &Moment<'_>, position: &Position, outbox: &mut Outbox) {
        let Estimate { pose_in_map, certainty } = position.estimate(now.model.map.as_ref());
        let active = &now.model.settings.active;
        let certain = certainty > if self.was_certain { active.certainty } else { active.found_certainty };
        if certain != self.was_certain {
            self.was_certain = certain;
            let report = if certain { Report::PositionFound { certainty } } else { Report::PositionLost { certainty } };
            outbox.events.push(report.into());
        }
        outbox.fluents.extend([
            (X, Reading::Float(pose_in_map.x_m)),
            (Y, Reading::Float(pose_in_map.y_m)),
            (O, Reading::Float(pose_in_map.heading_rad)),
            (POS_CERTAINTY, Reading::Float(certainty)),
        ]);
    }
}
