//! What a laser scan shows of the surfaces it meets.

use crate::geometry::Point;
use crate::sensors::LaserScan;

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
pub fn smoothed(scan: LaserScan<'_>) -> Vec<f32> {
    (0..scan.ranges_m.len()).map(|beam| smoothed_reading_m(scan, beam)).collect()
}

fn smoothed_reading_m(scan: LaserScan<'_>, beam: usize) -> f32 {
    let reading_m = scan.ranges_m[beam];
    let (mut sum_m, mut count) = (reading_m, 1.0);
    for aside in 1..=ASIDE {
        let Some(pair) = scan.laser.to_both_sides(beam, aside) else { break };
        let pair_m = pair.map(|beside| scan.ranges_m[beside]);
        if pair_m.iter().any(|neighbour_m| (neighbour_m - reading_m).abs() > STEP_M) {
            break;
        }
        sum_m += pair_m[0] + pair_m[1];
        count += 2.0;
    }
    sum_m / count
}

/// Whether the beam through a point, or one beside it, ends on the surface the point is of.
pub fn is_seen(scan: LaserScan<'_>, point_in_base: Point) -> bool {
    let away_m = point_in_base.coords.norm();
    let bearing_rad = libm::atan2(point_in_base.y, point_in_base.x);
    let Some(beams) = scan.laser.with_neighbours(bearing_rad) else { return false };
    beams.iter().any(|&beam| (f64::from(scan.ranges_m[beam]) - away_m).abs() < SURFACE_M)
}

/// Where the beams end that end near the robot.
pub fn points_in_base(scan: LaserScan<'_>) -> impl Iterator<Item = Point> {
    let near_m = scan.laser.range_m.min(NEAR_M);
    scan.ranges_m.iter().enumerate().filter_map(move |(beam, &reading_m)| {
        let reading_m = f64::from(reading_m);
        let (sin, cos) = libm::sincos(scan.laser.direction_rad(beam));
        (reading_m > 0.0 && reading_m < near_m).then(|| Point::new(reading_m * cos, reading_m * sin))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::LaserScanner;
    use rpl_random::Stream;

    const FRONT: LaserScanner = LaserScanner { readings: 181, resolution_deg: 1.0, range_m: 8.0 };

    fn scan(ranges_m: &[f32]) -> LaserScan<'_> {
        LaserScan { laser: &FRONT, ranges_m }
    }

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
        assert!(squares(&smoothed(scan(&noisy))) < squares(&noisy) / 3.0);
        for (smooth_m, true_m) in smoothed(scan(&truth)).iter().zip(&truth) {
            assert!((smooth_m - true_m).abs() < 0.005, "{smooth_m} {true_m}");
        }
    }

    #[test]
    fn a_point_short_of_a_wall_is_seen_to_be_of_it_and_one_before_or_beside_the_scan_is_not() {
        let wall: Vec<f32> = (0..181).map(wall_m).collect();
        assert!(is_seen(scan(&wall), Point::new(0.3, 0.47)) && is_seen(scan(&wall), Point::new(0.3, 0.53)));
        for (x, y) in [(0.3, 0.4), (0.3, 0.6), (0.3, -0.5), (-0.3, 0.5)] {
            assert!(!is_seen(scan(&wall), Point::new(x, y)), "({x}, {y})");
        }
        assert!(points_in_base(scan(&wall)).all(|point| (point.y - 0.5).abs() < 1e-6 && point.x < 2.0));
        assert!(points_in_base(scan(&wall)).count() > 60);
    }

    #[test]
    fn no_reading_is_mixed_with_what_is_behind_it() {
        let mut post = vec![8.0_f32; 181];
        post[90] = 0.6;
        assert_eq!(smoothed(scan(&post)), post);
    }
}
