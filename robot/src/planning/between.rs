//! What keeps two points of a map apart: doors that are closed or too narrow, things that stand in
//! the way, rooms without a way out.

use super::areas::Area;
use super::cost_to_go::TARGET_REACH_M;
use super::gap::{Gap, gap_between, needed_m};
use super::passage::DOOR_APPROACH_M;
use super::planner::PlannerModel;
use super::topological::TopologicalModel;
use super::way::ESCAPE_REACH_M;
use crate::geometry::Point;
use crate::world::{Door, Outline, Solid, SolidOrigin, is_same_name};

/// More causes than this are not told.
const MOST_CAUSES: usize = 3;

/// A thing is in the way if there is floor of both sides so near to it, beyond the robot's radius.
const BESIDE_M: f64 = 0.25;

/// Areas, by whether they belong to a part of the floor that hangs together.
pub(super) struct FloorPart(Vec<bool>);

/// What keeps the robot from going through a door.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shut {
    /// The map shows it closed.
    Closed,
    /// A thing in the map stands before it.
    Blocked(SolidOrigin),
    /// There is no floor on one of its sides.
    Nowhere,
    /// The robot does not fit.
    Narrow,
}

impl TopologicalModel {
    /// Why the map leaves no way between two points, in words. Cost: areas, and cells around doors
    /// and things.
    pub fn what_is_between(&self, planner: &PlannerModel, start: Point, goal: Point) -> String {
        let Some(to) = self.areas.near(planner, goal, TARGET_REACH_M) else {
            return format!("at {} {}", shown(goal), self.why_no_room(planner, goal));
        };
        let Some(from) = self.areas.near(planner, start, ESCAPE_REACH_M) else {
            let why = self.why_no_room(planner, start);
            return format!("at {}, where the robot takes itself to be, {why}", shown(start));
        };
        let (here, there) = (self.part(from), self.part(to));
        if self.is_in(&here, to) {
            return format!("something that has been seen, and is not in the map, lies before {}", shown(goal));
        }
        let cause = self.what_parts(planner, &here, &there);
        let shut = || self.shut_room(to, &there).or_else(|| self.shut_room(from, &here));
        let gap = || {
            let Gap { at, width_m } = gap_between(planner, &self.world, start, goal)?;
            let needed_m = needed_m(planner.robot_radius_m());
            Some(format!("the gap at {} is {width_m:.2} m wide, and the robot needs {needed_m:.2} m", shown(at)))
        };
        cause.or_else(gap).or_else(shut).unwrap_or_else(|| {
            format!("walls, or floor the map does not know, lie between {} and {}", shown(start), shown(goal))
        })
    }

    /// The doors, else the things, between two parts of the floor.
    pub(super) fn what_parts(&self, planner: &PlannerModel, here: &FloorPart, there: &FloorPart) -> Option<String> {
        let mut causes = self.shut_doors(planner, here, there);
        if causes.is_empty() {
            causes = self.things_between(planner, here, there);
        }
        causes.truncate(MOST_CAUSES);
        (!causes.is_empty()).then(|| causes.join(", and "))
    }

    /// Why the robot does not fit at a point: "the robot does not fit: ...".
    pub(super) fn why_no_room(&self, planner: &PlannerModel, at: Point) -> String {
        let bounds = self.world.bounds();
        if !bounds.contains(at) {
            let (min, max) = (shown(bounds.min), shown(bounds.max));
            return format!("there is no floor: the world reaches from {min} to {max}");
        }
        let solids = self.world.solids();
        let mapped: Vec<&Solid> = solids.iter().filter(|solid| self.world.is_mapped(solid.origin)).collect();
        let to_edge_m = [at.x - bounds.min.x, at.y - bounds.min.y, bounds.max.x - at.x, bounds.max.y - at.y];
        let to_edge_m = to_edge_m.into_iter().fold(f64::INFINITY, f64::min);
        let away = |solid: &&&Solid| solid.outline.distance_m(at);
        let solid = mapped.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        let to_solid_m = solid.map_or(f64::INFINITY, |solid| away(&solid));
        let to_unknown_m = self.to_unknown_m(planner, &mapped, at, to_solid_m.min(to_edge_m));
        let (what, away_m) = match solid {
            Some(solid) if to_solid_m == 0.0 => {
                return format!("the robot does not fit: that is inside {}", self.world.called(solid.origin));
            }
            Some(solid) if to_solid_m <= to_edge_m && to_unknown_m.is_none() => {
                (self.world.called(solid.origin), to_solid_m)
            }
            Some(_) | None => match to_unknown_m {
                Some(0.0) => return "the map knows no floor".to_owned(),
                Some(away_m) => ("floor that the map does not know".to_owned(), away_m),
                None => ("the edge of the world".to_owned(), to_edge_m),
            },
        };
        let radius_m = planner.robot_radius_m();
        format!("the robot does not fit: {what} is {away_m:.2} m away, and the robot's radius is {radius_m} m")
    }

    /// How far it is to floor the map does not know, if that is nearer than `least_m`.
    fn to_unknown_m(&self, planner: &PlannerModel, mapped: &[&Solid], at: Point, least_m: f64) -> Option<f64> {
        let grid = &planner.grid;
        let half_m = grid.resolution_m / 2.0;
        let off_m = |cell: usize| (at - grid.centre(cell)).abs().map(|off_m| (off_m - half_m).max(0.0)).norm();
        let reach_m = least_m.min(planner.robot_radius_m() + TARGET_REACH_M);
        let is_bare = |cell: usize| {
            let centre = grid.centre(cell);
            mapped.iter().all(|solid| solid.outline.distance_m(centre) > half_m * std::f64::consts::SQRT_2)
        };
        let mut near: Vec<(f64, usize)> = grid
            .square(at, reach_m + grid.resolution_m)
            .filter(|&cell| grid.is_obstacle[cell])
            .map(|cell| (off_m(cell), cell))
            .filter(|&(away_m, _)| away_m < reach_m)
            .collect();
        near.sort_by(|one, other| one.0.total_cmp(&other.0));
        near.into_iter().find(|&(_, cell)| is_bare(cell)).map(|(away_m, _)| away_m)
    }

