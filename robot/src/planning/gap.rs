//! The widest gap that is too narrow, where no way leads between two points.

use super::narrow::GAP_AIR_M;
use super::planner::PlannerModel;
use crate::geometry::{Point, Vector};
use crate::occupancy::{Cell, squared_distances_cells};
use crate::world::{CloseUp, World};
use std::collections::BinaryHeap;

/// A gap is measured in cells of this size.
const GRAIN_M: f64 = 0.01;

/// A gap that lets nothing at all through is a wall.
const LEAST_M: f64 = 0.1;

/// A gap between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gap {
    pub at: Point,
    pub width_m: f64,
}

/// How wide a gap must be for a robot to be let through for sure.
pub(super) fn needed_m(robot_radius_m: f64) -> f64 {
    2.0 * robot_radius_m + GAP_AIR_M
}

/// Where it is narrowest on the way between two points on which that is widest; none if it is wide enough, or if
/// there is no way even for a point. Cost: cells, by a queue.
pub(super) fn gap_between(planner: &PlannerModel, world: &World, start: Point, goal: Point) -> Option<Gap> {
    let way = widest_way(planner, start, goal)?;
    let least_m = planner.obstacle_distance_at_m(way.iter().copied().min_by(|&one, &other| {
        planner.obstacle_distance_at_m(one).total_cmp(&planner.obstacle_distance_at_m(other))
    })?);
    let close_up = CloseUp::new(world);
    // Where cells are as narrow as the narrowest, small ones tell which is.
    let narrowest =
        way.into_iter().filter(|&cell| planner.obstacle_distance_at_m(cell) <= least_m + planner.grid.resolution_m);
    let gaps = narrowest.map(|cell| widest_in_cell(planner, &close_up, cell));
    let gap = gaps.min_by(|one, other| one.width_m.total_cmp(&other.width_m))?;
    (LEAST_M..needed_m(planner.robot_radius_m())).contains(&gap.width_m).then_some(gap)
}

/// The part of a cell with most room around it.
fn widest_in_cell(planner: &PlannerModel, close_up: &CloseUp<'_>, cell: usize) -> Gap {
    let grid = &planner.grid;
    let reach = libm::ceil((planner.robot_radius_m() + grid.resolution_m) / GRAIN_M) as usize;
    let parts = libm::round(grid.resolution_m / GRAIN_M) as usize;
    let size = parts + 2 * reach;
    let half = Vector::new(size as f64, size as f64) * (GRAIN_M / 2.0);
    let map = close_up.draw(grid.centre(cell) - half, GRAIN_M, size, size);
    let is_obstacle: Vec<bool> = map.cells.iter().map(|&cell| cell != Cell::Free).collect();
    let squared = squared_distances_cells(size, size, &is_obstacle);
    let within = (0..parts * parts).map(|part| (reach + part % parts, reach + part / parts));
    let squared_at = |&(x, y): &(usize, usize)| squared[y * size + x];
    let (x, y) = within.max_by_key(squared_at).unwrap_or((reach, reach));
    // The middle of a cell is up to half a cell off the middle of the gap.
    Gap { at: map.centre(x, y), width_m: 2.0 * libm::sqrt(f64::from(squared_at(&(x, y)))) * GRAIN_M }
}

/// The cells of the way on which the least distance to an obstacle is largest.
fn widest_way(planner: &PlannerModel, start: Point, goal: Point) -> Option<Vec<usize>> {
    let grid = &planner.grid;
    let (from, to) = (grid.cell_at(start)?, grid.cell_at(goal)?);
    let mut before = vec![usize::MAX; grid.prices.len()];
    // Distances are not negative, so that their bits have their order.
    let room = |cell: usize| planner.obstacle_distance_at_m(cell).to_bits();
    before[from] = from;
    let mut open = BinaryHeap::from([(room(from), from)]);
    while let Some((least, cell)) = open.pop() {
        if cell == to {
            let mut way = vec![to];
            let mut at = to;
            while at != from {
                at = before[at];
                way.push(at);
            }
            return Some(way);
        }
        for offset in grid.offsets {
            let next = cell.wrapping_add_signed(offset);
            if before[next] == usize::MAX && !grid.is_obstacle[next] {
                before[next] = cell;
                open.push((least.min(room(next)), next));
            }
        }
    }
    None
}
