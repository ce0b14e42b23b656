//! What the sonars heard lately, and from where: a cone tells on which arc the nearest surface lies,
//! the cones of other moments and places tell where on it there is none.

use crate::geometry::{Point, Pose, wrap_angle_rad};
use crate::sensors::SONARS;
use serde::{Deserialize, Serialize};

/// After so much motion or time the sonars have another view.
const VIEW_M: f64 = 0.1;
const VIEW_RAD: f64 = 0.087;
const VIEW_S: f64 = 0.5;

/// Older views say nothing: somebody may have come since.
const REMEMBERED_S: f64 = 8.0;

/// So much farther than a point a reading must be to have passed it: five times the noise nearby.
const PASSED_M: f64 = 0.08;

/// One scan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct SonarView {
    from_in_odom: Pose,
    /// Of its heading.
    cos: f64,
    sin: f64,
    at_s: f64,
    /// 0 where nothing was heard.
    heard_m: [f32; SONARS],
}

impl SonarView {
    /// Whether the sound went through a point and came back from behind it.
    fn passed(&self, point_in_odom: Point) -> bool {
        let (dx, dy) = (point_in_odom.x - self.from_in_odom.x_m, point_in_odom.y - self.from_in_odom.y_m);
        let in_base = Point::new(self.cos * dx + self.sin * dy, self.cos * dy - self.sin * dx);
        f64::from(self.heard_m[cone_around(in_base)]) > in_base.coords.norm() + PASSED_M
    }
}

/// The latest views, oldest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct SonarViews(Vec<SonarView>);

impl SonarViews {
    /// At most so many.
    const CAPACITY: usize = 40;

    /// Takes in a scan, and whether it is from a new place, direction or time.
    pub fn take_in(&mut self, from_in_odom: Pose, sonar_m: &[f32; SONARS], max_range_m: f64, at_s: f64) -> bool {
        self.0.retain(|view| at_s - view.at_s <= REMEMBERED_S);
        let is_new = self.0.last().is_none_or(|last| {
            let turned_rad = wrap_angle_rad(from_in_odom.heading_rad - last.from_in_odom.heading_rad).abs();
            from_in_odom.distance_m(last.from_in_odom) >= VIEW_M || turned_rad >= VIEW_RAD || at_s - last.at_s >= VIEW_S
        });
        if is_new {
            if self.0.len() == Self::CAPACITY {
                self.0.remove(0);
            }
            let heard_m = sonar_m.map(|range_m| if f64::from(range_m) < max_range_m { range_m } else { 0.0 });
            let (sin, cos) = libm::sincos(from_in_odom.heading_rad);
            self.0.push(SonarView { from_in_odom, cos, sin, at_s, heard_m });
        }
        is_new
    }

    /// Whether the sound of any view passed through a point.
    pub fn passed(&self, point_in_odom: Point) -> bool {
        self.0.iter().any(|view| view.passed(point_in_odom))
    }
}

/// The sonar whose cone a direction is in, without an arctangent: the edges of the cones lie at odd
/// multiples of 7.5°.
fn cone_around(in_base: Point) -> usize {
    const TAN_7_5: f64 = 0.131_652_497_587_395_85;
    const TAN_22_5: f64 = 0.414_213_562_373_095_03;
    const TAN_37_5: f64 = 0.767_326_987_978_960_3;
    let (across, along) = (in_base.x.abs().min(in_base.y.abs()), in_base.x.abs().max(in_base.y.abs()));
    let in_octant = [TAN_7_5, TAN_22_5, TAN_37_5].iter().filter(|&&edge| across > edge * along).count();
    let in_quadrant = if in_base.y.abs() > in_base.x.abs() { SONARS / 4 - in_octant } else { in_octant };
    let in_half = if in_base.x < 0.0 { SONARS / 2 - in_quadrant } else { in_quadrant };
    if in_base.y < 0.0 { (SONARS - in_half) % SONARS } else { in_half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::sonar_direction_rad;

    fn ahead(distance_m: f64, bearing_rad: f64) -> Point {
        Point::new(distance_m * libm::cos(bearing_rad), distance_m * libm::sin(bearing_rad))
    }

    #[test]
    fn every_direction_is_in_the_cone_about_the_nearest_axis() {
        for degree in 0..720 {
            let bearing_rad = (0.5 * f64::from(degree) + 0.1).to_radians();
            let nearest = (0..SONARS)
                .min_by(|&a, &b| {
                    let off = |sonar| wrap_angle_rad(bearing_rad - sonar_direction_rad(sonar)).abs();
                    off(a).total_cmp(&off(b))
                })
                .expect("a sonar");
            assert_eq!(cone_around(ahead(2.0, bearing_rad)), nearest, "{bearing_rad}");
        }
    }

    #[test]
    fn sound_passes_what_is_nearer_in_its_cone() {
        let mut views = SonarViews::default();
        let mut sonar_m = [5.0; SONARS];
        sonar_m[1] = 1.0;
        assert!(views.take_in(Pose::default(), &sonar_m, 5.0, 0.0));
        assert!(!views.take_in(Pose::default(), &sonar_m, 5.0, 0.4));
        let heard_rad = sonar_direction_rad(1);
        assert!(views.passed(ahead(0.8, heard_rad)));
        assert!(!views.passed(ahead(0.95, heard_rad)), "that may be its echo");
        assert!(!views.passed(ahead(0.8, 0.0)), "silence tells nothing");
        views.take_in(Pose::default(), &[5.0; SONARS], 5.0, REMEMBERED_S + 0.1);
        assert!(!views.passed(ahead(0.8, heard_rad)), "that is long ago");
    }
}
