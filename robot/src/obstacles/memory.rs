//! What the sensors saw lately, kept in `odom`: cones are sparse, some readings are lost, and not every
//! sensor looks all around.

use super::sonar_views::SonarViews;
use crate::geometry::{Point, Pose, Transform, wrap_angle_rad};
use crate::sensors::{LaserScan, SonarArray, SonarMount, SonarScan};
use serde::{Deserialize, Serialize};

/// Readings farther than this are not remembered: the arc they may come from is too wide.
const USEFUL_RANGE_M: f64 = 2.0;

/// Remembered points farther from the robot than this are forgotten.
const MEMORY_RANGE_M: f64 = 2.5;

/// Points are forgotten this long after they were last seen, time without their sensor not counted:
/// nothing could have shown that they are gone.
const MEMORY_S: f64 = 6.0;

/// A point seen at one place for this long, and never looked through, stands there. A person walking
/// across a cone is gone from it after 0.9 m, at 0.6 m/s after 1.5 s.
const STANDING_S: f64 = 2.0;

/// Points of an arc that are this little farther from a surface of the map than the nearest are on it
/// too.
const AS_NEAR_M: f64 = 0.03;

/// Points nearer to each other than this are one.
const GRAIN_M: f64 = 0.05;

/// The arc of the rim on which a touch is felt.
const FELT_RAD: f64 = std::f64::consts::TAU / 24.0;

/// Half as many readings must pass through a point before it is forgotten.
const DOUBTS: u8 = 6;

/// A point seen only once may be another sonar's echo: a single reading through it is enough.
const DOUBTS_AT_FIRST: u8 = 4;

/// What finds obstacles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
enum Source {
    Sonar,
    Laser,
    /// The robot ran into it: there may be no sensor that sees it.
    Bumper,
}

/// A point where the nearest surface of a cone may be, where a laser beam ended, or where the robot was touched.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RememberedPoint {
    /// Its cell on a grid of 5 cm, by which points are kept apart and in order.
    cell: (i32, i32),
    /// What saw it. Only the same can see that it is gone: a box may be there for one of them alone.
    sensor: Source,
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
        self.is_felt() || self.seen_at_s - self.first_seen_at_s >= STANDING_S
    }

    /// Whether the robot ran into it.
    pub fn is_felt(&self) -> bool {
        self.sensor == Source::Bumper
    }
}

/// Obstacle points seen lately. Points that a later reading passes through are doubted and then
/// forgotten, others after some seconds or metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleMemory {
    /// Time with sonars, with the laser, and all of it.
    now_s: [f64; 3],
    views: SonarViews,
    is_touched: bool,
    /// Sorted by cell and sensor.
    points: Vec<RememberedPoint>,
}

impl ObstacleMemory {
    /// The most points; the ones seen longest ago go first.
    pub const CAPACITY: usize = 400;

    /// Takes in what the sensors say at a place, or only lets `step_s` pass. `off_map_m` tells of a point in `odom` how far it is from the nearest surface of the map, if that
    /// is near.
    pub fn update(
        &mut self,
        odometry_in_odom: Pose,
        sonar: Option<SonarScan<'_>>,
        laser: Option<LaserScan<'_>>,
        step_s: f64,
        off_map_m: impl Fn(Point) -> Option<f64>,
    ) {
        self.now_s[Source::Bumper as usize] += step_s;
        if let Some(scan) = sonar {
            self.hear(odometry_in_odom, scan, step_s, &off_map_m);
        }
        if let Some(scan) = laser {
            self.see(odometry_in_odom, scan, step_s);
        }
        let here = odometry_in_odom.point();
        self.points.retain(|point| {
            self.now_s[point.sensor as usize] - point.seen_at_s <= MEMORY_S
                && (point.point_in_odom - here).norm_squared() <= MEMORY_RANGE_M * MEMORY_RANGE_M
        });
        self.forget_oldest();
    }

    fn hear(
        &mut self,
        odometry_in_odom: Pose,
        scan: SonarScan<'_>,
        step_s: f64,
        off_map_m: &impl Fn(Point) -> Option<f64>,
    ) {
        let SonarScan { sonars, ranges_m } = scan;
        self.now_s[Source::Sonar as usize] += step_s;
        let now_s = self.now_s[Source::Sonar as usize];
        let is_new_view = self.views.take_in(odometry_in_odom, scan, now_s);
        self.doubt(odometry_in_odom, Source::Sonar, |point, point_in_base| {
            doubts_of_sonars(scan, is_new_view || !point.is_seen_again, point_in_base)
        });
        let mut arc = Vec::new();
        for (mount, &range_m) in sonars.mounts.iter().zip(ranges_m) {
            let range_m = f64::from(range_m);
            if range_m > 0.0 && range_m < sonars.range_m.min(USEFUL_RANGE_M) {
                arc.clear();
                arc.extend(arc_in_odom(odometry_in_odom, mount, sonars.cone_rad, range_m));
                self.narrow(sonars, &mut arc, off_map_m);
                arc.iter().for_each(|&point| self.remember(point, Source::Sonar, range_m));
            }
        }
    }

    fn see(&mut self, odometry_in_odom: Pose, scan: LaserScan<'_>, step_s: f64) {
        self.now_s[Source::Laser as usize] += step_s;
        self.doubt(odometry_in_odom, Source::Laser, |_, point_in_base| doubts_of_laser(scan, point_in_base));
        let useful_m = scan.laser.range_m.min(USEFUL_RANGE_M);
        for (beam, &range_m) in scan.ranges_m.iter().enumerate() {
            let range_m = f64::from(range_m);
            if range_m > 0.0 && range_m < useful_m {
                let bearing_rad = odometry_in_odom.heading_rad + scan.laser.direction_rad(beam);
                let seen = ahead_of(odometry_in_odom.point(), bearing_rad, range_m);
                self.remember(seen, Source::Laser, range_m);
            }
        }
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
        for heading_rad in [-0.7, 0.0, 0.7] {
            let middle = SonarMount { at_in_base: Point::origin(), heading_rad };
            for point in arc_in_odom(odometry_in_odom, &middle, FELT_RAD, robot_radius_m + 0.01) {
                self.remember(point, Source::Bumper, robot_radius_m);
            }
        }
        true
    }

