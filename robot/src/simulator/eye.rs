//! The eye of the camera: where each of its pixels looks.

use super::fan::Fan;
use crate::description::Camera;
use crate::geometry::Vector;
use crate::sensors::{CameraView, LaserScanner, Pixel};

/// So far the camera sees.
pub(super) const SIGHT_M: f64 = 6.0;

/// Rays of the fan for each column of the image, so that what stands has its edge to a part of a pixel.
const RAYS_PER_COLUMN: usize = 3;

/// The camera of a robot, ready for looking.
#[derive(Debug)]
pub(super) struct Eye {
    pub camera: Camera,
    /// The bearings of the image.
    pub fan: Fan,
    /// Where each pixel looks, the top row first.
    pub lines: Vec<Line>,
}

/// Where a pixel looks, in `pan`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    /// In the plane, of unit length.
    pub direction: Vector,
    /// How far it sinks in each metre along.
    pub drop_per_m: f64,
    /// The ray of the fan beside it.
    pub ray: usize,
}

impl Eye {
    pub fn new(camera: Camera) -> Self {
        let fan = Fan::new(bearings(&camera.view));
        let line = |number: usize| {
            let (column, row) = (number % camera.view.columns, number / camera.view.columns);
            let sight = camera.view.sight(Pixel { column: column as f64 + 0.5, row: row as f64 + 0.5 });
            let ray = libm::round(fan.scanner.reading_at(libm::atan2(sight.direction.y, sight.direction.x)));
            let ray = ray.clamp(0.0, fan.scanner.readings as f64 - 1.0) as usize;
            Line { direction: sight.direction, drop_per_m: sight.drop_per_m, ray }
        };
        Self { lines: (0..camera.view.columns * camera.view.rows).map(line).collect(), fan, camera }
    }
}

/// Rays over all bearings of an image: the lower a row, the wider they are apart.
fn bearings(view: &CameraView) -> LaserScanner {
    let corner = view.sight(Pixel { column: 0.0, row: view.rows as f64 }).direction;
    let widest_deg = libm::atan2(corner.y, corner.x).to_degrees();
    let readings = RAYS_PER_COLUMN * view.columns + 1;
    LaserScanner { readings, resolution_deg: 2.0 * widest_deg / (readings - 1) as f64, range_m: SIGHT_M }
}
