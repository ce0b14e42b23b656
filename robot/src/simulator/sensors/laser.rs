//! The laser range finder.

use super::Commands;
use crate::geometry::{Pose, Vector, wrap_angle_rad};
use crate::sensors::LaserScanner;
use crate::simulator::model::SimulatorModel;
use crate::simulator::state::SimulatorState;
use crate::simulator::surface::SurfaceForm;
use crate::simulator::sweep::{cross, disc_along};
use rpl_random::Stream;

impl SimulatorModel {
    /// One scan; none if the robot has no laser.
    pub(super) fn scan_laser(&self, state: &SimulatorState, _: &Commands, stream: &mut Stream) -> Option<Vec<f32>> {
        let laser = self.robot().laser?;
        let most_m = laser.scanner.range_m;
        let ranges_m = self.laser_ranges(state, state.robot_in_map);
        let readings = ranges_m.into_iter().map(|range_m| {
            if stream.chance(laser.dropout_probability) || range_m >= most_m {
                return most_m as f32;
            }
            (range_m + laser.noise_m * stream.normal()).clamp(0.0, most_m) as f32
        });
        Some(readings.collect())
    }

    /// Distance to the first surface that the robot's laser sees along each reading, at most its range: no
    /// noise. Nothing without a laser.
    pub fn laser_ranges(&self, state: &SimulatorState, robot_in_map: Pose) -> Vec<f64> {
        let Some(laser) = &self.sensors.laser else { return Vec::new() };
        let mut ranges_m = vec![laser.range_m; laser.readings];
        let lay = |form: &SurfaceForm| self.lay(laser, form, &mut ranges_m);
        self.for_each_visible(state, robot_in_map, |seen_by| seen_by.laser, lay);
        ranges_m
    }

    /// Shortens the readings that meet a surface, given in `base`.
    fn lay(&self, laser: &LaserScanner, form: &SurfaceForm, ranges_m: &mut [f64]) {
        match *form {
            SurfaceForm::Edge { a, b } => {
                let twice_area_m2 = cross(a.coords, b.coords);
                if twice_area_m2 >= 0.0 {
                    return;
                }
                let along = b - a;
                let (from_rad, to_rad) = (libm::atan2(b.y, b.x), libm::atan2(a.y, a.x));
                self.shorten(laser, ranges_m, [from_rad, to_rad], |direction| {
                    Some(twice_area_m2 / cross(direction, along)).filter(|range_m| *range_m > 0.0)
                });
            }
            SurfaceForm::Disc { centre, radius_m } => {
                let distance_m = centre.coords.norm_squared().sqrt();
                if distance_m <= radius_m {
                    return;
                }
                let middle_rad = libm::atan2(centre.y, centre.x);
                let half_rad = libm::asin(radius_m / distance_m);
                let (from_rad, to_rad) = (wrap_angle_rad(middle_rad - half_rad), wrap_angle_rad(middle_rad + half_rad));
                self.shorten(laser, ranges_m, [from_rad, to_rad], |direction| {
                    disc_along(direction, centre.coords, radius_m).map(|echo| echo.range_m)
                });
            }
        }
    }

    /// Applies a hit to all readings between two directions, counter-clockwise.
    fn shorten(
        &self,
        laser: &LaserScanner,
        ranges_m: &mut [f64],
        between_rad: [f64; 2],
        hit: impl Fn(Vector) -> Option<f64>,
    ) {
        let [from, to] = between_rad.map(|angle_rad| laser.reading_at(angle_rad));
        // A surface straight behind runs over ±180°, and shows up at the two ends of the scan or not at
        // all.
        let pieces =
            if from <= to { [(from, to), (1.0, 0.0)] } else { [(from, f64::INFINITY), (f64::NEG_INFINITY, to)] };
        for (from, to) in pieces {
            let first = libm::ceil(from - 1e-9).max(0.0);
            let last = libm::floor(to + 1e-9).min(ranges_m.len() as f64 - 1.0);
            if first > last {
                continue;
            }
            let piece = first as usize..=last as usize;
            for (range_m, direction) in ranges_m[piece.clone()].iter_mut().zip(&self.laser_directions[piece]) {
                if let Some(hit_m) = hit(*direction) {
                    *range_m = range_m.min(hit_m);
                }
            }
        }
    }
}
