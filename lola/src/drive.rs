//! For tests: a robot that drives along a hallway of the simulator, and what it finds.

use crate::beside::axes_in_odom;
use crate::feature::{Percept, Side};
use crate::features::FeatureDetection;
use crate::registration::Registration;
use rpl_robot::avoidance::DriveLimits;
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Point, Pose, Velocity, wrap_angle_rad};
use rpl_robot::navigation::{DriveTask, LocalDrive, NavigationInput};
use rpl_robot::sensors::SonarScan;
use rpl_robot::simulator::{Commands, SimulatorModel, SimulatorSettings, SimulatorState};
use rpl_robot::world::World;
use std::sync::Arc;

/// A hallway of 2.2 m along x, from (1, 4) to (15, 6.2), the robot in it at (1.8, 5.1) looking along it; more text
/// after it.
pub(crate) fn corridor(more: &str) -> String {
    format!(
        "name = \"corridor\"\nsize = [16.0, 10.0]\nstart = [1.8, 5.1, 0]\n\
         [[wall]]\nline = [[0.925, 3.925], [15.075, 3.925], [15.075, 6.275], [0.925, 6.275], [0.925, 3.925]]\n{more}"
    )
}

/// A drive along the axis as it is known, in the middle between the walls.
pub(crate) struct Drive {
    pub model: SimulatorModel,
    pub state: SimulatorState,
    pub registration: Registration,
    pub detection: Option<FeatureDetection>,
    /// Where the robot was on the map when the detection was started.
    pub detected_from: Pose,
    pub odometry_in_odom: Pose,
    /// What the sonars heard last.
    pub ranges_m: Vec<f32>,
    pub percepts: Vec<Percept>,
    /// Where there are markers, if there is a camera.
    pub markers_in_odom: Option<Vec<Point>>,
    drive: LocalDrive,
    commands: Commands,
    lane_m: f64,
}

impl Drive {
    pub fn begin(text: &str, robot: RobotDescription, seed: u64, guess_off_rad: f64) -> Self {
        let world = World::parse(text, "hallway.toml").expect("no faults");
        let model = SimulatorModel::new(Arc::new(world), SimulatorSettings::of(robot));
        let state = model.start(seed);
        Self {
            registration: Registration::start(guess_off_rad - state.robot_in_map.heading_rad),
            detected_from: state.robot_in_map,
            model,
            state,
            detection: None,
            odometry_in_odom: Pose::default(),
            ranges_m: Vec::new(),
            percepts: Vec::new(),
            markers_in_odom: None,
            drive: LocalDrive::follow(Vec::new()),
            commands: Commands { sonars_on: true, ..Commands::default() },
            lane_m: 0.0,
        }
    }

    /// The hallway of these tests runs along x.
    pub fn true_axis_in_odom_rad(&self) -> f64 {
        wrap_angle_rad(self.odometry_in_odom.heading_rad - self.state.robot_in_map.heading_rad)
    }

    /// A step: the robot drives on along the axis, and detects features once the axis is known.
    pub fn step(&mut self) {
        let percept = self.model.step(&mut self.state, &self.commands);
        let sonars = self.model.sensors.sonars.as_ref().expect("it has sonars");
        let ranges_m = percept.sonar_m.as_ref().expect("they are on");
        let scan = SonarScan { sonars, ranges_m };
        let odometry_in_odom = percept.odometry_in_odom;
        self.odometry_in_odom = odometry_in_odom;
        self.ranges_m.clone_from(ranges_m);
        self.registration.take_in(odometry_in_odom, scan);
        let (along, left) = axes_in_odom(self.registration.heading_in_odom_rad());
        let at = odometry_in_odom.point().coords;
        if let Some(axis) = self.registration.axis() {
            if self.detection.is_none() {
                self.detected_from = self.state.robot_in_map;
                self.detection = Some(FeatureDetection::start(axis, odometry_in_odom));
            }
            let distance_m = |side| axis.wall_distance_m(odometry_in_odom, side);
            if let Some((left_m, right_m)) = distance_m(Side::Left).zip(distance_m(Side::Right)) {
                self.lane_m = left.dot(&at) + (left_m - right_m) / 2.0;
            }
            let markers = self.markers_in_odom.as_deref();
            let detection = self.detection.as_mut().expect("started above");
            self.percepts.extend(detection.take_in(axis, odometry_in_odom, scan, markers));
        }
        let target_in_odom = Point::from(along * (along.dot(&at) + 1.5) + left * self.lane_m);
        self.drive.task = DriveTask::Follow { path_in_odom: vec![target_in_odom] };
        let velocity = Velocity { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps };
        let input =
            NavigationInput { odometry_in_odom, velocity, sonar: Some(scan), laser: None, bumped: percept.bumped };
        let limits = DriveLimits::of(self.model.robot());
        let Velocity { translation_mps, rotation_radps } = self.drive.step(&limits, &input, 0.5).velocity;
        (self.commands.translation_mps, self.commands.rotation_radps) = (translation_mps, rotation_radps);
    }

    /// Goes no farther: the hallway ends here.
    pub fn stop_at(&mut self, end_m: f64) {
        if let (Some(axis), Some(detection)) = (self.registration.axis(), &mut self.detection) {
            self.percepts.extend(detection.finish(axis, Some(end_m), self.markers_in_odom.as_deref()));
        }
    }

    /// Drives up to this place of the map.
    pub fn drive_to(&mut self, x_m: f64) {
        let mut steps = 0;
        while self.state.robot_in_map.x_m < x_m && steps < 2_000 {
            self.step();
            steps += 1;
        }
    }
}
