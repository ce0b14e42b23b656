//! Worlds from recorded maps: what is occupied in the map is a wall.

use super::check::ROBOT_RADIUS_M;
use super::{Rect, World};
use crate::geometry::{Point, Pose, Vector};
use crate::localization::DistanceField;
use crate::occupancy::{Cell, OccupancyGrid};

/// No cell of the map has room for the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the map has no free space that the robot fits into ({ROBOT_RADIUS_M} m around its middle)")]
pub struct NoRoom;

impl World {
    /// A world of a recorded map alone. The robot starts where it has most space around it.
    ///
    /// # Errors
    /// The robot fits nowhere.
    pub fn from_map(name: &str, map: OccupancyGrid) -> Result<Self, NoRoom> {
        let start = roomiest(&map).ok_or(NoRoom)?;
        Ok(Self {
            name: name.to_owned(),
            origin_in_map: map.origin_in_map,
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
        })
    }
}

/// Width and height of a map.
pub(super) fn size_m(map: &OccupancyGrid) -> Vector {
    Vector::new(map.columns as f64, map.rows as f64) * map.resolution_m
}

/// Middle of the free cell that is farthest from anything occupied.
fn roomiest(map: &OccupancyGrid) -> Option<Point> {
    let field = DistanceField::new(map);
    let mut best: Option<(f64, Point)> = None;
    for index in (0..map.cells.len()).filter(|&index| map.cells[index] == Cell::Free) {
        let centre = map.centre(index % map.columns, index / map.columns);
        let clearance_m = field.clearance_m(centre);
        if clearance_m > best.map_or(ROBOT_RADIUS_M, |(most_m, _)| most_m) {
            best = Some((clearance_m, centre));
        }
    }
    best.map(|(_, centre)| centre)
}

/// The occupied cells as rectangles: runs along x, of which equal ones above each other are one.
pub(super) fn blocks(map: &OccupancyGrid) -> Vec<Rect> {
    let corner =
        |column: usize, row: usize| map.origin_in_map + Vector::new(column as f64, row as f64) * map.resolution_m;
    let mut blocks: Vec<Rect> = Vec::new();
    // Columns of the runs that the row below ends with, and their rectangles.
    let mut below: Vec<(usize, usize, usize)> = Vec::new();
    for row in 0..map.rows {
        let cells = &map.cells[row * map.columns..][..map.columns];
        let mut open = Vec::new();
        let mut first = 0;
        for run in cells.chunk_by(|a, b| a == b) {
            let end = first + run.len();
            if run[0] == Cell::Occupied {
                let above = below.iter().find(|(from, to, _)| (*from, *to) == (first, end));
                let block = above.map_or(blocks.len(), |(_, _, block)| *block);
                match above {
                    Some(_) => blocks[block].max = corner(end, row + 1),
                    None => blocks.push(Rect { min: corner(first, row), max: corner(end, row + 1) }),
                }
                open.push((first, end, block));
            }
            first = end;
        }
        below = open;
    }
    blocks
}
