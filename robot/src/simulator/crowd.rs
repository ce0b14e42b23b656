//! Where the people of a crowd can walk to, and how they get there.
//!
//! People find their ways by cost fields, as the robot does: what it costs to cross a floor is neutral
//! ground, and theirs are of the real floor and for a body of their size. The robot's own planner, which
//! knows what the robot believes, is not used.

use super::walker::PERSON_RADIUS_M;
use crate::geometry::{Point, distance_m};
use crate::planning::{CostGrid, CostToGo, Inflation};
use crate::world::{Rect, TravelMode, World, is_same_name};
use rpl_random::Stream;
use std::sync::Arc;

/// Edge of a cell of the floor.
const CELL_M: f64 = 0.1;

/// People keep this far from walls where they can.
const COMFORTABLE_M: f64 = 0.6;

/// Distance between the spots of a hallway, or of a floor without names, that people walk to.
const SPACING_M: f64 = 3.0;

/// The most destinations, each of which takes 4 bytes a cell.
const MOST_DESTINATIONS: usize = 40;

/// Spots tried for each person at the start, and destinations for the next walk.
const TRIES: usize = 200;

/// Nobody of the crowd starts nearer to the robot.
const OFF_THE_ROBOT_M: f64 = 1.5;

/// The destinations of a world and the ways to them. Built once, shared.
#[derive(Debug)]
pub(super) struct Crowd {
    destinations: Vec<Destination>,
    rooms: Vec<Rect>,
    bounds: Rect,
    /// The floor that can be reached from the robot's start when the world begins.
    open_floor: CostToGo,
}

#[derive(Debug)]
struct Destination {
    /// The room it is in, by its index.
    room: Option<usize>,
    /// The doors of that room.
    doors: Vec<usize>,
    /// The ways to it with all doors open.
    ways: CostToGo,
}

impl Crowd {
    /// Takes the places, rooms and hallways of a world as destinations; if these are few, spots all
    /// over its floor. None if the world has nobody but people with paths.
    pub fn new(world: &World) -> Option<Self> {
        if world.crowd == 0 {
            return None;
        }
        let inflation = Inflation { comfortable_distance_m: COMFORTABLE_M, ..Inflation::of_robot(PERSON_RADIUS_M) };
        let floor = Arc::new(CostGrid::new(&world.floor(CELL_M, |_| true), inflation));
        let ways_to = |spot: Point| CostToGo::new(floor.clone(), spot);
        let start = world.start_in_map.point();
        let reachable = ways_to(start);
        let mut spots = named_spots(world);
        spots.retain(|spot| reachable.cost_m(*spot).is_some());
        if spots.len() < 4 {
            spots.extend(lattice(world.bounds()).filter(|spot| reachable.cost_m(*spot).is_some()));
        }
        spots.push(start);
        // Of many, some all over the list.
        let stride = spots.len().div_ceil(MOST_DESTINATIONS);
        let destination = |spot: &Point| {
            let room = world.rooms.iter().position(|room| room.rect.contains(*spot));
            Destination { room, doors: doors_of(world, room), ways: ways_to(*spot) }
        };
        let destinations = spots.iter().step_by(stride).map(destination).collect();
        let open = CostGrid::new(&world.floor(CELL_M, |door| world.doors[door].open), inflation);
        let rooms = world.rooms.iter().map(|room| room.rect).collect();
        Some(Self { destinations, rooms, bounds: world.bounds(), open_floor: CostToGo::new(Arc::new(open), start) })
    }

    /// Memory that the ways to the destinations of a world take at most.
    pub fn needed_bytes(world: &World) -> f64 {
        let fields = if world.crowd == 0 { 0 } else { MOST_DESTINATIONS + 2 };
        let cells = world.size_m.x * world.size_m.y / (CELL_M * CELL_M);
        cells * (fields * size_of::<u32>()) as f64
    }

    /// How many destinations there are; at least one.
    pub fn len(&self) -> usize {
        self.destinations.len()
    }

    /// The destination with the shortest way to a point.
    pub fn nearest(&self, to_in_map: Point) -> usize {
        let left_m = |destination: &usize| self.left_m(*destination, to_in_map);
        (0..self.len()).min_by(|one, other| left_m(one).total_cmp(&left_m(other))).unwrap_or(0)
    }