    /// All that can be got to from an area.
    pub(super) fn part(&self, from: Area) -> FloorPart {
        let mut part = FloorPart(vec![false; self.areas.count()]);
        let mut beside: Vec<Vec<Area>> = vec![Vec::new(); self.areas.count()];
        for passage in &self.passages {
            let [one, other] = passage.areas;
            beside[self.areas.index(one)].push(other);
            beside[self.areas.index(other)].push(one);
        }
        let mut open = vec![from];
        while let Some(area) = open.pop() {
            if !std::mem::replace(&mut part.0[self.areas.index(area)], true) {
                open.extend(&beside[self.areas.index(area)]);
            }
        }
        part
    }

    pub(super) fn is_in(&self, part: &FloorPart, area: Area) -> bool {
        part.0[self.areas.index(area)]
    }

    fn joins(&self, one: &[Area], other: &[Area], here: &FloorPart, there: &FloorPart) -> bool {
        let has = |areas: &[Area], part: &FloorPart| areas.iter().any(|&area| self.is_in(part, area));
        has(one, here) && has(other, there) || has(one, there) && has(other, here)
    }

    /// The areas on the two sides of a door.
    pub(super) fn sides(&self, planner: &PlannerModel, door: &Door) -> [Vec<Area>; 2] {
        [-1.0, 1.0].map(|side| {
            let beside = door.at + door.through() * (side * DOOR_APPROACH_M);
            self.areas.around(planner, &Outline::Disc { centre: beside, radius_m: 0.0 }, DOOR_APPROACH_M - 0.2)
        })
    }

    /// Whether the map leaves a way through a door.
    pub(super) fn is_passable(&self, door: usize) -> bool {
        self.passages.iter().any(|passage| passage.door == Some(door))
    }

    /// The doors between two parts that the map leaves no way through.
    fn shut_doors(&self, planner: &PlannerModel, here: &FloorPart, there: &FloorPart) -> Vec<String> {
        let doors = self.world.doors.iter().enumerate().filter(|(index, _)| !self.is_passable(*index));
        let between = doors.filter(|(_, door)| {
            let [one, other] = self.sides(planner, door);
            self.joins(&one, &other, here, there)
        });
        between.map(|(_, door)| self.why_shut(planner, door)).collect()
    }

    /// What keeps the robot from going through a door that is not passable.
    pub(super) fn shut(&self, planner: &PlannerModel, door: &Door) -> Shut {
        if !door.mapped_open {
            return Shut::Closed;
        }
        let things = self.world.solids().into_iter().filter(|solid| matches!(solid.origin, SolidOrigin::Object(_)));
        let mut before = things.filter(|thing| thing.outline.distance_m(door.at) < DOOR_APPROACH_M);
        match before.find(|thing| self.world.is_mapped(thing.origin)) {
            Some(thing) => Shut::Blocked(thing.origin),
            None if self.sides(planner, door).iter().any(Vec::is_empty) => Shut::Nowhere,
            None => Shut::Narrow,
        }
    }

    /// The same in words.
    pub(super) fn why_shut(&self, planner: &PlannerModel, door: &Door) -> String {
        let named = format!("the door of room `{}` at {}", door.room, shown(door.at));
        match self.shut(planner, door) {
            Shut::Closed => format!("{named} is closed in the map"),
            Shut::Blocked(thing) => format!("{} stands before {named}", self.world.called(thing)),
            Shut::Nowhere => {
                format!("{named} leads nowhere: on one of its sides there is no floor the robot fits on")
            }
            Shut::Narrow => format!(
                "{named} is {:.2} m wide, too narrow for the robot, which needs {:.2} m",
                door.width_m,
                needed_m(planner.robot_radius_m())
            ),
        }
    }

    /// The things in the map with floor of both parts beside them.
    fn things_between(&self, planner: &PlannerModel, here: &FloorPart, there: &FloorPart) -> Vec<String> {
        let solids = self.world.solids();
        let things = solids
            .iter()
            .filter(|solid| matches!(solid.origin, SolidOrigin::Object(_)) && self.world.is_mapped(solid.origin));
        let between = things.filter(|thing| {
            let beside = self.areas.around(planner, &thing.outline, planner.robot_radius_m() + BESIDE_M);
            self.joins(&beside, &beside, here, there)
        });
        between.map(|thing| format!("{} stands in the way", self.world.called(thing.origin))).collect()
    }

    /// A room that nothing leads out of, seen from one of its areas.
    fn shut_room(&self, area: Area, part: &FloorPart) -> Option<String> {
        let room = self.areas.room(area)?;
        let leads_out = self.areas.all().any(|other| self.is_in(part, other) && self.areas.room(other) != Some(room));
        if leads_out {
            return None;
        }
        let name = &self.world.rooms[room].name;
        let has_door = self.world.doors.iter().any(|door| is_same_name(&door.room, name));
        Some(match has_door {
            true => format!("no way leads out of room `{name}`"),
            false => format!("room `{name}` has no door, and its walls leave no opening for the robot"),
        })
    }
}

/// A point as it is told.
pub(super) fn shown(point: Point) -> String {
    format!("({:.2}, {:.2})", point.x, point.y)
}
