//! Where the robot can stand, tile by tile of a plane.

use super::grid::{BeliefGrid, Place, TILE};

/// The cells of a tile.
pub(super) type Cells = [f32; TILE];

/// Which cells can be stood in: all headings have the same. A tile without any is kept nowhere.
#[derive(Debug)]
pub(super) struct Ground {
    /// By number of the tile; none where nobody can stand.
    tiles: Vec<Option<Box<GroundTile>>>,
    /// Numbers of the others, growing.
    numbers: Vec<u32>,
    cells: usize,
}

/// A tile in which somebody can stand.
#[derive(Clone, Debug)]
pub(super) struct GroundTile {
    /// 1 for cells that can be stood in, else 0.
    pub admissible: Cells,
    /// How many can.
    pub cells: usize,
}

impl Ground {
    /// Of the cells of a grid for whose columns and rows `is_free` holds.
    pub(super) fn new(grid: &BeliefGrid, is_free: impl Fn(usize, usize) -> bool) -> Self {
        let mut tiles: Vec<Option<Box<GroundTile>>> = vec![None; grid.tiles()];
        let mut cells = 0;
        for (column, row) in (0..grid.rows).flat_map(|row| (0..grid.columns).map(move |column| (column, row))) {
            if is_free(column, row) {
                let Place { tile, cell } = grid.place(column, row);
                let tile =
                    tiles[tile].get_or_insert_with(|| Box::new(GroundTile { admissible: [0.0; TILE], cells: 0 }));
                tile.admissible[cell] = 1.0;
                tile.cells += 1;
                cells += 1;
            }
        }
        let numbers = (0..tiles.len() as u32).filter(|&number| tiles[number as usize].is_some()).collect();
        Self { tiles, numbers, cells }
    }

    /// A tile, if somebody can stand in it.
    pub(super) fn tile(&self, number: u32) -> Option<&GroundTile> {
        self.tiles.get(number as usize).and_then(|tile| tile.as_deref())
    }

    /// Numbers of the tiles in which somebody can stand, growing.
    pub(super) fn numbers(&self) -> &[u32] {
        &self.numbers
    }

    /// The tiles in which somebody can stand, with their numbers.
    pub(super) fn tiles(&self) -> impl Iterator<Item = (u32, &GroundTile)> {
        self.numbers.iter().filter_map(|&number| Some((number, self.tile(number)?)))
    }

    /// How many cells of a plane can be stood in.
    pub(super) fn cells(&self) -> usize {
        self.cells
    }

    /// Whether a cell can be stood in.
    pub(super) fn is_free(&self, place: Place) -> bool {
        self.tile(place.tile as u32).is_some_and(|tile| tile.is_free(place.cell))
    }
}

impl GroundTile {
    /// Whether a cell of it can be stood in.
    pub(super) fn is_free(&self, cell: usize) -> bool {
        self.admissible[cell] > 0.0
    }

    /// The cells that can be stood in.
    pub(super) fn free(&self) -> impl Iterator<Item = usize> {
        (0..TILE).filter(|&cell| self.is_free(cell))
    }

    /// The same value in each cell that can be stood in.
    pub(super) fn filled(&self, value: f32) -> Cells {
        self.admissible.map(|admissible| admissible * value)
    }
}
