//! The map as the robot's path planner sees it.

use super::close_map::{CloseMap, Patch};
use super::cost_grid::{CostGrid, Inflation, MOVES, OPEN_FLOOR};
use super::cost_to_go::CostToGo;
use super::narrow::narrow_cells;
use super::open_edge::{OpenEdge, open_edges};
use crate::geometry::Point;
use crate::occupancy::OccupancyGrid;
use crate::world::{CloseUp, World};
use std::sync::Arc;

/// A map with its obstacles inflated, and how far they are. Immutable; share it. Points are of the
/// frame of the map.
#[derive(Clone, Debug)]
pub struct PlannerModel {
    pub(super) grid: Arc<CostGrid>,
    /// Of the cells of the grid.
    obstacle_distances_m: Vec<f32>,
    open_edges: Vec<OpenEdge>,
    close_map: CloseMap,
}

impl PlannerModel {
    /// Inflates the obstacles of a map. Unknown cells and everything outside the map count as
    /// obstacles. O(cells).
    pub fn new(map: &OccupancyGrid, inflation: Inflation) -> Self {
        let (grid, obstacle_distances_m) = CostGrid::with_distances(map, inflation);
        Self { grid: Arc::new(grid), obstacle_distances_m, open_edges: open_edges(map), close_map: CloseMap::default() }
    }

    /// Of the map of a world in cells of this size, and of smaller ones where it is narrow. Cost: cells, and for narrow
    /// places the small cells around them.
    pub fn of_world(world: &World, resolution_m: f64, inflation: Inflation) -> Self {
        let map = world.map(resolution_m);
        let (mut grid, obstacle_distances_m) = CostGrid::with_distances(&map, inflation);
        let close_up = CloseUp::new(world);
        let draw = |corner, small_m, columns, rows| close_up.draw(corner, small_m, columns, rows);
        let (narrow, close_map) = narrow_cells(&grid, &obstacle_distances_m, draw);
        grid.open(narrow);
        Self { grid: Arc::new(grid), obstacle_distances_m, open_edges: open_edges(&map), close_map }
    }

    /// How far the robot reaches around its middle.
    pub fn robot_radius_m(&self) -> f64 {
        self.grid.inflation.body_radius_m
    }

    /// Distance from the middle of the cell around a point to the edge of the nearest obstacle cell
    /// (half a cell less than to its centre); 0 outside the map.
    pub fn obstacle_distance_m(&self, point_in_frame: Point) -> f64 {
        self.grid.cell_at(point_in_frame).map_or(0.0, |cell| f64::from(self.obstacle_distances_m[cell]))
    }

    /// The same of a cell of the grid.
    pub(super) fn obstacle_distance_at_m(&self, cell: usize) -> f64 {
        f64::from(self.obstacle_distances_m[cell])
    }

    /// How far a point is from the nearest obstacle cell, if it is at most a cell.
    pub fn off_obstacle_m(&self, point_in_frame: Point) -> Option<f64> {
        let grid = &self.grid;
        let middle = grid.cell_at(point_in_frame)?;
        let half_m = grid.resolution_m / 2.0;
        let off_m = |cell: usize| {
            let off = (point_in_frame - grid.centre(cell)).abs().map(|off_m| (off_m - half_m).max(0.0));
            off.norm()
        };
        std::iter::once(middle)
            .chain(MOVES.map(|step| grid.neighbour(middle, step)))
            .filter(|&cell| grid.is_obstacle[cell])
            .map(off_m)
            .min_by(f64::total_cmp)
    }

    /// What a metre costs at a point, in metres of open floor; `None` where the robot does not fit.
    pub fn price(&self, point_in_frame: Point) -> Option<f64> {
        let cell = self.grid.cell_at(point_in_frame)?;
        self.grid.fits_in_cell(cell, point_in_frame).then(|| f64::from(self.grid.prices[cell]) / f64::from(OPEN_FLOOR))
    }

    /// Whether the robot fits at a point.
    pub fn is_traversable(&self, point_in_frame: Point) -> bool {
        self.grid.cell_at(point_in_frame).is_some_and(|cell| self.grid.fits_in_cell(cell, point_in_frame))
    }

    /// Whether the straight way between two points is traversable.
    pub fn is_straight_way_free(&self, from_in_frame: Point, to_in_frame: Point) -> bool {
        self.grid.straight_cost_m(from_in_frame, to_in_frame).is_some()
    }

    /// Centres of the obstacle cells within `reach_m` of a point that have a free cell beside them,
    /// in row order.
    pub fn obstacle_edges_near(&self, point_in_frame: Point, reach_m: f64) -> Vec<Point> {
        let grid = &self.grid;
        let is_edge = |cell: usize| MOVES[..4].iter().any(|&step| !grid.is_obstacle[grid.neighbour(cell, step)]);
        let edges = grid.square(point_in_frame, reach_m).filter(|&cell| grid.is_obstacle[cell] && is_edge(cell));
        let centres = edges.map(|cell| grid.centre(cell));
        centres.filter(|centre| (centre - point_in_frame).norm_squared() <= reach_m * reach_m).collect()
    }

    /// The map around the narrow places beside a point, in small cells.
    pub fn narrow_places(&self, point_in_frame: Point) -> Vec<&Patch> {
        self.close_map.around(point_in_frame).collect()
    }

    /// Where the map ends and no wall, side by side.
    pub fn open_edges(&self) -> &[OpenEdge] {
        &self.open_edges
    }

    /// Points of the map's open edge within `reach_m` of a point, a cell apart. Cost: stretches of open edge, if the
    /// edge of the map is within reach.
    pub fn open_edge_near(&self, point_in_frame: Point, reach_m: f64) -> impl Iterator<Item = Point> + '_ {
        let grid = &self.grid;
        // The outermost cells may be beyond the edge.
        let inner = (point_in_frame - grid.origin_in_frame).add_scalar(-reach_m - grid.resolution_m);
        let rest = Point::new(grid.columns as f64, grid.rows as f64) * grid.resolution_m
            - (point_in_frame - grid.origin_in_frame).add_scalar(reach_m + grid.resolution_m);
        let is_inside = inner.min() > 0.0 && rest.coords.min() > 0.0;
        let edges = if is_inside { &[][..] } else { &self.open_edges };
        edges.iter().flat_map(move |edge| edge.points_near(point_in_frame, reach_m, grid.resolution_m))
    }

    /// What it costs to go from every cell to a target.
    pub fn cost_to_go(&self, target_in_frame: Point) -> CostToGo {
        CostToGo::new(self.grid.clone(), target_in_frame)
    }

    /// What it costs to go from every cell to a target when there are obstacles at these points besides
    /// those in the map.
    pub fn cost_to_go_around(&self, target_in_frame: Point, blocked_in_frame: &[Point]) -> CostToGo {
        if blocked_in_frame.is_empty() {
            return self.cost_to_go(target_in_frame);
        }
        CostToGo::new(Arc::new(self.grid.with_obstacles_at(blocked_in_frame)), target_in_frame)
    }
}
