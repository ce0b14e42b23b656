//! What it costs the robot to be somewhere: the map, its obstacle distances, and the price of
//! coming close.

use super::distance::squared_distances_cells;
use super::value_field::ValueField;
use crate::geometry::{Point, distance_m};
use crate::occupancy::{Cell, OccupancyGrid};
use std::sync::Arc;

/// How the planner treats closeness to obstacles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannerParameters {
    /// Cells nearer to an obstacle than this are not entered.
    pub robot_radius_m: f64,
    /// From this obstacle distance on, a metre costs a metre.
    pub comfortable_distance_m: f64,
    /// What a metre costs in addition right at `robot_radius_m`; at most 15.
    pub closeness_weight: f64,
}

impl Default for PlannerParameters {
    fn default() -> Self {
        Self { robot_radius_m: 0.265, comfortable_distance_m: 0.75, closeness_weight: 3.0 }
    }
}

/// A target that the robot does not fit at may be moved so far.
pub(super) const TARGET_REACH_M: f64 = 0.3;

/// What was seen and is in no map is kept clear of by so much more: it is known as points on arcs, and
/// the collision avoidance does not get through a gap that the robot just fits into.
const SEEN_MARGIN_M: f64 = 0.08;

/// The price of a metre on open floor. The unit makes lengths of straight and diagonal moves whole
/// numbers, see [`super::value_field`].
pub(super) const OPEN_FLOOR: u16 = 210;

/// The eight moves in the order of the bits of [`CostGrid::moves`]: straight ones first.
pub(super) const MOVES: [(i64, i64); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// Prices of cells on the map's grid, with a frame of one blocked cell around it so that every cell
/// has eight neighbours.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CostGrid {
    pub resolution_m: f64,
    pub origin_in_map: Point,
    /// Of the map, without the frame.
    pub columns: usize,
    /// Of the map, without the frame.
    pub rows: usize,
    /// From one framed row to the next.
    pub stride: usize,
    /// What each of the moves adds to a framed index.
    pub offsets: [isize; 8],
    /// Price of a metre in units of [`OPEN_FLOOR`], 0 where the robot does not fit. Framed.
    pub prices: Vec<u16>,
    /// Whether the map has an obstacle there, or nothing known. Framed.
    pub is_obstacle: Vec<bool>,
    /// Bit k: move k leads to a traversable cell without cutting a corner. Framed.
    pub moves: Vec<u8>,
}

impl CostGrid {
    /// Framed index of the cell around a point, if it is on the map.
    pub fn cell_at(&self, point_in_map: Point) -> Option<usize> {
        let column = libm::floor((point_in_map.x - self.origin_in_map.x) / self.resolution_m);
        let row = libm::floor((point_in_map.y - self.origin_in_map.y) / self.resolution_m);
        let inside = column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        inside.then(|| (row as usize + 1) * self.stride + column as usize + 1)
    }

    /// Centre of a framed cell.
    pub fn centre(&self, cell: usize) -> Point {
        let column = (cell % self.stride) as f64 - 0.5;
        let row = (cell / self.stride) as f64 - 0.5;
        Point::new(self.origin_in_map.x + column * self.resolution_m, self.origin_in_map.y + row * self.resolution_m)
    }

    /// The neighbour a move leads to; `cell` must not be in the frame.
    pub fn neighbour(&self, cell: usize, (dx, dy): (i64, i64)) -> usize {
        (cell as i64 + dx + dy * self.stride as i64) as usize
    }

    /// The prices of two cells together.
    pub fn prices_of(&self, cell: usize, other: usize) -> u32 {
        u32::from(self.prices[cell]) + u32::from(self.prices[other])
    }

    /// Whether a cell is in the frame, and not of the map.
    pub fn is_frame(&self, cell: usize) -> bool {
        let (column, row) = (cell % self.stride, cell / self.stride);
        !(1..=self.columns).contains(&column) || !(1..=self.rows).contains(&row)
    }

    fn moves_from(&self, cell: usize) -> u8 {
        if self.prices[cell] == 0 {
            return 0;
        }
        let free = |dx, dy| self.prices[self.neighbour(cell, (dx, dy))] > 0;
        MOVES.iter().enumerate().fold(0, |bits, (bit, &(dx, dy))| {
            let possible = free(dx, dy) && (dx == 0 || dy == 0 || (free(dx, 0) && free(0, dy)));
            bits | (u8::from(possible) << bit)
        })
    }

    fn refresh_moves(&mut self, cells: impl Iterator<Item = usize>) {
        for cell in cells {
            if !self.is_frame(cell) {
                self.moves[cell] = self.moves_from(cell);
            }
        }
    }

