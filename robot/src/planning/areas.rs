//! The floor the robot fits on, cut along the edges of rooms into areas, and the openings between
//! them: what a map says of ways, whether or not there is a door.

use super::cost_grid::{CostGrid, MOVES};
use super::planner::PlannerModel;
use crate::geometry::{Point, Vector};
use crate::world::{Outline, Rect, Room};

/// No area.
const NOWHERE: u32 = u32::MAX;

/// A connected part of the floor within one room, or outside all rooms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Area(u32);

/// Where one can go from one area into another: a straight gap along the edge of a room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Opening {
    /// Its middle.
    pub at: Point,
    /// Clear width for the robot's middle.
    pub clear_m: f64,
    /// Across it, of unit length, from the first area to the second.
    pub through: Vector,
    /// On its two sides.
    pub areas: [Area; 2],
}

/// The areas of a map. Immutable.
#[derive(Clone, Debug)]
pub(super) struct Areas {
    /// Of each cell of the planner's grid, rimmed like it.
    labels: Vec<u32>,
    /// The room each area is in, by its index.
    rooms: Vec<Option<usize>>,
    /// Cells of each area.
    cells: Vec<usize>,
}

impl Areas {
    /// Cuts the floor along the edges of the rooms. O(cells).
    pub fn new(planner: &PlannerModel, rooms: &[Room]) -> Self {
        let grid = &planner.grid;
        let room_of = rooms_of_cells(grid, rooms);
        let mut areas = Self { labels: vec![NOWHERE; grid.prices.len()], rooms: Vec::new(), cells: Vec::new() };
        let mut open = Vec::new();
        for first in 0..grid.prices.len() {
            if grid.prices[first] == 0 || areas.labels[first] != NOWHERE {
                continue;
            }
            let (label, mut cells) = (areas.rooms.len() as u32, 0);
            areas.labels[first] = label;
            open.push(first);
            while let Some(cell) = open.pop() {
                cells += 1;
                for next in beside(grid, cell) {
                    if areas.labels[next] == NOWHERE && room_of[next] == room_of[first] {
                        areas.labels[next] = label;
                        open.push(next);
                    }
                }
            }
            areas.rooms.push((room_of[first] != NOWHERE).then_some(room_of[first] as usize));
            areas.cells.push(cells);
        }
        areas
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.rooms.len()
    }

    /// The room of an area, by its index; none outside all rooms.
    pub fn room(&self, area: Area) -> Option<usize> {
        self.rooms[area.0 as usize]
    }

    /// Cells of an area.
    pub fn cells(&self, area: Area) -> usize {
        self.cells[area.0 as usize]
    }

    /// A number below [`count`](Self::count).
    pub fn index(&self, area: Area) -> usize {
        area.0 as usize
    }

    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = Area> {
        (0..self.rooms.len() as u32).map(Area)
    }

    /// The area around a point; of a point the robot does not fit at, that of the nearest point
    /// within reach.
    pub fn near(&self, planner: &PlannerModel, point_in_map: Point, reach_m: f64) -> Option<Area> {
        let cell = planner.grid.cell_at(point_in_map)?;
        self.of_cell(cell).or_else(|| {
            let mut near = planner.grid.disc(point_in_map, reach_m);
            near.retain(|(cell, _)| self.labels[*cell] != NOWHERE);
            near.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).and_then(|(cell, _)| self.of_cell(cell))
        })
    }

    /// The areas with floor within reach of a body.
    pub fn around(&self, planner: &PlannerModel, body: &Outline, reach_m: f64) -> Vec<Area> {
        let grid = &planner.grid;
        let Rect { min, max } = body.bounds();
        let reach = Vector::new(reach_m, reach_m);
        let near = cells_in(grid, Rect { min: min - reach, max: max + reach }).into_iter();
        let near = near.filter(|&cell| self.labels[cell] != NOWHERE && body.distance_m(grid.centre(cell)) <= reach_m);
        let mut areas: Vec<Area> = near.filter_map(|cell| self.of_cell(cell)).collect();
        areas.sort();
        areas.dedup();
        areas
    }

    fn of_cell(&self, cell: usize) -> Option<Area> {
        (self.labels[cell] != NOWHERE).then(|| Area(self.labels[cell]))
    }

    /// Where areas touch, in the order of their lines. O(cells).
    pub fn openings(&self, planner: &PlannerModel) -> Vec<Opening> {
        let grid = &planner.grid;
        let mut steps: Vec<AreaStep> = Vec::new();
        for cell in 0..self.labels.len() {
            let Some(here) = self.of_cell(cell) else { continue };
            let (column, row) = (cell % grid.stride, cell / grid.stride);
            for (is_eastward, bit, next, line, along) in
                [(true, 0, cell + 1, column, row), (false, 1, cell + grid.stride, row, column)]
            {
                if grid.moves[cell] & (1 << bit) == 0 {
                    continue;
                }
                if let Some(there) = self.of_cell(next).filter(|there| *there != here) {
                    steps.push(AreaStep { is_eastward, line, areas: [here, there], along });
                }
            }
        }
        steps.sort_by_key(|step| (step.is_eastward, step.line, step.areas, step.along));
        steps.chunk_by(|a, b| a.goes_on_with(b)).map(|run| opening(grid, run)).collect()
    }
}

