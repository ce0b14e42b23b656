//! From the map frame to a drawing.

use super::writing::rounded;
use rpl_robot::geometry::Point;

/// From the map frame to the drawing, y downwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Pixels of a metre.
    pub px_per_m: f64,
    /// What lies at the upper left corner of the map.
    pub corner_in_map: Point,
    /// Where that is across the sheet.
    pub left_px: f64,
    /// The same, downwards.
    pub top_px: f64,
}

impl Frame {
    /// Across the sheet.
    pub fn x(self, x_in_map_m: f64) -> f64 {
        rounded(self.left_px + (x_in_map_m - self.corner_in_map.x) * self.px_per_m)
    }

    /// Down the sheet.
    pub fn y(self, y_in_map_m: f64) -> f64 {
        rounded(self.top_px + (self.corner_in_map.y - y_in_map_m) * self.px_per_m)
    }

    /// Both.
    pub fn at(self, point_in_map: Point) -> (f64, f64) {
        (self.x(point_in_map.x), self.y(point_in_map.y))
    }

    /// A length.
    pub fn length(self, length_m: f64) -> f64 {
        rounded(length_m * self.px_per_m)
    }
}
