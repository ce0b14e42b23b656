//! Whether a robot can drive straight from one point to another.

use rpl_robot::geometry::{Point, distance_m};
use rpl_robot::occupancy::{DistanceField, OccupancyGrid};

/// Steps along a line are at least this long, next to obstacles.
const LEAST_STEP_M: f64 = 0.02;

/// ... and at most this long, so that no narrow place is stepped over.
const MOST_STEP_M: f64 = 0.3;

/// A map, looked at by a robot that needs some room on either side.
pub(super) struct Sight {
    field: DistanceField,
    pub(super) robot_radius_m: f64,
}

impl Sight {
    /// Of a robot of this radius. O(cells).
    pub(super) fn new(map: &OccupancyGrid, robot_radius_m: f64) -> Self {
        Self { field: DistanceField::new(map), robot_radius_m }
    }

    /// Whether a robot can drive straight from one point to the other.
    pub(super) fn is_free(&self, from_in_map: Point, to_in_map: Point) -> bool {
        self.room_m(from_in_map, to_in_map).is_some()
    }

    /// How much room there is on either side of a robot that drives straight from one point to another, at least;
    /// none if an obstacle of the map is nearer to the line than its radius. Cost: its length over the room there is.
    pub(super) fn room_m(&self, from_in_map: Point, to_in_map: Point) -> Option<f64> {
        let length_m = distance_m(from_in_map, to_in_map);
        let (mut gone_m, mut least_m) = (0.0, f64::INFINITY);
        loop {
            let share = if length_m > 0.0 { (gone_m / length_m).min(1.0) } else { 1.0 };
            let at_in_map = from_in_map + (to_in_map - from_in_map) * share;
            let spare_m = self.field.clearance_m(at_in_map) - self.robot_radius_m;
            if spare_m < 0.0 {
                return None;
            }
            least_m = spare_m.min(least_m);
            if share >= 1.0 {
                return Some(least_m);
            }
            // Where there is much room, what comes next has at least the rest of it.
            gone_m += spare_m.clamp(LEAST_STEP_M, MOST_STEP_M);
        }
    }
}
