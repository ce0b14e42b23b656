//! Collision avoidance over time: velocities out of the dynamic window, and a way out where none of them
//! gets the robot on.
//!
//! When the robot is held up, and which way out it takes, is no matter of the paper: the numbers are ours.

use super::clearance::{CLEARANCE_HORIZON_M, open_distance_m};
use super::dynamic_window::{TURN_IN_PLACE_RAD, WindowInput, best_velocity};
use super::limits::DriveLimits;
use crate::geometry::{Point, Velocity, wrap_angle_rad};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// How the collision avoidance gets on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum AvoidanceStatus {
    /// On the way to the target.
    Driving,
    /// Going where there is room, away from the target if need be.
    Escaping,
    /// Has not got away for several seconds.
    Stuck,
}

/// A decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AvoidanceChoice {
    /// To command.
    pub velocity: Velocity,
    /// How it gets on.
    pub status: AvoidanceStatus,
}

/// State of the collision avoidance: whether it is held up, and which way out it is trying.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CollisionAvoidance {
    /// For how long it has hardly moved though it should.
    held_up_s: f64,
    /// For how long it has not been driving freely.
    stuck_s: f64,
    escape: Option<Escape>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Escape {
    heading_in_odom_rad: f64,
    from_in_odom: Point,
    left_s: f64,
}

/// Held up for this time, the robot looks for another way out.
const PATIENCE_S: f64 = 1.0;
/// After this time without driving freely it is stuck.
const STUCK_S: f64 = 8.0;
/// Slower than this it hardly moves, unless it is there: so near to where it is to stand.
const CRAWLING_MPS: f64 = 0.04;
const THERE_M: f64 = 0.1;
/// What turning in place counts for against driving that does not get on.
const TURNING_WEIGHT: f64 = 0.2;
/// After these times held up, or not driving freely, it does not get on as it should.
const HESITATING_S: f64 = 0.25;
const FLAGGING_S: f64 = 0.5;
/// An escape ends after this distance or time.
const ESCAPE_M: f64 = 0.4;
const ESCAPE_S: f64 = 5.0;
/// It is as fast as this at most, as if it were to stand a little ahead, and looks for another way out
/// where this one is closed although the robot faces it to within this angle.
const ESCAPE_MPS: f64 = 0.2;
const ESCAPE_REMAINING_M: f64 = 1.0;
const FACING_RAD: f64 = 0.15;

/// A way out is looked for in this many directions all around,
const DIRECTIONS: u32 = 36;
/// each of which must be open so far, and a little to both sides of it too;
const OPEN_M: f64 = 0.15;
const ASIDE_RAD: f64 = 0.15;
/// the way back costs this much against the openness of the most open.
const OFF_TARGET_WEIGHT: f64 = 0.5;

impl Escape {
    fn velocity(&mut self, limits: &DriveLimits, input: &WindowInput<'_>) -> Velocity {
        let turn_rad = wrap_angle_rad(self.heading_in_odom_rad - input.odometry_in_odom.heading_rad);
        let target_in_base = Point::new(libm::cos(turn_rad), libm::sin(turn_rad));
        let speed_limit_mps = input.speed_limit_mps.min(ESCAPE_MPS);
        let velocity = best_velocity(
            limits,
            &WindowInput { target_in_base, remaining_m: ESCAPE_REMAINING_M, speed_limit_mps, ..*input },
        );
        if turn_rad.abs() < FACING_RAD && velocity.translation_mps <= 0.0 {
            self.heading_in_odom_rad = input.odometry_in_odom.heading_rad + way_out_rad(limits, input);
        }
        velocity
    }
}

impl CollisionAvoidance {
    /// One decision. Cost: [`best_velocity`], and when held up a look around.
    pub fn step(&mut self, limits: &DriveLimits, input: &WindowInput<'_>) -> AvoidanceChoice {
        self.end_escape(limits, input);
        if let Some(escape) = &mut self.escape {
            self.stuck_s += limits.step_s;
            return AvoidanceChoice { velocity: escape.velocity(limits, input), status: self.status() };
        }
        let velocity = best_velocity(limits, input);
        self.watch(limits, input, velocity);
        AvoidanceChoice { velocity, status: self.status() }
    }

