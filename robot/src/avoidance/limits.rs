//! What the robot can do, and what it is allowed to.

use crate::description::RobotDescription;
use crate::geometry::Velocity;
use crate::world::TravelMode;

/// Steps until a command has taken effect: it is given after one percept, and the next one shows it.
const COMMAND_STEPS: f64 = 2.0;

/// The share of the angular deceleration that turns count on: what is left is for a late command.
const TURN_BRAKING: f64 = 0.7;

/// Between the robot's disc and an obstacle point that it still moves towards: the noise of a reading.
const HARD_MARGIN_M: f64 = 0.01;

/// What the robot can do, and what it is allowed to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveLimits {
    /// Of the robot's disc.
    pub robot_radius_m: f64,
    /// Counter-clockwise and clockwise alike.
    pub max_rotation_radps: f64,
    /// For speeding up.
    pub translation_acceleration_mps2: f64,
    /// For braking.
    pub translation_deceleration_mps2: f64,
    /// For speeding up and for braking.
    pub rotation_acceleration_radps2: f64,
    /// From one command to the next.
    pub step_s: f64,
    /// Air kept between the robot's disc and an obstacle point when it stands.
    pub margin_m: f64,
    /// Air kept besides for each metre per second.
    pub margin_s: f64,
    /// Speed in a hallway.
    pub hallway_mps: f64,
    /// Speed among furniture.
    pub office_mps: f64,
    /// Speed through a door.
    pub doorway_mps: f64,
}

impl Default for DriveLimits {
    /// Those of the papers' robot.
    fn default() -> Self {
        Self::of(&RobotDescription::papers())
    }
}

impl DriveLimits {
    /// Those of a robot.
    pub fn of(robot: &RobotDescription) -> Self {
        let RobotDescription { motors, driving, .. } = robot;
        Self {
            robot_radius_m: robot.radius_m,
            max_rotation_radps: driving.max_rotation_radps,
            translation_acceleration_mps2: motors.translation_acceleration_mps2,
            translation_deceleration_mps2: driving.translation_deceleration_mps2,
            rotation_acceleration_radps2: driving.rotation_acceleration_radps2,
            step_s: robot.step_us as f64 / 1e6,
            margin_m: 0.02,
            margin_s: 0.1,
            hallway_mps: driving.hallway_mps,
            office_mps: driving.office_mps,
            doorway_mps: driving.doorway_mps,
        }
    }

    /// The speed allowed in a travel mode.
    pub fn speed_limit_mps(&self, mode: TravelMode) -> f64 {
        match mode {
            TravelMode::Hallway => self.hallway_mps,
            TravelMode::Office => self.office_mps,
            TravelMode::Doorway => self.doorway_mps,
        }
    }

    /// The way the robot still makes at a speed before it stands: as far as it gets until a command
    /// takes effect, then braking.
    pub fn stopping_distance_m(&self, translation_mps: f64) -> f64 {
        translation_mps * COMMAND_STEPS * self.step_s
            + translation_mps * translation_mps / (2.0 * self.translation_deceleration_mps2)
    }

    /// The speed from which the robot stands within a way: the inverse of [`Self::stopping_distance_m`].
    pub fn speed_to_stop_in_mps(&self, way_m: f64) -> f64 {
        let (late_s, braking_mps2) = (COMMAND_STEPS * self.step_s, self.translation_deceleration_mps2);
        braking_mps2 * (libm::sqrt(late_s * late_s + 2.0 * way_m.max(0.0) / braking_mps2) - late_s)
    }

    /// The velocity a step later when another is wanted.
    pub fn towards(&self, now: Velocity, wanted: Velocity) -> Velocity {
        let towards = |from: f64, to: f64, most: f64| from + (to - from).clamp(-most, most);
        let speeds_up = wanted.translation_mps > now.translation_mps;
        let change_mps2 =
            if speeds_up { self.translation_acceleration_mps2 } else { self.translation_deceleration_mps2 };
        let change_radps = self.rotation_acceleration_radps2 * self.step_s;
        Velocity {
            translation_mps: towards(now.translation_mps, wanted.translation_mps, change_mps2 * self.step_s),
            rotation_radps: towards(now.rotation_radps, wanted.rotation_radps, change_radps),
        }
    }

    /// The rotation from which a turn by an angle can still be braked in time, with a reserve.
    pub fn braked_turn_radps(&self, turn_rad: f64) -> f64 {
        let timely_radps = libm::sqrt(2.0 * TURN_BRAKING * self.rotation_acceleration_radps2 * turn_rad.abs());
        libm::copysign(timely_radps.min(self.max_rotation_radps), turn_rad)
    }

    /// How near the middle of the robot may come to an obstacle point at a speed: the disc and a
    /// margin that grows with the speed.
    pub fn safe_radius_m(&self, translation_mps: f64) -> f64 {
        self.robot_radius_m + self.margin_m + self.margin_s * translation_mps
    }

    /// The least distance of an obstacle point that is still approached at all.
    pub(super) fn hard_radius_m(&self) -> f64 {
        self.robot_radius_m + HARD_MARGIN_M
    }
}
