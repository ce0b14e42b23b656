//! What the sonars saw lately, kept in `odom`: twenty-four cones are sparse, and some are lost.

use crate::geometry::{Point, Pose, wrap_angle_rad};
use crate::localization::SONARS;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Half the opening of a sonar cone.
const HALF_CONE_RAD: f64 = TAU / SONARS as f64 / 2.0;

/// Readings farther than this are not remembered: the arc they may come from is too wide.
const USEFUL_RANGE_M: f64 = 2.0;

/// Remembered points farther from the robot than this are forgotten.
const MEMORY_RANGE_M: f64 = 2.5;

/// Points are forgotten this long after they were last seen, time without sonars not counted:
/// nothing could have shown that they are gone.
const MEMORY_S: f64 = 6.0;

/// Points nearer to each other than this are one.
const GRAIN_M: f64 = 0.05;

/// Half as many readings must pass through a point before it is forgotten.
const DOUBTS: u8 = 6;

/// A point where the nearest surface of a cone may be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RememberedPoint {
    /// Its cell on a grid of 5 cm, by which points are kept apart and in order.
    cell: (i32, i32),
    /// Where it was seen last, in `odom`.
    pub point_in_odom: Point,
    /// The reading it comes from.
    pub range_m: f64,
    seen_at_s: f64,
    doubts: u8,
}

/// Obstacle points seen lately. Points that a later reading passes through are doubted and then
/// forgotten, others after some seconds or metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleMemory {
    /// Time with sonars.
    now_s: f64,
    /// Sorted by cell.
    points: Vec<RememberedPoint>,
}

impl ObstacleMemory {
    /// At most so many points; the ones seen longest ago go first.
    pub const CAPACITY: usize = 400;

    /// Takes in one scan, or only lets `step_s` pass. A reading is the distance from the robot's
    /// centre; one that is not in (0, `max_range_m`) saw nothing.
    pub fn update(&mut self, odometry_in_odom: Pose, sonar_m: Option<&[f32; SONARS]>, max_range_m: f64, step_s: f64) {
        if let Some(sonar_m) = sonar_m {
            self.now_s += step_s;
            self.doubt(odometry_in_odom, sonar_m, max_range_m);
            for (sonar, &range_m) in sonar_m.iter().enumerate() {
                let range_m = f64::from(range_m);
                if range_m > 0.0 && range_m < max_range_m.min(USEFUL_RANGE_M) {
                    self.see(odometry_in_odom, direction_rad(sonar), range_m);
                }
            }
        }
        let here = odometry_in_odom.point();
        self.points.retain(|point| {
            self.now_s - point.seen_at_s <= MEMORY_S
                && (point.point_in_odom - here).norm_squared() <= MEMORY_RANGE_M * MEMORY_RANGE_M
        });
        self.forget_oldest();
    }

    /// Remembers an obstacle felt, not seen: the robot drives forward only, so it is at the front.
    pub fn feel(&mut self, odometry_in_odom: Pose, robot_radius_m: f64) {
        for direction_rad in [-0.7, 0.0, 0.7] {
            self.see(odometry_in_odom, direction_rad, robot_radius_m + 0.01);
        }
    }

    /// The points, in `odom`.
    pub fn points(&self) -> &[RememberedPoint] {
        &self.points
    }

    /// The points as seen from the robot, appended to `points_in_base`.
    pub fn append_in_base(&self, odometry_in_odom: Pose, points_in_base: &mut Vec<Point>) {
        let odom_in_base = Transform::new(odometry_in_odom.inverse());
        points_in_base.extend(self.points.iter().map(|point| odom_in_base.apply(point.point_in_odom)));
    }

    /// The surface is somewhere on the arc: all of it counts.
    fn see(&mut self, odometry_in_odom: Pose, direction_rad: f64, range_m: f64) {
        let steps = libm::ceil(HALF_CONE_RAD * range_m / (1.6 * GRAIN_M)).max(1.0) as i32;
        for step in -steps..=steps {
            let angle_rad =
                odometry_in_odom.heading_rad + direction_rad + HALF_CONE_RAD * f64::from(step) / f64::from(steps);
            let (sin, cos) = libm::sincos(angle_rad);
            let point_in_odom = Point::new(odometry_in_odom.x_m + cos * range_m, odometry_in_odom.y_m + sin * range_m);
            self.remember(point_in_odom, range_m);
        }
    }

    fn remember(&mut self, point_in_odom: Point, range_m: f64) {
        let cell = (libm::floor(point_in_odom.x / GRAIN_M) as i32, libm::floor(point_in_odom.y / GRAIN_M) as i32);
        let seen = RememberedPoint { cell, point_in_odom, range_m, seen_at_s: self.now_s, doubts: 0 };
        match self.points.binary_search_by(|point| point.cell.cmp(&cell)) {
            Ok(index) => self.points[index] = seen,
            Err(index) => self.points.insert(index, seen),
        }
    }

    /// A sonar that hears nothing tells half as much: smooth walls throw its sound away.
    fn doubt(&mut self, odometry_in_odom: Pose, sonar_m: &[f32; SONARS], max_range_m: f64) {
        let odom_in_base = Transform::new(odometry_in_odom.inverse());
        for point in &mut self.points {
            let point_in_base = odom_in_base.apply(point.point_in_odom);
            let bearing_rad = libm::atan2(point_in_base.y, point_in_base.x);
            let sonar = libm::round(bearing_rad / (2.0 * HALF_CONE_RAD)) as i64;
            let off_axis_rad = wrap_angle_rad(bearing_rad - sonar as f64 * 2.0 * HALF_CONE_RAD).abs();
            let reading_m = f64::from(sonar_m[sonar.rem_euclid(SONARS as i64) as usize]);
            let passes = reading_m > point_in_base.coords.norm() + GRAIN_M;
            if passes && off_axis_rad < 0.95 * HALF_CONE_RAD {
                point.doubts += if reading_m < max_range_m { 2 } else { 1 };
            }
        }
        self.points.retain(|point| point.doubts < DOUBTS);
    }

    fn forget_oldest(&mut self) {
        if self.points.len() <= Self::CAPACITY {
            return;
        }
        let mut times: Vec<f64> = self.points.iter().map(|point| point.seen_at_s).collect();
        times.sort_by(f64::total_cmp);
        let oldest_kept = times[times.len() - Self::CAPACITY];
        self.points.retain(|point| point.seen_at_s >= oldest_kept);
        self.points.truncate(Self::CAPACITY);
    }
}

/// Where sonar number `sonar` looks, from straight ahead.
pub fn direction_rad(sonar: usize) -> f64 {
    sonar as f64 * 2.0 * HALF_CONE_RAD
}

/// A pose with its sine and cosine taken once, for many points.
pub(super) struct Transform {
    x_m: f64,
    y_m: f64,
    sin: f64,
    cos: f64,
}

impl Transform {
    pub fn new(pose: Pose) -> Self {
        let (sin, cos) = libm::sincos(pose.heading_rad);
        Self { x_m: pose.x_m, y_m: pose.y_m, sin, cos }
    }

    pub fn apply(&self, inner: Point) -> Point {
        Point::new(
            self.x_m + self.cos * inner.x - self.sin * inner.y,
            self.y_m + self.sin * inner.x + self.cos * inner.y,
        )
    }
}
