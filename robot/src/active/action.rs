//! The grid of actions: points relative to the robot.

use crate::geometry::Point;

/// A square of cells around the robot, `[row][column]` row-major, in the base frame: columns along
/// x (forward), rows along y (left); the robot stands on the middle of the middle cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActionGrid {
    /// Edge of a cell.
    pub resolution_m: f64,
    /// Cells from the middle to each side.
    pub reach: usize,
}

impl ActionGrid {
    /// Cells that reach at least `reach_m` to each side.
    pub fn new(resolution_m: f64, reach_m: f64) -> Self {
        Self { resolution_m, reach: libm::ceil(reach_m / resolution_m) as usize }
    }

    /// Cells along one side; odd.
    pub fn side(self) -> usize {
        2 * self.reach + 1
    }

    /// All cells.
    pub fn cells(self) -> usize {
        self.side() * self.side()
    }

    /// The cell the robot stands on.
    pub fn robot(self) -> usize {
        self.reach * self.side() + self.reach
    }

    /// Middle of a cell.
    pub fn point_in_base(self, cell: usize) -> Point {
        self.point_at(cell % self.side(), cell / self.side())
    }

    /// The same by column and row.
    pub fn point_at(self, column: usize, row: usize) -> Point {
        let along = |index: usize| (index as f64 - self.reach as f64) * self.resolution_m;
        Point::new(along(column), along(row))
    }

    /// The cell around a point, if it is on the grid.
    pub fn cell_at(self, point_in_base: Point) -> Option<usize> {
        let index = |m: f64| libm::round(m / self.resolution_m) as i64 + self.reach as i64;
        let (column, row) = (index(point_in_base.x), index(point_in_base.y));
        let inside = |index: i64| (0..self.side() as i64).contains(&index);
        (inside(column) && inside(row)).then(|| row as usize * self.side() + column as usize)
    }

    /// The up to eight neighbours of a cell, with their distance in cells.
    pub fn neighbours(self, cell: usize) -> impl Iterator<Item = (usize, f64)> {
        let (row, column) = ((cell / self.side()) as i64, (cell % self.side()) as i64);
        let side = self.side() as i64;
        const STEPS: [(i64, i64); 8] = [(0, 1), (1, 0), (0, -1), (-1, 0), (1, 1), (1, -1), (-1, -1), (-1, 1)];
        STEPS.into_iter().filter_map(move |(down, along)| {
            let (row, column) = (row + down, column + along);
            let inside = (0..side).contains(&row) && (0..side).contains(&column);
            let distance = if down != 0 && along != 0 { std::f64::consts::SQRT_2 } else { 1.0 };
            inside.then_some(((row * side + column) as usize, distance))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_and_points_agree_and_the_robot_is_the_origin() {
        let grid = ActionGrid::new(0.15, 2.0);
        assert_eq!(grid.point_in_base(grid.robot()), Point::origin());
        for cell in 0..grid.cells() {
            assert_eq!(grid.cell_at(grid.point_in_base(cell)), Some(cell));
        }
        assert_eq!(grid.neighbours(0).count(), 3);
        assert_eq!(grid.neighbours(grid.robot()).count(), 8);
    }
}