/// From one cell into a cell of another area.
#[derive(Clone, Copy, Debug)]
struct AreaStep {
    /// To the next column, else to the next row.
    is_eastward: bool,
    /// The column or row it begins in.
    line: usize,
    areas: [Area; 2],
    /// The other coordinate.
    along: usize,
}

impl AreaStep {
    fn goes_on_with(&self, next: &Self) -> bool {
        (self.is_eastward, self.line, self.areas) == (next.is_eastward, next.line, next.areas)
            && next.along == self.along + 1
    }
}

fn opening(grid: &CostGrid, run: &[AreaStep]) -> Opening {
    let AreaStep { is_eastward, line, areas, along } = run[0];
    let cell = |line: usize, along: usize| {
        if is_eastward { along * grid.stride + line } else { line * grid.stride + along }
    };
    let last = along + run.len() - 1;
    let corners = [grid.point(cell(line, along)), grid.point(cell(line + 1, last))];
    Opening {
        at: nalgebra::center(&corners[0], &corners[1]),
        clear_m: run.len() as f64 * grid.resolution_m,
        through: if is_eastward { Vector::new(1.0, 0.0) } else { Vector::new(0.0, 1.0) },
        areas,
    }
}

/// The cells that can be entered from a cell in a straight move.
fn beside(grid: &CostGrid, cell: usize) -> impl Iterator<Item = usize> + '_ {
    let moves = grid.moves[cell];
    let straight = MOVES[..4].iter().enumerate();
    straight.filter(move |(bit, _)| moves & (1 << bit) != 0).map(move |(_, &step)| grid.neighbour(cell, step))
}

/// The room that the middle of each cell is in, the first of several.
fn rooms_of_cells(grid: &CostGrid, rooms: &[Room]) -> Vec<u32> {
    let mut room_of = vec![NOWHERE; grid.prices.len()];
    for (index, room) in rooms.iter().enumerate() {
        for cell in cells_in(grid, room.rect) {
            if room_of[cell] == NOWHERE {
                room_of[cell] = index as u32;
            }
        }
    }
    room_of
}

/// The cells whose middles lie in a rectangle.
fn cells_in(grid: &CostGrid, rect: Rect) -> Vec<usize> {
    let first =
        |from_m: f64, origin_m: f64| libm::ceil((from_m - origin_m) / grid.resolution_m - 0.5 - 1e-9).max(0.0) as usize;
    let end = |to_m: f64, origin_m: f64, count: usize| {
        let past = libm::floor((to_m - origin_m) / grid.resolution_m - 0.5 + 1e-9) + 1.0;
        past.clamp(0.0, count as f64) as usize
    };
    let columns = first(rect.min.x, grid.origin_in_frame.x)..end(rect.max.x, grid.origin_in_frame.x, grid.columns);
    let rows = first(rect.min.y, grid.origin_in_frame.y)..end(rect.max.y, grid.origin_in_frame.y, grid.rows);
    rows.flat_map(|row| columns.clone().map(move |column| (row + 1) * grid.stride + column + 1)).collect()
}

/// Whether an opening is the doorway of a door at a point, `width_m` wide, in a wall one goes
/// through along `through`.
pub(super) fn is_in_doorway(opening: &Opening, at: Point, width_m: f64, through: Vector) -> bool {
    /// The edge of a room may be so far from the line of the wall.
    const OFF_WALL_M: f64 = 0.5;
    let offset = opening.at - at;
    let is_parallel = opening.through.dot(&through).abs() > 0.5;
    is_parallel && offset.dot(&through).abs() <= OFF_WALL_M && offset.perp(&through).abs() <= width_m / 2.0
}
