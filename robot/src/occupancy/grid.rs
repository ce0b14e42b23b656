//! Occupancy grids: a map as the robot has it.

use crate::geometry::Point;
use serde::{Deserialize, Serialize};

/// What the map says of one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cell {
    /// Nothing stands there.
    Free,
    /// A wall or an object stands in at least a part of it.
    Occupied,
    /// Not known, such as the outside of a building.
    Unknown,
}

/// A grid of square cells, row-major `cells[row][column]`, row 0 at the smallest y.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OccupancyGrid {
    /// Edge of a cell.
    pub resolution_m: f64,
    /// Lower left corner of cell (0, 0), in the frame it was made in.
    pub origin_in_frame: Point,
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
    /// `rows * columns` cells.
    pub cells: Vec<Cell>,
}

impl OccupancyGrid {
    /// A grid with every cell the same.
    pub fn filled(origin_in_frame: Point, resolution_m: f64, columns: usize, rows: usize, cell: Cell) -> Self {
        Self { resolution_m, origin_in_frame, columns, rows, cells: vec![cell; columns * rows] }
    }

    /// The part with free cells and one cell around it: what cannot be stood in needs no belief. The
    /// whole grid if nothing is free.
    pub fn around_free(&self) -> Self {
        let (mut columns, mut rows) = (None::<(usize, usize)>, None::<(usize, usize)>);
        for (row, cells) in self.cells.chunks_exact(self.columns.max(1)).enumerate() {
            let Some(first) = cells.iter().position(|&cell| cell == Cell::Free) else { continue };
            let last = cells.iter().rposition(|&cell| cell == Cell::Free).unwrap_or(first);
            columns = Some(columns.map_or((first, last), |(west, east)| (west.min(first), east.max(last))));
            rows = Some((rows.map_or(row, |(south, _)| south), row));
        }
        let with_margin = |found: Option<(usize, usize)>, count: usize| {
            found.map_or(0..count, |(first, last)| first.saturating_sub(1)..(last + 2).min(count))
        };
        let (columns, rows) = (with_margin(columns, self.columns), with_margin(rows, self.rows));
        let origin_in_frame = Point::new(
            self.origin_in_frame.x + columns.start as f64 * self.resolution_m,
            self.origin_in_frame.y + rows.start as f64 * self.resolution_m,
        );
        let row_cells = |row: usize| &self.cells[row * self.columns..][columns.clone()];
        Self {
            resolution_m: self.resolution_m,
            origin_in_frame,
            columns: columns.len(),
            rows: rows.len(),
            cells: rows.clone().flat_map(row_cells).copied().collect(),
        }
    }

    /// Column and row of the cell around a point, if the point is on the grid.
    pub fn cell_at(&self, point_in_frame: Point) -> Option<(usize, usize)> {
        let column = libm::floor((point_in_frame.x - self.origin_in_frame.x) / self.resolution_m);
        let row = libm::floor((point_in_frame.y - self.origin_in_frame.y) / self.resolution_m);
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then_some((column as usize, row as usize))
    }

    /// Centre of a cell.
    pub fn centre(&self, column: usize, row: usize) -> Point {
        Point::new(
            self.origin_in_frame.x + (column as f64 + 0.5) * self.resolution_m,
            self.origin_in_frame.y + (row as f64 + 0.5) * self.resolution_m,
        )
    }

    /// The cell at a column and row.
    pub fn get(&self, column: usize, row: usize) -> Cell {
        self.cells[row * self.columns + column]
    }

    /// The cells to the west, south, east and north of one, those that are on the grid.
    pub fn beside(&self, column: usize, row: usize) -> impl Iterator<Item = (usize, usize)> + use<> {
        let west = column.checked_sub(1).map(|column| (column, row));
        let south = row.checked_sub(1).map(|row| (column, row));
        let east = (column + 1 < self.columns).then_some((column + 1, row));
        let north = (row + 1 < self.rows).then_some((column, row + 1));
        [west, south, east, north].into_iter().flatten()
    }

    /// Overwrites one cell.
    pub fn set(&mut self, column: usize, row: usize, cell: Cell) {
        self.cells[row * self.columns + column] = cell;
    }

    /// The cell around a point; a point outside the grid is unknown.
    pub fn at(&self, point_in_frame: Point) -> Cell {
        self.cell_at(point_in_frame).map_or(Cell::Unknown, |(column, row)| self.get(column, row))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_part_around_free_cells_has_the_same_cells_at_the_same_places() {
        let mut grid = OccupancyGrid::filled(Point::new(-2.0, 3.0), 0.5, 9, 7, Cell::Unknown);
        grid.set(3, 2, Cell::Free);
        grid.set(5, 4, Cell::Free);
        grid.set(6, 4, Cell::Occupied);
        let part = grid.around_free();
        assert_eq!((part.columns, part.rows), (5, 5));
        for row in 0..part.rows {
            for column in 0..part.columns {
                assert_eq!(part.get(column, row), grid.at(part.centre(column, row)));
            }
        }
        assert_eq!(part.around_free(), part);
        let blank = OccupancyGrid::filled(Point::origin(), 0.5, 4, 3, Cell::Unknown);
        assert_eq!(blank.around_free(), blank);
    }
}
