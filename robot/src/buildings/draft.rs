//! A floor plan in the making.

use crate::geometry::{Point, Pose, Vector};
use crate::occupancy::{Cell, OccupancyGrid};
use crate::world::{Axis, Door, Object, Rect, Region, Room, SeenBy, Shape, TravelMode, Wall, World};
use rpl_random::Stream;

/// Outer walls run so far within the edge of the world.
pub(super) const INSET_M: f64 = 0.1;

/// How thick walls are.
pub(super) const WALL_M: f64 = 0.15;

/// Nothing stands nearer to the middle of a door.
const DOOR_FREE_M: f64 = 1.1;

/// A door is wider than the robot by at least this.
const DOOR_AIR_M: f64 = 0.32;

/// How wide doors are, for a robot that fits through.
const DOOR_M: (f64, f64) = (0.8, 1.2);

/// The plan of a building, and what stands in it.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    pub origin_in_map: Point,
    pub size_m: Vector,
    pub recorded: Option<OccupancyGrid>,
    pub walls: Vec<Wall>,
    pub rooms: Vec<Room>,
    pub doors: Vec<Door>,
    pub hallways: Vec<Rect>,
    /// What never moves: racks, pillars, panes.
    pub fixtures: Vec<Object>,
    /// What people move.
    pub furniture: Vec<Object>,
    /// Where furniture may stand, each a rectangle of free floor.
    pub floors: Vec<Rect>,
    pub people: usize,
    /// A point of the floor that start and places hang together with, if not any floor will do.
    pub within: Option<Point>,
}

impl Draft {
    /// Empty ground.
    pub fn new(size_m: Vector) -> Self {
        Self {
            origin_in_map: Point::origin(),
            size_m,
            recorded: None,
            walls: Vec::new(),
            rooms: Vec::new(),
            doors: Vec::new(),
            hallways: Vec::new(),
            fixtures: Vec::new(),
            furniture: Vec::new(),
            floors: Vec::new(),
            people: 0,
            within: None,
        }
    }

    /// Ground with a wall around it. The floor within is not said yet.
    pub fn walled(size_m: Vector) -> Self {
        let mut draft = Self::new(size_m);
        let Rect { min, max } = draft.outline();
        draft.wall(&[(min.x, min.y), (max.x, min.y), (max.x, max.y), (min.x, max.y), (min.x, min.y)]);
        draft
    }

    /// The line of the outer walls.
    pub fn outline(&self) -> Rect {
        let inset = Vector::new(INSET_M, INSET_M);
        Rect { min: self.origin_in_map + inset, max: self.origin_in_map + self.size_m - inset }
    }

    /// The floor within the outer walls.
    pub fn inside(&self) -> Rect {
        floor_within(self.outline())
    }

    pub fn wall(&mut self, line: &[(f64, f64)]) {
        let line = line.iter().map(|&(x, y)| Point::new(x, y)).collect();
        self.walls.push(Wall { line, thickness_m: WALL_M });
    }

    /// A room between the middles of its walls; answers its name.
    pub fn room(&mut self, between: Rect) -> String {
        let (name, rect) = (format!("room-{}", self.rooms.len() + 1), floor_within(between));
        self.rooms.push(Room { name: name.clone(), rect });
        self.floors.push(rect);
        name
    }

    pub fn door(&mut self, room: String, at: Point, width_m: f64, axis: Axis) {
        self.doors.push(Door { room, at, width_m, axis, open: true, mapped_open: true });
    }

    /// Something that never moves.
    pub fn fixture(&mut self, what: &str, shape: Shape, seen_by: SeenBy) {
        let name = format!("{what}-{}", self.fixtures.len() + 1);
        self.fixtures.push(Object { name, shape, mapped: true, seen_by });
    }

