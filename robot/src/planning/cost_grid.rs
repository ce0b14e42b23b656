//! What it costs a body to be somewhere: the obstacles of a map, and the price of coming close to
//! them. Not only for robots: people have such grids too.

use super::narrow_cell::{NarrowCell, NarrowCells, PARTS};
use crate::geometry::{Point, distance_m};
use crate::occupancy::{Cell, OccupancyGrid, squared_distances_cells};
use std::sync::Arc;

/// How far obstacles reach: around the body that moves, and in its liking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inflation {
    /// Cells nearer to an obstacle than this are not entered.
    pub body_radius_m: f64,
    /// From this obstacle distance on, a metre costs a metre.
    pub comfortable_distance_m: f64,
    /// What a metre costs in addition right at `body_radius_m`; at most 15.
    pub closeness_weight: f64,
}

impl Inflation {
    /// That of a robot on a map of its world.
    pub fn of_robot(body_radius_m: f64) -> Self {
        Self { body_radius_m, comfortable_distance_m: 0.75, closeness_weight: 3.0 }
    }

    /// Price of a metre at a distance from the nearest obstacle, in units of [`OPEN_FLOOR`]; 0 where the
    /// body does not fit.
    pub(super) fn price(self, obstacle_distance_m: f64) -> u16 {
        if obstacle_distance_m < self.body_radius_m {
            return 0;
        }
        let band_m = self.comfortable_distance_m - self.body_radius_m;
        let closeness = if band_m > 0.0 {
            ((self.comfortable_distance_m - obstacle_distance_m) / band_m).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let weight = self.closeness_weight.clamp(0.0, 15.0);
        (f64::from(OPEN_FLOOR) * (1.0 + weight * closeness * closeness)) as u16
    }
}

/// Obstacles seen but in no map are kept clear of by this much more: they are known as points on arcs, and
/// the collision avoidance does not get through a gap that the robot just fits into.
const SEEN_MARGIN_M: f64 = 0.08;

/// The price of a metre on open floor. The unit makes lengths of straight and diagonal moves whole
/// numbers, see [`CostToGo`](super::CostToGo).
pub(super) const OPEN_FLOOR: u16 = 210;

/// The eight moves in the order of the bits of [`CostGrid::moves`]: straight ones first.
pub(super) const MOVES: [(i64, i64); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// Prices of cells on the map's grid, with a rim of one blocked cell around it so that every cell
/// has eight neighbours. Lies in the frame of the map it is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct CostGrid {
    /// What it was made with.
    pub(super) inflation: Inflation,
    pub(super) resolution_m: f64,
    pub(super) origin_in_frame: Point,
    /// Of the map, without the rim.
    pub(super) columns: usize,
    /// Of the map, without the rim.
    pub(super) rows: usize,
    /// From one rimmed row to the next.
    pub(super) stride: usize,
    /// What each of the moves adds to a rimmed index.
    pub(super) offsets: [isize; 8],
    /// Price of a metre in units of [`OPEN_FLOOR`], 0 where the body does not fit. Rimmed.
    pub(super) prices: Vec<u16>,
    /// Whether the map has an obstacle there, or nothing known. Rimmed.
    pub(super) is_obstacle: Vec<bool>,
    /// Bit k: move k leads to a traversable cell without cutting a corner. Rimmed.
    pub(super) moves: Vec<u8>,
    /// Cells of which the body fits into a part.
    pub(super) narrow: Arc<NarrowCells>,
    /// None of them is cheaper.
    pub(super) narrow_price: u16,
}

impl CostGrid {
    /// Inflates the obstacles of a map. Unknown cells and everything outside the map count as
    /// obstacles. O(cells).
    pub fn new(map: &OccupancyGrid, inflation: Inflation) -> Self {
        Self::with_distances(map, inflation).0
    }

