//! Robots as data: what one is made of and what it can do, read from a file. Nothing here knows who moves
//! it, what it believes or what it is asked to do.
//!
//! One robot drives in all of them: a round body that turns on the spot and drives ahead. What differs is
//! how large and how fast it is, what it sees with, and what else it has.

mod builtin;
mod parse;
#[cfg(test)]
mod tests;

use crate::sensors::{CameraView, LaserScanner, RangeSensors, SonarArray, SonarLayout};
use serde::{Deserialize, Serialize};

/// No robot is smaller.
pub const LEAST_RADIUS_M: f64 = 0.02;

/// What a robot is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotDescription {
    /// Its name.
    pub name: String,
    /// What it is, in a sentence.
    pub purpose: String,
    /// Time from one percept to the next.
    pub step_us: u64,
    /// Of its body, a disc.
    pub radius_m: f64,
    /// What its wheels can do.
    pub motors: Motors,
    /// How it is driven.
    pub driving: Driving,
    /// Its sonars.
    pub sonar: Option<Sonar>,
    /// Its laser range finder.
    pub laser: Option<Laser>,
    /// Its camera.
    pub camera: Option<Camera>,
    /// Whether it feels that it touches something.
    pub bumper: bool,
    /// Its gripper.
    pub gripper: Option<GripperDescription>,
    /// Its battery; without one it drives for ever.
    pub battery: Option<BatteryDescription>,
    /// How its dead reckoning strays.
    pub odometry: OdometryDrift,
}

/// What the wheels of a robot can do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Motors {
    /// Fastest translation.
    pub max_translation_mps: f64,
    /// Fastest rotation.
    pub max_rotation_radps: f64,
    /// How fast translation picks up.
    pub translation_acceleration_mps2: f64,
    /// How fast translation slows down; brakes are stronger than the motors.
    pub translation_deceleration_mps2: f64,
    /// How fast rotation picks up and slows down.
    pub rotation_acceleration_radps2: f64,
    /// How fast translation slows down when the motors are cut and the brakes close: harder than one
    /// drives.
    pub halt_deceleration_mps2: f64,
    /// The same for rotation.
    pub halt_deceleration_radps2: f64,
}

/// How a robot is driven: what is counted on of what the motors can do, and how fast it goes where.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Driving {
    /// No rotation that is faster is asked for.
    pub max_rotation_radps: f64,
    /// The braking that is counted on.
    pub translation_deceleration_mps2: f64,
    /// The change of rotation that is counted on.
    pub rotation_acceleration_radps2: f64,
    /// Speed in a hallway.
    pub hallway_mps: f64,
    /// Speed among furniture.
    pub office_mps: f64,
    /// Speed through a door.
    pub doorway_mps: f64,
}

/// The sonars of a robot and their errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sonar {
    /// Where each sits and looks.
    pub layout: SonarLayout,
    /// Opening of a cone.
    pub cone_rad: f64,
    /// Readings reach no farther; also the reading without an echo.
    pub range_m: f64,
    /// Standard deviation of an echo, the part that does not depend on the distance.
    pub noise_m: f64,
    /// Standard deviation of an echo per metre of distance.
    pub noise_per_m: f64,
    /// Beyond this incidence, measured from the surface's normal, a wall may reflect the pulse away.
    pub specular_angle_rad: f64,
    /// How likely a wall beyond that angle gives no direct echo.
    pub specular_miss_probability: f64,
    /// How likely an edge, such as a door jamb, gives no echo: it scatters only a part of the pulse.
    pub edge_miss_probability: f64,
    /// How likely a missed surface gives no reading at all rather than one over a detour, which is
    /// too long.
    pub specular_silence_probability: f64,
    /// A miss depends on how the wall is hit; it stays as it is while the robot has not moved by about
    /// this, so that standing still does not average it out.
    pub specular_coherence_m: f64,
    /// The same for turning.
    pub specular_coherence_rad: f64,
    /// How likely a sonar hears another sonar's pulse and reads too short.
    pub crosstalk_probability: f64,
    /// How likely a single reading is lost.
    pub dropout_probability: f64,
}

/// The laser range finder of a robot and its errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Laser {
    /// How its readings lie.
    pub scanner: LaserScanner,
    /// Standard deviation of a reading.
    pub noise_m: f64,
    /// How likely a reading is lost, as on glass or a black surface.
    pub dropout_probability: f64,
}

