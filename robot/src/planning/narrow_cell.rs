//! Cells that the body fits into a part of.

use crate::geometry::{Point, Vector};
use std::collections::BTreeMap;

/// Small cells along each edge of a cell.
pub(super) const PARTS: usize = 5;

/// A cell of which the body fits into a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NarrowCell {
    /// Where it has most air around it.
    pub point: Point,
    /// How much that is, to its middle.
    pub clearance_m: f64,
    /// Bit `row · PARTS + column`: the body fits there.
    pub fits: u32,
}

impl NarrowCell {
    /// Whether the body fits at a point so far from the middle of the cell, in cells.
    pub fn fits_at(&self, off_cells: Vector) -> bool {
        let part = |off_cells: f64| (((off_cells + 0.5) * PARTS as f64).max(0.0) as usize).min(PARTS - 1);
        self.fits & (1 << (part(off_cells.y) * PARTS + part(off_cells.x))) != 0
    }
}

/// All of a map, by their numbers in the grid of costs.
pub(super) type NarrowCells = BTreeMap<usize, NarrowCell>;