    /// The same, with the distance from the middle of each cell to the edge of the nearest obstacle cell
    /// (half a cell less than to its centre), in metres. Rimmed.
    pub(super) fn with_distances(map: &OccupancyGrid, inflation: Inflation) -> (Self, Vec<f32>) {
        let stride = map.columns + 2;
        let rimmed = stride * (map.rows + 2);
        let mut is_obstacle = vec![true; rimmed];
        for row in 0..map.rows {
            for column in 0..map.columns {
                is_obstacle[(row + 1) * stride + column + 1] = map.get(column, row) != Cell::Free;
            }
        }
        let distances_m: Vec<f32> = squared_distances_cells(stride, map.rows + 2, &is_obstacle)
            .into_iter()
            .map(|squared| ((libm::sqrt(f64::from(squared)) - 0.5).max(0.0) * map.resolution_m) as f32)
            .collect();
        let prices = distances_m
            .iter()
            .zip(&is_obstacle)
            .map(|(&distance_m, &is_obstacle)| if is_obstacle { 0 } else { inflation.price(f64::from(distance_m)) })
            .collect();
        let mut grid = Self {
            inflation,
            resolution_m: map.resolution_m,
            origin_in_frame: map.origin_in_frame,
            columns: map.columns,
            rows: map.rows,
            stride,
            offsets: MOVES.map(|(dx, dy)| dx as isize + dy as isize * stride as isize),
            prices,
            is_obstacle,
            moves: vec![0; rimmed],
            narrow: Arc::default(),
            narrow_price: u16::MAX,
        };
        for cell in 0..rimmed {
            if !grid.is_rim(cell) {
                grid.moves[cell] = grid.moves_from(cell);
            }
        }
        (grid, distances_m)
    }

    /// The grid with obstacles at these points besides.
    pub(super) fn with_obstacles_at(&self, points_in_frame: &[Point]) -> Self {
        let Inflation { body_radius_m, comfortable_distance_m, .. } = self.inflation;
        let reach_m = comfortable_distance_m.max(body_radius_m) + SEEN_MARGIN_M;
        let mut grid = self.clone();
        let mut changed = Vec::new();
        for &point in points_in_frame {
            for (cell, middle_away_m) in grid.disc(point, reach_m) {
                let narrow = grid.narrow_at(cell);
                let away_m = narrow.map_or(middle_away_m, |narrow| distance_m(narrow.point, point));
                let new_price = self.inflation.price(away_m - SEEN_MARGIN_M);
                let old_price = grid.prices[cell];
                if old_price > 0 && (new_price == 0 || new_price > old_price) {
                    grid.prices[cell] = new_price;
                    changed.push(cell);
                }
            }
        }
        let around = changed.into_iter().filter(|&cell| grid.prices[cell] == 0).collect::<Vec<_>>();
        for cell in around {
            grid.moves[cell] = 0;
            for step in MOVES {
                let beside = grid.neighbour(cell, step);
                if !grid.is_rim(beside) {
                    grid.moves[beside] &= grid.moves_from(beside);
                }
            }
        }
        grid
    }

    /// Rimmed index of the cell around a point, if it is on the map.
    pub(super) fn cell_at(&self, point_in_frame: Point) -> Option<usize> {
        let column = libm::floor((point_in_frame.x - self.origin_in_frame.x) / self.resolution_m);
        let row = libm::floor((point_in_frame.y - self.origin_in_frame.y) / self.resolution_m);
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then(|| (row as usize + 1) * self.stride + column as usize + 1)
    }

    /// Centre of a rimmed cell.
    pub(super) fn centre(&self, cell: usize) -> Point {
        let column = (cell % self.stride) as f64 - 0.5;
        let row = (cell / self.stride) as f64 - 0.5;
        Point::new(
            self.origin_in_frame.x + column * self.resolution_m,
            self.origin_in_frame.y + row * self.resolution_m,
        )
    }

    /// The neighbour a move leads to; `cell` must not be in the rim.
    pub(super) fn neighbour(&self, cell: usize, (dx, dy): (i64, i64)) -> usize {
        (cell as i64 + dx + dy * self.stride as i64) as usize
    }

