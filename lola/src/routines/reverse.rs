//! Reversing: slowly back along the axis of a hallway, as far as the robot sees behind.

use rpl_robot::avoidance::{DriveLimits, open_distance_m};
use rpl_robot::geometry::{Velocity, wrap_angle_rad};
use rpl_robot::navigation::NavigationInput;
use rpl_robot::obstacles::ObstacleMemory;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// How fast the robot backs up, and at least towards the end.
const FASTEST_MPS: f64 = 0.25;
const SLOWEST_MPS: f64 = 0.04;

/// It is there when it is within this distance.
const THERE_M: f64 = 0.015;

/// What it needs free behind it, in straight line and a little to both sides.
const ROOM_M: f64 = 0.15;
const ASIDE_RAD: f64 = 0.2;
const HORIZON_M: f64 = 1.0;

/// How fast it turns for each radian off the axis.
const STEERING_PER_S: f64 = 1.0;

/// What has stood behind for longer than this does not go away.
const PATIENCE_S: f64 = 6.0;

/// How a step went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReverseStatus {
    /// To command.
    Driving(Velocity),
    /// The robot stands where it is to.
    Arrived,
    /// Something is behind it, or it does not see what is.
    Blocked,
}

/// State of a drive backwards.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reverse {
    memory: ObstacleMemory,
    held_up_s: f64,
}

impl Reverse {
    /// One step of `limits.step_s`, with this much still to go backwards against the axis of the hallway.
    pub fn step(
        &mut self,
        limits: &DriveLimits,
        input: &NavigationInput<'_>,
        heading_in_odom_rad: f64,
        back_m: f64,
    ) -> ReverseStatus {
        let here = input.odometry_in_odom;
        self.memory.update(here, input.sonar, input.laser, limits.step_s, |_| None);
        if back_m <= THERE_M {
            let stands = input.velocity.translation_mps.abs() < SLOWEST_MPS;
            return if stands { ReverseStatus::Arrived } else { ReverseStatus::Driving(Velocity::default()) };
        }
        let mut obstacles_in_base = Vec::new();
        self.memory.append_in_base(here, &mut obstacles_in_base);
        let open_m = |aside_rad: f64| open_distance_m(limits, &obstacles_in_base, PI + aside_rad, HORIZON_M);
        let behind_m = [-ASIDE_RAD, 0.0, ASIDE_RAD].map(open_m).into_iter().fold(HORIZON_M, f64::min);
        let backwards_mps = -input.velocity.translation_mps;
        if !input.sees_towards(PI) || behind_m < ROOM_M + limits.stopping_distance_m(backwards_mps.max(0.0)) {
            self.held_up_s += limits.step_s;
            let is_blocked = self.held_up_s > PATIENCE_S || input.bumped;
            return if is_blocked { ReverseStatus::Blocked } else { ReverseStatus::Driving(Velocity::default()) };
        }
        let braked_mps = libm::sqrt(limits.translation_acceleration_mps2 * back_m);
        let off_rad = wrap_angle_rad(heading_in_odom_rad - here.heading_rad);
        ReverseStatus::Driving(Velocity {
            translation_mps: -braked_mps.clamp(SLOWEST_MPS, FASTEST_MPS),
            rotation_radps: (STEERING_PER_S * off_rad).clamp(-0.3, 0.3),
        })
    }
}