    /// Whether something with these bounds has room beside others, off all doors.
    pub fn has_room_for<'o>(&self, bounds: Rect, others: impl IntoIterator<Item = &'o Object>) -> bool {
        let on_floor = self.floors.iter().any(|floor| floor.contains(bounds.min) && floor.contains(bounds.max));
        let overlaps = |other: &Object| overlap(bounds, other.outline().bounds());
        let is_near = |door: &Door| (door.at - door.at.sup(&bounds.min).inf(&bounds.max)).norm() < DOOR_FREE_M;
        on_floor
            && !self.doors.iter().any(is_near)
            && !self.fixtures.iter().any(overlaps)
            && !others.into_iter().any(overlaps)
            && self.recorded.as_ref().is_none_or(|grid| is_free(grid, bounds))
    }

    /// The world with these pieces of furniture; its start and its places are not said yet.
    pub fn world(&self, name: &str, furniture: &[Object]) -> World {
        let region = |mode: TravelMode| move |rect: &Rect| Region { mode, rect: *rect };
        let rooms: Vec<Rect> = self.rooms.iter().map(|room| room.rect).collect();
        let regions = rooms.iter().map(region(TravelMode::Office));
        World {
            name: name.to_owned(),
            origin_in_map: self.origin_in_map,
            size_m: self.size_m,
            recorded: self.recorded.clone(),
            start_in_map: Pose::default(),
            walls: self.walls.clone(),
            rooms: self.rooms.clone(),
            doors: self.doors.clone(),
            objects: self.fixtures.iter().chain(furniture).cloned().collect(),
            places: Vec::new(),
            regions: regions.chain(self.hallways.iter().map(region(TravelMode::Hallway))).collect(),
            people: Vec::new(),
            crowd: 0,
            items: Vec::new(),
            markers: Vec::new(),
            landmarks: Vec::new(),
        }
    }
}

/// The floor between the middles of walls around it.
pub(super) fn floor_within(between: Rect) -> Rect {
    let half = Vector::new(WALL_M, WALL_M) / 2.0;
    Rect { min: between.min + half, max: between.max - half }
}

pub(super) fn rect(x0: f64, y0: f64, x1: f64, y1: f64) -> Rect {
    Rect { min: Point::new(x0, y0), max: Point::new(x1, y1) }
}

fn overlap(a: Rect, b: Rect) -> bool {
    a.min.x < b.max.x && b.min.x < a.max.x && a.min.y < b.max.y && b.min.y < a.max.y
}

fn is_free(grid: &OccupancyGrid, bounds: Rect) -> bool {
    let (Some(first), Some(last)) = (grid.cell_at(bounds.min), grid.cell_at(bounds.max)) else { return false };
    (first.1..=last.1).all(|row| (first.0..=last.0).all(|column| grid.get(column, row) == Cell::Free))
}

/// A length, short ones more often than long ones: half of them in the lowest quarter, by ratios.
pub(super) fn mostly_short(stream: &mut Stream, least_m: f64, most_m: f64) -> f64 {
    let share = stream.uniform();
    least_m * libm::pow(most_m / least_m, share * share)
}

/// How wide a door is that a robot fits through.
pub(super) fn door_width_m(stream: &mut Stream, robot_radius_m: f64) -> f64 {
    let least_m = DOOR_M.0.max(2.0 * robot_radius_m + DOOR_AIR_M);
    stream.uniform_in(least_m, DOOR_M.1.max(least_m + 0.1))
}

/// The widest such door.
pub(super) fn widest_door_m(robot_radius_m: f64) -> f64 {
    DOOR_M.1.max(2.0 * robot_radius_m + DOOR_AIR_M + 0.1)
}

/// Cuts a length into pieces of about this size, all at least the smaller one long: the ends between them.
pub(super) fn cuts(stream: &mut Stream, from_m: f64, to_m: f64, (least_m, most_m): (f64, f64)) -> Vec<f64> {
    let mut ends = Vec::new();
    let mut at_m = from_m;
    loop {
        at_m += stream.uniform_in(least_m, most_m);
        if at_m > to_m - least_m {
            return ends;
        }
        ends.push(at_m);
    }
}

/// People about, in some buildings.
pub(super) fn people(stream: &mut Stream) -> usize {
    if stream.chance(0.3) { 1 + stream.index(4) } else { 0 }
}
