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

    /// Whether a scan shows what this ring does turned by this angle in `odom`, rather than as it was. A robot that is
    /// elsewhere now may have been turned.
    pub fn is_turned(&self, by_rad: f64, odometry_in_odom: Pose, scan: SonarScan<'_>) -> bool {
        if self.from_in_odom.distance_m(odometry_in_odom) > NEAR_M {
            return true;
        }
        self.alike(by_rad, odometry_in_odom, scan) > self.alike(0.0, odometry_in_odom, scan)
    }

    /// How many sonars hear what one that looked that way heard before, if all around is turned by this angle.
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

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::sensors::{SonarArray, SonarLayout};

    /// What a ring hears in the middle of a hallway 2.2 m wide, looking by this angle off its axis.
    fn in_hallway(sonars: &SonarArray, off_rad: f64) -> Vec<f32> {
        let range_m = |heading_rad: f64| 1.1 / libm::sin(heading_rad + off_rad).abs().max(0.25);
        sonars.mounts.iter().map(|mount| range_m(mount.heading_rad) as f32).collect()
    }

    #[test]
    fn a_turn_by_hand_shows_in_all_sonars_and_a_turn_of_its_own_does_not() {
        let sonars = SonarArray::new(&SonarLayout::Ring(24), 15_f64.to_radians(), 5.0);
        let scan = |ranges_m| SonarScan { sonars: &sonars, ranges_m };
        let before = in_hallway(&sonars, 0.0);
        let ring = Ring::of(Pose::default(), scan(&before));
        // The odometry does not notice: in `odom` the hallway is turned the other way.
        let turned = in_hallway(&sonars, 1.2);
        assert!(ring.is_turned(-1.2, Pose::new(0.1, 0.0, 0.0), scan(&turned)));
        assert!(!ring.is_turned(-1.2, Pose::new(0.1, 0.0, 0.0), scan(&before)), "nobody turned it");
        assert!(!ring.is_turned(-1.2, Pose::new(0.1, 0.0, 1.2), scan(&turned)), "it turned itself");
        assert!(ring.is_turned(-1.2, Pose::new(2.0, 0.0, 0.0), scan(&before)), "it is elsewhere, who knows");
    }
}
