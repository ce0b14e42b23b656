//! Rectangles of the map of an arena.

use super::interval::{Interval, Millimetres};
use super::walls::{overlap, shrunk};
use rpl_robot::geometry::Point;
use rpl_robot::world::Rect;

/// A rectangle of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// From and to along x.
    pub x_mm: Interval,
    /// From and to along y.
    pub y_mm: Interval,
}

impl Area {
    /// With its edges moved inwards.
    pub fn shrunk(self, by_mm: Millimetres) -> Self {
        Self { x_mm: shrunk(self.x_mm, by_mm), y_mm: shrunk(self.y_mm, by_mm) }
    }

    /// Whether two share floor.
    pub fn overlaps(self, other: Self) -> bool {
        overlap(self.x_mm, other.x_mm) && overlap(self.y_mm, other.y_mm)
    }

    /// As a rectangle of the map.
    pub fn rect(self) -> Rect {
        let metres = |x_mm: Millimetres, y_mm: Millimetres| Point::new(x_mm as f64 / 1000.0, y_mm as f64 / 1000.0);
        Rect { min: metres(self.x_mm.0, self.y_mm.0), max: metres(self.x_mm.1, self.y_mm.1) }
    }
}
