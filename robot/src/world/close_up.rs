//! The robot's map of a world in small cells, for a part of it at a time.

use super::map::{beyond_edge, occupy};
use super::solid::Solid;
use super::{Rect, World};
use crate::geometry::{Point, Vector};
use crate::occupancy::{Cell, OccupancyGrid};

/// Bodies are kept apart by squares of this size.
const SQUARE_M: f64 = 2.0;

/// What the robot's map of a world shows, ready to be drawn in parts.
pub(crate) struct CloseUp<'w> {
    world: &'w World,
    /// Those that are in the map.
    solids: Vec<Solid>,
    columns: usize,
    /// The solids that reach into each square, row by row.
    squares: Vec<Vec<u32>>,
}

impl<'w> CloseUp<'w> {
    /// Cost: the number of bodies, and the squares they reach into.
    pub fn new(world: &'w World) -> Self {
        let solids: Vec<Solid> = world.solids().into_iter().filter(|solid| world.is_mapped(solid.origin)).collect();
        let count = |length_m: f64| (libm::ceil(length_m / SQUARE_M) as usize).max(1);
        let (columns, rows) = (count(world.size_m.x), count(world.size_m.y));
        let mut close_up = Self { world, solids, columns, squares: vec![Vec::new(); columns * rows] };
        for number in 0..close_up.solids.len() {
            for square in close_up.squares_in(close_up.solids[number].outline.bounds()) {
                close_up.squares[square].push(number as u32);
            }
        }
        close_up
    }

    /// A grid of a given number of columns and rows with its lower left corner at a point: what is occupied and what is
    /// not known, as [`World::map`] has it, but that floor nobody gets to is free. Cost: cells, and cells of the bodies
    /// in it.
    pub fn draw(&self, corner_in_map: Point, resolution_m: f64, columns: usize, rows: usize) -> OccupancyGrid {
        let mut grid = OccupancyGrid::filled(corner_in_map, resolution_m, columns, rows, Cell::Free);
        let size = Vector::new(columns as f64, rows as f64) * resolution_m;
        let mut near: Vec<u32> = self
            .squares_in(Rect { min: corner_in_map, max: corner_in_map + size })
            .flat_map(|square| self.squares[square].iter().copied())
            .collect();
        near.sort_unstable();
        near.dedup();
        for number in near {
            occupy(&mut grid, &self.solids[number as usize].outline, self.world.bounds());
        }
        beyond_edge(&mut grid, self.world.bounds());
        self.world.forget_unrecorded(&mut grid);
        grid
    }

    fn squares_in(&self, rect: Rect) -> impl Iterator<Item = usize> + use<> {
        let (columns, rows) = (self.columns, self.squares.len() / self.columns);
        let at = |along_m: f64, count: usize| ((along_m / SQUARE_M).max(0.0) as usize).min(count - 1);
        let (from, to) = (rect.min - self.world.origin_in_map, rect.max - self.world.origin_in_map);
        let (first, last) = (at(from.x, columns), at(to.x, columns));
        (at(from.y, rows)..=at(to.y, rows))
            .flat_map(move |row| (first..=last).map(move |column| row * columns + column))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_that_of_the_whole_map() {
        for name in ["flat", "dept", "warehouse"] {
            let world = World::builtin(name).expect("built in");
            let (whole, close_up) = (world.map(0.02), CloseUp::new(&world));
            for (column, row) in [(0, 0), (100, 150), (333, 87), (whole.columns - 40, whole.rows - 30)] {
                let corner = world.origin_in_map + Vector::new(column as f64, row as f64) * 0.02;
                let part = close_up.draw(corner, 0.02, 60, 50);
                for (x, y) in (0..60).flat_map(|x| (0..50).map(move |y| (x, y))) {
                    let is_occupied = whole.at(part.centre(x, y)) == Cell::Occupied;
                    assert_eq!(part.get(x, y) == Cell::Occupied, is_occupied, "{name} {column} {row} {x} {y}");
                }
            }
        }
    }
}
