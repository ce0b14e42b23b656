//! Every number of the simulated robot.

use crate::sensors::SONAR_RANGE_M;
use crate::world::ROBOT_RADIUS_M;

/// Body, motors, sensors and gripper of the simulated robot; the default is a B21 with Polaroid
/// sonars in a plastered office corridor.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatorSettings {
    /// Time between two percepts: 50 ms, a control cycle of the papers' collision avoidance
    /// rounded down.
    pub step_us: u64,
    /// Radius of the body (B21: 53 cm across).
    pub robot_radius_m: f64,
    /// Fastest translation (RHINO's collision avoidance drove up to 95 cm/s).
    pub max_translation_mps: f64,
    /// Fastest rotation (60° per second).
    pub max_rotation_radps: f64,
    /// How fast translation picks up.
    pub translation_acceleration_mps2: f64,
    /// How fast translation slows down; brakes are stronger than the motors.
    pub translation_deceleration_mps2: f64,
    /// How fast rotation picks up and slows down.
    pub rotation_acceleration_radps2: f64,
    /// How fast translation slows down when the motors are cut and the brakes close: harder than one
    /// drives, so that the robot stands within half a second from its top speed.
    pub halt_deceleration_mps2: f64,
    /// The same for rotation.
    pub halt_deceleration_radps2: f64,

    /// Readings reach no farther; also the reading of a sonar without an echo.
    pub sonar_max_range_m: f64,
    /// Standard deviation of an echo, the part that does not depend on the distance.
    pub sonar_noise_m: f64,
    /// Standard deviation of an echo per metre of distance (Polaroid states 1 % over the range).
    pub sonar_noise_per_m: f64,
    /// Beyond this incidence, measured from the surface's normal, a wall may reflect the pulse away.
    /// Painted plaster loses the Polaroid's 6 mm waves from about 25° to 30°.
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
    /// How likely a sonar hears another sonar's pulse and reads too short. The ring fires its
    /// sonars in turn, so this is rare: here once in about 40 scans.
    pub crosstalk_probability: f64,
    /// How likely a single reading is lost.
    pub dropout_probability: f64,

    /// Whether there is a laser range finder. Off: it costs as much time as all sonars together.
    pub laser: bool,
    /// Readings reach no farther; also the reading without a return.
    pub laser_max_range_m: f64,
    /// Standard deviation of a laser reading (Sick PLS: a few centimetres).
    pub laser_noise_m: f64,
    /// How likely a laser reading is lost, as on glass or a black surface.
    pub laser_dropout_probability: f64,

    /// Random part of measured distance: standard deviation after one metre; grows with the root of
    /// the distance, so it does not depend on the length of a step.
    pub odometry_translation_noise_m_per_sqrt_m: f64,
    /// Random part of measured turns after one radian of turning.
    pub odometry_rotation_noise_rad_per_sqrt_rad: f64,
    /// Random part of the measured heading after one metre of driving.
    pub odometry_rotation_noise_rad_per_sqrt_m: f64,
    /// Spread, from robot to robot, of a constant scale error of measured distance (tyre wear).
    pub odometry_translation_bias: f64,
    /// Spread of a constant scale error of measured turns.
    pub odometry_rotation_bias: f64,
    /// Spread of a constant drift of the heading with the distance driven (a synchro drive's base
    /// creeps because its wheels are never quite parallel).
    pub odometry_heading_bias_radpm: f64,

    /// Air that people keep between themselves and the robot. At 0 they do not mind it, and run into
    /// it.
    pub person_clearance_m: f64,
    /// How long a person who gets no further waits before turning back, or going elsewhere.
    pub person_patience_us: u64,

    /// How long a full battery lasts while the robot stands.
    pub battery_standing_s: f64,
    /// How long it lasts while the robot drives (B21: some hours).
    pub battery_driving_s: f64,
    /// How long an empty one takes to be full.
    pub battery_charging_s: f64,

    /// How far from the robot's middle the gripper reaches.
    pub gripper_reach_m: f64,
    /// How long a grasp takes.
    pub grasp_us: u64,
    /// How long a release takes.
    pub release_us: u64,
    /// How likely a grasp closes on nothing.
    pub grasp_failure_probability: f64,
    /// How likely the gripper does not let go.
    pub release_failure_probability: f64,
}

impl Default for SimulatorSettings {
    fn default() -> Self {
        Self {
            step_us: 50_000,
            robot_radius_m: ROBOT_RADIUS_M,
            max_translation_mps: 0.95,
            max_rotation_radps: 60.0_f64.to_radians(),
            translation_acceleration_mps2: 0.5,
            translation_deceleration_mps2: 1.0,
            rotation_acceleration_radps2: 90.0_f64.to_radians(),
            halt_deceleration_mps2: 2.5,
            halt_deceleration_radps2: 180.0_f64.to_radians(),
            sonar_max_range_m: SONAR_RANGE_M,
            sonar_noise_m: 0.015,
            sonar_noise_per_m: 0.01,
            specular_angle_rad: 27.0_f64.to_radians(),
            specular_miss_probability: 0.6,
            edge_miss_probability: 0.2,
            specular_silence_probability: 0.7,
            specular_coherence_m: 0.1,
            specular_coherence_rad: 5.0_f64.to_radians(),
            crosstalk_probability: 0.001,
            dropout_probability: 0.01,
            laser: false,
            laser_max_range_m: 8.0,
            laser_noise_m: 0.02,
            laser_dropout_probability: 0.002,
            odometry_translation_noise_m_per_sqrt_m: 0.02,
            odometry_rotation_noise_rad_per_sqrt_rad: 0.02,
            odometry_rotation_noise_rad_per_sqrt_m: 0.5_f64.to_radians(),
            odometry_translation_bias: 0.01,
            odometry_rotation_bias: 0.01,
            odometry_heading_bias_radpm: 0.2_f64.to_radians(),
            person_clearance_m: 0.25,
            person_patience_us: 5_000_000,
            battery_standing_s: 8.0 * 3600.0,
            battery_driving_s: 4.0 * 3600.0,
            battery_charging_s: 900.0,
            gripper_reach_m: 0.8,
            grasp_us: 3_000_000,
            release_us: 2_000_000,
            grasp_failure_probability: 0.03,
            release_failure_probability: 0.005,
        }
    }
}

impl SimulatorSettings {
    /// A robot whose sensors, odometry and gripper make no errors: for closed forms and debugging.
    pub fn exact() -> Self {
        Self {
            sonar_noise_m: 0.0,
            sonar_noise_per_m: 0.0,
            specular_miss_probability: 0.0,
            edge_miss_probability: 0.0,
            crosstalk_probability: 0.0,
            dropout_probability: 0.0,
            laser_noise_m: 0.0,
            laser_dropout_probability: 0.0,
            odometry_translation_noise_m_per_sqrt_m: 0.0,
            odometry_rotation_noise_rad_per_sqrt_rad: 0.0,
            odometry_rotation_noise_rad_per_sqrt_m: 0.0,
            odometry_translation_bias: 0.0,
            odometry_rotation_bias: 0.0,
            odometry_heading_bias_radpm: 0.0,
            grasp_failure_probability: 0.0,
            release_failure_probability: 0.0,
            ..Self::default()
        }
    }

    /// Length of a step in seconds.
    pub fn step_s(&self) -> f64 {
        self.step_us as f64 * 1e-6
    }
}
