//! Whether a robot can drive straight from one point to another.

use rpl_robot::geometry::{Point, distance_m};
use rpl_robot::occupancy::{DistanceField, OccupancyGrid};

/// Steps along a line are at least this long, next to obstacles.
const LEAST_STEP_M: f64 = 0.02;

/// A map, looked at by a robot that needs some room on either side.
pub(super) struct Sight {
    field: DistanceField,
    room_m: f64,
}

impl Sight {
    /// Of a robot of this radius. O(cells).
    pub(super) fn new(map: &OccupancyGrid, robot_radius_m: f64) -> Self {
        Self { field: DistanceField::new(map), room_m: robot_radius_m }
    }

    /// Whether no obstacle of the map is nearer to the line between two points than the robot's radius. Cost:
    /// its length over the room there is.
    pub(super) fn is_free(&self, from_in_map: Point, to_in_map: Point) -> bool {
        let length_m = distance_m(from_in_map, to_in_map);
        let mut gone_m = 0.0;
        loop {
            let share = if length_m > 0.0 { (gone_m / length_m).min(1.0) } else { 1.0 };
            let spare_m = self.field.clearance_m(from_in_map + (to_in_map - from_in_map) * share) - self.room_m;
            if spare_m < 0.0 {
                return false;
            }
            if share >= 1.0 {
                return true;
            }
            gone_m += spare_m.max(LEAST_STEP_M);
        }
    }
}
