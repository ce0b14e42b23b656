//! What a plane is made of: squares of cells that wake and sleep together.

use super::ground::Cells;
use super::kernel;
use std::sync::Arc;

/// A tile that takes part in updates: one of its cells is above θ, or was at the last update.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tile {
    /// Its number in the plane.
    pub number: u32,
    /// `[row][column]`; 0 where nobody can stand.
    pub cells: Arc<Cells>,
    /// Sum of the stored cells at the last update.
    pub mass: f64,
    /// Largest of them.
    pub peak: f32,
}

impl Tile {
    /// Of these cells.
    pub(super) fn new(number: u32, cells: Cells) -> Self {
        let extent = kernel::extent(&cells);
        Self { number, cells: Arc::new(cells), mass: extent.mass, peak: extent.peak }
    }

    /// Of cells that are summed when they are weighed next.
    pub(super) fn to_be_weighed(number: u32, cells: Arc<Cells>) -> Self {
        Self { number, cells, mass: 0.0, peak: 0.0 }
    }
}
