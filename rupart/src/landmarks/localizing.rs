//! The states Loc1, which goes before a landmark, and Loc2, which turns to its wall and measures.

use super::wall_ahead::{WallAhead, wall_ahead};
use rpl_robot::avoidance::DriveLimits;
use rpl_robot::geometry::{Point, Pose, Vector, Velocity, wrap_angle_rad};
use rpl_robot::navigation::NavigationInput;
use rpl_robot::world::Landmark;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// The robot stands this far before a landmark to measure ...
const BEFORE_M: f64 = 0.9;

/// ... or within this distance of that.
const THERE_M: f64 = 0.2;

/// How fast it drives there, once it looks there.
const APPROACH_MPS: f64 = 0.3;
const AHEAD_RAD: f64 = 0.4;

/// It looks to the wall when it is ahead to within this angle ...
const FACED_RAD: f64 = 2.0 / 180.0 * PI;

/// ... and turns once more if what it heard says that it does not.
const OFF_FACED_RAD: f64 = 6.0 / 180.0 * PI;

/// How many scans are heard, and how many images seen at the least, before the position is taken.
const SCANS: usize = 20;
const FEWEST_BEARINGS: usize = 2;

/// A robot that has no position after this time gives up.
const PATIENCE_S: f64 = 20.0;

/// The landmark that the robot localizes by.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LocalizingTarget {
    /// Which it is taken for.
    pub landmark: usize,
    /// Where it was seen last.
    pub at_in_odom: Point,
    /// Where it faces, as far as the robot knows.
    pub facing_in_odom_rad: f64,
}

/// What was measured before a landmark.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LandmarkFix {
    /// The landmark.
    pub landmark: usize,
    /// From the middle of the robot, straight to the wall.
    pub wall_m: f64,
    /// In which direction that is.
    pub wall_bearing_rad: f64,
    /// In which direction the landmark is.
    pub landmark_bearing_rad: f64,
}

impl LandmarkFix {
    /// Where the robot is, by the distance of the wall and the angle of the camera.
    pub fn pose_in_map(&self, landmark: &Landmark) -> Pose {
        let to_wall = -landmark.facing();
        let left = Vector::new(-to_wall.y, to_wall.x);
        let aside_m = self.wall_m * libm::tan(self.landmark_bearing_rad - self.wall_bearing_rad);
        let at_in_map = landmark.pose_in_map.point() - to_wall * self.wall_m - left * aside_m;
        Pose::new(at_in_map.x, at_in_map.y, landmark.pose_in_map.heading_rad + PI - self.wall_bearing_rad)
    }
}

/// How localizing ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocalizingEnd {
    /// The position is known.
    Localized(LandmarkFix),
    /// The landmark was not come to, or not heard and seen from there.
    Lost,
}

/// How far the robot has got with localizing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Localizing {
    target: Option<LocalizingTarget>,
    spent_s: f64,
    /// How much it is to turn further, by what the sonars have heard.
    off_rad: f64,
    scans_m: Vec<Vec<f32>>,
    bearings_rad: Vec<f64>,
}

impl Localizing {
    /// Begins with a landmark.
    pub fn begin(target: LocalizingTarget) -> Self {
        Self { target: Some(target), ..Self::default() }
    }

    /// The landmark.
    pub fn target(&self) -> Option<&LocalizingTarget> {
        self.target.as_ref()
    }

    /// The landmark was seen again, from where the odometry was here.
    pub fn see(&mut self, robot_in_odom: Pose, at_in_base: Point) {
        if let Some(target) = &mut self.target {
            target.at_in_odom = robot_in_odom.transform(at_in_base);
        }
        if !self.scans_m.is_empty() {
            self.bearings_rad.push(libm::atan2(at_in_base.y, at_in_base.x));
        }
    }

    /// Counts the time, and tells whether it is spent.
    pub fn is_spent(&mut self, step_s: f64) -> bool {
        self.spent_s += step_s;
        self.spent_s > PATIENCE_S
    }

    /// Loc1: how to drive to before the landmark; none once it is there.
    pub fn approach(&self, limits: &DriveLimits, robot_in_odom: Pose) -> Option<Velocity> {
        let target = self.target?;
        let (sin, cos) = libm::sincos(target.facing_in_odom_rad);
        let spot_in_odom = target.at_in_odom + Vector::new(cos, sin) * BEFORE_M;
        let spot_in_base = robot_in_odom.inverse().transform(spot_in_odom);
        if spot_in_base.coords.norm() < THERE_M {
            return None;
        }
        let bearing_rad = libm::atan2(spot_in_base.y, spot_in_base.x);
        let translation_mps = if bearing_rad.abs() < AHEAD_RAD { APPROACH_MPS } else { 0.0 };
        Some(Velocity { translation_mps, rotation_radps: limits.braked_turn_radps(bearing_rad) })
    }

    /// Loc2: how to turn to the wall; none while the robot looks to it.
    pub fn turn(&self, limits: &DriveLimits, robot_in_odom: Pose) -> Option<Velocity> {
        let target = self.target?;
        let wall_rad = target.facing_in_odom_rad + PI + self.off_rad;
        let bearing_rad = wrap_angle_rad(wall_rad - robot_in_odom.heading_rad);
        let is_listening = !self.scans_m.is_empty();
        (!is_listening && bearing_rad.abs() > FACED_RAD)
            .then(|| Velocity { translation_mps: 0.0, rotation_radps: limits.braked_turn_radps(bearing_rad) })
    }

    /// Loc2, once the robot looks to the wall: listens and looks until it knows where it is.
    pub fn measure(&mut self, input: &NavigationInput<'_>) -> Option<LocalizingEnd> {
        let target = self.target?;
        let scan = input.sonar?;
        if input.velocity.rotation_radps.abs() > 0.01 {
            return None;
        }
        self.scans_m.push(scan.ranges_m.to_vec());
        if self.scans_m.len() < SCANS || self.bearings_rad.len() < FEWEST_BEARINGS {
            return (self.scans_m.len() > 3 * SCANS).then_some(LocalizingEnd::Lost);
        }
        let Some(WallAhead { off_m, bearing_rad }) = wall_ahead(scan.sonars, &self.scans_m) else {
            return Some(LocalizingEnd::Lost);
        };
        let landmark_bearing_rad = self.bearings_rad.iter().sum::<f64>() / self.bearings_rad.len() as f64;
        self.scans_m.clear();
        self.bearings_rad.clear();
        if bearing_rad.abs() > OFF_FACED_RAD {
            self.off_rad += bearing_rad;
            return None;
        }
        Some(LocalizingEnd::Localized(LandmarkFix {
            landmark: target.landmark,
            wall_m: off_m,
            wall_bearing_rad: bearing_rad,
            landmark_bearing_rad,
        }))
    }
}
