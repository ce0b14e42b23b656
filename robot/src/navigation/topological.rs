//! Topological plans: which doors to go through, and the target points that lead through them
//! orthogonally and along the corridor past no other office (Beetz, Burgard, Fox, Cremers 1998,
//! Sect. 3.1, Fig. 12).

use super::planner::PlannerModel;
use crate::geometry::{Point, Pose, Vector, distance_m};
use crate::world::{Axis, Door, Place, Rect, Region, Room, TravelMode, World};
use serde::{Deserialize, Serialize};

/// How far before and behind a door its target points lie.
const DOOR_APPROACH_M: f64 = 0.75;

/// How far from the robot's line the last point may be for it to count as passed.
const PASSING_WIDTH_M: f64 = 0.3;

/// Two target points nearer to each other than this are one.
const SAME_TARGET_M: f64 = 0.4;

/// What a door adds to a way: it is gone through slowly, and no office is entered only to be left
/// again by the way it was entered.
const DOOR_COSTS_M: f64 = 2.0;

/// A point to drive to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Where.
    pub point_in_map: Point,
    /// Which way to look there; only the last target of a plan has one.
    pub heading_rad: Option<f64>,
}

impl Target {
    /// A target the robot only passes through.
    pub fn through(point_in_map: Point) -> Self {
        Self { point_in_map, heading_rad: None }
    }

    /// A target to stand at and look from.
    pub fn at(pose_in_map: Pose) -> Self {
        Self { point_in_map: pose_in_map.point(), heading_rad: Some(pose_in_map.heading_rad) }
    }
}

/// The structure of a way: its target points, and the regions it leads through.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NavigationPlan {
    /// In order; at least the destination.
    pub targets: Vec<Target>,
    /// The regions the way crosses, in the order they are first entered, each once.
    pub regions: Vec<Region>,
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("no way there: {reason}")]
pub struct Unreachable {
    /// In words for the user.
    pub reason: String,
}

/// Where a point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Area {
    /// In a room, by its index.
    Room(usize),
    /// Outside all rooms.
    Corridor,
}

/// An open door with the areas on its two sides and the line through it.
#[derive(Clone, Copy, Debug)]
struct Passage {
    /// As an index into the world's doors.
    door: usize,
    at: Point,
    width_m: f64,
    /// Across the wall, of unit length, from the first area to the second.
    through: Vector,
    areas: [Area; 2],
}

/// Rooms, doors and regions of a world as the map shows them. Immutable; share it.
#[derive(Clone, Debug)]
pub struct TopologicalModel {
    rooms: Vec<Room>,
    passages: Vec<Passage>,
    closed_doors: Vec<String>,
    regions: Vec<Region>,
}

impl TopologicalModel {
    /// Takes rooms, regions and the doors that are open in the map.
    pub fn new(world: &World) -> Self {
        let mut model = Self {
            rooms: world.rooms.clone(),
            passages: Vec::new(),
            closed_doors: Vec::new(),
            regions: world.regions.clone(),
        };
        for (index, door) in world.doors.iter().enumerate() {
            if door.mapped_open {
                let passage = model.passage(index, door);
                model.passages.push(passage);
            } else {
                model.closed_doors.push(door.room.clone());
            }
        }
        model
    }

    /// The plan from a pose to a place. Doors found closed, given as indices into the world's doors,
    /// are gone through only if there is no other way. `Unreachable` if no chain of open doors joins
    /// them, or if the map leaves no way between two of its targets. Cost: a value field for each
    /// target.
    pub fn plan(
        &self,
        planner: &PlannerModel,
        start_in_map: Pose,
        destination: &Place,
        closed_doors: &[usize],
    ) -> Result<NavigationPlan, Unreachable> {
        let goal = Target::at(destination.pose_in_map);
        let start = start_in_map.point();
        let (from, to) = (self.area_at(start), self.area_at(goal.point_in_map));
        let chain = self
            .chain(start, from, goal.point_in_map, to, closed_doors)
            .or_else(|| self.chain(start, from, goal.point_in_map, to, &[]))
            .ok_or_else(|| self.no_chain(to))?;
        let beside_doors = |passage: &Passage| [-1.0, 1.0].map(|side| clear_point_on_axis(planner, passage, side));
        let mut points: Vec<Point> = chain.iter().flat_map(beside_doors).collect();
        points.push(goal.point_in_map);
        merge_near_points(&mut points);
        drop_passed(planner, &mut points, start);
        let points = self.joined(planner, start, &points, destination)?;
        let regions = self.regions_along(start, &points);
        let (_, through) = points.split_last().unwrap_or((&goal.point_in_map, &[]));
        let mut targets: Vec<Target> = through.iter().copied().map(Target::through).collect();
        targets.push(goal);
        Ok(NavigationPlan { targets, regions })
    }

