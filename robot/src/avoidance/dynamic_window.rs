//! The dynamic window (Fox, Burgard, Thrun, "The Dynamic Window Approach to Collision Avoidance",
//! 1997): of the velocities that can be reached within a moment, and from which the robot can still stop
//! before the next obstacle on its arc, the one that best combines heading, clearance and speed.
//!
//! The weights, the width of the window and how finely it is searched are ours.

use super::clearance::{CLEARANCE_HORIZON_M, Obstacle, clearance_m, near_obstacles, stops_in_time};
use super::limits::DriveLimits;
use crate::geometry::{Point, Pose, Velocity};
use std::f64::consts::PI;

/// What one decision is made from.
#[derive(Clone, Copy, Debug)]
pub struct WindowInput<'a> {
    /// For the memory of which way an escape goes.
    pub odometry_in_odom: Pose,
    /// Of the last percept.
    pub velocity: Velocity,
    /// Everything known to stand around the robot.
    pub obstacles_in_base: &'a [Point],
    /// Where to go.
    pub target_in_base: Point,
    /// Of the travel mode.
    pub speed_limit_mps: f64,
    /// How far it is still to the place where the robot is to stand.
    pub remaining_m: f64,
}

/// Velocities that can be reached within this time are considered,
pub const WINDOW_S: f64 = 0.25;
/// this many translations
const TRANSLATIONS: usize = 11;
/// times this many rotations, besides straight on and the turn to the target.
const ROTATIONS: usize = 21;

/// How many velocities a decision looks at.
pub const CANDIDATES: usize = TRANSLATIONS * (ROTATIONS + 2);

/// Weights of the paper's objective G, summing to 1: heading, clearance, speed.
const HEADING_WEIGHT: f64 = 0.7;
const CLEARANCE_WEIGHT: f64 = 0.12;
const SPEED_WEIGHT: f64 = 0.18;

/// The share of the acceleration that the last metres to where the robot is to stand count on, and the least speed
/// there: it stands where it is to, and not before.
const ARRIVAL_BRAKING: f64 = 0.6;
const ARRIVAL_MPS: f64 = 0.03;

/// The robot looks ahead at most this share of the way to its target: behind it every heading is bad.
const LOOK_SHARE: f64 = 0.5;

/// Beyond this bearing the robot turns before it drives.
pub(super) const TURN_IN_PLACE_RAD: f64 = 0.9;

/// The best of the admissible velocities; a full stop of the translation if none is. Cost:
/// [`CANDIDATES`] × obstacle points nearer than the clearance, and fewer where a velocity cannot be the
/// best whatever its clearance.
///
/// # Deviation
/// The paper's clearance is the distance to the next obstacle on the arc; here velocities are admissible
/// if the robot can stop within that distance after two more steps, which a command needs to take
/// effect. The paper takes velocities to change at once; here the best ones are driven ahead with the
/// true accelerations, until the robot stands, before they are chosen. So there is always a way to stop
/// short of everything known. Towards a target at the side or behind the robot turns in place, for paths
/// of the planner may start with a turn in a narrow place.
pub fn best_velocity(limits: &DriveLimits, input: &WindowInput<'_>) -> Velocity {
    let bearing_rad = libm::atan2(input.target_in_base.y, input.target_in_base.x);
    let window = ReachableVelocities::around(limits, input, bearing_rad);
    let near =
        near_obstacles(limits, input.obstacles_in_base, window.fastest_mps, |point| Obstacle::new(limits, point));
    let mut best: Option<(f64, Velocity)> = None;
    for rotation_radps in window.rotations() {
        let ahead = TargetAhead::after_turning(limits, input, rotation_radps);
        for translation_mps in window.translations() {
            let velocity = Velocity { translation_mps, rotation_radps };
            let without_clearance = ahead.value(translation_mps);
            if best.is_some_and(|(most, _)| without_clearance + CLEARANCE_WEIGHT <= most) {
                continue;
            }
            if let Some(clearance_m) = clearance_m(limits, &near, velocity) {
                let value = without_clearance + CLEARANCE_WEIGHT * clearance_m / CLEARANCE_HORIZON_M;
                if best.is_none_or(|(most, _)| value > most) && stops_in_time(limits, &near, input.velocity, velocity) {
                    best = Some((value, velocity));
                }
            }
        }
    }
    best.map_or_else(|| brake(limits, &near, input.velocity, window.straightest_turn_radps), |(_, velocity)| velocity)
}

/// As hard as possible; turning towards the target meanwhile only if that does not bend the way into
/// something.
fn brake(limits: &DriveLimits, near: &[Obstacle], now: Velocity, straightest_turn_radps: f64) -> Velocity {
    let turning = Velocity { translation_mps: 0.0, rotation_radps: straightest_turn_radps };
    if stops_in_time(limits, near, now, turning) { turning } else { Velocity::default() }
}

