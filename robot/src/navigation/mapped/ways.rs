//! What a robot has found out about the ways of its map: what stands in them, and whether it gets on.

use super::blockages::Blockages;
use super::costs::{Costs, KnownCosts};
use super::model::NavigationModel;
use super::progress::MapProgress;
use crate::geometry::{Point, Pose, Transform};
use crate::navigation::cache::Cache;
use crate::obstacles::{DoorMemory, ObstacleMemory, RememberedPoint, barriers};
use crate::planning::Target;
use serde::{Deserialize, Serialize};

/// State besides the targets; what the sensors saw and which doors were found closed outlives them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct MapWays {
    pub memory: ObstacleMemory,
    pub doors: DoorMemory,
    pub blockages: Blockages,
    /// Until then blockages are not planned around: with them there was no way.
    trusting_map_until_s: f64,
    /// Until then doors found closed are not planned around: there was no other way.
    trying_doors_until_s: f64,
    pub next_look_s: f64,
    /// Until then the robot must see where it is.
    pub sonars_until_s: f64,
    pub progress: MapProgress,
    pub without_way_s: f64,
    #[serde(skip)]
    costs: Cache<KnownCosts>,
}

/// How long the robot wants its sonars after being held up or touched.
const SEEING_S: f64 = 5.0;
/// An obstacle point this far from all obstacles of the map is unmapped ...
const UNMAPPED_M: f64 = 0.3;
/// ... and one that was felt this far.
const UNMAPPED_FELT_M: f64 = 0.15;
/// Readings up to this are sharp enough to plan around.
const SHARP_RANGE_M: f64 = 1.5;
/// How long blockages or closed doors are not planned around where there is no way around them.
const TRUSTING_MAP_S: f64 = 5.0;

impl MapWays {
    /// For new targets.
    pub fn start(&mut self, now_s: f64, patience_s: f64) {
        *self = Self {
            memory: std::mem::take(&mut self.memory),
            doors: std::mem::take(&mut self.doors),
            next_look_s: now_s,
            progress: MapProgress::from(now_s, patience_s),
            ..Self::default()
        };
    }

    /// Bytes of planned ways that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        self.costs.bytes_apart(&earlier.costs)
    }

    /// The doors found closed, as indices into the world's doors.
    pub fn closed_doors(&self, now_s: f64) -> Vec<usize> {
        self.doors.closed(now_s)
    }

    /// The doors found closed, unless there was no other way.
    pub fn avoided_doors(&self, now_s: f64) -> Vec<usize> {
        if now_s < self.trying_doors_until_s { Vec::new() } else { self.closed_doors(now_s) }
    }

    /// Whether somebody there tries a door found closed.
    pub fn is_at_closed_door(&self, model: &NavigationModel, here: Point, now_s: f64) -> bool {
        let is_trying = now_s < self.trying_doors_until_s;
        is_trying && self.doors.closed(now_s).iter().any(|&door| model.is_at_door(door, here))
    }

    /// What it costs to go to a target.
    pub fn costs(&mut self, model: &NavigationModel, target: Target, now_s: f64) -> Costs {
        let barriers_in_map = barriers(&model.doorways, &self.avoided_doors(now_s));
        let blocked_in_map = self.blockages.points_in_map().collect();
        self.costs.costs(model, target.point_in_frame, barriers_in_map, blocked_in_map)
    }

    /// The robot must see where it is, for a while.
    pub fn want_sonars(&mut self, now_s: f64) {
        self.sonars_until_s = now_s + SEEING_S;
    }

    /// Forgets all blockages, and looks for none for a while.
    pub fn trust_map(&mut self, now_s: f64) {
        self.blockages.clear();
        self.trusting_map_until_s = now_s + TRUSTING_MAP_S;
    }

    /// Whether blockages are looked for.
    pub fn doubts_map(&self, now_s: f64) -> bool {
        now_s >= self.trusting_map_until_s
    }

    /// Takes doors found closed for open for a while: somebody may open them.
    pub fn try_doors(&mut self, now_s: f64) {
        self.trying_doors_until_s = now_s + TRUSTING_MAP_S;
    }

    /// Whatever was found was found somewhere else.
    pub fn forget_where_things_are(&mut self, now_s: f64) {
        self.blockages.clear();
        self.doors = DoorMemory::default();
        self.progress.measure_from_elsewhere();
        self.next_look_s = now_s;
    }

    /// What was seen sharply, or felt, in the map.
    pub fn sharp_points(&self, estimated_in_map: Pose, odometry_in_odom: Pose) -> Vec<Point> {
        let to_map = to_map(estimated_in_map, odometry_in_odom);
        self.sharp().map(|point| to_map.apply(point.point_in_odom)).collect()
    }

    /// What of it stands there and is not in the map; with each whether it was felt.
    pub fn unmapped_points(
        &self,
        model: &NavigationModel,
        estimated_in_map: Pose,
        odometry_in_odom: Pose,
    ) -> Vec<(Point, bool)> {
        let to_map = to_map(estimated_in_map, odometry_in_odom);
        let standing = self.sharp().filter(|point| point.stands());
        let in_map = standing.map(|point| (to_map.apply(point.point_in_odom), point.is_felt()));
        let is_unmapped = |&(point_in_map, is_felt): &(Point, bool)| {
            let least_m = if is_felt { UNMAPPED_FELT_M } else { UNMAPPED_M };
            model.planner.obstacle_distance_m(point_in_map) > least_m
        };
        in_map.filter(is_unmapped).collect()
    }

    fn sharp(&self) -> impl Iterator<Item = &RememberedPoint> {
        self.memory.points().iter().filter(|point| point.range_m <= SHARP_RANGE_M)
    }
}

fn to_map(estimated_in_map: Pose, odometry_in_odom: Pose) -> Transform {
    Transform::new(estimated_in_map.compose(odometry_in_odom.inverse()))
}
