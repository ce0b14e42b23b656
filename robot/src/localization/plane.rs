//! One plane of the belief: all cells of equal heading, of which only the tiles are kept that matter.

use super::grid::{BeliefGrid, Place};
use super::saved_tiles;
use super::tile::Tile;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The cells of one heading. Clones share them until one is written.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// Those that are awake, their numbers growing. What is asleep has the belief's one value.
    #[serde(with = "saved_tiles")]
    pub(super) tiles: Arc<Vec<Tile>>,
    /// Where cells really are, relative to their middles, in cells along x and y: motion that is
    /// not yet applied, at most half a cell.
    pub(super) offset_cells: [f64; 2],
    /// Variance of motion that is not yet applied, along x and y.
    ///
    /// # Deviation
    /// The paper keeps the motion a_π of an inactive part and applies it when the part comes back. Here every plane
    /// is moved alike at every step, also one without tiles: what is not yet applied depends on the way of the robot
    /// alone, and not on what slept and woke.
    pub(super) variance_cells: [f64; 2],
}

impl Plane {
    /// A plane of these tiles.
    pub(super) fn of(tiles: Vec<Tile>) -> Self {
        Self { tiles: Arc::new(tiles), ..Self::default() }
    }

    /// Whether any of its cells takes part in updates.
    pub fn is_active(&self) -> bool {
        !self.tiles.is_empty()
    }

    /// How many of its tiles another plane shares: planes of a fork share them until they are written.
    pub fn shared_tiles(&self, other: &Self) -> usize {
        let is_shared =
            |tile: &&Tile| other.tile(tile.number).is_some_and(|held| Arc::ptr_eq(&held.cells, &tile.cells));
        self.tiles.iter().filter(is_shared).count()
    }

    /// A tile that is awake. O(log tiles).
    pub(super) fn tile(&self, number: u32) -> Option<&Tile> {
        let at = self.tiles.binary_search_by_key(&number, |tile| tile.number).ok()?;
        self.tiles.get(at)
    }

    /// The tiles, copied first if a fork shares the list.
    pub(super) fn tiles_mut(&mut self) -> &mut Vec<Tile> {
        Arc::make_mut(&mut self.tiles)
    }

    /// What is stored in a cell, if it is awake.
    pub(super) fn stored(&self, place: Place) -> Option<f32> {
        self.tile(place.tile as u32).map(|tile| tile.cells[place.cell])
    }

    /// Where a cell's middle really is, in fractions of a cell.
    pub(super) fn position_cells(&self, grid: &BeliefGrid, place: Place) -> (f64, f64) {
        let [column, row] = grid.column_and_row(place);
        (column as f64 + self.offset_cells[0], row as f64 + self.offset_cells[1])
    }
}
