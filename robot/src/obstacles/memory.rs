//! What the sensors saw lately, kept in `odom`: twenty-four cones are sparse, some are lost, and the
//! laser looks ahead only.

use super::sonar_views::SonarViews;
use crate::geometry::{Point, Pose, Transform, wrap_angle_rad};
use crate::sensors::{RangeSensor, SONAR_CONE_RAD, SONARS, laser_direction_rad, sonar_direction_rad};
use serde::{Deserialize, Serialize};

/// Half the opening of a sonar cone.
const HALF_CONE_RAD: f64 = SONAR_CONE_RAD / 2.0;

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

/// Points of an arc that are this little farther from a surface of the map than the nearest are on it
/// too.
const AS_NEAR_M: f64 = 0.03;

/// Points nearer to each other than this are one.
const GRAIN_M: f64 = 0.05;

/// Half as many readings must pass through a point before it is forgotten.
const DOUBTS: u8 = 6;

/// A point seen only once may be another sonar's echo: a single reading through it is enough.
const DOUBTS_AT_FIRST: u8 = 4;

/// A point where the nearest surface of a cone may be, or one where a laser beam ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RememberedPoint {
    /// Its cell on a grid of 5 cm, by which points are kept apart and in order.
    cell: (i32, i32),
    /// What saw it. Only the same can see that it is gone: a box may be there for one of them alone.
    sensor: RangeSensor,
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

/// Obstacle points seen lately. Points that a later reading passes through are doubted and then
/// forgotten, others after some seconds or metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleMemory {
    /// Time with sonars, and with the laser.
    now_s: [f64; 2],
    views: SonarViews,
    is_touched: bool,
    /// Sorted by cell and sensor.
    points: Vec<RememberedPoint>,
}

impl ObstacleMemory {
    /// At most so many points; the ones seen longest ago go first.
    pub const CAPACITY: usize = 400;

