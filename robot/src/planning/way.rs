//! Ways that follow from what it costs to go on.

use super::cost_grid::{CostGrid, MOVES};
use super::cost_to_go::{CostToGo, UNREACHABLE, move_cost};
use crate::geometry::{Point, distance_m};

/// How far a start that the body does not fit at may be from free floor.
pub(super) const ESCAPE_REACH_M: f64 = 1.0;

impl CostToGo {
    /// The way from a point to the target: the point itself, corners, the target. Straightened
    /// wherever the straight way is free and costs no more than the way along the cells, so that it
    /// keeps as clear of obstacles as that. A start the body does not fit at is left for the
    /// nearest free cell first. `None` if there is no way.
    pub fn path(&self, from_in_frame: Point) -> Option<Vec<Point>> {
        let (mut path, cells) = self.approach(from_in_frame, f64::INFINITY)?;
        path.extend(straightened(&self.grid, &cells));
        Some(path)
    }

    /// The farthest point of the way from a point that can be reached in a straight line and lies at
    /// most `reach_m` along it; beyond the next corner if that is nearer than `least_m`. Cheap: looks
    /// only that far ahead.
    pub fn lookahead(&self, from_in_frame: Point, least_m: f64, reach_m: f64) -> Option<Point> {
        let (escape, cells) = self.approach(from_in_frame, reach_m)?;
        let corner = if escape.is_empty() { farthest_straight(&self.grid, &cells, 0) } else { 0 };
        let beyond = cells[corner..].iter().find(|&&cell| distance_m(from_in_frame, cell) >= least_m);
        beyond.or(cells.last()).copied()
    }

    /// The next `reach_m` of the way from a point, cell by cell, not straightened.
    pub fn way_ahead(&self, from_in_frame: Point, reach_m: f64) -> Option<Vec<Point>> {
        let (mut way, cells) = self.approach(from_in_frame, reach_m)?;
        way.extend(cells);
        Some(way)
    }

    /// The escape from an inflated cell (the start, or nothing), and the way along the cells from
    /// there, cut off after `reach_m`.
    fn approach(&self, from_in_frame: Point, reach_m: f64) -> Option<(Vec<Point>, Vec<Point>)> {
        let start = self.grid.cell_at(from_in_frame)?;
        if self.costs[start] != UNREACHABLE {
            return Some((Vec::new(), self.descend(start, from_in_frame, reach_m)?));
        }
        if self.grid.prices[start] > 0 {
            return None;
        }
        let free = self.escape(start)?;
        Some((vec![from_in_frame], self.descend(free, self.grid.point(free), reach_m)?))
    }

    fn descend(&self, start: usize, start_in_frame: Point, reach_m: f64) -> Option<Vec<Point>> {
        let target_in_frame = self.target_in_frame()?;
        let mut points = vec![start_in_frame];
        let (mut cell, mut along_m) = (start, 0.0);
        while self.costs[cell] > 0 && along_m < reach_m {
            let (next, length) = self.best_move(cell)?;
            along_m += length * self.grid.resolution_m;
            cell = next;
            points.push(self.grid.point(cell));
        }
        if self.costs[cell] == 0 {
            if points.len() > 1 {
                points.pop();
            }
            points.push(target_in_frame);
        }
        Some(points)
    }

    /// The neighbour on the cheapest way and the length of the move in cells; of equals the first
    /// in the order of the moves.
    fn best_move(&self, cell: usize) -> Option<(usize, f64)> {
        let mut best: Option<(u32, usize, f64)> = None;
        for (bit, &step) in MOVES.iter().enumerate() {
            if self.grid.moves[cell] & (1 << bit) == 0 {
                continue;
            }
            let next = self.grid.neighbour(cell, step);
            let through = self.costs[next].saturating_add(move_cost(self.grid.prices_of(cell, next), bit));
            if self.costs[next] < self.costs[cell] && best.is_none_or(|(least, _, _)| through < least) {
                best = Some((through, next, if bit < 4 { 1.0 } else { std::f64::consts::SQRT_2 }));
            }
        }
        best.map(|(_, next, length)| (next, length))
    }

    /// The nearest cell with a cost that can be got to without crossing an obstacle of the map; of
    /// equals the first found. A start inside an obstacle, where only an estimate can be, may be
    /// left across it.
    fn escape(&self, start: usize) -> Option<usize> {
        let reach = ESCAPE_REACH_M / self.grid.resolution_m;
        let position = |cell: usize| ((cell % self.grid.stride) as f64, (cell / self.grid.stride) as f64);
        let (column, row) = position(start);
        let away = |cell: usize| {
            let (x, y) = position(cell);
            (x - column) * (x - column) + (y - row) * (y - row)
        };
        let may_cross = self.grid.is_obstacle[start];
        let mut seen = std::collections::BTreeSet::from([start]);
        let mut found = vec![start];
        let mut nearest: Option<usize> = None;
        let mut next_found = 0;
        while next_found < found.len() {
            let cell = found[next_found];
            next_found += 1;
            if self.costs[cell] != UNREACHABLE && nearest.is_none_or(|best| away(cell) < away(best)) {
                nearest = Some(cell);
            }
            if self.grid.is_rim(cell) {
                continue;
            }
            for step in MOVES {
                let next = self.grid.neighbour(cell, step);
                let is_open = may_cross || !self.grid.is_obstacle[next];
                if is_open && away(next) <= reach * reach && seen.insert(next) {
                    found.push(next);
                }
            }
        }
        nearest
    }
}

/// The corners that remain of a way when every stretch is straightened that can be.
fn straightened(grid: &CostGrid, points: &[Point]) -> Vec<Point> {
    let mut corners = vec![points[0]];
    let mut from = 0;
    while from + 1 < points.len() {
        from = farthest_straight(grid, points, from);
        corners.push(points[from]);
    }
    corners
}

/// The farthest point after `from` to which the straight way is free and no dearer than the way
/// along the points; the next point if there is none.
fn farthest_straight(grid: &CostGrid, points: &[Point], from: usize) -> usize {
    const PATIENCE: usize = 8;
    let (mut farthest, mut along_m) = ((from + 1).min(points.len() - 1), 0.0);
    for to in from + 1..points.len() {
        let Some(step_m) = grid.straight_cost_m(points[to - 1], points[to]) else { break };
        along_m += step_m;
        let straight_m = grid.straight_cost_m(points[from], points[to]);
        if straight_m.is_some_and(|straight_m| straight_m <= along_m * (1.0 + 1e-9)) {
            farthest = to;
        } else if to > farthest + PATIENCE {
            break;
        }
    }
    farthest
}

/// Length of a polyline.
pub fn path_length_m(path: &[Point]) -> f64 {
    path.windows(2).map(|pair| distance_m(pair[0], pair[1])).sum()
}
