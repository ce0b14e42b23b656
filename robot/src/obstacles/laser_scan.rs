//! What a laser scan shows of the surfaces it meets.

use crate::geometry::Point;
use crate::sensors::laser_direction_rad;

/// Readings to each side that a reading is averaged with.
const ASIDE: usize = 2;

/// Neighbours on one surface differ by less.
const STEP_M: f32 = 0.1;

/// Points nearer to each other than this are of one surface.
const SURFACE_M: f64 = 0.05;

/// Farther points do not matter to the collision avoidance.
const NEAR_M: f64 = 2.5;

/// Each reading averaged with its neighbours on the same surface, pair by pair outwards as long as both
/// differ little from it: the noise of a reading is more than the air in a narrow gap. In pairs,
/// because then a plane stays where it is, however it is hit. A post of 15 cm seen from half a metre
/// is drawn 1 mm too far away, the edges of things not at all.
pub fn smoothed(laser_m: &[f32]) -> Vec<f32> {
    (0..laser_m.len()).map(|beam| smoothed_reading_m(laser_m, beam)).collect()
}

fn smoothed_reading_m(laser_m: &[f32], beam: usize) -> f32 {
    let reading_m = laser_m[beam];
    let (mut sum_m, mut count) = (reading_m, 1.0);
    for aside in 1..=ASIDE.min(beam).min(laser_m.len() - 1 - beam) {
        let pair_m = [laser_m[beam - aside], laser_m[beam + aside]];
        if pair_m.iter().any(|neighbour_m| (neighbour_m - reading_m).abs() > STEP_M) {
            break;
        }
        sum_m += pair_m[0] + pair_m[1];
        count += 2.0;
    }
    sum_m / count
}

/// Whether the beam through a point, or one beside it, ends on the surface the point is of.
pub fn is_seen(laser_m: &[f32], point_in_base: Point) -> bool {
    let away_m = point_in_base.coords.norm();
    let bearing_rad = libm::atan2(point_in_base.y, point_in_base.x);
    let beam = libm::round(bearing_rad.to_degrees() + (laser_m.len() as f64 - 1.0) / 2.0);
    if beam < 1.0 || beam + 1.0 >= laser_m.len() as f64 {
        return false;
    }
    laser_m[beam as usize - 1..][..3].iter().any(|&reading_m| (f64::from(reading_m) - away_m).abs() < SURFACE_M)
}

/// Where the beams end that end near the robot.
pub fn points_in_base(laser_m: &[f32]) -> impl Iterator<Item = Point> {
    laser_m.iter().enumerate().filter_map(|(beam, &reading_m)| {
        let reading_m = f64::from(reading_m);
        let (sin, cos) = libm::sincos(laser_direction_rad(laser_m.len(), beam));
        (reading_m > 0.0 && reading_m < NEAR_M).then(|| Point::new(reading_m * cos, reading_m * sin))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_random::Stream;

    /// A wall 0.5 m to the left of the robot, parallel to it, up to 2 m ahead, and nothing beyond.
    fn wall_m(beam: usize) -> f32 {
        let bearing_rad = (beam as f64 - 90.0).to_radians();
        let range_m = 0.5 / libm::sin(bearing_rad).max(1e-9);
        (if range_m * libm::cos(bearing_rad) < 2.0 { range_m } else { 8.0 }) as f32
    }

    #[test]
    fn a_wall_stays_in_place_with_half_the_noise_and_its_end_stays_sharp() {
        let truth: Vec<f32> = (0..181).map(wall_m).collect();
        let mut stream = Stream::new(1, "laser");
        let noisy: Vec<f32> = truth.iter().map(|&range_m| range_m + 0.01 * stream.normal() as f32).collect();
        let squares = |scan: &[f32]| -> f32 {
            (120..=178).map(|beam| (scan[beam] - truth[beam]) * (scan[beam] - truth[beam])).sum()
        };
        assert!(squares(&smoothed(&noisy)) < squares(&noisy) / 3.0);
        for (smooth_m, true_m) in smoothed(&truth).iter().zip(&truth) {
            assert!((smooth_m - true_m).abs() < 0.005, "{smooth_m} {true_m}");
        }
    }

    #[test]
    fn a_point_short_of_a_wall_is_seen_to_be_of_it_and_one_before_or_beside_the_scan_is_not() {
        let scan: Vec<f32> = (0..181).map(wall_m).collect();
        assert!(is_seen(&scan, Point::new(0.3, 0.47)) && is_seen(&scan, Point::new(0.3, 0.53)));
        for (x, y) in [(0.3, 0.4), (0.3, 0.6), (0.3, -0.5), (-0.3, 0.5)] {
            assert!(!is_seen(&scan, Point::new(x, y)), "({x}, {y})");
        }
        assert!(points_in_base(&scan).all(|point| (point.y - 0.5).abs() < 1e-6 && point.x < 2.0));
        assert!(points_in_base(&scan).count() > 60);
    }

    #[test]
    fn no_reading_is_mixed_with_what_is_behind_it() {
        let mut scan = vec![8.0_f32; 181];
        scan[90] = 0.6;
        assert_eq!(smoothed(&scan), scan);
        assert_eq!(smoothed(&[]), Vec::<f32>::new());
    }
}
