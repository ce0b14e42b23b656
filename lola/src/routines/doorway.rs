//! The frame of a door that the robot drives through, by sonar.

use rpl_robot::geometry::{Point, Pose, distance_m, wrap_angle_rad};
use rpl_robot::sensors::SonarScan;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// The posts of a door stand at most so far from the middle of the robot, and from one another,
const POST_M: f64 = 0.8;
const WIDEST_M: f64 = 1.2;

/// as seen from between them so far apart: the walls of a corner are square to one another.
const OPPOSITE_RAD: f64 = 2.1;

/// How many scans hear them at about the same place: an echo over a detour is not heard so.
const SIGHTINGS: u32 = 6;
const SAME_M: f64 = 0.3;

/// How much room there is beyond the door on each side, and on both together: behind a gap between a thing and a
/// wall the wall goes on.
const OPEN_M: f64 = 0.65;
const OPEN_TOGETHER_M: f64 = 2.0;

/// The robot is through when it has gone this far from between the posts; a wall is no thicker.
const THROUGH_M: f64 = 0.45;
const THICKEST_M: f64 = 0.95;

/// The way the robot came is remembered in pieces of this length, and in this number of them: a robot that comes
/// through a door was before it, and did not turn round in a corner.
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

/// What may be a doorway.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Gap {
    /// As it was where it was narrowest.
    narrowest: Doorway,
    /// How often it was heard.
    sightings: u32,
}

/// Looks for doorways while the robot drives.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DoorwayDetection {
    /// What the robot is in or has just left, each in a place of its own: a false echo makes another gap, and does
    /// not hide the one that was heard before.
    gaps: Vec<Gap>,
    /// Where the robot was, the last place last.
    trail_in_odom: Vec<Point>,
}

impl DoorwayDetection {
    /// Takes a scan in; a doorway is told once, when the robot is through.
    pub fn take_in(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) -> Option<Doorway> {
        let here = odometry_in_odom;
        self.go_on(here.point());
        if let Some((one, other)) = posts(scan) {
            let (one, other) = (here.transform(one), here.transform(other));
            let width_m = distance_m(one, other);
            if width_m < WIDEST_M {
                let middle_in_odom = between(one, other, self.way_rad(here));
                self.see(Doorway { middle_in_odom, width_m });
            }
        }
        let gone_m = |gap: &Gap| distance_m(here.point(), gap.narrowest.middle_in_odom.point());
        self.gaps.retain(|gap| gone_m(gap) <= THICKEST_M);
        let passed = self.gaps.iter().find(|gap| self.is_through(gap, here, scan)).map(|gap| gap.narrowest)?;
        self.gaps.clear();
        Some(passed)
    }

    /// Keeps the narrowest of what was heard in about the same place, and how often it was.
    fn see(&mut self, doorway: Doorway) {
        let is_same =
            |gap: &&mut Gap| distance_m(gap.narrowest.middle_in_odom.point(), doorway.middle_in_odom.point()) < SAME_M;
        match self.gaps.iter_mut().find(is_same) {
            Some(gap) => {
                gap.sightings += 1;
                gap.narrowest = if doorway.width_m < gap.narrowest.width_m { doorway } else { gap.narrowest };
            }
            None => self.gaps.push(Gap { narrowest: doorway, sightings: 1 }),
        }
    }

    /// Whether the robot has come through a gap, and it was a doorway.
    fn is_through(&self, gap: &Gap, here: Pose, scan: SonarScan<'_>) -> bool {
        let middle_in_odom = gap.narrowest.middle_in_odom;
        gap.sightings >= SIGHTINGS
            && here.relative_to(middle_in_odom).x_m > THROUGH_M
            && self.came_through(middle_in_odom)
            && is_open(scan, wrap_angle_rad(middle_in_odom.heading_rad - here.heading_rad))
    }

    fn go_on(&mut self, here: Point) {
        if self.trail_in_odom.last().is_none_or(|&last| distance_m(last, here) >= TRAIL_M) {
            self.trail_in_odom.push(here);
        }
        if self.trail_in_odom.len() > TRAIL {
            self.trail_in_odom.remove(0);
        }
    }

    /// The way the robot went lately; the way it looks if it has not gone.
    fn way_rad(&self, here: Pose) -> f64 {
        let behind = self.trail_in_odom.iter().rev().nth(3).or(self.trail_in_odom.first());
        match behind.map(|&behind| here.point() - behind) {
            Some(way) if way.norm() > TRAIL_M => libm::atan2(way.y, way.x),
            Some(_) | None => here.heading_rad,
        }
    }

    /// Whether the robot was before the doorway, and went between its posts.
    fn came_through(&self, middle_in_odom: Pose) -> bool {
        let frame = middle_in_odom.inverse();
        let trail: Vec<Point> = self.trail_in_odom.iter().map(|&place| frame.transform(place)).collect();
        let was_before = trail.iter().any(|place| place.x < -BEFORE_M);
        let mut between = trail.iter().filter(|place| place.x.abs() < TRAIL_M).peekable();
        was_before && between.peek().is_some() && between.all(|place| place.y.abs() < POST_M / 2.0)
    }
}

