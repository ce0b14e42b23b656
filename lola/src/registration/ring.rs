//! What all sonars heard together, held against what they hear later: whether the robot was turned on the spot.

use rpl_robot::geometry::{Pose, wrap_angle_rad};
use rpl_robot::sensors::SonarScan;
use serde::{Deserialize, Serialize};

/// Two readings are of one thing if they are no farther apart; the robot has gone on a little, and people walk.
const SAME_M: f64 = 0.3;

/// What was heard farther away from where the robot is now says nothing.
const NEAR_M: f64 = 0.6;

/// What was heard all around the robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ring {
    from_in_odom: Pose,
    ranges_m: Vec<f32>,
}

impl Ring {
    /// Keeps a scan.
    pub fn of(odometry_in_odom: Pose, scan: SonarScan<'_>) -> Self {
        Self { from_in_odom: odometry_in_odom, ranges_m: scan.ranges_m.to_vec() }
    }

    /// Whether a scan shows what this ring does turned by so much in `odom`, rather than as it was. Who is elsewhere
    /// now may have been turned.
    pub fn is_turned(&self, by_rad: f64, odometry_in_odom: Pose, scan: SonarScan<'_>) -> bool {
        if self.from_in_odom.distance_m(odometry_in_odom) > NEAR_M {
            return true;
        }
        self.alike(by_rad, odometry_in_odom, scan) > self.alike(0.0, odometry_in_odom, scan)
    }

    /// How many sonars hear what one that looked that way heard before, if all around is turned by so much.
    fn alike(&self, by_rad: f64, odometry_in_odom: Pose, scan: SonarScan<'_>) -> usize {
        let turned_rad = odometry_in_odom.heading_rad - self.from_in_odom.heading_rad - by_rad;
        let is_alike = |heard: &(usize, &f32)| {
            let (sonar, range_m) = (heard.0, *heard.1);
            let looked_rad = scan.sonars.mounts[sonar].heading_rad + turned_rad;
            let off_rad = |before: usize| wrap_angle_rad(scan.sonars.mounts[before].heading_rad - looked_rad).abs();
            let same_way = (0..self.ranges_m.len()).filter(|&before| off_rad(before) <= scan.sonars.cone_rad);
            let is_heard = f64::from(range_m) < scan.sonars.range_m;
            is_heard && same_way.into_iter().any(|before| f64::from((self.ranges_m[before] - range_m).abs()) < SAME_M)
        };
        scan.ranges_m.iter().enumerate().filter(is_alike).count()
    }
}
