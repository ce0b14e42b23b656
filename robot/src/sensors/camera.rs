//! The camera: how its pixels lie, and where on the floor each of them looks.

use crate::geometry::{Point, Vector};
use serde::{Deserialize, Serialize};

/// How a camera sees: a pinhole over the middle of the robot, which looks down at a fixed tilt and is turned
/// by a pan unit. What it sees lies in the frame `pan`, whose x axis is where it is turned to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraView {
    /// Pixels of a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// From the left edge of an image to its right one, through its middle.
    pub field_of_view_rad: f64,
    /// Over the floor.
    pub height_m: f64,
    /// How far below the horizon the middle of an image is.
    pub tilt_rad: f64,
}

/// A place in an image: pixels from its left edge, and rows from its top one. The middle of the first pixel
/// is at (0.5, 0.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// From the left edge.
    pub column: f64,
    /// From the top edge.
    pub row: f64,
}

/// Where a pixel looks, in `pan`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// In the plane, of unit length.
    pub direction: Vector,
    /// How far the line of sight sinks in each metre along it; negative above the horizon.
    pub drop_per_m: f64,
}

impl CameraView {
    /// Pixels from the pinhole to the image.
    fn focal(&self) -> f64 {
        self.columns as f64 / 2.0 / libm::tan(self.field_of_view_rad / 2.0)
    }

    /// How far below the middle of an image its lower edge is seen.
    pub fn half_height_rad(&self) -> f64 {
        libm::atan(self.rows as f64 / 2.0 / self.focal())
    }

    /// Where a pixel looks.
    pub fn sight(&self, pixel: Pixel) -> Sight {
        let (sin, cos) = libm::sincos(self.tilt_rad);
        let focal = self.focal();
        let right = (pixel.column - self.columns as f64 / 2.0) / focal;
        let down = (pixel.row - self.rows as f64 / 2.0) / focal;
        let (ahead, left) = (cos - down * sin, -right);
        let length = libm::hypot(ahead, left);
        Sight { direction: Vector::new(ahead, left) / length, drop_per_m: (sin + down * cos) / length }
    }

    /// The point of the floor that a pixel shows, in `pan`; none at the horizon and above.
    pub fn floor_point(&self, pixel: Pixel) -> Option<Point> {
        let Sight { direction, drop_per_m } = self.sight(pixel);
        (drop_per_m > 0.0).then(|| Point::from(direction * (self.height_m / drop_per_m)))
    }

    /// Where a point of the floor is seen, given in `pan`; none behind the camera. The pixel may lie outside
    /// the image.
    pub fn pixel_of(&self, floor_in_pan: Point) -> Option<Pixel> {
        let (sin, cos) = libm::sincos(self.tilt_rad);
        let depth_m = floor_in_pan.x * cos + self.height_m * sin;
        if depth_m <= 0.0 {
            return None;
        }
        let down = (self.height_m * cos - floor_in_pan.x * sin) / depth_m;
        let right = -floor_in_pan.y / depth_m;
        let focal = self.focal();
        let (column, row) = (self.columns as f64 / 2.0 + right * focal, self.rows as f64 / 2.0 + down * focal);
        Some(Pixel { column, row })
    }
}

/// A colour: red, green and blue.
pub type Rgb = [u8; 3];

/// A colour image.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CameraImage {
    /// Pixels of a row.
    pub columns: usize,
    /// `rows · columns · 3` bytes: red, green, blue; the top row first, each from left to right.
    pub rgb: Vec<u8>,
}

impl CameraImage {
    /// The colour of a pixel; both count from 0, and must be within the image.
    pub fn at(&self, column: usize, row: usize) -> Rgb {
        let first = 3 * (row * self.columns + column);
        [self.rgb[first], self.rgb[first + 1], self.rgb[first + 2]]
    }

    /// Rows of pixels.
    pub fn rows(&self) -> usize {
        self.rgb.len() / (3 * self.columns.max(1))
    }
}

/// What a camera that is on tells in a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraReading {
    /// Where it is turned to, counter-clockwise from straight ahead.
    pub pan_rad: f64,
    /// What it sees, once a period of its description.
    pub image: Option<CameraImage>,
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: CameraView = CameraView {
        columns: 80,
        rows: 60,
        field_of_view_rad: std::f64::consts::FRAC_PI_3,
        height_m: 1.1,
        tilt_rad: 0.5,
    };

    #[test]
    fn the_middle_of_an_image_looks_down_by_the_tilt() {
        let ahead = VIEW.floor_point(Pixel { column: 40.0, row: 30.0 }).expect("it looks down");
        assert!((ahead.x - 1.1 / libm::tan(0.5)).abs() < 1e-12 && ahead.y == 0.0, "{ahead}");
    }

    #[test]
    fn the_edges_of_an_image_are_the_field_of_view_apart() {
        let level = CameraView { tilt_rad: 0.0, ..VIEW };
        let bearing = |column| {
            let Sight { direction, drop_per_m } = level.sight(Pixel { column, row: 30.0 });
            assert_eq!(drop_per_m, 0.0, "the middle row of a level camera is the horizon");
            libm::atan2(direction.y, direction.x)
        };
        assert!((bearing(0.0) - bearing(80.0) - VIEW.field_of_view_rad).abs() < 1e-12);
        assert!(bearing(0.0) > 0.0, "left is left");
        assert_eq!(level.floor_point(Pixel { column: 40.0, row: 30.0 }), None);
    }

    #[test]
    fn a_point_is_seen_by_the_pixel_that_looks_at_it() {
        for column in 0..80 {
            for row in 0..60 {
                let pixel = Pixel { column: column as f64 + 0.3, row: row as f64 + 0.6 };
                let seen = VIEW.floor_point(pixel).and_then(|point| VIEW.pixel_of(point)).expect("floor");
                assert!((seen.column - pixel.column).abs() < 1e-9 && (seen.row - pixel.row).abs() < 1e-9);
            }
        }
        assert_eq!(VIEW.pixel_of(Point::new(-2.0, 0.0)), None, "behind the camera");
    }
}