    /// The region around a point: of several the one with the stricter mode.
    pub fn region_at(&self, point_in_map: Point) -> Option<Region> {
        let around = self.regions.iter().filter(|region| region.rect.contains(point_in_map));
        around.copied().reduce(|best, region| if region.mode > best.mode { region } else { best })
    }

    /// A doorway is of the corridor if it leads there, else of the room on this side.
    fn area_at(&self, point_in_map: Point) -> Area {
        let room = self.rooms.iter().position(|room| room.rect.contains(point_in_map));
        let between_rooms = || {
            let passages = self.passages.iter().filter(|passage| !passage.areas.contains(&Area::Corridor));
            passages.filter_map(|passage| passage.side_of(point_in_map)).next()
        };
        room.map(Area::Room).or_else(between_rooms).unwrap_or(Area::Corridor)
    }

    fn passage(&self, index: usize, door: &Door) -> Passage {
        let normal = match door.axis {
            Axis::X => Vector::new(0.0, 1.0),
            Axis::Y => Vector::new(1.0, 0.0),
        };
        let areas = [-1.0, 1.0].map(|side| self.area_at(door.at + normal * (side * DOOR_APPROACH_M * 0.5)));
        Passage { door: index, at: door.at, width_m: door.width_m, through: normal, areas }
    }

    fn no_chain(&self, to: Area) -> Unreachable {
        let reason = match to {
            Area::Room(room) => {
                let name = &self.rooms[room].name;
                if self.closed_doors.contains(name) {
                    format!("the map shows no open door to room {name}")
                } else {
                    format!("no door of room {name} is joined to where the robot is")
                }
            }
            Area::Corridor => "no open door leads out of the room the robot is in".to_owned(),
        };
        Unreachable { reason }
    }

    /// The doors to go through, each with the direction: the shortest chain by the distances of the
    /// doors from each other, and what each door costs.
    fn chain(&self, start: Point, from: Area, goal: Point, to: Area, closed_doors: &[usize]) -> Option<Vec<Passage>> {
        if from == to {
            return Some(Vec::new());
        }
        // A node is a door in one of its two directions; few doors, so the nearest open node is
        // searched for linearly.
        let open = self.passages.iter().filter(|passage| !closed_doors.contains(&passage.door));
        let nodes: Vec<Passage> = open.flat_map(|&passage| [passage, passage.reversed()]).collect();
        let mut length_m: Vec<f64> = nodes
            .iter()
            .map(|node| if node.areas[0] == from { distance_m(start, node.at) } else { f64::INFINITY })
            .collect();
        let mut before: Vec<Option<usize>> = vec![None; nodes.len()];
        let mut closed = vec![false; nodes.len()];
        let mut best: Option<(f64, usize)> = None;
        while let Some(node) = nearest_open(&length_m, &closed) {
            closed[node] = true;
            if nodes[node].areas[1] == to {
                let whole_m = length_m[node] + distance_m(nodes[node].at, goal);
                if best.is_none_or(|(least_m, _)| whole_m < least_m) {
                    best = Some((whole_m, node));
                }
            }
            for next in 0..nodes.len() {
                let through_m = length_m[node] + distance_m(nodes[node].at, nodes[next].at) + DOOR_COSTS_M;
                if nodes[next].areas[0] == nodes[node].areas[1] && through_m < length_m[next] {
                    length_m[next] = through_m;
                    before[next] = Some(node);
                }
            }
        }
        let mut chain = Vec::new();
        let mut node = Some(best?.1);
        while let Some(index) = node {
            chain.push(nodes[index]);
            node = before[index];
        }
        chain.reverse();
        Some(chain)
    }

    /// The points, and between two of them points on the centre line of the corridor wherever the
    /// shortest way leads through an office of others.
    fn joined(
        &self,
        planner: &PlannerModel,
        start: Point,
        points: &[Point],
        destination: &Place,
    ) -> Result<Vec<Point>, Unreachable> {
        let mut joined = Vec::new();
        let mut from = start;
        for &to in points {
            let path = if planner.is_straight_way_free(from, to) {
                vec![from, to]
            } else {
                planner.value_field(to).path(from).ok_or_else(|| no_way(from, to, destination))?
            };
            if self.leads_through_others(&path) {
                let ends = [from, to].map(|end| self.hallway_at(end).map(|hallway| on_centre_line(&hallway, end)));
                joined.extend(ends.into_iter().flatten().filter(|&point| has_clearance(planner, point)));
            }
            joined.push(to);
            from = to;
        }
        Ok(joined)
    }

    /// Whether a way crosses rooms other than those of its two ends.
    fn leads_through_others(&self, path: &[Point]) -> bool {
        const GRAIN_M: f64 = 0.2;
        let [first, .., last] = path else { return false };
        let ends = [Area::Corridor, self.area_at(*first), self.area_at(*last)];
        path.windows(2).any(|leg| {
            let steps = libm::ceil(distance_m(leg[0], leg[1]) / GRAIN_M).max(1.0) as usize;
            let along = |step: usize| leg[0] + (leg[1] - leg[0]) * (step as f64 / steps as f64);
            (0..=steps).any(|step| !ends.contains(&self.area_at(along(step))))
        })
    }

