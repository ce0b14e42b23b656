//! Where the robot believes itself to be, which all modules read.

use super::model::{MapModel, OfficeModel};
use crate::geometry::Pose;
use crate::localization::{Estimate, Localization, Spread};
use serde::{Deserialize, Serialize};

/// Where the robot believes itself to be. Only position tracking writes here; others look, doubt it,
/// or begin a search; modules of other crates can only look.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// The filter; none without a map.
    pub(super) localization: Option<Localization>,
    /// A plan has reason to think the estimate is wrong; position tracking answers in the next step.
    pub(super) is_doubted: bool,
    /// A search has begun, and plans have not been told what it left of the belief.
    is_given_up: bool,
    /// Dead reckoning at the end of the last step.
    odometry_in_odom: Pose,
}

impl Position {
    /// The position at the start of a run.
    pub(super) fn new(model: &OfficeModel) -> Self {
        let localization = model.map.as_ref().map(|map| {
            if model.settings.start_known {
                Localization::start_at(&map.localization, model.world.start_in_map, Spread::default())
            } else {
                Localization::start_uniform(&map.localization)
            }
        });
        Self { localization, is_doubted: false, is_given_up: false, odometry_in_odom: Pose::default() }
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
    pub(super) fn doubt(&mut self) {
        self.is_doubted = true;
    }

    /// The robot is told where it is.
    pub(super) fn tell(&mut self, map: &MapModel, pose_in_map: Pose, spread: Spread) {
        self.localization = Some(Localization::start_at(&map.localization, pose_in_map, spread));
    }

    /// The robot may be anywhere.
    pub(in crate::office) fn forget(&mut self, map: &MapModel) {
        self.localization = Some(Localization::start_uniform(&map.localization));
    }

    /// The belief for a search, which gives it up as it begins if it is worth nothing.
    pub(super) fn begin_search(&mut self) -> Option<&mut Localization> {
        self.is_given_up = self.localization.is_some();
        self.localization.as_mut()
    }

    /// Whether a search has begun since this was asked last.
    pub(super) fn take_given_up(&mut self) -> bool {
        std::mem::take(&mut self.is_given_up)
    }

    /// The step is over.
    pub(super) fn end_step(&mut self, odometry_in_odom: Pose) {
        self.odometry_in_odom = odometry_in_odom;
    }
}