    /// Whether the robot does not get on as it should.
    pub fn is_held_up(&self) -> bool {
        self.escape.is_some() || self.held_up_s > HESITATING_S || self.stuck_s > FLAGGING_S
    }

    fn status(&self) -> AvoidanceStatus {
        if self.stuck_s > STUCK_S {
            AvoidanceStatus::Stuck
        } else if self.escape.is_some() {
            AvoidanceStatus::Escaping
        } else {
            AvoidanceStatus::Driving
        }
    }

    fn watch(&mut self, limits: &DriveLimits, input: &WindowInput<'_>, velocity: Velocity) {
        let bearing_rad = libm::atan2(input.target_in_base.y, input.target_in_base.x);
        let crawls = velocity.translation_mps < CRAWLING_MPS && input.velocity.translation_mps < CRAWLING_MPS;
        if !crawls || input.remaining_m < THERE_M {
            self.held_up_s = 0.0;
            self.stuck_s = (self.stuck_s - limits.step_s).max(0.0);
            return;
        }
        // Turning towards a target at the side is not being held up, but it must not last.
        let weight = if bearing_rad.abs() < TURN_IN_PLACE_RAD { 1.0 } else { TURNING_WEIGHT };
        self.held_up_s += weight * limits.step_s;
        self.stuck_s += weight * limits.step_s;
        if self.held_up_s > PATIENCE_S {
            self.held_up_s = 0.0;
            self.escape = Some(Escape {
                heading_in_odom_rad: input.odometry_in_odom.heading_rad + way_out_rad(limits, input),
                from_in_odom: input.odometry_in_odom.point(),
                left_s: ESCAPE_S,
            });
        }
    }

    fn end_escape(&mut self, limits: &DriveLimits, input: &WindowInput<'_>) {
        if let Some(escape) = &mut self.escape {
            escape.left_s -= limits.step_s;
            let gone_m = (input.odometry_in_odom.point() - escape.from_in_odom).norm();
            if gone_m > ESCAPE_M || escape.left_s <= 0.0 {
                self.escape = None;
            }
        }
    }
}

/// The direction that is open and least off the target; straight back if none is open.
fn way_out_rad(limits: &DriveLimits, input: &WindowInput<'_>) -> f64 {
    let bearing_rad = libm::atan2(input.target_in_base.y, input.target_in_base.x);
    let mut best = (f64::NEG_INFINITY, PI);
    for step in 0..DIRECTIONS {
        let direction_rad = wrap_angle_rad(f64::from(step) * PI / (f64::from(DIRECTIONS) / 2.0));
        // A gap that is open in one direction only closes with the noise of the next reading.
        let open_m = [-ASIDE_RAD, 0.0, ASIDE_RAD]
            .map(|aside_rad| {
                open_distance_m(limits, input.obstacles_in_base, direction_rad + aside_rad, CLEARANCE_HORIZON_M)
            })
            .into_iter()
            .fold(CLEARANCE_HORIZON_M, f64::min);
        let off_rad = wrap_angle_rad(direction_rad - bearing_rad).abs();
        let score = open_m / CLEARANCE_HORIZON_M - OFF_TARGET_WEIGHT * off_rad / PI;
        if open_m > OPEN_M && score > best.0 {
            best = (score, direction_rad);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;

    #[test]
    fn a_walled_in_robot_is_stuck_after_a_while() {
        let ring: Vec<Point> = (0..72)
            .map(|step| Pose::new(0.0, 0.0, f64::from(step) * PI / 36.0).transform(Point::new(0.28, 0.0)))
            .collect();
        let mut avoidance = CollisionAvoidance::default();
        let input = WindowInput {
            odometry_in_odom: Pose::default(),
            velocity: Velocity::default(),
            obstacles_in_base: &ring,
            target_in_base: Point::new(1.0, 0.0),
            speed_limit_mps: 0.65,
            remaining_m: 5.0,
        };
        let limits = DriveLimits::default();
        let statuses: Vec<AvoidanceStatus> = (0..300).map(|_| avoidance.step(&limits, &input).status).collect();
        assert_eq!(statuses[0], AvoidanceStatus::Driving);
        assert_eq!(statuses[299], AvoidanceStatus::Stuck);
    }
}
