//! The laser range finder.

use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A laser range finder in the middle of the robot, which looks ahead: how its readings lie.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LaserScanner {
    /// Readings of a scan.
    pub readings: usize,
    /// The angle from one to the next.
    pub resolution_deg: f64,
    /// Readings reach no farther; one of this value saw nothing.
    pub range_m: f64,
}

impl LaserScanner {
    /// Direction of a reading in `base`: from right to left about straight ahead.
    pub fn direction_rad(&self, reading: usize) -> f64 {
        ((reading as f64 - self.middle()) * self.resolution_deg).to_radians()
    }

    /// Which reading a direction belongs to, in readings; the first is 0. It may lie before the first or
    /// behind the last.
    pub fn reading_at(&self, direction_rad: f64) -> f64 {
        direction_rad.to_degrees() / self.resolution_deg + self.middle()
    }

    /// The reading nearest to a direction between its neighbours; none where it has only one, or none.
    pub fn with_neighbours(&self, direction_rad: f64) -> Option<[usize; 3]> {
        let nearest = libm::round(self.reading_at(direction_rad));
        if self.goes_around() {
            let reading = |at: f64| (at as i64).rem_euclid(self.readings as i64) as usize;
            return Some([reading(nearest - 1.0), reading(nearest), reading(nearest + 1.0)]);
        }
        if nearest < 1.0 || nearest + 1.0 >= self.readings as f64 {
            return None;
        }
        let nearest = nearest as usize;
        Some([nearest - 1, nearest, nearest + 1])
    }

    /// The readings to both sides of one, `aside` readings away; none beyond the ends.
    pub fn to_both_sides(&self, reading: usize, aside: usize) -> Option<[usize; 2]> {
        if self.goes_around() {
            let count = self.readings;
            return (2 * aside < count).then(|| [(reading + count - aside) % count, (reading + aside) % count]);
        }
        let right = reading.checked_sub(aside)?;
        (reading + aside < self.readings).then_some([right, reading + aside])
    }

    /// Whether the last reading is beside the first.
    pub fn goes_around(&self) -> bool {
        self.readings as f64 * self.resolution_deg > 360.0 - 1e-6
    }

    /// Whether it looks in a direction.
    pub fn looks(&self, direction_rad: f64) -> bool {
        let reading = self.reading_at(direction_rad);
        self.goes_around() || (0.0..=self.readings as f64 - 1.0).contains(&reading)
    }

    fn middle(&self) -> f64 {
        (self.readings as f64 - 1.0) / 2.0
    }
}

/// What the laser saw at a moment.
#[derive(Clone, Copy, Debug)]
pub struct LaserScan<'a> {
    /// The laser.
    pub laser: &'a LaserScanner,
    /// Distances from the robot's middle, in the order of [`LaserScanner::direction_rad`].
    pub ranges_m: &'a [f32],
}

impl<'a> LaserScan<'a> {
    /// The readings nearest to directions in whole degrees; none is a number where the laser does not look.
    pub fn ranges_towards_m(&self, bearings_deg: &[i32]) -> Cow<'a, [f32]> {
        let range_m = |&bearing_deg: &i32| {
            let direction_rad = f64::from(bearing_deg).to_radians();
            let nearest = libm::round(self.laser.reading_at(direction_rad)) as i64;
            let reading = nearest.rem_euclid(self.laser.readings.max(1) as i64) as usize;
            if self.laser.looks(direction_rad) { self.ranges_m[reading] } else { f32::NAN }
        };
        bearings_deg.iter().map(range_m).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_lie_where_they_are_found() {
        let front = LaserScanner { readings: 181, resolution_deg: 1.0, range_m: 8.0 };
        let around = LaserScanner { readings: 360, resolution_deg: 1.0, range_m: 3.5 };
        let fine = LaserScanner { readings: 541, resolution_deg: 0.5, range_m: 30.0 };
        for laser in [front, around, fine] {
            for reading in 0..laser.readings {
                let found = laser.reading_at(laser.direction_rad(reading));
                assert!((found - reading as f64).abs() < 1e-9, "{found}");
            }
        }
        assert_eq!(front.with_neighbours(0.0), Some([89, 90, 91]));
        assert_eq!(front.with_neighbours(90_f64.to_radians()), None, "the last has one neighbour");
        assert_eq!(around.with_neighbours(179.6_f64.to_radians()), Some([358, 359, 0]));
        assert!(!front.looks(3.0) && around.looks(3.0) && fine.looks(2.0));
        assert_eq!((front.to_both_sides(1, 2), around.to_both_sides(1, 2)), (None, Some([359, 3])));
    }
}