    /// Cells whose centres lie within `reach_m` of a point, with their distances, in row order.
    pub fn disc(&self, centre_in_map: Point, reach_m: f64) -> Vec<(usize, f64)> {
        let reach = libm::ceil(reach_m / self.resolution_m) as i64 + 1;
        let Some(middle) = self.cell_at(centre_in_map) else { return Vec::new() };
        let (column, row) = ((middle % self.stride) as i64, (middle / self.stride) as i64);
        let mut cells = Vec::new();
        for y in (row - reach).max(1)..=(row + reach).min(self.rows as i64) {
            for x in (column - reach).max(1)..=(column + reach).min(self.columns as i64) {
                let cell = y as usize * self.stride + x as usize;
                let squared_m2 = (self.centre(cell) - centre_in_map).norm_squared();
                if squared_m2 <= reach_m * reach_m {
                    cells.push((cell, squared_m2.sqrt()));
                }
            }
        }
        cells
    }

    /// What the straight way between two points costs in metres of open floor: its length weighed
    /// with the price of each cell it crosses. `None` if it crosses a cell the robot does not fit
    /// in, or leaves the map.
    pub fn straight_cost_m(&self, from_in_map: Point, to_in_map: Point) -> Option<f64> {
        let start = self.cell_at(from_in_map)?;
        self.cell_at(to_in_map)?;
        let length_m = distance_m(from_in_map, to_in_map);
        let price = |cell: usize| (self.prices[cell] > 0).then(|| f64::from(self.prices[cell]) / f64::from(OPEN_FLOOR));
        let mut walk = Walk::new(self, start, from_in_map, to_in_map);
        let mut cost_m = 0.0;
        loop {
            let (cell, share) = (walk.cell, walk.share_in_cell());
            cost_m += price(cell)? * share * length_m;
            if !walk.advance(self.stride) {
                return Some(cost_m);
            }
        }
    }
}

/// A walk along a segment from cell to cell (Amanatides and Woo); places on it are shares of its
/// length.
struct Walk {
    cell: usize,
    at: f64,
    next: [f64; 2],
    step: [f64; 2],
    forward: [bool; 2],
}

impl Walk {
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

/// The map as the path planner sees it. Immutable; share it.
#[derive(Clone, Debug)]
pub struct PlannerModel {
    parameters: PlannerParameters,
    pub(super) grid: Arc<CostGrid>,
    /// Framed like the grid.
    obstacle_distances_m: Vec<f32>,
}

impl PlannerModel {
    /// Inflates the obstacles of a map. Unknown cells and everything outside the map count as
    /// obstacles. O(cells).
    pub fn new(map: &OccupancyGrid, parameters: PlannerParameters) -> Self {
        let stride = map.columns + 2;
        let framed = stride * (map.rows + 2);
        let mut is_obstacle = vec![true; framed];
        for row in 0..map.rows {
            for column in 0..map.columns {
                is_obstacle[(row + 1) * stride + column + 1] = map.get(column, row) != Cell::Free;
            }
        }
        let obstacle_distances_m: Vec<f32> = squared_distances_cells(stride, map.rows + 2, &is_obstacle)
            .iter()
            .map(|&squared| ((libm::sqrt(squared as f64) - 0.5).max(0.0) * map.resolution_m) as f32)
            .collect();
        let prices = obstacle_distances_m
            .iter()
            .zip(&is_obstacle)
            .map(|(&distance_m, &is_obstacle)| if is_obstacle { 0 } else { price(f64::from(distance_m), parameters) })
            .collect();
        let mut grid = CostGrid {
            resolution_m: map.resolution_m,
            origin_in_map: map.origin_in_map,
            columns: map.columns,
            rows: map.rows,
            stride,
            offsets: MOVES.map(|(dx, dy)| dx as isize + dy as isize * stride as isize),
            prices,
            is_obstacle,
            moves: vec![0; framed],
        };
        grid.refresh_moves(0..framed);
        Self { parameters, grid: Arc::new(grid), obstacle_distances_m }
    }

    /// How far the robot reaches around its middle.
    pub fn robot_radius_m(&self) -> f64 {
        self.parameters.robot_radius_m
    }

    /// Distance from the middle of the cell around a point to the edge of the nearest obstacle cell
    /// (half a cell less than to its centre); 0 outside the map.
    pub fn obstacle_distance_m(&self, point_in_map: Point) -> f64 {
        self.grid.cell_at(point_in_map).map_or(0.0, |cell| f64::from(self.obstacle_distances_m[cell]))
    }

