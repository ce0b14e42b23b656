//! What of a world the robot cannot get to from its start, by its map: places, rooms, doors, things.

use super::between::{FloorPart, Shut, shown};
use super::cost_to_go::TARGET_REACH_M;
use super::open_edge::OpenEdge;
use super::planner::PlannerModel;
use super::topological::TopologicalModel;
use super::way::ESCAPE_REACH_M;
use crate::file_text::Finding;
use crate::world::{Door, Outline, Room, SolidOrigin, is_same_name};

/// A room of which less can be got to is told.
const LEAST_SHARE: f64 = 0.5;

/// A recorded map of which less can be got to is told.
const LEAST_SHARE_OF_MAP: f64 = 0.9;

/// What is probably not meant as it stands in a world file, and where it stands there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Concern {
    /// The table, such as "place", and its number among those of its kind; none at the top.
    pub table: Option<(&'static str, usize)>,
    /// The key in it.
    pub key: &'static str,
    /// What was found.
    pub message: String,
    /// What to do.
    pub help: &'static str,
}

impl Concern {
    /// With its place in the text of the world file.
    pub fn in_file(&self, file: &str, text: &str) -> Finding {
        Finding::in_toml(file, text, self.table, self.key, &self.message, self.help)
    }
}

fn concern(table: &'static str, index: usize, key: &'static str, message: String, help: &'static str) -> Concern {
    Concern { table: Some((table, index)), key, message, help }
}

impl TopologicalModel {
    /// Everything that is probably not meant, in the order of tables. The gripper, if there is one, reaches
    /// so far.
    /// Cost: areas, and cells around doors and things, for each place.
    pub fn survey(&self, planner: &PlannerModel, gripper_reach_m: Option<f64>) -> Vec<Concern> {
        let start = self.world.start_in_map.point();
        let Some(from) = self.areas.near(planner, start, ESCAPE_REACH_M) else {
            let message = format!("at the start {} {}", shown(start), self.why_no_room(planner, start));
            let help = "put it where the map is free";
            return vec![Concern { table: None, key: "start", message, help }];
        };
        let here = self.part(from);
        let mut found: Vec<Concern> = self.concern_of_map(&here).into_iter().collect();
        found.extend(self.concern_of_edge(planner));
        found.extend(self.world.rooms.iter().enumerate().filter_map(|(index, room)| {
            let message = self.concern_of_room(planner, &here, index, room)?;
            Some(concern("room", index, "rect", message, "a room is entered through a [[door]] or a gap in its walls"))
        }));
        found.extend(self.world.doors.iter().enumerate().filter_map(|(index, door)| {
            let (key, message) = self.concern_of_door(planner, index, door)?;
            Some(concern(
                "door",
                index,
                key,
                message,
                "a door stands between two pieces of floor, and lets the robot through",
            ))
        }));
        found.extend(self.concerns_of_places(planner, &here));
        if let Some(reach_m) = gripper_reach_m {
            found.extend(self.concerns_of_items(planner, &here, reach_m));
        }
        found.extend(self.concerns_of_people());
        found
    }

    /// Where walls were recorded, little is shut off on purpose.
    fn concern_of_map(&self, here: &FloorPart) -> Option<Concern> {
        self.world.recorded.as_ref()?;
        let cells = |counts: &dyn Fn(super::areas::Area) -> bool| -> usize {
            self.areas.all().filter(|&area| counts(area)).map(|area| self.areas.cells(area)).sum()
        };
        let (reached, all) = (cells(&|area| self.is_in(here, area)), cells(&|_| true));
        let share = reached as f64 / all as f64;
        (share < LEAST_SHARE_OF_MAP).then(|| Concern {
            table: None,
            key: "start",
            message: format!(
                "from the start {} the robot gets to {:.0} % of the floor it fits on",
                shown(self.world.start_in_map.point()),
                100.0 * share
            ),
            help: "look at the map with `--png FILE`: the start may be outside, or walls may be where doors are",
        })
    }

    /// Nothing tells the robot where it is along an edge without a wall.
    fn concern_of_edge(&self, planner: &PlannerModel) -> Option<Concern> {
        let edges = planner.open_edges();
        let longest = edges.iter().max_by(|one, other| one.length_m().total_cmp(&other.length_m()))?;
        let all_m: f64 = edges.iter().map(OpenEdge::length_m).sum();
        let [from, to] = longest.ends_in_frame.map(shown);
        Some(Concern {
            table: None,
            key: if self.world.recorded.is_some() { "map" } else { "size" },
            message: format!(
                "the world ends in open floor along {all_m:.1} m of its edge, the longest stretch from {from} to {to}: \
                 no sensor finds anything there, and nobody gets beyond it"
            ),
            help: "put a [[wall]] there, unless there is none",
        })
    }