/// The target as the robot will see it once it has driven at a rotation for a moment and stopped
/// turning.
struct TargetAhead {
    /// Where half the turn points, in a frame turned by the whole turn.
    way_cos: f64,
    way_sin: f64,
    /// The target in that frame, from where the robot is now.
    target: Point,
    longest_way_m: f64,
    speed_limit_mps: f64,
}

impl TargetAhead {
    fn after_turning(limits: &DriveLimits, input: &WindowInput<'_>, rotation_radps: f64) -> Self {
        let braking_rad = rotation_radps * rotation_radps.abs() / (2.0 * limits.rotation_acceleration_radps2);
        let turned_rad = rotation_radps * WINDOW_S + braking_rad;
        let (sin, cos) = libm::sincos(turned_rad);
        let (half_sin, half_cos) = libm::sincos(turned_rad / 2.0);
        let target = input.target_in_base;
        Self {
            way_cos: half_cos,
            way_sin: -half_sin,
            target: Point::new(cos * target.x + sin * target.y, cos * target.y - sin * target.x),
            longest_way_m: target.coords.norm() * LOOK_SHARE,
            speed_limit_mps: input.speed_limit_mps,
        }
    }

    /// The objective but for the clearance: how well the robot looks at the target, and how fast it
    /// goes.
    fn value(&self, translation_mps: f64) -> f64 {
        let way_m = (translation_mps * WINDOW_S).min(self.longest_way_m);
        let off_rad = libm::atan2(self.target.y - way_m * self.way_sin, self.target.x - way_m * self.way_cos).abs();
        let speed = if self.speed_limit_mps > 0.0 { translation_mps / self.speed_limit_mps } else { 0.0 };
        HEADING_WEIGHT * (1.0 - off_rad / PI) + SPEED_WEIGHT * speed
    }
}

/// The velocities within reach.
struct ReachableVelocities {
    slowest_mps: f64,
    fastest_mps: f64,
    rightmost_radps: f64,
    leftmost_radps: f64,
    /// The rotation that ends just at the bearing of the target when braked in time.
    straightest_turn_radps: f64,
}

impl ReachableVelocities {
    fn around(limits: &DriveLimits, input: &WindowInput<'_>, bearing_rad: f64) -> Self {
        let gain_mps = limits.translation_acceleration_mps2 * WINDOW_S;
        let loss_mps = limits.translation_deceleration_mps2 * WINDOW_S;
        let gain_radps = limits.rotation_acceleration_radps2 * WINDOW_S;
        let braked_mps =
            libm::sqrt(2.0 * limits.translation_acceleration_mps2 * ARRIVAL_BRAKING * input.remaining_m.max(0.0));
        let turning = if bearing_rad.abs() > TURN_IN_PLACE_RAD { 0.0 } else { libm::cos(bearing_rad) };
        let allowed_mps = (input.speed_limit_mps * turning).min(braked_mps.max(ARRIVAL_MPS));
        let slowest_mps = (input.velocity.translation_mps - loss_mps).max(0.0);
        let fastest_mps = (input.velocity.translation_mps + gain_mps).min(allowed_mps).max(slowest_mps);
        let most_radps = limits.max_rotation_radps;
        let rotation_radps = input.velocity.rotation_radps.clamp(-most_radps, most_radps);
        let rightmost_radps = (rotation_radps - gain_radps).max(-most_radps);
        let leftmost_radps = (rotation_radps + gain_radps).min(most_radps);
        let straightest_turn_radps = limits.braked_turn_radps(bearing_rad).clamp(rightmost_radps, leftmost_radps);
        Self { slowest_mps, fastest_mps, rightmost_radps, leftmost_radps, straightest_turn_radps }
    }

    fn translations(&self) -> impl Iterator<Item = f64> + use<> {
        let (least, most) = (self.slowest_mps, self.fastest_mps);
        (0..TRANSLATIONS).map(move |step| least + (most - least) * step as f64 / (TRANSLATIONS - 1) as f64)
    }

    /// Evenly spread, and besides these straight on and the turn to the target.
    fn rotations(&self) -> impl Iterator<Item = f64> + use<> {
        let (least, most) = (self.rightmost_radps, self.leftmost_radps);
        (0..ROTATIONS)
            .map(move |step| least + (most - least) * step as f64 / (ROTATIONS - 1) as f64)
            .chain([0.0_f64.clamp(least, most), self.straightest_turn_radps])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn input(obstacles_in_base: &[Point], target_in_base: Point, velocity: Velocity) -> WindowInput<'_> {
        WindowInput {
            odometry_in_odom: Pose::default(),
            velocity,
            obstacles_in_base,
            target_in_base,
            speed_limit_mps: 0.65,
            remaining_m: 5.0,
        }
    }