    /// The prices of two cells together.
    pub(super) fn prices_of(&self, cell: usize, other: usize) -> u32 {
        u32::from(self.prices[cell]) + u32::from(self.prices[other])
    }

    /// Whether a cell is in the rim, and not of the map.
    pub(super) fn is_rim(&self, cell: usize) -> bool {
        let (column, row) = (cell % self.stride, cell / self.stride);
        !(1..=self.columns).contains(&column) || !(1..=self.rows).contains(&row)
    }

    /// What is narrow about a cell.
    pub(super) fn narrow_at(&self, cell: usize) -> Option<&NarrowCell> {
        if self.prices[cell] < self.narrow_price { None } else { self.narrow.get(&cell) }
    }

    /// Where the body goes through a cell: its middle, or where it is narrow the point with most air.
    pub(super) fn point(&self, cell: usize) -> Point {
        self.narrow_at(cell).map_or_else(|| self.centre(cell), |narrow| narrow.point)
    }

    /// Whether the body fits at a point of a cell.
    pub(super) fn fits_in_cell(&self, cell: usize, point_in_frame: Point) -> bool {
        let Some(narrow) = self.narrow_at(cell) else { return self.prices[cell] > 0 };
        narrow.fits_at((point_in_frame - self.centre(cell)) / self.resolution_m)
    }

    /// Whether it does all along between two points of a cell.
    pub(super) fn fits_along(&self, cell: usize, from: Point, to: Point) -> bool {
        self.steps(from, to).all(|at| self.fits_in_cell(cell, at))
    }

    /// Whether it does between two points of cells beside each other.
    pub(super) fn fits_between(&self, from: Point, to: Point) -> bool {
        self.steps(from, to).all(|at| self.cell_at(at).is_some_and(|cell| self.fits_in_cell(cell, at)))
    }

    /// Points along a short way, two in each part of a cell.
    fn steps(&self, from: Point, to: Point) -> impl Iterator<Item = Point> + use<> {
        let steps = libm::ceil(distance_m(from, to) / self.resolution_m * 2.0 * PARTS as f64).max(1.0);
        (0..=steps as usize).map(move |step| from + (to - from) * (step as f64 / steps))
    }

    /// In a narrow place corners are no matter of whole cells.
    fn moves_from(&self, cell: usize) -> u8 {
        if self.prices[cell] == 0 {
            return 0;
        }
        let is_narrow = self.narrow_at(cell).is_some();
        let free = |dx, dy| self.prices[self.neighbour(cell, (dx, dy))] > 0;
        MOVES.iter().enumerate().fold(0, |bits, (bit, &(dx, dy))| {
            let leaves_corners = dx == 0
                || dy == 0
                || (free(dx, 0) && free(0, dy))
                || is_narrow
                || self.narrow_at(self.neighbour(cell, (dx, dy))).is_some();
            bits | (u8::from(free(dx, dy) && leaves_corners) << bit)
        })
    }

    /// A point itself if the body fits there, else the point of the nearest cell within reach where it
    /// does.
    pub(super) fn nearest_traversable(&self, point_in_frame: Point, reach_m: f64) -> Option<Point> {
        let cell = self.cell_at(point_in_frame)?;
        if self.fits_in_cell(cell, point_in_frame) {
            return Some(point_in_frame);
        }
        if self.prices[cell] > 0 {
            return Some(self.point(cell));
        }
        let mut nearest: Option<(f64, Point)> = None;
        for (cell, away_m) in self.disc(point_in_frame, reach_m) {
            if self.prices[cell] > 0 && nearest.is_none_or(|(best_m, _)| away_m < best_m) {
                nearest = Some((away_m, self.point(cell)));
            }
        }
        nearest.map(|(_, centre)| centre)
    }

