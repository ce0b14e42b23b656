//! Occupancy grids: the map as the robot has it.

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
    /// Lower left corner of cell (0, 0), in the map frame.
    pub origin_in_map: Point,
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
    /// `rows * columns` cells.
    pub cells: Vec<Cell>,
}

impl OccupancyGrid {
    /// A grid with every cell the same.
    pub fn filled(origin_in_map: Point, resolution_m: f64, columns: usize, rows: usize, cell: Cell) -> Self {
        Self { resolution_m, origin_in_map, columns, rows, cells: vec![cell; columns * rows] }
    }

    /// Column and row of the cell around a point, if the point is on the grid.
    pub fn cell_at(&self, point_in_map: Point) -> Option<(usize, usize)> {
        let column = libm::floor((point_in_map.x - self.origin_in_map.x) / self.resolution_m);
        let row = libm::floor((point_in_map.y - self.origin_in_map.y) / self.resolution_m);
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then_some((column as usize, row as usize))
    }

    /// Centre of a cell, in the map frame.
    pub fn centre(&self, column: usize, row: usize) -> Point {
        Point::new(
            self.origin_in_map.x + (column as f64 + 0.5) * self.resolution_m,
            self.origin_in_map.y + (row as f64 + 0.5) * self.resolution_m,
        )
    }

    /// The cell at a column and row.
    pub fn get(&self, column: usize, row: usize) -> Cell {
        self.cells[row * self.columns + column]
    }

    /// Overwrites one cell.
    pub fn set(&mut self, column: usize, row: usize, cell: Cell) {
        self.cells[row * self.columns + column] = cell;
    }

    /// The cell around a point; a point outside the grid is unknown.
    pub fn at(&self, point_in_map: Point) -> Cell {
        self.cell_at(point_in_map).map_or(Cell::Unknown, |(column, row)| self.get(column, row))
    }
}