    /// How far a point is from the nearest obstacle cell, if it is at most a cell.
    pub fn off_obstacle_m(&self, point_in_map: Point) -> Option<f64> {
        let grid = &self.grid;
        let middle = grid.cell_at(point_in_map)?;
        let half_m = grid.resolution_m / 2.0;
        let off_m = |cell: usize| {
            let off = (point_in_map - grid.centre(cell)).abs().map(|off_m| (off_m - half_m).max(0.0));
            off.norm()
        };
        std::iter::once(middle)
            .chain(MOVES.map(|step| grid.neighbour(middle, step)))
            .filter(|&cell| grid.is_obstacle[cell])
            .map(off_m)
            .min_by(f64::total_cmp)
    }

    /// What a metre costs at a point, in metres of open floor; `None` where the robot does not fit.
    pub fn price(&self, point_in_map: Point) -> Option<f64> {
        let price = self.grid.prices[self.grid.cell_at(point_in_map)?];
        (price > 0).then(|| f64::from(price) / f64::from(OPEN_FLOOR))
    }

    /// Whether the robot fits at a point.
    pub fn is_traversable(&self, point_in_map: Point) -> bool {
        self.grid.cell_at(point_in_map).is_some_and(|cell| self.grid.prices[cell] > 0)
    }

    /// Whether the straight way between two points is traversable.
    pub fn is_straight_way_free(&self, from_in_map: Point, to_in_map: Point) -> bool {
        self.grid.straight_cost_m(from_in_map, to_in_map).is_some()
    }

    /// Centres of the obstacle cells within `reach_m` of a point that have a free cell beside them,
    /// in row order.
    pub fn obstacle_edges_near(&self, point_in_map: Point, reach_m: f64) -> Vec<Point> {
        let is_edge =
            |cell: usize| MOVES[..4].iter().any(|&step| !self.grid.is_obstacle[self.grid.neighbour(cell, step)]);
        self.grid
            .disc(point_in_map, reach_m)
            .into_iter()
            .filter(|&(cell, _)| self.grid.is_obstacle[cell] && is_edge(cell))
            .map(|(cell, _)| self.grid.centre(cell))
            .collect()
    }

    /// The value of every cell for a target. A target the robot does not fit at is moved to the
    /// nearest cell within 0.3 m where it does; without one no cell has a value.
    pub fn value_field(&self, target_in_map: Point) -> ValueField {
        self.field_on(self.grid.clone(), target_in_map)
    }

    /// The value of every cell for a target when there are obstacles at these points besides those
    /// in the map.
    pub fn value_field_around(&self, target_in_map: Point, blocked_in_map: &[Point]) -> ValueField {
        if blocked_in_map.is_empty() {
            return self.value_field(target_in_map);
        }
        let mut grid = (*self.grid).clone();
        self.block(&mut grid, blocked_in_map);
        self.field_on(Arc::new(grid), target_in_map)
    }

    fn block(&self, grid: &mut CostGrid, blocked_in_map: &[Point]) {
        let reach_m = self.parameters.comfortable_distance_m.max(self.parameters.robot_radius_m) + SEEN_MARGIN_M;
        let mut changed = Vec::new();
        for &point in blocked_in_map {
            for (cell, away_m) in grid.disc(point, reach_m) {
                let new_price = price(away_m - SEEN_MARGIN_M, self.parameters);
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
            let neighbours = MOVES.map(|step| grid.neighbour(cell, step));
            grid.refresh_moves(neighbours.into_iter());
        }
    }

    fn field_on(&self, grid: Arc<CostGrid>, target_in_map: Point) -> ValueField {
        let target = self.nearest_traversable(&grid, target_in_map, TARGET_REACH_M);
        ValueField::new(grid, target)
    }

    fn nearest_traversable(&self, grid: &CostGrid, point_in_map: Point, reach_m: f64) -> Option<Point> {
        let cell = grid.cell_at(point_in_map)?;
        if grid.prices[cell] > 0 {
            return Some(point_in_map);
        }
        let mut nearest: Option<(f64, Point)> = None;
        for (cell, away_m) in grid.disc(point_in_map, reach_m) {
            if grid.prices[cell] > 0 && nearest.is_none_or(|(best_m, _)| away_m < best_m) {
                nearest = Some((away_m, grid.centre(cell)));
            }
        }
        nearest.map(|(_, centre)| centre)
    }
}

/// Price of a metre at a distance from the nearest obstacle, in units of [`OPEN_FLOOR`]; 0 where the
/// robot does not fit.
fn price(obstacle_distance_m: f64, parameters: PlannerParameters) -> u16 {
    if obstacle_distance_m < parameters.robot_radius_m {
        return 0;
    }
    let band_m = parameters.comfortable_distance_m - parameters.robot_radius_m;
    let closeness = if band_m > 0.0 {
        ((parameters.comfortable_distance_m - obstacle_distance_m) / band_m).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let weight = parameters.closeness_weight.clamp(0.0, 15.0);
    (f64::from(OPEN_FLOOR) * (1.0 + weight * closeness * closeness)) as u16
}
