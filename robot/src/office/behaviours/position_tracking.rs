//! Position tracking: it takes each percept into the belief, and tells where the robot is and whether
//! that is known.

use super::{Module, ModuleSpec, Moment, Work, continuous, fluent_number};
use crate::geometry::Pose;
use crate::localization::{Estimate, Localization, Spread};
use crate::office::{MapModel, OfficeModel, Report};
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

/// Where the robot believes itself to be. Only position tracking writes here; others look, doubt it,
/// or begin a search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// The filter; none without a map.
    localization: Option<Localization>,
    /// A plan has reason to think the estimate is wrong; position tracking answers in the next step.
    is_doubted: bool,
    /// Dead reckoning at the end of the last step.
    odometry_in_odom: Pose,
}

impl Position {
    /// The position at the start of a run.
    pub(crate) fn new(model: &OfficeModel) -> Self {
        let localization = model.map.as_ref().map(|map| {
            if model.settings.start_known {
                Localization::start_at(&map.localization, model.world.start_in_map, Spread::default())
            } else {
                Localization::start_uniform(&map.localization)
            }
        });
        Self { localization, is_doubted: false, odometry_in_odom: Pose::default() }
    }

    /// The filter; none without a map.
    pub fn localization(&self) -> Option<&Localization> {
        self.localization.as_ref()
    }

    /// Without a map the robot is where its odometry says, in `odom`: there is nothing to be lost in.
    pub fn estimate(&self, map: Option<&MapModel>) -> Estimate {
        match (map, &self.localization) {
            (Some(map), Some(localization)) => localization.estimate(&map.localization),
            _ => Estimate { pose_in_map: self.odometry_in_odom, certainty: 1.0 },
        }
    }

    /// Dead reckoning at the end of the last step.
    pub fn odometry_in_odom(&self) -> Pose {
        self.odometry_in_odom
    }

    /// A plan has reason to think that the estimate is wrong.
    pub(crate) fn doubt(&mut self) {
        self.is_doubted = true;
    }

    /// The robot is told where it is.
    pub(crate) fn tell(&mut self, map: &MapModel, pose_in_map: Pose, spread: Spread) {
        self.localization = Some(Localization::start_at(&map.localization, pose_in_map, spread));
    }

    /// The belief for a search, which gives it up as it begins if it is worth nothing.
    pub(super) fn begin_search(&mut self) -> Option<&mut Localization> {
        self.localization.as_mut()
    }

    /// The step is over.
    pub(crate) fn end_step(&mut self, odometry_in_odom: Pose) {
        self.odometry_in_odom = odometry_in_odom;
    }
}

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
