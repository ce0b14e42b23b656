//! A fan of rays from the middle of the robot, and where surfaces meet it, exactly: each is laid onto the
//! rays between its two ends.

use super::echo::{cross, disc_along};
use super::surface::SurfaceForm;
use crate::geometry::{Vector, wrap_angle_rad};
use crate::sensors::LaserScanner;

/// Rays that lie like the readings of a laser, with their directions.
#[derive(Debug)]
pub(super) struct Fan {
    pub scanner: LaserScanner,
    /// Unit vectors.
    directions: Vec<Vector>,
}

impl Fan {
    pub fn new(scanner: LaserScanner) -> Self {
        let unit = |reading| {
            let (sin, cos) = libm::sincos(scanner.direction_rad(reading));
            Vector::new(cos, sin)
        };
        Self { directions: (0..scanner.readings).map(unit).collect(), scanner }
    }

    /// Tells each ray that meets a surface how far off it does; the surface is given in the frame of the fan.
    pub fn lay<T>(&self, form: &SurfaceForm, rays: &mut [T], meet: impl Fn(&mut T, f64)) {
        match *form {
            SurfaceForm::Edge { a, b } => {
                let twice_area_m2 = cross(a.coords, b.coords);
                if twice_area_m2 >= 0.0 {
                    return;
                }
                let along = b - a;
                let between_rad = [libm::atan2(b.y, b.x), libm::atan2(a.y, a.x)];
                self.meet_between(rays, between_rad, meet, |direction| {
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
                let between_rad = [wrap_angle_rad(middle_rad - half_rad), wrap_angle_rad(middle_rad + half_rad)];
                self.meet_between(rays, between_rad, meet, |direction| {
                    disc_along(direction, centre.coords, radius_m).map(|echo| echo.range_m)
                });
            }
        }
    }

    /// All rays between two directions, counter-clockwise, that have a hit.
    fn meet_between<T>(
        &self,
        rays: &mut [T],
        between_rad: [f64; 2],
        meet: impl Fn(&mut T, f64),
        hit: impl Fn(Vector) -> Option<f64>,
    ) {
        let [from, to] = between_rad.map(|angle_rad| self.scanner.reading_at(angle_rad));
        // A surface straight behind runs over ±180°, and shows up at the two ends of the fan or not at
        // all.
        let pieces =
            if from <= to { [(from, to), (1.0, 0.0)] } else { [(from, f64::INFINITY), (f64::NEG_INFINITY, to)] };
        for (from, to) in pieces {
            let first = libm::ceil(from - 1e-9).max(0.0);
            let last = libm::floor(to + 1e-9).min(rays.len() as f64 - 1.0);
            if first > last {
                continue;
            }
            let piece = first as usize..=last as usize;
            for (ray, direction) in rays[piece.clone()].iter_mut().zip(&self.directions[piece]) {
                if let Some(hit_m) = hit(*direction) {
                    meet(ray, hit_m);
                }
            }
        }
    }
}