    /// Whether a body fits there when the world begins.
    pub fn is_open(&self, at_in_map: Point) -> bool {
        self.open_floor.cost_m(at_in_map).is_some()
    }

    /// Metres of open floor from a point to a destination; infinite from where nobody can stand.
    pub fn left_m(&self, destination: usize, from_in_map: Point) -> f64 {
        self.destinations[destination].ways.cost_m(from_in_map).unwrap_or(f64::INFINITY)
    }

    /// The spot so far along the way to a destination, or its end.
    pub fn spot_ahead(&self, destination: usize, from_in_map: Point, reach_m: f64) -> Point {
        let way = self.destinations[destination].ways.way_ahead(from_in_map, reach_m);
        way.and_then(|way| way.last().copied()).unwrap_or(from_in_map)
    }

    /// Another destination than the last for somebody who stands at a point; none in another room
    /// that is shut.
    pub fn draw(&self, stream: &mut Stream, from: Point, last: usize, is_closed: impl Fn(usize) -> bool) -> usize {
        let here = self.rooms.iter().position(|rect| rect.contains(from));
        let shut = |destination: &Destination| {
            destination.room != here
                && !destination.doors.is_empty()
                && destination.doors.iter().all(|door| is_closed(*door))
        };
        for _ in 0..TRIES {
            let drawn = stream.index(self.destinations.len());
            if drawn != last && !shut(&self.destinations[drawn]) {
                return drawn;
            }
        }
        last
    }

    /// A free spot for somebody to begin, off the robot and, if there is room, off the others.
    pub fn free_spot(
        &self,
        stream: &mut Stream,
        taken: &[Point],
        robot: Point,
        is_free: impl Fn(Point) -> bool,
    ) -> Point {
        let Rect { min, max } = self.bounds;
        let mut best = (f64::NEG_INFINITY, robot);
        for _ in 0..TRIES {
            let spot = Point::new(stream.uniform_in(min.x, max.x), stream.uniform_in(min.y, max.y));
            if self.open_floor.cost_m(spot).is_none() || distance_m(spot, robot) < OFF_THE_ROBOT_M || !is_free(spot) {
                continue;
            }
            let off_m = taken.iter().map(|other| distance_m(*other, spot)).fold(f64::INFINITY, f64::min);
            if off_m > 3.0 * PERSON_RADIUS_M {
                return spot;
            }
            if off_m > best.0 {
                best = (off_m, spot);
            }
        }
        best.1
    }
}

/// Places, the middles of rooms, and spots along hallways.
fn named_spots(world: &World) -> Vec<Point> {
    let places = world.places.iter().map(|place| place.pose_in_map.point());
    let rooms = world.rooms.iter().map(|room| room.rect.centre());
    let hallways = world.regions.iter().filter(|region| region.mode == TravelMode::Hallway);
    let Rect { min, max } = world.bounds();
    let within = hallways.map(|region| Rect { min: region.rect.min.sup(&min), max: region.rect.max.inf(&max) });
    places.chain(rooms).chain(within.flat_map(lattice)).collect()
}

/// Spots all over a rectangle, off its edges.
fn lattice(rect: Rect) -> impl Iterator<Item = Point> {
    let size_m = rect.max - rect.min;
    let count = |length_m: f64| (libm::round(length_m / SPACING_M) as usize).max(1);
    let (columns, rows) = (count(size_m.x), count(size_m.y));
    let at = move |index: usize, count: usize, length_m: f64| (index as f64 + 0.5) / count as f64 * length_m;
    (0..rows * columns).map(move |cell| {
        let (column, row) = (cell % columns, cell / columns);
        Point::new(rect.min.x + at(column, columns, size_m.x), rect.min.y + at(row, rows, size_m.y))
    })
}

fn doors_of(world: &World, room: Option<usize>) -> Vec<usize> {
    let Some(room) = room.map(|room| &world.rooms[room]) else { return Vec::new() };
    let doors = world.doors.iter().enumerate();
    doors.filter(|(_, door)| is_same_name(&door.room, &room.name)).map(|(index, _)| index).collect()
}
