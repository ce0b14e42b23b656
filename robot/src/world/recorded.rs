//! Worlds from recorded maps: what is occupied in the map is a wall.

use super::World;
use crate::geometry::{Point, Pose, Vector};
use crate::occupancy::{Cell, DistanceField, OccupancyGrid};

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

/// Middle of the cell with most room around it in the largest piece of floor that the robot fits on.
/// What is not known, and the edge of the map, is no room: behind it may be anything.
fn roomiest(map: &OccupancyGrid, robot_radius_m: f64) -> Option<Point> {
    let floor = Floor::new(map, robot_radius_m);
    let mut seen = vec![false; map.cells.len()];
    let (mut enclosed, mut open) = (Vec::new(), Vec::new());
    for first in 0..map.cells.len() {
        let first = (first % map.columns, first / map.columns);
        if seen[first.1 * map.columns + first.0] || !floor.fits(first) {
            continue;
        }
        let piece = floor.piece_around(first, &mut seen);
        let largest = if piece.iter().any(|&cell| floor.is_open(cell)) { &mut open } else { &mut enclosed };
        if piece.len() > largest.len() {
            *largest = piece;
        }
    }
    let largest = if ENCLOSED_FACTOR * enclosed.len() >= open.len() { enclosed } else { open };
    let mut best: Option<(f64, Point)> = None;
    for (column, row) in largest {
        let room_m = floor.clearance_m((column, row));
        if best.is_none_or(|(most_m, _)| room_m > most_m) {
            best = Some((room_m, map.centre(column, row)));
        }
    }
    best.map(|(_, centre)| centre)
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
        let mut solid = map.clone();
        solid.cells.iter_mut().filter(|cell| **cell == Cell::Unknown).for_each(|cell| *cell = Cell::Occupied);
        Self { map, distances: DistanceField::new(&solid), robot_radius_m }
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

    /// The cells that hang together with one and have not been seen.
    fn piece_around(&self, first: (usize, usize), seen: &mut [bool]) -> Vec<(usize, usize)> {
        let (mut piece, mut open) = (Vec::new(), vec![first]);
        while let Some((column, row)) = open.pop() {
            if std::mem::replace(&mut seen[row * self.map.columns + column], true) || !self.fits((column, row)) {
                continue;
            }
            piece.push((column, row));
            open.extend(self.map.beside(column, row));
        }
        piece
    }
}