    /// Forgets all points.
    pub fn forget(&mut self) {
        *self = Self { is_touched: self.is_touched, ..Self::default() };
    }

    /// Forgets points.
    pub fn forget_where(&mut self, is_meant: impl Fn(Point) -> bool) {
        self.points.retain(|point| !is_meant(point.point_in_odom));
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
    fn narrow(&self, sonars: &SonarArray, arc_in_odom: &mut Vec<Point>, off_map_m: &impl Fn(Point) -> Option<f64>) {
        let is_possible = |point: &Point| !self.views.passed(sonars, *point);
        if arc_in_odom.iter().any(is_possible) {
            arc_in_odom.retain(is_possible);
        }
        let least_m = arc_in_odom.iter().filter_map(|&point| off_map_m(point)).min_by(f64::total_cmp);
        if let Some(least_m) = least_m {
            arc_in_odom.retain(|&point| off_map_m(point).is_some_and(|off_m| off_m <= least_m + AS_NEAR_M));
        }
    }

    fn remember(&mut self, point_in_odom: Point, sensor: Source, range_m: f64) {
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

    /// Adds the doubts that a scan casts on a point in `base`.
    fn doubt(&mut self, odometry_in_odom: Pose, sensor: Source, doubts: impl Fn(&RememberedPoint, Point) -> u8) {
        let odom_in_base = Transform::new(odometry_in_odom.inverse());
        for point in self.points.iter_mut().filter(|point| point.sensor == sensor) {
            point.doubts += doubts(point, odom_in_base.apply(point.point_in_odom));
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
fn arc_in_odom(
    odometry_in_odom: Pose,
    mount: &SonarMount,
    cone_rad: f64,
    range_m: f64,
) -> impl Iterator<Item = Point> + use<> {
    let half_rad = cone_rad / 2.0;
    let steps = libm::ceil(half_rad * range_m / (1.6 * GRAIN_M)).max(1.0) as i32;
    let apex_in_odom = odometry_in_odom.transform(mount.at_in_base);
    let axis_rad = odometry_in_odom.heading_rad + mount.heading_rad;
    (-steps..=steps).map(move |step| {
        let off_rad = half_rad * f64::from(step) / f64::from(steps);
        ahead_of(apex_in_odom, axis_rad + off_rad, range_m)
    })
}

/// What the sonar says of a point that doubts it most. One that hears nothing tells half as much: smooth
/// walls throw its sound away.
fn doubts_of_sonars(scan: SonarScan<'_>, silence_counts: bool, point_in_base: Point) -> u8 {
    let SonarScan { sonars, ranges_m } = scan;
    let doubts = sonars.hearing(point_in_base).map(|(sonar, off)| {
        let bearing_rad = libm::atan2(off.y, off.x);
        let off_axis_rad = wrap_angle_rad(bearing_rad - sonars.mounts[sonar].heading_rad).abs();
        let reading_m = f64::from(ranges_m[sonar]);
        let passes = reading_m > off.norm() + GRAIN_M && off_axis_rad < 0.95 * (sonars.cone_rad / 2.0);
        match passes {
            true if reading_m < sonars.range_m => 2,
            true => u8::from(silence_counts),
            false => 0,
        }
    });
    doubts.max().unwrap_or(0)
}

/// The beam through a point must end behind it, and so must those beside it: they may have missed a
/// thin thing.
fn doubts_of_laser(scan: LaserScan<'_>, point_in_base: Point) -> u8 {
    let bearing_rad = libm::atan2(point_in_base.y, point_in_base.x);
    let away_m = point_in_base.coords.norm();
    let Some(beams) = scan.laser.with_neighbours(bearing_rad) else { return 0 };
    let passes = beams.iter().all(|&beam| f64::from(scan.ranges_m[beam]) > away_m + GRAIN_M);
    2 * u8::from(passes)
}

fn ahead_of(from_in_odom: Point, bearing_in_odom_rad: f64, range_m: f64) -> Point {
    let (sin, cos) = libm::sincos(bearing_in_odom_rad);
    Point::new(from_in_odom.x + cos * range_m, from_in_odom.y + sin * range_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::RobotDescription;

    /// Nothing is heard but by the sonar of a ring that looks ahead.
    fn hear(memory: &mut ObstacleMemory, heading_rad: f64, ahead_m: f32, off_map_m: impl Fn(Point) -> Option<f64>) {
        let sonars = RobotDescription::papers().range_sensors().sonars.expect("it has a ring");
        let mut ranges_m = vec![5.0; sonars.mounts.len()];
        ranges_m[0] = ahead_m;
        let scan = SonarScan { sonars: &sonars, ranges_m: &ranges_m };
        memory.update(Pose::new(0.0, 0.0, heading_rad), Some(scan), None, 0.05, off_map_m);
    }

    fn look(memory: &mut ObstacleMemory, heading_rad: f64, ahead_m: f32, times: u32) {
        for _ in 0..times {
            hear(memory, heading_rad, ahead_m, no_map);
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
        hear(&mut memory, -0.065, 2.5, no_map);
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
        hear(&mut memory, 0.0, 1.5, off_map_m);
        let (left_m, right_m) = left_and_right_m(&memory);
        assert!(left_m > 0.18 && right_m > 0.11, "{left_m} {right_m}");
    }
}
