//! What the sensors saw lately, kept in `odom`: twenty-four cones are sparse, some are lost, and the
//! laser looks ahead only.

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

/// Points are forgotten this long after they were last seen, time without their sensor not counted:
/// nothing could have shown that they are gone.
const MEMORY_S: f64 = 6.0;

/// What was seen at one place for so long, and never looked through, stands there. A person walking
/// across a cone is gone from it after 0.9 m, at 0.6 m/s after 1.5 s.
const STANDING_S: f64 = 2.0;

/// Points nearer to each other than this are one.
const GRAIN_M: f64 = 0.05;

/// Half as many readings must pass through a point before it is forgotten.
const DOUBTS: u8 = 6;

/// A point seen only once may be another sonar's echo: a single reading through it is enough.
const DOUBTS_AT_FIRST: u8 = 4;

/// A wall hit at an angle, or an edge, throws the sound away as long as the robot hardly moves. So
/// silence casts doubt on what was heard more than once only after so much motion or time.
const VIEW_M: f64 = 0.1;
const VIEW_RAD: f64 = 0.087;
const VIEW_S: f64 = 0.5;

/// What saw a point. Only the same can see that it is gone: a box may be there for one of them alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
enum Sensor {
    Sonar,
    Laser,
}

/// A point where the nearest surface of a cone may be, or one where a laser beam ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RememberedPoint {
    /// Its cell on a grid of 5 cm, by which points are kept apart and in order.
    cell: (i32, i32),
    sensor: Sensor,
    /// Where it was seen last, in `odom`.
    pub point_in_odom: Point,
    /// The reading it comes from.
    pub range_m: f64,
    first_seen_at_s: f64,
    seen_at_s: f64,
    is_seen_again: bool,
    doubts: u8,
}

impl RememberedPoint {
    /// Whether it is something that stands there, and not somebody walking by.
    pub fn stands(&self) -> bool {
        self.seen_at_s - self.first_seen_at_s >= STANDING_S
    }
}

/// From where and when silence last cast doubts on all points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct View {
    from_in_odom: Pose,
    at_s: f64,
}

/// Obstacle points seen lately. Points that a later reading passes through are doubted and then
/// forgotten, others after some seconds or metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleMemory {
    /// Time with sonars, and with the laser.
    now_s: [f64; 2],
    view: View,
    /// Sorted by cell and sensor.
    points: Vec<RememberedPoint>,
}

impl ObstacleMemory {
    /// At most so many points; the ones seen longest ago go first.
    pub const CAPACITY: usize = 400;

    /// Takes in what the sensors say at a place, or only lets `step_s` pass. A reading is the distance
    /// from the robot's centre; a sonar's that is not in (0, `sonar_max_range_m`) heard nothing. The
    /// laser's readings are a degree apart, in order from right to left about straight ahead.
    pub fn update(
        &mut self,
        odometry_in_odom: Pose,
        sonar_m: Option<&[f32; SONARS]>,
        laser_m: Option<&[f32]>,
        sonar_max_range_m: f64,
        step_s: f64,
    ) {
        if let Some(sonar_m) = sonar_m {
            self.now_s[Sensor::Sonar as usize] += step_s;
            let is_new_view = self.is_new_view(odometry_in_odom);
            self.doubt(odometry_in_odom, Sensor::Sonar, |point, bearing_rad, away_m| {
                let silence_counts = is_new_view || !point.is_seen_again;
                doubts_of_sonar(sonar_m, sonar_max_range_m, silence_counts, bearing_rad, away_m)
            });
            for (sonar, &range_m) in sonar_m.iter().enumerate() {
                let range_m = f64::from(range_m);
                if range_m > 0.0 && range_m < sonar_max_range_m.min(USEFUL_RANGE_M) {
                    self.hear(odometry_in_odom, direction_rad(sonar), range_m);
                }
            }
        }
        if let Some(laser_m) = laser_m {
            self.now_s[Sensor::Laser as usize] += step_s;
            self.doubt(odometry_in_odom, Sensor::Laser, |_, bearing_rad, away_m| {
                doubts_of_laser(laser_m, bearing_rad, away_m)
            });
            for (beam, &range_m) in laser_m.iter().enumerate() {
                let range_m = f64::from(range_m);
                if range_m > 0.0 && range_m < USEFUL_RANGE_M {
                    let bearing_rad = odometry_in_odom.heading_rad + laser_bearing_rad(laser_m, beam);
                    self.remember(ahead_of(odometry_in_odom, bearing_rad, range_m), Sensor::Laser, range_m);
                }
            }
        }
        let here = odometry_in_odom.point();
        self.points.retain(|point| {
            self.now_s[point.sensor as usize] - point.seen_at_s <= MEMORY_S
                && (point.point_in_odom - here).norm_squared() <= MEMORY_RANGE_M * MEMORY_RANGE_M
        });
        self.forget_oldest();
    }