    fn hallway_at(&self, point_in_map: Point) -> Option<Rect> {
        let hallways = self.regions.iter().filter(|region| region.mode == TravelMode::Hallway);
        hallways.map(|region| region.rect).find(|rect| rect.contains(point_in_map))
    }

    fn regions_along(&self, start: Point, points: &[Point]) -> Vec<Region> {
        const GRAIN_M: f64 = 0.05;
        let mut regions: Vec<Region> = Vec::new();
        let mut from = start;
        for &to in points {
            let steps = libm::ceil(distance_m(from, to) / GRAIN_M).max(1.0) as usize;
            for step in 0..=steps {
                let share = step as f64 / steps as f64;
                if let Some(region) = self.region_at(from + (to - from) * share)
                    && !regions.contains(&region)
                {
                    regions.push(region);
                }
            }
            from = to;
        }
        regions
    }
}

impl Passage {
    fn reversed(self) -> Self {
        Self { through: -self.through, areas: [self.areas[1], self.areas[0]], ..self }
    }

    /// The area on the side of the leaf on which a point in the doorway lies.
    fn side_of(&self, point_in_map: Point) -> Option<Area> {
        let offset = point_in_map - self.at;
        let (across_m, along_m) =
            (offset.dot(&self.through), offset.dot(&Vector::new(-self.through.y, self.through.x)));
        let is_inside = across_m.abs() <= DOOR_APPROACH_M * 0.5 && along_m.abs() <= self.width_m / 2.0;
        is_inside.then(|| self.areas[usize::from(across_m > 0.0)])
    }
}

fn nearest_open(length_m: &[f64], closed: &[bool]) -> Option<usize> {
    let mut nearest: Option<usize> = None;
    for node in 0..length_m.len() {
        if !closed[node] && length_m[node].is_finite() && nearest.is_none_or(|best| length_m[node] < length_m[best]) {
            nearest = Some(node);
        }
    }
    nearest
}

fn has_clearance(planner: &PlannerModel, point_in_map: Point) -> bool {
    const ROOM_TO_TURN_M: f64 = 0.35;
    planner.is_traversable(point_in_map) && planner.obstacle_distance_m(point_in_map) >= ROOM_TO_TURN_M
}

/// The point on the line through a door at the usual distance, or as near to that as furniture
/// allows.
fn clear_point_on_axis(planner: &PlannerModel, passage: &Passage, side: f64) -> Point {
    let at = |away_m: f64| passage.at + passage.through * (side * away_m);
    let shifts_m = (0..=10).flat_map(|step| [f64::from(step), -f64::from(step)]).map(|step| step * 0.05);
    shifts_m
        .map(|shift_m| at(DOOR_APPROACH_M + shift_m))
        .find(|&point| has_clearance(planner, point) && planner.is_straight_way_free(passage.at, point))
        .unwrap_or_else(|| at(DOOR_APPROACH_M))
}

/// The foot of a point on the long middle axis of a corridor.
fn on_centre_line(corridor: &Rect, point: Point) -> Point {
    let (centre, size) = (corridor.centre(), corridor.max - corridor.min);
    if size.x >= size.y { Point::new(point.x, centre.y) } else { Point::new(centre.x, point.y) }
}

/// Of two consecutive points that are nearly one, the later stays: it is the door's or the
/// destination.
fn merge_near_points(points: &mut Vec<Point>) {
    let mut index = 0;
    while index + 1 < points.len() {
        if distance_m(points[index], points[index + 1]) < SAME_TARGET_M {
            points.remove(index);
        } else {
            index += 1;
        }
    }
}

/// Whether a robot at `here` has `point` behind it on its way to `next`, and the rest of that way
/// lies straight ahead.
pub(super) fn is_passed(planner: &PlannerModel, here: Point, point: Point, next: Point) -> bool {
    let way = next - point;
    let length_m = way.norm();
    if length_m < 1e-9 {
        return true;
    }
    let along_m = (here - point).dot(&way) / length_m;
    let aside_m = (here - point).perp(&way).abs() / length_m;
    let is_beside = along_m > 0.0 && along_m <= length_m && aside_m < PASSING_WIDTH_M;
    is_beside && planner.is_straight_way_free(here, next)
}

fn drop_passed(planner: &PlannerModel, points: &mut Vec<Point>, here: Point) {
    let last_passed = points.windows(2).rposition(|pair| is_passed(planner, here, pair[0], pair[1]));
    if let Some(index) = last_passed {
        points.drain(..=index);
    }
}

fn no_way(from: Point, to: Point, destination: &Place) -> Unreachable {
    let reason = format!(
        "the map leaves no way from ({:.2}, {:.2}) to ({:.2}, {:.2}) on the way to {}",
        from.x, from.y, to.x, to.y, destination.name
    );
    Unreachable { reason }
}