/// The camera of a robot on its pan unit, and its errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// How it sees.
    pub view: CameraView,
    /// Time from one image to the next while it is on.
    pub period_us: u64,
    /// So far it turns from straight ahead to either side.
    pub pan_range_rad: f64,
    /// Fastest turning of the pan unit.
    pub max_pan_radps: f64,
    /// How fast that picks up and slows down.
    pub pan_acceleration_radps2: f64,
    /// Spread of a colour's value, in a range of 0 to 1.
    pub noise: f64,
}

/// A gripper.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GripperDescription {
    /// How far from the robot's middle it reaches.
    pub reach_m: f64,
    /// How long a grasp takes.
    pub grasp_us: u64,
    /// How long a release takes.
    pub release_us: u64,
    /// How likely a grasp closes on nothing.
    pub grasp_failure_probability: f64,
    /// How likely it does not let go.
    pub release_failure_probability: f64,
}

/// A battery.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BatteryDescription {
    /// How long a full one lasts while the robot stands.
    pub standing_s: f64,
    /// How long it lasts while the robot drives.
    pub driving_s: f64,
    /// How long an empty one takes to be full.
    pub charging_s: f64,
}

/// How dead reckoning strays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OdometryDrift {
    /// Random part of measured distance: standard deviation after one metre; grows with the root of
    /// the distance, so it does not depend on the length of a step.
    pub translation_noise_m_per_sqrt_m: f64,
    /// Random part of measured turns after one radian of turning.
    pub rotation_noise_rad_per_sqrt_rad: f64,
    /// Random part of the measured heading after one metre of driving.
    pub rotation_noise_rad_per_sqrt_m: f64,
    /// Spread, from robot to robot, of a constant scale error of measured distance (tyre wear).
    pub translation_bias: f64,
    /// Spread of a constant scale error of measured turns.
    pub rotation_bias: f64,
    /// Spread of a constant drift of the heading with the distance driven (a synchro drive's base
    /// creeps because its wheels are never quite parallel).
    pub heading_bias_radpm: f64,
}

impl OdometryDrift {
    /// Odometry that does not stray.
    pub const NONE: Self = Self {
        translation_noise_m_per_sqrt_m: 0.0,
        rotation_noise_rad_per_sqrt_rad: 0.0,
        rotation_noise_rad_per_sqrt_m: 0.0,
        translation_bias: 0.0,
        rotation_bias: 0.0,
        heading_bias_radpm: 0.0,
    };

    /// Every error multiplied by `factor`.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self {
            translation_noise_m_per_sqrt_m: factor * self.translation_noise_m_per_sqrt_m,
            rotation_noise_rad_per_sqrt_rad: factor * self.rotation_noise_rad_per_sqrt_rad,
            rotation_noise_rad_per_sqrt_m: factor * self.rotation_noise_rad_per_sqrt_m,
            translation_bias: factor * self.translation_bias,
            rotation_bias: factor * self.rotation_bias,
            heading_bias_radpm: factor * self.heading_bias_radpm,
        }
    }
}

impl RobotDescription {
    /// Length of a step in seconds.
    pub fn step_s(&self) -> f64 {
        self.step_us as f64 * 1e-6
    }

    /// How its range sensors look, ready for looking things up.
    pub fn range_sensors(&self) -> RangeSensors {
        let array = |sonar: &Sonar| SonarArray::new(&sonar.layout, sonar.cone_rad, sonar.range_m);
        RangeSensors { sonars: self.sonar.as_ref().map(array), laser: self.laser.map(|laser| laser.scanner) }
    }

    /// The same robot as projections simulate it: with odometry that does not stray, for nobody sets it right there,
    /// and with long steps.
    #[must_use]
    pub fn foreseen(&self) -> Self {
        const STEP_US: u64 = 100_000;
        Self { step_us: self.step_us.max(STEP_US), odometry: OdometryDrift::NONE, ..self.clone() }
    }

    /// The same robot with sensors, odometry and a gripper that make no errors: for closed forms and
    /// debugging.
    #[must_use]
    pub fn without_errors(mut self) -> Self {
        if let Some(sonar) = &mut self.sonar {
            (sonar.noise_m, sonar.noise_per_m) = (0.0, 0.0);
            (sonar.specular_miss_probability, sonar.edge_miss_probability) = (0.0, 0.0);
            (sonar.crosstalk_probability, sonar.dropout_probability) = (0.0, 0.0);
        }
        if let Some(laser) = &mut self.laser {
            (laser.noise_m, laser.dropout_probability) = (0.0, 0.0);
        }
        if let Some(camera) = &mut self.camera {
            camera.noise = 0.0;
        }
        if let Some(gripper) = &mut self.gripper {
            (gripper.grasp_failure_probability, gripper.release_failure_probability) = (0.0, 0.0);
        }
        Self { odometry: OdometryDrift::NONE, ..self }
    }
}