    /// Where the robot is after some way on the arc of its speeds.
    fn on_arc(velocity: Velocity, way_m: f64) -> Point {
        let curvature_per_m = velocity.rotation_radps / velocity.translation_mps;
        if curvature_per_m.abs() < 1e-9 {
            return Point::new(way_m, 0.0);
        }
        let (sin, cos) = libm::sincos(way_m * curvature_per_m);
        Point::new(sin / curvature_per_m, (1.0 - cos) / curvature_per_m)
    }

    proptest! {
        #[test]
        fn the_stopping_arc_touches_no_obstacle(
            obstacles in proptest::collection::vec((-2.0..2.0f64, -2.0..2.0f64), 0..30),
            target in (-2.0..2.0f64, -2.0..2.0f64),
            velocity in (0.0..0.7f64, -1.0..1.0f64),
        ) {
            let limits = DriveLimits::default();
            let obstacles: Vec<Point> = obstacles
                .into_iter()
                .map(|(x, y)| Point::new(x, y))
                .filter(|point| point.coords.norm() > limits.robot_radius_m)
                .collect();
            let velocity = Velocity { translation_mps: velocity.0, rotation_radps: velocity.1 };
            let chosen = best_velocity(&limits, &input(&obstacles, Point::new(target.0, target.1), velocity));
            if chosen.translation_mps > 0.0 {
                let stopping_m = limits.stopping_distance_m(chosen.translation_mps);
                for step in 0..=200 {
                    let robot = on_arc(chosen, stopping_m * f64::from(step) / 200.0);
                    for obstacle in &obstacles {
                        let away_m = (obstacle - robot).norm();
                        prop_assert!(away_m > limits.robot_radius_m, "{chosen:?} {obstacle} {away_m}");
                    }
                }
            }
        }
    }

    #[test]
    fn free_distance_agrees_with_small_steps_along_the_arc() {
        let limits = DriveLimits::default();
        for (x, y, rotation_radps) in
            [(1.0, 0.0, 0.0), (1.0, 0.3, 0.0), (0.7, 0.6, 0.8), (0.3, -0.9, -1.0), (0.0, 1.2, 0.9)]
        {
            let velocity = Velocity { translation_mps: 0.5, rotation_radps };
            let obstacle = Point::new(x, y);
            let radius_m = limits.safe_radius_m(0.5);
            let stepped = (0..40_000)
                .map(|step| f64::from(step) * 1e-4)
                .find(|&way_m| (on_arc(velocity, way_m) - obstacle).norm() <= radius_m);
            let free_m = Obstacle::new(&limits, obstacle).free_distance_m(radius_m, rotation_radps / 0.5);
            match stepped {
                Some(way_m) => assert!((way_m - free_m).abs() < 2e-4, "{way_m} {free_m}"),
                None => assert!(free_m > 3.9),
            }
        }
    }

    #[test]
    fn a_free_robot_speeds_up_straight_ahead() {
        let chosen = best_velocity(&DriveLimits::default(), &input(&[], Point::new(3.0, 0.0), Velocity::default()));
        assert!(chosen.translation_mps > 0.1 && chosen.rotation_radps.abs() < 1e-9, "{chosen:?}");
    }

    #[test]
    fn a_target_behind_is_turned_to_in_place() {
        let limits = DriveLimits::default();
        for y in [0.1, -0.1] {
            let chosen = best_velocity(&limits, &input(&[], Point::new(-2.0, y), Velocity::default()));
            assert_eq!(chosen.translation_mps, 0.0);
            assert!(chosen.rotation_radps * y > 0.0, "{chosen:?}");
        }
    }

    #[test]
    fn a_wall_ahead_stops_the_robot() {
        let wall: Vec<Point> = (-20..=20).map(|step| Point::new(0.3, f64::from(step) * 0.05)).collect();
        let velocity = Velocity { translation_mps: 0.4, rotation_radps: 0.0 };
        let chosen = best_velocity(&DriveLimits::default(), &input(&wall, Point::new(2.0, 0.0), velocity));
        assert_eq!(chosen.translation_mps, 0.0);
    }

    #[test]
    fn mirrored_scenes_give_mirrored_speeds() {
        let obstacles = [Point::new(0.9, 0.2), Point::new(0.6, -0.7)];
        let mirrored = obstacles.map(|point| Point::new(point.x, -point.y));
        let limits = DriveLimits::default();
        let left = best_velocity(&limits, &input(&obstacles, Point::new(1.5, 0.4), Velocity::default()));
        let right = best_velocity(&limits, &input(&mirrored, Point::new(1.5, -0.4), Velocity::default()));
        assert_eq!(left.translation_mps, right.translation_mps);
        assert!((left.rotation_radps + right.rotation_radps).abs() < 1e-9);
    }
}