    /// Takes in what the sensors say at a place, or only lets `step_s` pass. A reading is the distance
    /// from the robot's centre; a sonar's that is not in (0, `sonar_max_range_m`) heard nothing. The
    /// laser's readings are a degree apart, in order from right to left about straight ahead.
    /// `off_map_m` tells of a point in `odom` how far it is from the nearest surface of the map, if that
    /// is near.
    pub fn update(
        &mut self,
        odometry_in_odom: Pose,
        sonar_m: Option<&[f32; SONARS]>,
        laser_m: Option<&[f32]>,
        sonar_max_range_m: f64,
        step_s: f64,
        off_map_m: impl Fn(Point) -> Option<f64>,
    ) {
        if let Some(sonar_m) = sonar_m {
            self.now_s[RangeSensor::Sonar as usize] += step_s;
            let now_s = self.now_s[RangeSensor::Sonar as usize];
            let is_new_view = self.views.take_in(odometry_in_odom, sonar_m, sonar_max_range_m, now_s);
            self.doubt(odometry_in_odom, RangeSensor::Sonar, |point, bearing_rad, away_m| {
                let silence_counts = is_new_view || !point.is_seen_again;
                doubts_of_sonar(sonar_m, sonar_max_range_m, silence_counts, bearing_rad, away_m)
            });
            let mut arc = Vec::new();
            for (sonar, &range_m) in sonar_m.iter().enumerate() {
                let range_m = f64::from(range_m);
                if range_m > 0.0 && range_m < sonar_max_range_m.min(USEFUL_RANGE_M) {
                    arc.clear();
                    arc.extend(arc_in_odom(odometry_in_odom, sonar_direction_rad(sonar), range_m));
                    self.narrow(&mut arc, &off_map_m);
                    arc.iter().for_each(|&point| self.remember(point, RangeSensor::Sonar, range_m));
                }
            }
        }
        if let Some(laser_m) = laser_m {
            self.now_s[RangeSensor::Laser as usize] += step_s;
            self.doubt(odometry_in_odom, RangeSensor::Laser, |_, bearing_rad, away_m| {
                doubts_of_laser(laser_m, bearing_rad, away_m)
            });
            for (beam, &range_m) in laser_m.iter().enumerate() {
                let range_m = f64::from(range_m);
                if range_m > 0.0 && range_m < USEFUL_RANGE_M {
                    let bearing_rad = odometry_in_odom.heading_rad + laser_direction_rad(laser_m.len(), beam);
                    self.remember(ahead_of(odometry_in_odom, bearing_rad, range_m), RangeSensor::Laser, range_m);
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

    /// Remembers what the robot has run into, if it was not touched before; tells whether it was not.
    /// It drives forward only, so that is at its front; where it is later, as long as it is touched,
    /// depends on how the robot has turned.
    pub fn feel(&mut self, odometry_in_odom: Pose, robot_radius_m: f64, bumped: bool) -> bool {
        let is_new = bumped && !self.is_touched;
        self.is_touched = bumped;
        if !is_new {
            return false;
        }
        for direction_rad in [-0.7, 0.0, 0.7] {
            for point in arc_in_odom(odometry_in_odom, direction_rad, robot_radius_m + 0.01) {
                self.remember(point, RangeSensor::Sonar, robot_radius_m);
            }
        }
        true
    }

    /// Forgets all points.
    pub fn forget(&mut self) {
        *self = Self { is_touched: self.is_touched, ..Self::default() };
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

    /// The surface is somewhere on the arc, and not where the sound passed from another place or
    /// direction; if it passed everywhere, something has come since. Where the arc meets a surface of
    /// the map, that is what was heard.
    fn narrow(&self, arc_in_odom: &mut Vec<Point>, off_map_m: &impl Fn(Point) -> Option<f64>) {
        let is_possible = |point: &Point| !self.views.passed(*point);
        if arc_in_odom.iter().any(is_possible) {
            arc_in_odom.retain(is_possible);
        }
        let least_m = arc_in_odom.iter().filter_map(|&point| off_map_m(point)).min_by(f64::total_cmp);
        if let Some(least_m) = least_m {
            arc_in_odom.retain(|&point| off_map_m(point).is_some_and(|off_m| off_m <= least_m + AS_NEAR_M));
        }
    }

    fn remember(&mut self, point_in_odom: Point, sensor: RangeSensor, range_m: f64) {
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

    /// Adds the doubts that a scan casts on a point in a direction at a distance.
    fn doubt(
        &mut self,
        odometry_in_odom: Pose,
        sensor: RangeSensor,
        doubts: impl Fn(&RememberedPoint, f64, f64) -> u8,
    ) {
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

/// Where the surface may be that a sonar hears, no farther apart than the grain.
fn arc_in_odom(odometry_in_odom: Pose, direction_rad: f64, range_m: f64) -> impl Iterator<Item = Point> {
    let steps = libm::ceil(HALF_CONE_RAD * range_m / (1.6 * GRAIN_M)).max(1.0) as i32;
    (-steps..=steps).map(move |step| {
        let off_rad = HALF_CONE_RAD * f64::from(step) / f64::from(steps);
        ahead_of(odometry_in_odom, odometry_in_odom.heading_rad + direction_rad + off_rad, range_m)
    })
}

/// A sonar that hears nothing tells half as much: smooth walls throw its sound away.
fn doubts_of_sonar(
    sonar_m: &[f32; SONARS],
    max_range_m: f64,
    silence_counts: bool,
    bearing_rad: f64,
    away_m: f64,
) -> u8 {
    let sonar = libm::round(bearing_rad / (SONAR_CONE_RAD)) as i64;
    let off_axis_rad = wrap_angle_rad(bearing_rad - sonar as f64 * SONAR_CONE_RAD).abs();
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

fn ahead_of(odometry_in_odom: Pose, bearing_in_odom_rad: f64, range_m: f64) -> Point {
    let (sin, cos) = libm::sincos(bearing_in_odom_rad);
    Point::new(odometry_in_odom.x_m + cos * range_m, odometry_in_odom.y_m + sin * range_m)
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
            memory.update(Pose::new(0.0, 0.0, heading_rad), Some(&scan(ahead_m)), None, 5.0, 0.05, no_map);
        }
    }

    fn no_map(_: Point) -> Option<f64> {
        None
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

    /// How far to the left of straight ahead the points of one arc reach.
    fn left_and_right_m(memory: &ObstacleMemory) -> (f64, f64) {
        let aside_m = memory.points().iter().map(|point| point.point_in_odom.y);
        (aside_m.clone().fold(f64::NEG_INFINITY, f64::max), aside_m.fold(f64::INFINITY, f64::min))
    }

    #[test]
    fn where_another_cone_passed_there_is_nothing() {
        // To the right of 3.75° the room is open as seen with the robot turned, to the left is a wall.
        let mut memory = ObstacleMemory::default();
        memory.update(Pose::new(0.0, 0.0, -0.065), Some(&scan(2.5)), None, 5.0, 0.05, no_map);
        look(&mut memory, 0.0, 1.5, 1);
        let (left_m, right_m) = left_and_right_m(&memory);
        assert!(left_m > 0.18 && right_m > 0.08, "{left_m} {right_m}");
    }

    #[test]
    fn an_echo_where_all_was_open_is_somewhere_on_its_arc() {
        let mut memory = ObstacleMemory::default();
        look(&mut memory, 0.0, 2.5, 1);
        look(&mut memory, 0.0, 1.5, 1);
        let (left_m, right_m) = left_and_right_m(&memory);
        assert!(left_m > 0.18 && right_m < -0.18, "{left_m} {right_m}");
    }

    #[test]
    fn an_echo_the_map_expects_is_where_the_map_has_it() {
        // The edge of a wall on the left, parallel to the way.
        let off_map_m = |point: Point| (point.y > 0.05).then_some((0.15 - point.y).max(0.0));
        let mut memory = ObstacleMemory::default();
        memory.update(Pose::default(), Some(&scan(1.5)), None, 5.0, 0.05, off_map_m);
        let (left_m, right_m) = left_and_right_m(&memory);
        assert!(left_m > 0.18 && right_m > 0.11, "{left_m} {right_m}");
    }
}
