//! The map around narrow places, as sharp as they need it.

use crate::geometry::{Point, Vector};
use std::collections::BTreeMap;

/// Distances are kept in steps of this size.
const STEP_M: f64 = 0.0025;

/// The surroundings of narrow places, by the squares of the map that they lie in.
#[derive(Clone, Debug, Default)]
pub(super) struct CloseMap {
    /// Edge of a square.
    pub square_m: f64,
    pub origin_in_frame: Point,
    pub patches: BTreeMap<(i64, i64), Patch>,
}

/// A square of the map and a margin around it, in small cells.
#[derive(Clone, Debug)]
pub struct Patch {
    corner_in_frame: Point,
    small_m: f64,
    size: usize,
    /// Of each cell to the nearest surface, in steps; negative in what is no floor.
    steps: Vec<i8>,
}

impl CloseMap {
    /// The patches of the squares around a point.
    pub fn around(&self, point_in_frame: Point) -> impl Iterator<Item = &Patch> {
        let at = (point_in_frame - self.origin_in_frame).map(|along_m| libm::floor(along_m / self.square_m) as i64);
        let squares = (-1..=1).flat_map(move |row| (-1..=1).map(move |column| (at.y + row, at.x + column)));
        squares.filter_map(|square| self.patches.get(&square))
    }
}

impl Patch {
    /// Of a square grid, by the squared distances, in cells, to the nearest cell of the other kind.
    pub(super) fn new(
        corner_in_frame: Point,
        small_m: f64,
        size: usize,
        to_obstacle: &[u32],
        to_floor: &[u32],
    ) -> Self {
        let steps = to_obstacle.iter().zip(to_floor).map(|(&to_obstacle, &to_floor)| {
            let cells = |squared: u32| libm::sqrt(f64::from(squared)) - 0.5;
            let distance_m = small_m * if to_obstacle > 0 { cells(to_obstacle) } else { -cells(to_floor) };
            libm::round(distance_m / STEP_M).clamp(-127.0, 127.0) as i8
        });
        Self { corner_in_frame, small_m, size, steps: steps.collect() }
    }

    fn cell_at(&self, point_in_frame: Point) -> Option<usize> {
        let at = (point_in_frame - self.corner_in_frame) / self.small_m;
        let inside = at.min() >= 0.0 && at.max() < self.size as f64;
        inside.then(|| at.y as usize * self.size + at.x as usize)
    }

    /// How far a point is from the nearest surface, on either side of it; none beside the patch. To half a small cell,
    /// and at most about 0.3 m.
    pub fn off_surface_m(&self, point_in_frame: Point) -> Option<f64> {
        self.cell_at(point_in_frame).map(|cell| f64::from(self.steps[cell]).abs() * STEP_M)
    }

    /// Points on the surfaces, on the side of the floor.
    pub fn surfaces(&self) -> impl Iterator<Item = Point> + '_ {
        const BESIDE: [(i64, i64); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
        let edge = libm::round(-0.5 * self.small_m / STEP_M) as i8;
        let size = self.size as i64;
        let is_floor = move |column: i64, row: i64| {
            let inside = (0..size).contains(&column) && (0..size).contains(&row);
            inside && self.steps[(row * size + column) as usize] > 0
        };
        let edges = self.steps.iter().enumerate().filter(move |&(_, &steps)| steps == edge);
        edges.flat_map(move |(cell, _)| {
            let (column, row) = (cell as i64 % size, cell as i64 / size);
            let beside = BESIDE.into_iter().filter(move |&(x, y)| is_floor(column + x, row + y));
            beside.map(move |(x, y)| {
                let at = Vector::new(column as f64 + 0.5 + 0.5 * x as f64, row as f64 + 0.5 + 0.5 * y as f64);
                self.corner_in_frame + at * self.small_m
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::occupancy::squared_distances_cells;

    #[test]
    fn distances_and_surfaces_are_those_of_the_cells() {
        // What is left of the sixth of twelve columns is a wall.
        let is_wall: Vec<bool> = (0..144).map(|cell| cell % 12 < 6).collect();
        let is_floor: Vec<bool> = is_wall.iter().map(|&is_wall| !is_wall).collect();
        let [to_wall, to_floor] = [&is_wall, &is_floor].map(|cells| squared_distances_cells(12, 12, cells));
        let patch = Patch::new(Point::new(1.0, 2.0), 0.02, 12, &to_wall, &to_floor);
        for (x, off_m) in [(1.15, 0.03), (1.13, 0.01), (1.11, 0.01), (1.07, 0.05)] {
            let found_m = patch.off_surface_m(Point::new(x, 2.1)).expect("within");
            assert!((found_m - off_m).abs() < STEP_M, "{x}: {found_m}");
        }
        assert_eq!(patch.off_surface_m(Point::new(0.99, 2.1)), None);
        let surfaces: Vec<Point> = patch.surfaces().collect();
        assert!(surfaces.len() == 12 && surfaces.iter().all(|at| (at.x - 1.12).abs() < 1e-9), "{surfaces:?}");
    }
}
