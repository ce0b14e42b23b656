//! A scan as a laser's driver says it, and as all scans of a recording are: from right to left, on the same rays, with
//! one number for what had no echo.

use super::drive::ScanGeometry;
use crate::geometry::wrap_angle_rad;

/// What stands for no echo where the laser does not say how far it sees: farther than any parameter of the filter.
const NO_ECHO_M: f32 = 1000.0;

/// Scans may have this share of rays more or fewer than the first one, and as much of it on rays of their own.
const OTHER_RAYS: f64 = 0.1;

/// But so many rays may always be missing, or be too many.
const FEW_RAYS: f64 = 2.0;

/// A reading stands for a ray of the first scan from this near, in steps: the neighbour's reading for a ray that is
/// missing.
const NEAR_STEPS: f64 = 1.25;

/// A scan as a driver says it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rays<'r> {
    /// Bearing of the first reading.
    pub first_rad: f64,
    /// Bearing of the last reading; asked only where the step is not known.
    pub last_rad: f64,
    /// From one reading to the next; negative if they go from left to right.
    pub step_rad: f64,
    /// What is less was not measured.
    pub range_min_m: f32,
    /// What is more was not measured.
    pub range_max_m: f32,
    /// The readings in their order; none is refused.
    pub ranges_m: &'r [f32],
}

