//! How far the nearest surface of a map is, from everywhere.

use super::distance_transform::squared_distances_cells;
use super::grid::{Cell, OccupancyGrid};
use crate::geometry::Point;

/// The Euclidean distance from every cell of a map to the nearest one of a kind, such as those that are occupied.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    /// Edge of a cell.
    pub resolution_m: f64,
    pub(super) origin_in_frame: Point,
    columns: usize,
    /// Along x and y.
    size_cells: [f64; 2],
    /// `rows · columns`, from middle to middle, in cells.
    distance_cells: Vec<f32>,
}

impl DistanceField {
    /// To what is occupied. Exact; O(cells).
    pub fn new(map: &OccupancyGrid) -> Self {
        Self::to(map, |cell| cell == Cell::Occupied)
    }

    /// To cells of a kind. Exact; O(cells), 5 bytes each, of which 4 stay.
    pub fn to(map: &OccupancyGrid, is_meant: impl Fn(Cell) -> bool) -> Self {
        let is_meant: Vec<bool> = map.cells.iter().map(|&cell| is_meant(cell)).collect();
        let squared = squared_distances_cells(map.columns, map.rows, &is_meant);
        Self {
            resolution_m: map.resolution_m,
            origin_in_frame: map.origin_in_frame,
            columns: map.columns,
            size_cells: [map.columns as f64, map.rows as f64],
            // Into the same memory: both take four bytes.
            distance_cells: squared.into_iter().map(|square| libm::sqrt(f64::from(square)) as f32).collect(),
        }
    }

    /// The distance at a place, if it is in the map.
    #[inline(always)]
    pub(super) fn distance_at(&self, x_cells: f64, y_cells: f64) -> Option<f32> {
        let inside = x_cells >= 0.0 && y_cells >= 0.0 && x_cells < self.size_cells[0] && y_cells < self.size_cells[1];
        // 32 bits hold what is inside, and take the fewest instructions.
        let (column, row) = (x_cells as i32 as usize, y_cells as i32 as usize);
        if inside { self.distance_cells.get(row * self.columns + column).copied() } else { None }
    }

    /// Distance from the cell around a point to the nearest surface, to half a map cell; 0 outside
    /// the map.
    pub fn clearance_m(&self, point_in_frame: Point) -> f64 {
        let x = (point_in_frame.x - self.origin_in_frame.x) / self.resolution_m;
        let y = (point_in_frame.y - self.origin_in_frame.y) / self.resolution_m;
        let cells = self.distance_at(x, y).map_or(0.0, f64::from);
        (cells - 0.5).max(0.0) * self.resolution_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_random::Stream;

    #[test]
    fn the_field_is_the_distance_to_the_nearest_occupied_cell() {
        let mut stream = Stream::new(10_001, "map");
        let mut map = OccupancyGrid::filled(Point::new(-1.0, 2.0), 0.1, 37, 23, Cell::Free);
        for _ in 0..20 {
            map.set(stream.index(37), stream.index(23), Cell::Occupied);
        }
        let field = DistanceField::new(&map);
        for row in 0..map.rows {
            for column in 0..map.columns {
                let nearest = (0..map.cells.len())
                    .filter(|&index| map.cells[index] == Cell::Occupied)
                    .map(|index| {
                        let (x, y) = (index % map.columns, index / map.columns);
                        libm::hypot(x as f64 - column as f64, y as f64 - row as f64)
                    })
                    .fold(f64::INFINITY, f64::min);
                let found = f64::from(field.distance_cells[row * map.columns + column]);
                assert!((found - nearest).abs() < 1e-5, "{column} {row}: {found} {nearest}");
            }
        }
    }
}
