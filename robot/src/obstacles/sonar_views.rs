//! What the sonars heard lately, and from where: a cone tells on which arc the nearest surface lies,
//! the cones of other moments and places tell where on it there is none.

use crate::geometry::{Point, Pose, wrap_angle_rad};
use crate::sensors::{SonarArray, SonarScan};
use serde::{Deserialize, Serialize};

/// The motion or time after which the sonars have another view.
const VIEW_M: f64 = 0.1;
const VIEW_RAD: f64 = 0.087;
const VIEW_S: f64 = 0.5;

/// Older views say nothing: somebody may have come since.
const REMEMBERED_S: f64 = 8.0;

/// How much farther than a point a reading must be to have passed it: five times the noise nearby.
const PASSED_M: f64 = 0.08;

/// One scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct SonarView {
    from_in_odom: Pose,
    /// Of its heading.
    cos: f64,
    sin: f64,
    at_s: f64,
    /// 0 where nothing was heard.
    heard_m: Vec<f32>,
}

impl SonarView {
    /// Whether the sound went through a point and came back from behind it.
    fn passed(&self, sonars: &SonarArray, point_in_odom: Point) -> bool {
        let (dx, dy) = (point_in_odom.x - self.from_in_odom.x_m, point_in_odom.y - self.from_in_odom.y_m);
        let in_base = Point::new(self.cos * dx + self.sin * dy, self.cos * dy - self.sin * dx);
        sonars.is_heard(in_base, |sonar, off| f64::from(self.heard_m[sonar]) > off.norm() + PASSED_M)
    }
}

/// The latest views, oldest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct SonarViews(Vec<SonarView>);

impl SonarViews {
    /// The most views that are kept.
    const CAPACITY: usize = 40;

    /// Takes in a scan, and whether it is from a new place, direction or time.
    pub fn take_in(&mut self, from_in_odom: Pose, scan: SonarScan<'_>, at_s: f64) -> bool {
        self.0.retain(|view| at_s - view.at_s <= REMEMBERED_S);
        let is_new = self.0.last().is_none_or(|last| {
            let turned_rad = wrap_angle_rad(from_in_odom.heading_rad - last.from_in_odom.heading_rad).abs();
            from_in_odom.distance_m(last.from_in_odom) >= VIEW_M || turned_rad >= VIEW_RAD || at_s - last.at_s >= VIEW_S
        });
        if is_new {
            if self.0.len() == Self::CAPACITY {
                self.0.remove(0);
            }
            let max_range_m = scan.sonars.range_m;
            let heard = |&range_m: &f32| if f64::from(range_m) < max_range_m { range_m } else { 0.0 };
            let heard_m = scan.ranges_m.iter().map(heard).collect();
            let (sin, cos) = libm::sincos(from_in_odom.heading_rad);
            self.0.push(SonarView { from_in_odom, cos, sin, at_s, heard_m });
        }
        is_new
    }

    /// Whether the sound of any view passed through a point.
    pub fn passed(&self, sonars: &SonarArray, point_in_odom: Point) -> bool {
        self.0.iter().any(|view| view.passed(sonars, point_in_odom))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::RobotDescription;

    fn ahead(distance_m: f64, bearing_rad: f64) -> Point {
        Point::new(distance_m * libm::cos(bearing_rad), distance_m * libm::sin(bearing_rad))
    }

    #[test]
    fn sound_passes_what_is_nearer_in_its_cone() {
        let sonars = RobotDescription::papers().range_sensors().sonars.expect("it has a ring");
        let mut views = SonarViews::default();
        let mut sonar_m = vec![5.0; sonars.mounts.len()];
        let silent_m = sonar_m.clone();
        sonar_m[1] = 1.0;
        let scan = SonarScan { sonars: &sonars, ranges_m: &sonar_m };
        assert!(views.take_in(Pose::default(), scan, 0.0));
        assert!(!views.take_in(Pose::default(), scan, 0.4));
        let heard_rad = sonars.mounts[1].heading_rad;
        assert!(views.passed(&sonars, ahead(0.8, heard_rad)));
        assert!(!views.passed(&sonars, ahead(0.95, heard_rad)), "that may be its echo");
        assert!(!views.passed(&sonars, ahead(0.8, 0.0)), "silence tells nothing");
        views.take_in(Pose::default(), SonarScan { ranges_m: &silent_m, ..scan }, REMEMBERED_S + 0.1);
        assert!(!views.passed(&sonars, ahead(0.8, heard_rad)), "that is long ago");
    }
}