impl Rays<'_> {
    /// Where the readings point, from right to left; none if there are no readings, or their directions are unknown.
    pub fn geometry(&self) -> Option<ScanGeometry> {
        let readings = self.ranges_m.len();
        let last = readings.checked_sub(1)? as f64;
        let said_rad = self.step_rad;
        let known_rad = if said_rad.is_finite() && said_rad != 0.0 || last == 0.0 {
            said_rad
        } else {
            (self.last_rad - self.first_rad) / last
        };
        let is_known = known_rad.is_finite() && known_rad != 0.0 && self.first_rad.is_finite();
        let geometry = |first_rad, step_rad| ScanGeometry { readings, first_rad, step_rad };
        match (is_known, known_rad < 0.0) {
            (false, _) => None,
            (true, false) => Some(geometry(self.first_rad, known_rad)),
            (true, true) => Some(geometry(self.first_rad + last * known_rad, -known_rad)),
        }
    }

    /// How far the laser sees; none if it does not say so.
    pub fn range_m(&self) -> Option<f64> {
        Some(self.range_max_m).filter(|range_m| range_m.is_finite() && *range_m > 0.0).map(f64::from)
    }

    /// What stands for no echo.
    pub fn no_echo_m(&self) -> f32 {
        self.range_m().map_or(NO_ECHO_M, |range_m| range_m as f32)
    }

    /// The readings on the rays of another scan, each the nearest one; what was not measured is `no_echo_m`. None if
    /// too many of them point elsewhere. O(rays).
    pub fn on(&self, rays: &ScanGeometry, no_echo_m: f32) -> Option<Vec<f32>> {
        let own = self.geometry()?;
        let (wanted, had) = (rays.readings as f64, own.readings as f64);
        let allowed = (OTHER_RAYS * wanted).max(FEW_RAYS);
        if libm::fabs(wanted - had) > allowed {
            return None;
        }
        let last = had - 1.0;
        let middle_rad = own.bearing_rad(0) + last / 2.0 * own.step_rad;
        let mut missing = 0.0;
        let reading = |ray: usize| {
            // Around the middle of the scan, so that a whole turn may begin anywhere.
            let exact = wrap_angle_rad(rays.bearing_rad(ray) - middle_rad) / own.step_rad + last / 2.0;
            let nearest = libm::round(exact).clamp(0.0, last);
            if libm::fabs(exact - nearest) > NEAR_STEPS {
                missing += 1.0;
                return no_echo_m;
            }
            self.heard_m(nearest as usize, no_echo_m)
        };
        let readings: Vec<f32> = (0..rays.readings).map(reading).collect();
        (missing <= allowed).then_some(readings)
    }

    /// A reading, counted from the right. What the laser says is out of its range, 0, and what is no number had no echo.
    fn heard_m(&self, from_right: usize, no_echo_m: f32) -> f32 {
        let clockwise = self.geometry_is_clockwise();
        let index = if clockwise { self.ranges_m.len() - 1 - from_right } else { from_right };
        let range_m = self.ranges_m[index];
        let least_m = if self.range_min_m < self.no_echo_m() { self.range_min_m.max(0.0) } else { 0.0 };
        let is_measured = range_m > 0.0 && range_m >= least_m && range_m <= self.no_echo_m();
        if is_measured { range_m } else { no_echo_m }
    }

    fn geometry_is_clockwise(&self) -> bool {
        let said = self.step_rad.is_finite() && self.step_rad != 0.0;
        if said { self.step_rad < 0.0 } else { self.last_rad < self.first_rad }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    fn rays(ranges_m: &[f32]) -> Rays<'_> {
        Rays { first_rad: -1.0, last_rad: 1.0, step_rad: 0.5, range_min_m: 0.2, range_max_m: 3.5, ranges_m }
    }

    fn heard(rays: Rays) -> Vec<f32> {
        let geometry = rays.geometry().expect("its rays point somewhere");
        rays.on(&geometry, rays.no_echo_m()).expect("on its own rays")
    }

    #[test]
    fn what_was_not_measured_has_no_echo() {
        assert_eq!(heard(rays(&[0.0, f32::INFINITY, f32::NAN, 4.5, 1.0])), [3.5, 3.5, 3.5, 3.5, 1.0]);
        assert_eq!(heard(rays(&[0.1, f32::NEG_INFINITY, 3.5, 0.2, -1.0])), [3.5, 3.5, 3.5, 0.2, 3.5]);
    }

    #[test]
    fn readings_from_left_to_right_are_turned_round() {
        let left = Rays { first_rad: 1.0, last_rad: -1.0, step_rad: -0.5, ..rays(&[1.0, 2.0, 3.0, 2.5, 1.5]) };
        assert_eq!(left.geometry(), rays(left.ranges_m).geometry());
        assert_eq!(heard(left), [1.5, 2.5, 3.0, 2.0, 1.0]);
        // A driver that does not know its step.
        assert_eq!(heard(Rays { step_rad: 0.0, ..left }), heard(left));
    }

    #[test]
    fn a_scan_with_a_ray_less_is_that_of_its_neighbours_there() {
        let whole = rays(&[1.0, 1.1, 1.2, 1.3, 1.4]).geometry().expect("rays");
        assert_eq!(rays(&[1.0, 1.1, 1.2, 1.3]).on(&whole, 3.5), Some(vec![1.0, 1.1, 1.2, 1.3, 1.3]));
        assert_eq!(rays(&[1.0, 1.1]).on(&whole, 3.5), None);
        let elsewhere = Rays { first_rad: 1.0, ..rays(&[1.0; 5]) };
        assert_eq!(elsewhere.on(&whole, 3.5), None);
    }

    #[test]
    fn a_whole_turn_may_begin_anywhere() {
        let ranges_m: Vec<f32> = (1..=8).map(|reading| reading as f32 / 4.0).collect();
        let from_ahead = Rays { first_rad: 0.0, last_rad: 0.0, step_rad: TAU / 8.0, ..rays(&ranges_m) };
        let behind = ScanGeometry { readings: 8, first_rad: -PI, step_rad: TAU / 8.0 };
        let turned = from_ahead.on(&behind, 3.5).expect("the same rays");
        assert_eq!(turned, [1.25, 1.5, 1.75, 2.0, 0.25, 0.5, 0.75, 1.0]);
    }

    #[test]
    fn a_scan_without_rays_has_no_geometry() {
        assert_eq!(rays(&[]).geometry(), None);
        assert_eq!(Rays { step_rad: f64::NAN, last_rad: f64::NAN, ..rays(&[1.0, 1.0]) }.geometry(), None);
    }
}
