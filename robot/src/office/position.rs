//! Where the robot believes itself to be, which all modules read.

use super::model::{MapModel, OfficeModel};
use crate::geometry::Pose;
use crate::localization::{Estimate, LandmarkSighting, Localization, Spread};
use crate::world::World;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Where the robot believes itself to be. Only position tracking writes here; others look, doubt it,
/// or begin a search; modules of other crates look, and tell what was found out by landmarks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// The filter; none without a map, and where the robot goes by its odometry.
    pub(super) localization: Option<Localization>,
    /// A plan has reason to think the estimate is wrong; position tracking answers in the next step.
    pub(super) is_doubted: bool,
    /// A plan has said where the robot is; position tracking takes it in the next step.
    set_in_map: Option<Pose>,
    /// A search has begun, and plans have not been told what it left of the belief.
    is_given_up: bool,
    /// Dead reckoning at the end of the last step.
    odometry_in_odom: Pose,
    /// Where dead reckoning began, for a robot that goes by it; without a map nothing else is known of places.
    odom_in_map: Pose,
    /// Where a projected robot believes itself to be; it has no filter.
    #[serde(skip)]
    foreseen: Option<Estimate>,
}

impl Position {
    /// The position at the start of a run.
    pub(super) fn new(model: &OfficeModel) -> Self {
        let map = model.map.as_ref();
        let localization = map.filter(|_| model.settings.has_belief()).map(|map| {
            if model.settings.start_known {
                Localization::start_at(&map.localization, model.world.start_in_map, Spread::default())
            } else {
                Localization::start_uniform(&map.localization)
            }
        });
        let odom_in_map = map.map_or(Pose::default(), |_| model.world.start_in_map);
        Self {
            localization,
            is_doubted: false,
            set_in_map: None,
            is_given_up: false,
            odometry_in_odom: Pose::default(),
            odom_in_map,
            foreseen: None,
        }
    }

    /// The filter; none without a map.
    pub fn localization(&self) -> Option<&Localization> {
        self.localization.as_ref()
    }

    /// Without a belief the robot is where its odometry says, and doubts nothing; without a map that is in `odom`.
    pub fn estimate(&self, map: Option<&MapModel>) -> Estimate {
        if let Some(foreseen) = self.foreseen {
            return foreseen;
        }
        match (map, &self.localization) {
            (Some(map), Some(localization)) => localization.estimate(&map.localization),
            _ => Estimate { pose_in_map: self.odom_in_map.compose(self.odometry_in_odom), certainty: 1.0 },
        }
    }

    /// Probability that the position is not lost ([`Localization::tracking`]).
    pub fn tracking(&self, map: Option<&MapModel>) -> f64 {
        match (self.foreseen, map, &self.localization) {
            (None, Some(map), Some(localization)) => localization.tracking(&map.localization),
            _ => self.estimate(map).certainty,
        }
    }

    /// How many times as far as its description says its odometry errs ([`Localization::slip`]).
    pub(super) fn slip(&self) -> f64 {
        self.localization.as_ref().map_or(1.0, Localization::slip)
    }

    /// The share of what it has seen of late that is not as in the map ([`Localization::map_misfit`]).
    pub(super) fn map_misfit(&self) -> f64 {
        self.localization.as_ref().map_or(0.0, Localization::map_misfit)
    }

    /// The room in which most of that is, if it is in a room.
    pub(super) fn room_of_misfit<'w>(&self, world: &'w World) -> Option<&'w str> {
        let mut rooms = BTreeMap::<&str, f64>::new();
        for (at, readings) in self.localization.iter().flat_map(Localization::unmapped_readings) {
            if let Some(room) = world.room_at(at) {
                *rooms.entry(&room.name).or_default() += readings;
            }
        }
        rooms.into_iter().max_by(|one, other| one.1.total_cmp(&other.1)).map(|(room, _)| room)
    }

    /// Dead reckoning at the end of the last step.
    pub fn odometry_in_odom(&self) -> Pose {
        self.odometry_in_odom
    }

    /// A plan has reason to think that the estimate is wrong.
    pub(super) fn doubt(&mut self) {
        self.is_doubted = true;
    }

    /// Whether the robot gets no nearer where the map shows a way.
    pub(super) fn note_held_up(&mut self, is_held_up: bool) {
        self.localization.iter_mut().for_each(|localization| localization.note_held_up(is_held_up));
    }

    /// A plan says where the robot is.
    pub(super) fn set(&mut self, pose_in_map: Pose) {
        self.set_in_map = Some(pose_in_map);
    }

    /// Takes what a plan has said.
    pub(super) fn take_set(&mut self, map: &MapModel) {
        if let Some(pose_in_map) = self.set_in_map.take() {
            self.tell(map, pose_in_map, Spread::default());
        }
    }

    /// The robot is told where it is.
    pub(super) fn tell(&mut self, map: &MapModel, pose_in_map: Pose, spread: Spread) {
        self.odom_in_map = pose_in_map.compose(self.odometry_in_odom.inverse());
        if let Some(localization) = &mut self.localization {
            *localization = Localization::start_at(&map.localization, pose_in_map, spread);
        }
    }

    /// The robot has measured where it is, before a landmark.
    pub fn tell_by_landmark(&mut self, map: &MapModel, pose_in_map: Pose) {
        self.tell(map, pose_in_map, Spread::default());
    }

    /// Takes landmarks that were seen in this step into the belief, if there is one.
    pub fn see_landmarks(&mut self, map: &MapModel, sightings: &[LandmarkSighting]) {
        if let Some(localization) = &mut self.localization {
            localization.see(&map.localization, sightings);
        }
    }

    /// A projected robot believes itself to be there; its odometry has not strayed since the beginning.
    pub(super) fn foresee(&mut self, estimate: Estimate, odometry_in_odom: Pose) {
        (self.localization, self.foreseen, self.odometry_in_odom) = (None, Some(estimate), odometry_in_odom);
    }

    /// Whether a plan has given the estimate up since this was asked last.
    pub(super) fn take_doubt(&mut self) -> bool {
        std::mem::take(&mut self.is_doubted)
    }

    /// The robot may be anywhere.
    pub(in crate::office) fn forget(&mut self, map: &MapModel) {
        if let Some(localization) = &mut self.localization {
            *localization = Localization::start_uniform(&map.localization);
        }
    }

    /// The belief for a search, which gives it up as it begins if it is worth nothing.
    pub(super) fn begin_search(&mut self) -> Option<&mut Localization> {
        self.is_given_up = self.localization.is_some();
        self.localization.as_mut()
    }

    /// The belief for a search that has begun.
    pub(super) fn searched(&mut self) -> Option<&mut Localization> {
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
