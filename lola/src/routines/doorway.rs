//! The frame of a door that the robot drives through, by sonar.

use rpl_robot::geometry::{Point, Pose, distance_m, wrap_angle_rad};
use rpl_robot::sensors::SonarScan;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// The posts of a door stand at most so far from the middle of the robot, and from one another.
const POST_M: f64 = 0.8;
const WIDEST_M: f64 = 1.2;

/// Beyond the door there is so much room to both sides: behind a gap between a thing and a wall the wall goes on.
const OPEN_M: f64 = 0.75;

/// The robot is through when it has gone so far from between the posts; a wall is no thicker.
const THROUGH_M: f64 = 0.45;
const THICKEST_M: f64 = 0.9;

/// A post is looked for so far to both sides of abeam.
const ABEAM_RAD: f64 = 0.6;

/// The way the robot came is remembered in pieces of so much, so many of them: who comes through a door was
/// before it, and did not turn round in a corner.
const TRAIL_M: f64 = 0.1;
const TRAIL: usize = 15;
const BEFORE_M: f64 = 0.3;

/// A doorway that the robot has passed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Doorway {
    /// The middle between its posts, and which way leads out of it as the robot drove.
    pub middle_in_odom: Pose,
    /// From post to post.
    pub width_m: f64,
}

/// Looks for doorways while the robot drives.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DoorwayDetection {
    /// The narrowest there was since it became narrow.
    narrowest: Option<Doorway>,
    /// Where the robot was, the last place last.
    trail_in_odom: Vec<Point>,
}

impl DoorwayDetection {
    /// Takes a scan in; a doorway is told once, when the robot is through.
    pub fn take_in(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) -> Option<Doorway> {
        let here = odometry_in_odom;
        self.go_on(here.point());
        let (left, right) = (post(here, scan, FRAC_PI_2), post(here, scan, -FRAC_PI_2));
        if let (Some(left), Some(right)) = (left, right) {
            let width_m = distance_m(left, right);
            let is_post = |post: Point| distance_m(post, here.point()) < POST_M;
            let is_narrower = self.narrowest.is_none_or(|narrowest| width_m < narrowest.width_m);
            if is_post(left) && is_post(right) && width_m < WIDEST_M && is_narrower {
                self.narrowest = Some(Doorway { middle_in_odom: between(left, right, here), width_m });
            }
        }
        let doorway = self.narrowest?;
        let gone_m = distance_m(here.point(), doorway.middle_in_odom.point());
        let beyond = here.relative_to(doorway.middle_in_odom);
        if gone_m > THICKEST_M {
            self.narrowest = None;
        }
        let is_open = |post: Option<Point>| post.is_none_or(|post| distance_m(post, here.point()) > OPEN_M);
        let is_through = beyond.x_m > THROUGH_M && gone_m <= THICKEST_M && self.came_through(doorway.middle_in_odom);
        if is_through && is_open(left) && is_open(right) {
            self.narrowest = None;
            return Some(doorway);
        }
        None
    }

    fn go_on(&mut self, here: Point) {
        if self.trail_in_odom.last().is_none_or(|&last| distance_m(last, here) >= TRAIL_M) {
            self.trail_in_odom.push(here);
        }
        if self.trail_in_odom.len() > TRAIL {
            self.trail_in_odom.remove(0);
        }
    }

    /// Whether the robot was before the doorway, and went between its posts.
    fn came_through(&self, middle_in_odom: Pose) -> bool {
        let frame = middle_in_odom.inverse();
        let trail: Vec<Point> = self.trail_in_odom.iter().map(|&place| frame.transform(place)).collect();
        let was_before = trail.iter().any(|place| place.x < -BEFORE_M);
        let between = trail.iter().filter(|place| place.x.abs() < TRAIL_M);
        was_before && between.clone().count() > 0 && between.into_iter().all(|place| place.y.abs() < POST_M / 2.0)
    }
}

/// The nearest that is heard about abeam on a side, in `odom`.
fn post(here: Pose, scan: SonarScan<'_>, abeam_rad: f64) -> Option<Point> {
    let abeam = scan.sonars.mounts.iter().zip(scan.ranges_m).filter(|(mount, range_m)| {
        let off_rad = wrap_angle_rad(mount.heading_rad - abeam_rad).abs();
        off_rad < ABEAM_RAD && **range_m > 0.0 && f64::from(**range_m) < scan.sonars.range_m
    });
    let (mount, &range_m) = abeam.min_by(|one, other| one.1.total_cmp(other.1))?;
    let heard = Pose::new(mount.at_in_base.x, mount.at_in_base.y, mount.heading_rad);
    Some(here.transform(heard.transform(Point::new(f64::from(range_m), 0.0))))
}

/// Between two posts, looking the way the robot does.
fn between(left: Point, right: Point, here: Pose) -> Pose {
    let across_rad = libm::atan2(left.y - right.y, left.x - right.x);
    let normal_rad = wrap_angle_rad(across_rad - FRAC_PI_2);
    let off_rad = wrap_angle_rad(normal_rad - here.heading_rad);
    let heading_rad = if off_rad.abs() <= FRAC_PI_2 { normal_rad } else { normal_rad + 2.0 * FRAC_PI_2 };
    Pose::new((left.x + right.x) / 2.0, (left.y + right.y) / 2.0, heading_rad)
}
