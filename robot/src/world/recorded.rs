//! Worlds from recorded maps: what is occupied in the map is a wall.

use super::World;
use crate::geometry::{Point, Pose, Vector};
use crate::occupancy::{Cell, DistanceField, OccupancyGrid, flood};

/// No cell of the map has room for the robot.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the map has no free space that the robot fits into ({robot_radius_m} m around its middle)")]
pub struct NoRoom {
    /// Of the robot.
    pub robot_radius_m: f64,
}

impl World {
    /// A world of a recorded map alone. A robot of this radius starts where it has most space around it.
    ///
    /// # Errors
    /// The robot fits nowhere.
    pub fn from_map(name: &str, map: OccupancyGrid, robot_radius_m: f64) -> Result<Self, NoRoom> {
        let start = roomiest(&map, robot_radius_m).ok_or(NoRoom { robot_radius_m })?;
        Ok(Self {
            name: name.to_owned(),
            origin_in_map: map.origin_in_frame,
            size_m: size_m(&map),
            start_in_map: Pose::new(start.x, start.y, 0.0),
            recorded: Some(map),
            walls: Vec::new(),
            rooms: Vec::new(),
            doors: Vec::new(),
            objects: Vec::new(),
            places: Vec::new(),
            regions: Vec::new(),
            people: Vec::new(),
            crowd: 0,
            items: Vec::new(),
            markers: Vec::new(),
            landmarks: Vec::new(),
        })
    }
}

/// Width and height of a map.
pub(super) fn size_m(map: &OccupancyGrid) -> Vector {
    Vector::new(map.columns as f64, map.rows as f64) * map.resolution_m
}

/// An enclosed piece of floor is the building's, and one that the map ends in the outside, unless the
/// enclosed one is smaller by this factor.
const ENCLOSED_FACTOR: usize = 10;

/// Middle of the cell with most room around it in the largest piece of floor that the robot fits on, the first of them
/// row by row. What is not known, and the edge of the map, is no room: behind it may be anything. Cost: cells, 6 bytes
/// each.
fn roomiest(map: &OccupancyGrid, robot_radius_m: f64) -> Option<Point> {
    let floor = Floor::new(map, robot_radius_m);
    let cells = (0..map.rows).flat_map(|row| (0..map.columns).map(move |column| (column, row)));
    let mut is_closed: Vec<bool> = Vec::with_capacity(map.cells.len());
    is_closed.extend(cells.map(|cell| !floor.fits(cell)));
    let (mut enclosed, mut open) = (Piece::default(), Piece::default());
    for first in 0..map.cells.len() {
        if is_closed[first] {
            continue;
        }
        let mut piece = Piece::default();
        let from = (first % map.columns, first / map.columns);
        flood(map.columns, &mut is_closed, [from], |row, run| run.for_each(|column| piece.add(&floor, (column, row))));
        let largest = if piece.is_open { &mut open } else { &mut enclosed };
        if piece.cells > largest.cells {
            *largest = piece;
        }
    }
    let largest = if ENCLOSED_FACTOR * enclosed.cells >= open.cells { enclosed } else { open };
    largest.roomiest.map(|(_, (column, row))| map.centre(column, row))
}

/// A piece of floor that hangs together.
#[derive(Default)]
struct Piece {
    cells: usize,
    /// Whether the map ends somewhere beside it, and no wall.
    is_open: bool,
    /// The cell with most room around it, and how much that is.
    roomiest: Option<(f64, (usize, usize))>,
}

impl Piece {
    fn add(&mut self, floor: &Floor<'_>, (column, row): (usize, usize)) {
        let room_m = floor.clearance_m((column, row));
        let is_roomier = self.roomiest.is_none_or(|(most_m, (best_column, best_row))| {
            room_m > most_m || (room_m == most_m && (row, column) < (best_row, best_column))
        });
        if is_roomier {
            self.roomiest = Some((room_m, (column, row)));
        }
        self.cells += 1;
        self.is_open |= floor.is_open((column, row));
    }
}

/// Where the robot fits on a map.
struct Floor<'m> {
    map: &'m OccupancyGrid,
    /// To what is occupied or not known.
    distances: DistanceField,
    robot_radius_m: f64,
}

impl<'m> Floor<'m> {
    fn new(map: &'m OccupancyGrid, robot_radius_m: f64) -> Self {
        Self { map, distances: DistanceField::to(map, |cell| cell != Cell::Free), robot_radius_m }
    }

    fn to_edge_m(&self, (column, row): (usize, usize)) -> f64 {
        let cells = column.min(row).min(self.map.columns - 1 - column).min(self.map.rows - 1 - row);
        cells as f64 * self.map.resolution_m
    }

    fn to_solid_m(&self, (column, row): (usize, usize)) -> f64 {
        self.distances.clearance_m(self.map.centre(column, row))
    }

    fn clearance_m(&self, cell: (usize, usize)) -> f64 {
        self.to_solid_m(cell).min(self.to_edge_m(cell))
    }

    fn fits(&self, cell: (usize, usize)) -> bool {
        self.clearance_m(cell) > self.robot_radius_m
    }

    /// Whether the map ends beside the robot, and no wall.
    fn is_open(&self, cell: (usize, usize)) -> bool {
        let to_edge_m = self.to_edge_m(cell);
        to_edge_m < self.robot_radius_m + 2.0 * self.map.resolution_m && self.to_solid_m(cell) > to_edge_m
    }
}
