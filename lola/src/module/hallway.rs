//! What the robot knows of the hallway it is in.

use crate::feature::{Percept, Side};
use crate::features::FeatureDetection;
use crate::registration::{HallwayAxis, Registration};
use crate::routines::ScanAxis;
use rpl_robot::geometry::{Pose, wrap_angle_rad};
use rpl_robot::sensors::SonarScan;
use serde::{Deserialize, Serialize};

/// The robot was turned by hand when the walls run otherwise than the axis by so much, for so long.
const TURNED_RAD: f64 = 0.45;
const TURNED_S: f64 = 0.8;

/// The end of the hallway is reached so far before its wall.
const BEFORE_END_M: f64 = 0.9;

/// What is known of a hallway.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hallway {
    /// Its direction.
    pub registration: Registration,
    /// What is beside it; none before the first registration.
    detection: Option<FeatureDetection>,
    /// What was perceived in it, in the order of the numbers.
    pub percepts: Vec<Percept>,
    /// How the walls run around the robot.
    scan_axis: ScanAxis,
    turned_s: f64,
    /// Metres along the axis from where the robot was when it began with this hallway.
    along_m: f64,
    at_in_odom: Pose,
}

impl Hallway {
    /// Begins in a hallway whose direction is roughly known.
    pub fn start(heading_in_odom_rad: f64, at_in_odom: Pose) -> Self {
        Self {
            registration: Registration::start(heading_in_odom_rad),
            detection: None,
            percepts: Vec::new(),
            scan_axis: ScanAxis::default(),
            turned_s: 0.0,
            along_m: 0.0,
            at_in_odom,
        }
    }

    /// The direction the robot goes along it.
    pub fn heading_in_odom_rad(&self) -> f64 {
        self.registration.heading_in_odom_rad()
    }

    /// Where the robot is along it.
    pub fn along_m(&self) -> f64 {
        self.along_m
    }

    /// Where the robot was in it last.
    pub fn at_in_odom(&self) -> Pose {
        self.at_in_odom
    }

    /// The axis, if it is known.
    pub fn axis(&self) -> Option<&HallwayAxis> {
        self.registration.axis()
    }

    /// Keeps up with how far the robot has come.
    pub fn follow(&mut self, odometry_in_odom: Pose) {
        let driven = odometry_in_odom.point() - self.at_in_odom.point();
        let (sin, cos) = libm::sincos(self.heading_in_odom_rad());
        self.along_m += driven.x * cos + driven.y * sin;
        self.at_in_odom = odometry_in_odom;
    }

    /// Takes a scan in for the direction. Answers whether the robot stands otherwise in the hallway than its
    /// odometry says: it was turned by hand, and has to register again.
    pub fn register(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>, step_s: f64) -> bool {
        let was_known = self.axis().is_some();
        self.registration.take_in(odometry_in_odom, scan);
        self.scan_axis.take_in(scan);
        let walls_rad =
            self.scan_axis.axis_in_base_rad(scan).map(|in_base_rad| odometry_in_odom.heading_rad + in_base_rad);
        let is_off = walls_rad
            .is_some_and(|walls_rad| wrap_angle_rad(walls_rad - self.heading_in_odom_rad()).abs() > TURNED_RAD);
        self.turned_s = if is_off { self.turned_s + step_s } else { 0.0 };
        if let Some(walls_rad) = walls_rad.filter(|_| self.turned_s > TURNED_S) {
            self.turned_s = 0.0;
            self.registration = Registration::start(walls_rad);
            return true;
        }
        was_known && self.axis().is_none()
    }

    /// Takes a scan in for what is beside the robot; nothing before the axis is known.
    pub fn detect(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) {
        let Some(axis) = self.registration.axis() else { return };
        if self.detection.is_none() {
            self.along_m = 0.0;
        }
        let detection = self.detection.get_or_insert_with(|| FeatureDetection::start(axis, odometry_in_odom));
        self.percepts.extend(detection.take_in(axis, odometry_in_odom, scan, None));
    }

    /// Whether the robot stands before the end of it.
    pub fn is_at_end(&self) -> bool {
        let end_m = self.detection.as_ref().and_then(FeatureDetection::hallway_end_m);
        end_m.is_some_and(|end_m| end_m - self.along_m <= BEFORE_END_M)
    }

    /// From a pose to the wall on a side, if it was heard.
    pub fn wall_distance_m(&self, pose_in_odom: Pose, side: Side) -> Option<f64> {
        self.axis().and_then(|axis| axis.wall_distance_m(pose_in_odom, side))
    }

    /// The middle of an opening on the line of the wall, looking in. Where the wall was not heard, it is taken to
    /// be half a usual hallway away.
    pub fn opening_in_odom(&self, percept: &Percept) -> Pose {
        const HALF_WIDTH_M: f64 = 1.1;
        let heading_rad = self.heading_in_odom_rad();
        let here = Pose { heading_rad, ..self.at_in_odom };
        let wall_m = self.wall_distance_m(self.at_in_odom, percept.side).unwrap_or(HALF_WIDTH_M);
        let ahead_m = percept.middle_m() - self.along_m;
        let inwards_rad = percept.side.sign() * std::f64::consts::FRAC_PI_2;
        here.compose(Pose::new(ahead_m, percept.side.sign() * wall_m, inwards_rad))
    }
}