    /// Cells whose centres lie within `reach_m` of a point, with their distances, in row order.
    pub(super) fn disc(&self, centre_in_frame: Point, reach_m: f64) -> Vec<(usize, f64)> {
        let away2 = |cell: usize| (cell, (self.centre(cell) - centre_in_frame).norm_squared());
        let within = self.square(centre_in_frame, reach_m).map(away2);
        within.filter(|&(_, squared_m2)| squared_m2 <= reach_m * reach_m).map(|(cell, m2)| (cell, m2.sqrt())).collect()
    }

    /// Cells of the smallest square around a point that holds all whose centres lie within `reach_m` of it, in row
    /// order; none around a point that is not on the map.
    pub(super) fn square(&self, centre_in_frame: Point, reach_m: f64) -> impl Iterator<Item = usize> + use<> {
        let reach = libm::ceil(reach_m / self.resolution_m) as usize + 1;
        let (stride, rows, columns) = (self.stride, self.rows, self.columns);
        self.cell_at(centre_in_frame).into_iter().flat_map(move |middle| {
            let (column, row) = (middle % stride, middle / stride);
            let from = move |at: usize| at.saturating_sub(reach).max(1);
            (from(row)..=(row + reach).min(rows))
                .flat_map(move |y| (from(column)..=(column + reach).min(columns)).map(move |x| y * stride + x))
        })
    }

    /// What the straight way between two points costs in metres of open floor: its length weighed
    /// with the price of each cell it crosses. `None` if it crosses a cell the body does not fit
    /// in, or leaves the map.
    pub(super) fn straight_cost_m(&self, from_in_frame: Point, to_in_frame: Point) -> Option<f64> {
        let start = self.cell_at(from_in_frame)?;
        self.cell_at(to_in_frame)?;
        let length_m = distance_m(from_in_frame, to_in_frame);
        let price = |cell: usize| (self.prices[cell] > 0).then(|| f64::from(self.prices[cell]) / f64::from(OPEN_FLOOR));
        let at = |share: f64| from_in_frame + (to_in_frame - from_in_frame) * share;
        let mut walk = CellWalk::new(self, start, from_in_frame, to_in_frame);
        let mut cost_m = 0.0;
        loop {
            let (cell, share) = (walk.cell, walk.share_in_cell());
            cost_m += price(cell)? * share * length_m;
            if self.narrow_at(cell).is_some() && !self.fits_along(cell, at(walk.at), at(walk.at + share)) {
                return None;
            }
            if !walk.advance(self.stride) {
                return Some(cost_m);
            }
        }
    }
}

/// A walk along a segment from cell to cell (Amanatides and Woo); places on it are shares of its
/// length.
struct CellWalk {
    cell: usize,
    at: f64,
    next: [f64; 2],
    step: [f64; 2],
    forward: [bool; 2],
}

impl CellWalk {
    fn new(grid: &CostGrid, cell: usize, from: Point, to: Point) -> Self {
        let corner = grid.centre(cell) - nalgebra::Vector2::repeat(grid.resolution_m / 2.0);
        let mut walk = Self { cell, at: 0.0, next: [f64::INFINITY; 2], step: [f64::INFINITY; 2], forward: [true; 2] };
        for axis in 0..2 {
            let extent = to[axis] - from[axis];
            walk.forward[axis] = extent > 0.0;
            if extent != 0.0 {
                let edge = corner[axis] + if extent > 0.0 { grid.resolution_m } else { 0.0 };
                walk.next[axis] = ((edge - from[axis]) / extent).max(0.0);
                walk.step[axis] = grid.resolution_m / extent.abs();
            }
        }
        walk
    }

    fn share_in_cell(&self) -> f64 {
        self.next[0].min(self.next[1]).min(1.0) - self.at
    }

    /// Goes on into the next cell; false at the end of the segment.
    fn advance(&mut self, stride: usize) -> bool {
        let axis = usize::from(self.next[1] < self.next[0]);
        if self.next[axis] >= 1.0 {
            return false;
        }
        self.at = self.next[axis];
        self.next[axis] += self.step[axis];
        let jump = if axis == 0 { 1 } else { stride };
        self.cell = if self.forward[axis] { self.cell + jump } else { self.cell - jump };
        true
    }
}