    fn concern_of_room(&self, planner: &PlannerModel, here: &FloorPart, index: usize, room: &Room) -> Option<String> {
        let name = &room.name;
        let areas = || self.areas.all().filter(move |&area| self.areas.room(area) == Some(index));
        let all: usize = areas().map(|area| self.areas.cells(area)).sum();
        let reached: usize = areas().filter(|&area| self.is_in(here, area)).map(|area| self.areas.cells(area)).sum();
        let Some(largest) = areas().filter(|&area| !self.is_in(here, area)).max_by_key(|&area| self.areas.cells(area))
        else {
            return (all == 0).then(|| format!("the robot fits nowhere in room `{name}`"));
        };
        if reached as f64 >= LEAST_SHARE * all as f64 {
            return None;
        }
        let mut doors =
            self.world.doors.iter().enumerate().filter(|(_, door)| is_same_name(&door.room, name)).peekable();
        let has_door = doors.peek().is_some();
        // A closed door is closed on purpose, and one that is too narrow is told of itself.
        if reached == 0 && has_door && doors.all(|(door, _)| !self.is_passable(door)) {
            return None;
        }
        let why = self.what_parts(planner, here, &self.part(largest));
        let why = why.map_or(String::new(), |why| format!(": {why}"));
        Some(match (reached, has_door) {
            (0, false) if why.is_empty() => {
                format!(
                    "nothing leads into room `{name}`: it has no door, and its walls leave no opening for the robot"
                )
            }
            (0, _) => format!("the robot cannot get into room `{name}`{why}"),
            (_, _) => {
                let percent = 100.0 * reached as f64 / all as f64;
                format!("the robot gets to {percent:.0} % of the floor of room `{name}`{why}")
            }
        })
    }

    /// A door that is closed is so on purpose, wherever it leads.
    fn concern_of_door(&self, planner: &PlannerModel, index: usize, door: &Door) -> Option<(&'static str, String)> {
        if self.is_passable(index) {
            return None;
        }
        let key = match self.shut(planner, door) {
            Shut::Closed => return None,
            Shut::Blocked(_) | Shut::Nowhere => "at",
            Shut::Narrow => "width",
        };
        Some((key, self.why_shut(planner, door)))
    }

    fn concerns_of_places(&self, planner: &PlannerModel, here: &FloorPart) -> Vec<Concern> {
        let start = self.world.start_in_map.point();
        let concern_of = |(index, place): (usize, &crate::world::Place)| {
            let at = place.pose_in_map.point();
            let to = self.areas.near(planner, at, TARGET_REACH_M);
            if to.is_none_or(|area| !self.is_in(here, area)) {
                let why = self.what_is_between(planner, start, at);
                let message = format!("the robot cannot get from the start to the place `{}`: {why}", place.name);
                let help = "a place is where the robot stands: put it on free floor that it can get to";
                return Some(concern("place", index, "pose", message, help));
            }
            let radius_m = planner.robot_radius_m();
            let is_on_it =
                |object: &&crate::world::Object| !object.mapped && object.outline().distance_m(at) < radius_m;
            let object = self.world.objects.iter().find(is_on_it)?;
            let message = format!(
                "the object `{}`, which is not in the map, stands where the place `{}` is",
                object.name, place.name
            );
            Some(concern("place", index, "pose", message, "the robot will drive there and be blocked"))
        };
        self.world.places.iter().enumerate().filter_map(concern_of).collect()
    }

    fn concerns_of_items(&self, planner: &PlannerModel, here: &FloorPart, reach_m: f64) -> Vec<Concern> {
        let out_of_reach = |item: &crate::world::Item| {
            let around = Outline::Disc { centre: item.at, radius_m: 0.0 };
            !self.areas.around(planner, &around, reach_m).into_iter().any(|area| self.is_in(here, area))
        };
        let items = self.world.items.iter().enumerate().filter(|(_, item)| out_of_reach(item));
        let told = items.map(|(index, item)| {
            let message = format!(
                "the robot cannot get the item `{}` at {}: from no floor it gets to is that within {reach_m} m",
                item.name,
                shown(item.at)
            );
            concern("item", index, "at", message, "the gripper reaches only a little farther than the robot")
        });
        told.collect()
    }

    fn concerns_of_people(&self) -> Vec<Concern> {
        let walls: Vec<Outline> = self
            .world
            .solids()
            .into_iter()
            .filter(|solid| solid.origin == SolidOrigin::Wall)
            .map(|solid| solid.outline)
            .collect();
        let people = self.world.people.iter().enumerate().filter_map(|(index, person)| {
            let at = person.path.iter().find(|at| walls.iter().any(|wall| wall.contains(**at)))?;
            let message = format!("a person walks to {}, inside a wall", shown(*at));
            Some(concern("person", index, "path", message, "people walk on free floor"))
        });
        people.collect()
    }
}
