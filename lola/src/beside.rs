//! The sonars that look to the sides of a hallway, and what their readings say about a wall there.

use crate::feature::Side;
use rpl_robot::geometry::{Point, Pose, Vector, wrap_angle_rad};
use rpl_robot::sensors::SonarScan;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// A reading of a sonar that looks to a side, in the hallway's own directions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SideReading {
    /// The apex of the cone from the middle of the robot, along the axis.
    pub apex_along_m: f64,
    /// The same across the axis, positive towards the side.
    pub apex_aside_m: f64,
    /// The cone's edge that is farther back, from the perpendicular of the axis, positive ahead.
    pub from_rad: f64,
    /// Its edge that is farther ahead.
    pub to_rad: f64,
    /// What was heard, from the apex; infinite for silence.
    pub range_m: f64,
}

impl SideReading {
    /// The direction of the cone that is nearest to the perpendicular. From there the echo of a straight
    /// wall comes, as nothing of the wall that is in the cone is nearer.
    pub fn nearest_rad(&self) -> f64 {
        if self.from_rad > 0.0 { self.from_rad } else { self.to_rad.min(0.0) }
    }

    /// How far the cone's axis is off the perpendicular.
    pub fn off_rad(&self) -> f64 {
        (self.from_rad + self.to_rad).abs() / 2.0
    }

    /// The perpendicular distance of a wall that gives this echo, from the apex.
    ///
    /// # Deviation
    /// The paper projects each reading of the one transducer that is nearest to the perpendicular along that
    /// transducer's axis. The echo of a wall comes from its nearest point, though, which is on the
    /// perpendicular wherever that lies in the cone: taken as it is, the range is the distance. With that in
    /// mind the transducers beside the nearest one measure the same wall.
    pub fn perpendicular_m(&self) -> f64 {
        self.echo_m().1
    }

    /// Where a wall that gives this echo is met, from the apex: along the axis, and across it.
    pub fn echo_m(&self) -> (f64, f64) {
        let nearest_rad = self.nearest_rad();
        // That of the sonars which hear most is on the perpendicular.
        if nearest_rad == 0.0 || self.range_m == f64::INFINITY {
            return (0.0, self.range_m);
        }
        let (sin, cos) = libm::sincos(nearest_rad);
        (self.range_m * sin, self.range_m * cos)
    }

    /// Where on a wall at this perpendicular distance the echo comes from, along the axis from the middle of
    /// the robot.
    pub fn foot_m(&self, perpendicular_m: f64) -> f64 {
        self.apex_along_m + perpendicular_m * libm::tan(self.nearest_rad())
    }

    /// The part of a wall at this perpendicular distance that is in the cone, along the axis from the middle
    /// of the robot.
    pub fn footprint_m(&self, perpendicular_m: f64) -> (f64, f64) {
        let reach_m = |edge_rad: f64| self.apex_along_m + perpendicular_m * libm::tan(edge_rad);
        (reach_m(self.from_rad), reach_m(self.to_rad))
    }
}

/// The readings of the sonars that look to a side of a hallway, whose axes are at most `widest_rad` off the
/// perpendicular; the robot's heading is given from the axis.
pub fn side_readings<'a>(
    scan: SonarScan<'a>,
    heading_in_hallway_rad: f64,
    side: Side,
    widest_rad: f64,
) -> impl Iterator<Item = SideReading> + use<'a> {
    let (sin, cos) = libm::sincos(heading_in_hallway_rad);
    let half_cone_rad = scan.sonars.cone_rad / 2.0;
    scan.sonars.mounts.iter().zip(scan.ranges_m).filter_map(move |(mount, &range_m)| {
        let outwards_rad = heading_in_hallway_rad + mount.heading_rad - side.sign() * FRAC_PI_2;
        let ahead_rad = -side.sign() * wrap_angle_rad(outwards_rad);
        let Point { coords: at } = mount.at_in_base;
        let heard = range_m > 0.0 && f64::from(range_m) < scan.sonars.range_m;
        (ahead_rad.abs() <= widest_rad).then_some(SideReading {
            apex_along_m: cos * at.x - sin * at.y,
            apex_aside_m: side.sign() * (sin * at.x + cos * at.y),
            from_rad: ahead_rad - half_cone_rad,
            to_rad: ahead_rad + half_cone_rad,
            range_m: if heard { f64::from(range_m) } else { f64::INFINITY },
        })
    })
}

/// The directions of a hallway, in `odom`: along its axis and to its left.
pub fn axes_in_odom(axis_in_odom_rad: f64) -> (Vector, Vector) {
    let (sin, cos) = libm::sincos(axis_in_odom_rad);
    (Vector::new(cos, sin), Vector::new(-sin, cos))
}

/// How far a pose lies to a side of the line through the origin of `odom` along an axis.
pub fn aside_m(pose_in_odom: Pose, axis_in_odom_rad: f64, side: Side) -> f64 {
    let (_, left) = axes_in_odom(axis_in_odom_rad);
    side.sign() * left.dot(&pose_in_odom.point().coords)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::sensors::{SonarArray, SonarLayout};

    #[test]
    fn every_sonar_that_hears_a_straight_wall_tells_its_distance() {
        let sonars = SonarArray::new(&SonarLayout::Ring(24), 15_f64.to_radians(), 5.0);
        for heading_rad in [0.0, 0.05, -0.1, 0.3] {
            for side in Side::ALL {
                let range_m = |mount: f64| {
                    let off_rad = wrap_angle_rad(mount + heading_rad - side.sign() * FRAC_PI_2).abs();
                    (1.2 / libm::cos((off_rad - 7.5_f64.to_radians()).clamp(0.0, 1.4))) as f32
                };
                let ranges_m: Vec<f32> = sonars.mounts.iter().map(|mount| range_m(mount.heading_rad)).collect();
                let scan = SonarScan { sonars: &sonars, ranges_m: &ranges_m };
                let readings: Vec<_> = side_readings(scan, heading_rad, side, 0.6).collect();
                assert!(readings.len() >= 4);
                assert!(readings.iter().all(|reading| (reading.perpendicular_m() - 1.2).abs() < 1e-6));
                let ahead = readings.iter().filter(|reading| reading.foot_m(1.2) > 0.01).count();
                assert!(ahead >= 1 && ahead < readings.len(), "some look ahead, some look back");
            }
        }
    }
}
