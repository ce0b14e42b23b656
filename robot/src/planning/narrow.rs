//! Narrow places: where the cells of a map are too coarse to tell whether the body fits, small ones do.
//!
//! A wall that reaches into a cell fills it, so that a doorway in a map of 10 cm may be 20 cm narrower than it is.
//! Cells that would be free but for this are looked at again, those with something on two opposite sides: they are a
//! small part of any map, and ways cost what they did.

use super::close_map::{CloseMap, Patch};
use super::cost_grid::{CostGrid, MOVES};
use super::narrow_cell::{NarrowCell, NarrowCells, PARTS};
use crate::geometry::{Point, Vector, distance_m};
use crate::occupancy::{Cell, OccupancyGrid, squared_distances_cells};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The least air on each side of a body that goes through ...
pub(super) const AIR_M: f64 = 0.01;

/// ... and how much wider than itself a gap in the map must be for it to go through surely: the last of this are small
/// cells.
pub(super) const GAP_AIR_M: f64 = 0.07;

/// Cells that a gap of a cell more on each side would leave no room are not looked at again.
const COARSE_CELLS: f64 = 1.5;

/// What is narrow has something on two opposite sides, together at most so far away beyond the width of the body.
const OPPOSITE_M: f64 = 0.2;

/// Cells are looked at by squares with this many along each edge.
const SQUARE: usize = 8;

/// Looks again at the cells that may be narrow, and keeps what is around those that are; `close_up` draws a part of the map in small cells, given its corner, the
/// edge of a cell, columns and rows. Cost: cells, and for squares with narrow places their small cells.
pub(super) fn narrow_cells(
    grid: &CostGrid,
    distances_m: &[f32],
    close_up: impl Fn(Point, f64, usize, usize) -> OccupancyGrid,
) -> (NarrowCells, CloseMap) {
    let mut squares: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for cell in candidates(grid, distances_m) {
        squares.entry((cell / grid.stride / SQUARE, cell % grid.stride / SQUARE)).or_default().push(cell);
    }
    let small_m = grid.resolution_m / PARTS as f64;
    let margin = libm::ceil((grid.inflation.body_radius_m + AIR_M) / small_m) as usize + 2;
    let size = SQUARE * PARTS + 2 * margin;
    let mut found = NarrowCells::new();
    let mut close_map = CloseMap {
        square_m: SQUARE as f64 * grid.resolution_m,
        // The rim is no part of the map.
        origin_in_frame: grid.origin_in_frame - Vector::new(grid.resolution_m, grid.resolution_m),
        patches: BTreeMap::new(),
    };
    for ((row, column), cells) in squares {
        let first = Vector::new(column as f64, row as f64) * close_map.square_m;
        let corner = close_map.origin_in_frame + first - Vector::new(margin as f64, margin as f64) * small_m;
        let map = close_up(corner, small_m, size, size);
        let is_obstacle: Vec<bool> = map.cells.iter().map(|&cell| cell != Cell::Free).collect();
        let squared = squared_distances_cells(size, size, &is_obstacle);
        let clearance_m = |x: usize, y: usize| (libm::sqrt(f64::from(squared[y * size + x])) - 0.5) * small_m;
        let before = found.len();
        for cell in cells {
            let (left, below) = (cell % grid.stride % SQUARE * PARTS, cell / grid.stride % SQUARE * PARTS);
            let parts = (0..PARTS * PARTS).map(|part| {
                let (x, y) = (margin + left + part % PARTS, margin + below + part / PARTS);
                (part, map.centre(x, y), clearance_m(x, y))
            });
            found.extend(narrow_cell(grid, cell, parts).map(|narrow| (cell, narrow)));
        }
        if found.len() > before {
            let is_floor: Vec<bool> = is_obstacle.iter().map(|&is_obstacle| !is_obstacle).collect();
            let to_floor = squared_distances_cells(size, size, &is_floor);
            close_map
                .patches
                .insert((row as i64, column as i64), Patch::new(corner, small_m, size, &squared, &to_floor));
        }
    }
    (found, close_map)
}

/// What is narrow about a cell, by the clearance of its parts.
fn narrow_cell(grid: &CostGrid, cell: usize, parts: impl Iterator<Item = (usize, Point, f64)>) -> Option<NarrowCell> {
    let least_m = grid.inflation.body_radius_m + AIR_M - 1e-9;
    let mut narrow: Option<NarrowCell> = None;
    let mut fits = 0;
    for (part, point, clearance_m) in parts.filter(|(_, _, clearance_m)| *clearance_m >= least_m) {
        fits |= 1 << part;
        let off_m = |point: Point| distance_m(point, grid.centre(cell));
        // Of equals the one nearest to the middle.
        let is_better = |best: &NarrowCell| {
            clearance_m > best.clearance_m + 1e-9
                || clearance_m > best.clearance_m - 1e-9 && off_m(point) < off_m(best.point) - 1e-9
        };
        if narrow.as_ref().is_none_or(is_better) {
            narrow = Some(NarrowCell { point, clearance_m, fits });
        }
    }
    narrow.map(|narrow| NarrowCell { fits, ..narrow })
}

/// Free cells that the body does not fit into by the map, but may, with something on two opposite sides.
fn candidates<'g>(grid: &'g CostGrid, distances_m: &'g [f32]) -> impl Iterator<Item = usize> + 'g {
    let radius_m = grid.inflation.body_radius_m;
    let least_m = radius_m - COARSE_CELLS * grid.resolution_m;
    let may_fit = move |cell: &usize| {
        !grid.is_obstacle[*cell] && grid.prices[*cell] == 0 && f64::from(distances_m[*cell]) >= least_m
    };
    let most_m = 2.0 * radius_m + OPPOSITE_M;
    (0..grid.prices.len()).filter(may_fit).filter(move |&cell| {
        (0..8).filter(|bit| [0, 1, 4, 5].contains(bit)).any(|bit| {
            let step_m = grid.resolution_m * if bit < 4 { 1.0 } else { std::f64::consts::SQRT_2 };
            let most = libm::floor(most_m / step_m) as usize;
            let free = |offset: isize| {
                let mut at = cell;
                (0..=most)
                    .take_while(|_| {
                        at = at.wrapping_add_signed(offset);
                        !grid.is_obstacle[at]
                    })
                    .count()
            };
            let ahead = free(grid.offsets[bit]);
            ahead <= most && ahead + 1 + free(-grid.offsets[bit]) <= most
        })
    })
}

impl CostGrid {
    /// Opens the cells of which the body fits into a part. O(cells that are narrow).
    pub(super) fn open(&mut self, narrow: NarrowCells) {
        for (&cell, narrow) in &narrow {
            self.prices[cell] = self.inflation.price(narrow.clearance_m);
            self.narrow_price = self.narrow_price.min(self.prices[cell]);
        }
        self.narrow = Arc::new(narrow);
        let narrow = self.narrow.clone();
        for &cell in narrow.keys() {
            for (bit, step) in MOVES.into_iter().enumerate() {
                let next = self.neighbour(cell, step);
                let is_open = self.prices[next] > 0 && self.fits_between(self.point(cell), self.point(next));
                // The same move the other way.
                let back = (bit & 4) | ((bit + 2) & 3);
                self.moves[cell] = self.moves[cell] & !(1 << bit) | u8::from(is_open) << bit;
                self.moves[next] = self.moves[next] & !(1 << back) | u8::from(is_open) << back;
            }
        }
    }
}