/// The nearest that is heard, and the nearest opposite to it, in `base`.
fn posts(scan: SonarScan<'_>) -> Option<(Point, Point)> {
    let heard: Vec<(f64, Point)> = scan
        .sonars
        .mounts
        .iter()
        .zip(scan.ranges_m)
        .filter(|(_, range_m)| **range_m > 0.0 && f64::from(**range_m) < POST_M)
        .map(|(mount, &range_m)| {
            let apex = Pose::new(mount.at_in_base.x, mount.at_in_base.y, mount.heading_rad);
            (mount.heading_rad, apex.transform(Point::new(f64::from(range_m), 0.0)))
        })
        .collect();
    let nearer = |one: &&(f64, Point), other: &&(f64, Point)| one.1.coords.norm().total_cmp(&other.1.coords.norm());
    let one = heard.iter().min_by(nearer)?;
    let opposite = heard.iter().filter(|other| wrap_angle_rad(other.0 - one.0).abs() > OPPOSITE_RAD);
    Some((one.1, opposite.min_by(nearer)?.1))
}

/// Whether there is room on both sides of a direction.
fn is_open(scan: SonarScan<'_>, direction_rad: f64) -> bool {
    let ranges_m = scan.ranges_from_middle_m();
    let sides_m = [FRAC_PI_2, -FRAC_PI_2].map(|aside_rad| {
        let off_rad =
            |sonar: &usize| wrap_angle_rad(scan.sonars.mounts[*sonar].heading_rad - direction_rad - aside_rad).abs();
        let sonar = (0..ranges_m.len()).min_by(|one, other| off_rad(one).total_cmp(&off_rad(other)));
        sonar.map_or(0.0, |sonar| f64::from(ranges_m[sonar]).min(scan.sonars.range_m))
    });
    sides_m.iter().all(|&side_m| side_m > OPEN_M) && sides_m.iter().sum::<f64>() > OPEN_TOGETHER_M
}

/// Between two posts, looking about the way that the robot goes.
fn between(one: Point, other: Point, way_rad: f64) -> Pose {
    let across_rad = libm::atan2(one.y - other.y, one.x - other.x);
    let normal_rad = wrap_angle_rad(across_rad - FRAC_PI_2);
    let is_ahead = wrap_angle_rad(normal_rad - way_rad).abs() <= FRAC_PI_2;
    let heading_rad = if is_ahead { normal_rad } else { normal_rad + 2.0 * FRAC_PI_2 };
    Pose::new((one.x + other.x) / 2.0, (one.y + other.y) / 2.0, heading_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::sensors::{SonarArray, SonarLayout};

    const HALF_DOOR_M: f64 = 0.46;

    /// What a ring of sonars hears in the middle of a wall across the way, of which a door is left out.
    fn before_wall(sonars: &SonarArray, here: Pose) -> Vec<f32> {
        let wall: Vec<Point> = (-60..=60)
            .map(|step| f64::from(step) * 0.05)
            .filter(|y_m| y_m.abs() > HALF_DOOR_M)
            .map(|y_m| here.inverse().transform(Point::new(0.0, y_m)))
            .collect();
        let heard = |mount: usize| {
            let looks_rad = sonars.mounts[mount].heading_rad;
            let is_in_cone = |point: &&Point| {
                wrap_angle_rad(libm::atan2(point.y, point.x) - looks_rad).abs() <= sonars.cone_rad / 2.0
            };
            let apex_m = sonars.mounts[mount].at_in_base.coords.norm();
            wall.iter().filter(is_in_cone).map(|point| point.coords.norm() - apex_m).fold(sonars.range_m, f64::min)
                as f32
        };
        (0..sonars.mounts.len()).map(heard).collect()
    }

    #[test]
    fn a_false_echo_hides_no_door() {
        let sonars = SonarArray::new(&SonarLayout::Ring(24), 15_f64.to_radians(), 5.0);
        for has_false_echo in [false, true] {
            let mut doorways = DoorwayDetection::default();
            let mut found = Vec::new();
            for step in -60..=60 {
                let here = Pose::new(f64::from(step) * 0.02, 0.0, 0.0);
                let mut ranges_m = before_wall(&sonars, here);
                if has_false_echo && step == 18 {
                    // Ahead on one side, opposite to the post that is behind on the other.
                    ranges_m[3] = 0.25;
                }
                found.extend(doorways.take_in(here, SonarScan { sonars: &sonars, ranges_m: &ranges_m }));
            }
            let [doorway] = found[..] else { panic!("{found:?}") };
            let middle = doorway.middle_in_odom;
            assert!(middle.x_m.abs() < 0.15 && middle.y_m.abs() < 0.1 && middle.heading_rad.abs() < 0.3, "{doorway:?}");
        }
    }
}