    /// Remembers an obstacle felt, not seen: the robot drives forward only, so it is at the front.
    pub fn feel(&mut self, odometry_in_odom: Pose, robot_radius_m: f64) {
        for direction_rad in [-0.7, 0.0, 0.7] {
            self.hear(odometry_in_odom, direction_rad, robot_radius_m + 0.01);
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
    fn hear(&mut self, odometry_in_odom: Pose, direction_rad: f64, range_m: f64) {
        let steps = libm::ceil(HALF_CONE_RAD * range_m / (1.6 * GRAIN_M)).max(1.0) as i32;
        for step in -steps..=steps {
            let angle_rad =
                odometry_in_odom.heading_rad + direction_rad + HALF_CONE_RAD * f64::from(step) / f64::from(steps);
            self.remember(ahead_of(odometry_in_odom, angle_rad, range_m), Sensor::Sonar, range_m);
        }
    }

    fn remember(&mut self, point_in_odom: Point, sensor: Sensor, range_m: f64) {
        let cell = (libm::floor(point_in_odom.x / GRAIN_M) as i32, libm::floor(point_in_odom.y / GRAIN_M) as i32);
        let seen_at_s = self.now_s[sensor as usize];
        let seen = |first_seen_at_s, is_seen_again, doubts| RememberedPoint {
            cell,
            sensor,
            point_in_odom,
            range_m,
            first_seen_at_s,
            seen_at_s,
            is_seen_again,
            doubts,
        };
        match self.points.binary_search_by(|point| (point.cell, point.sensor).cmp(&(cell, sensor))) {
            Ok(index) => self.points[index] = seen(self.points[index].first_seen_at_s, true, 0),
            Err(index) => self.points.insert(index, seen(seen_at_s, false, DOUBTS_AT_FIRST)),
        }
    }

    /// Whether the sonars look from a new place; if so, the next new view is counted from here.
    fn is_new_view(&mut self, odometry_in_odom: Pose) -> bool {
        let View { from_in_odom, at_s } = self.view;
        let now_s = self.now_s[Sensor::Sonar as usize];
        let turned_rad = wrap_angle_rad(odometry_in_odom.heading_rad - from_in_odom.heading_rad).abs();
        let is_new =
            odometry_in_odom.distance_m(from_in_odom) >= VIEW_M || turned_rad >= VIEW_RAD || now_s - at_s >= VIEW_S;
        if is_new {
            self.view = View { from_in_odom: odometry_in_odom, at_s: now_s };
        }
        is_new
    }

    /// Adds the doubts that a scan casts on a point in a direction at a distance.
    fn doubt(&mut self, odometry_in_odom: Pose, sensor: Sensor, doubts: impl Fn(&RememberedPoint, f64, f64) -> u8) {
        let odom_in_base = Transform::new(odometry_in_odom.inverse());
        for point in self.points.iter_mut().filter(|point| point.sensor == sensor) {
            let point_in_base = odom_in_base.apply(point.point_in_odom);
            let bearing_rad = libm::atan2(point_in_base.y, point_in_base.x);
            point.doubts += doubts(point, bearing_rad, point_in_base.coords.norm());
        }
        self.points.retain(|point| point.doubts < DOUBTS);
    }

    fn forget_oldest(&mut self) {
        if self.points.len() <= Self::CAPACITY {
            return;
        }
        let now_s = self.now_s;
        let age_s = |point: &RememberedPoint| now_s[point.sensor as usize] - point.seen_at_s;
        let mut ages_s: Vec<f64> = self.points.iter().map(age_s).collect();
        ages_s.sort_by(f64::total_cmp);
        let oldest_kept_s = ages_s[Self::CAPACITY - 1];
        self.points.retain(|point| age_s(point) <= oldest_kept_s);
        self.points.truncate(Self::CAPACITY);
    }
}

/// A sonar that hears nothing tells half as much: smooth walls throw its sound away.
fn doubts_of_sonar(
    sonar_m: &[f32; SONARS],
    max_range_m: f64,
    silence_counts: bool,
    bearing_rad: f64,
    away_m: f64,
) -> u8 {
    let sonar = libm::round(bearing_rad / (2.0 * HALF_CONE_RAD)) as i64;
    let off_axis_rad = wrap_angle_rad(bearing_rad - sonar as f64 * 2.0 * HALF_CONE_RAD).abs();
    let reading_m = f64::from(sonar_m[sonar.rem_euclid(SONARS as i64) as usize]);
    let passes = reading_m > away_m + GRAIN_M && off_axis_rad < 0.95 * HALF_CONE_RAD;
    match passes {
        true if reading_m < max_range_m => 2,
        true => u8::from(silence_counts),
        false => 0,
    }
}

/// The beam through a point must end behind it, and so must those beside it: they may have missed a
/// thin thing.
fn doubts_of_laser(laser_m: &[f32], bearing_rad: f64, away_m: f64) -> u8 {
    let beam = libm::round(bearing_rad.to_degrees() + (laser_m.len() as f64 - 1.0) / 2.0);
    if beam < 1.0 || beam + 1.0 >= laser_m.len() as f64 {
        return 0;
    }
    let passes = laser_m[beam as usize - 1..][..3].iter().all(|&reading_m| f64::from(reading_m) > away_m + GRAIN_M);
    2 * u8::from(passes)
}

fn laser_bearing_rad(laser_m: &[f32], beam: usize) -> f64 {
    (beam as f64 - (laser_m.len() as f64 - 1.0) / 2.0).to_radians()
}

fn ahead_of(odometry_in_odom: Pose, bearing_in_odom_rad: f64, range_m: f64) -> Point {
    let (sin, cos) = libm::sincos(bearing_in_odom_rad);
    Point::new(odometry_in_odom.x_m + cos * range_m, odometry_in_odom.y_m + sin * range_m)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing is heard but by the sonar that looks ahead.
    fn scan(ahead_m: f32) -> [f32; SONARS] {
        let mut sonar_m = [5.0; SONARS];
        sonar_m[0] = ahead_m;
        sonar_m
    }

    fn look(memory: &mut ObstacleMemory, heading_rad: f64, ahead_m: f32, times: u32) {
        for _ in 0..times {
            memory.update(Pose::new(0.0, 0.0, heading_rad), Some(&scan(ahead_m)), None, 5.0, 0.05);
        }
    }

    fn knows_ahead(memory: &ObstacleMemory) -> bool {
        memory.points().iter().any(|point| (point.point_in_odom - Point::new(0.8, 0.0)).norm() < 0.05)
    }

    #[test]
    fn a_wall_that_falls_silent_is_remembered_until_it_is_silent_from_elsewhere() {
        let mut memory = ObstacleMemory::default();
        look(&mut memory, 0.0, 0.8, 3);
        look(&mut memory, 0.0, 5.0, 20);
        assert!(knows_ahead(&memory), "it may throw the sound away");
        for turn in 1..=6 {
            look(&mut memory, 0.1 * f64::from(turn), 5.0, 1);
        }
        assert!(!knows_ahead(&memory));
    }

    #[test]
    fn an_echo_heard_once_is_forgotten_at_once() {
        let mut memory = ObstacleMemory::default();
        look(&mut memory, 0.0, 0.8, 1);
        assert!(knows_ahead(&memory));
        look(&mut memory, 0.0, 2.0, 1);
        assert!(!knows_ahead(&memory));
    }
}
