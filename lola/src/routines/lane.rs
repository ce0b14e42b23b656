//! Where in a hallway there is room to drive on.

use rpl_robot::avoidance::DriveLimits;
use rpl_robot::geometry::Point;

/// Lanes are looked at up to so far to both sides of the robot, so far apart.
const ASIDE_M: f64 = 1.4;
const APART_M: f64 = 0.1;

/// A lane is looked at so far ahead; with less room than this it costs.
const HORIZON_M: f64 = 2.5;

/// Air beside the robot in a lane that is called free: what swerves needs more than what goes straight.
const AIR_M: f64 = 0.13;

/// What a metre off the wanted lane costs, what a metre off the one driven last, and what a metre that is
/// missing ahead.
const OFF_LANE: f64 = 0.5;
const OFF_LAST: f64 = 0.35;
const SHORT: f64 = 1.2;

/// A lane beside the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lane {
    /// How far to the left of the robot, across the hallway.
    pub aside_m: f64,
    /// How far it is free ahead, at most 2.5 m.
    pub free_m: f64,
}

/// The lane to drive in: near the wanted one and the one driven last, and free. The obstacle points lie in
/// the frame of the robot turned into the hallway: x along it, y to the left. Cost: 29 lanes × points.
pub fn clear_lane(limits: &DriveLimits, points: &[Point], wanted_m: f64, last_m: f64) -> Lane {
    let half_m = limits.robot_radius_m + AIR_M;
    let steps = (ASIDE_M / APART_M) as i32;
    let lanes = (-steps..=steps).map(|step| {
        let aside_m = f64::from(step) * APART_M;
        Lane { aside_m, free_m: free_m(limits, points, aside_m, half_m) }
    });
    let cost = |lane: &Lane| {
        let missing_m = HORIZON_M - lane.free_m;
        OFF_LANE * (lane.aside_m - wanted_m).abs() + OFF_LAST * (lane.aside_m - last_m).abs() + SHORT * missing_m
    };
    lanes.min_by(|one, other| cost(one).total_cmp(&cost(other))).unwrap_or(Lane { aside_m: wanted_m, free_m: 0.0 })
}

/// How far the robot's disc would get in a lane.
fn free_m(limits: &DriveLimits, points: &[Point], aside_m: f64, half_m: f64) -> f64 {
    let in_lane = points.iter().filter(|point| point.x > 0.0 && (point.y - aside_m).abs() < half_m);
    let nearest_m = in_lane.map(|point| point.x - limits.robot_radius_m).fold(HORIZON_M, f64::min);
    nearest_m.max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walls() -> Vec<Point> {
        (-10..40).flat_map(|step| [1.1, -1.1].map(|y| Point::new(f64::from(step) * 0.1, y))).collect()
    }

    #[test]
    fn the_wanted_lane_is_kept_where_it_is_free() {
        let lane = clear_lane(&DriveLimits::default(), &walls(), 0.3, 0.3);
        assert!((lane.aside_m - 0.3).abs() < 0.05 && lane.free_m == HORIZON_M, "{lane:?}");
    }

    #[test]
    fn a_box_is_passed_where_there_is_room() {
        let mut points = walls();
        points.extend((0..6).map(|step| Point::new(1.2, -0.4 + 0.1 * f64::from(step))));
        let lane = clear_lane(&DriveLimits::default(), &points, 0.0, 0.0);
        assert!(lane.aside_m.abs() > 0.3 && lane.free_m == HORIZON_M, "{lane:?}");
        points.extend((0..22).map(|step| Point::new(0.8, -1.1 + 0.1 * f64::from(step))));
        assert!(clear_lane(&DriveLimits::default(), &points, 0.0, 0.0).free_m < 0.6);
    }
}
