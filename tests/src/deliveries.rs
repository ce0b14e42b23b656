//! Deliveries in arenas with which somebody interferes.

use crate::mission::{Grid, Mission, model};
use rpl_lola::arena::{Arena, Hallway, LeadsTo};
use rpl_lola::feature::{Feature, Side};
use rpl_mission::modules::SiteRobot;
use rpl_robot::geometry::{Point, Pose};
use rpl_robot::office::OfficeSettings;
use rpl_robot::world::{Axis, World};
use rpl_runtime::run::system::System;

/// The robot is beside a door if it is so near to its middle along the hallway.
const BESIDE_M: f64 = 0.1;

/// Who stands before a door stands so far before its wall, and steps so far to and fro.
const BEFORE_M: f64 = 0.45;
const TO_AND_FRO_M: f64 = 0.2;

/// A door that the robot passes in a hallway.
#[derive(Clone, Debug, PartialEq)]
pub struct PassedDoor {
    /// The room behind it.
    pub room: String,
    /// Whether it is open.
    pub is_open: bool,
    /// Where somebody steps to and fro before it.
    pub before_in_map: [Point; 2],
}

/// The delivery of an arena, in the arena or in a world that was made of it.
pub fn delivery(arena: &Arena, world: World) -> Mission {
    let settings = OfficeSettings { map_known: false, ..Grid::Coarse.settings() };
    let told: Vec<String> = arena.instructions.iter().map(ToString::to_string).collect();
    Mission::new(model(world, settings), &format!("(follow-instructions \"{}\")", told.join(", ")))
}

/// How far along a hallway the robot counts openings, if it does.
pub fn counted_along_m(system: &System<SiteRobot>) -> Option<f64> {
    let hallway = system.outside.controller.modules.lola.hallway()?;
    hallway.detection().map(|detection| detection.along_m())
}

/// The door beside a robot that drives along a hallway, on either side, but neither that of the room it comes from
/// nor that of its goal.
pub fn door_beside(arena: &Arena, robot_in_map: Pose) -> Option<PassedDoor> {
    let hallway = arena.hallways.iter().find(|hallway| is_along(hallway, robot_in_map))?;
    let (along_m, _) = in_hallway(hallway.axis, robot_in_map);
    Side::ALL.into_iter().find_map(|side| {
        hallway.side(side).iter().find_map(|feature| {
            let middle_m = feature.middle_mm() as f64 / 1e3;
            let is_door = [Feature::OpenDoor, Feature::ClosedDoor].contains(&feature.feature);
            let LeadsTo::Room(index) = feature.leads_to else { return None };
            let room = format!("room-{}", index + 1);
            let is_known = arena.world.rooms.iter().any(|known| known.name == room);
            ((middle_m - along_m).abs() < BESIDE_M && is_door && is_known).then(|| PassedDoor {
                room,
                is_open: feature.feature == Feature::OpenDoor,
                before_in_map: [-TO_AND_FRO_M, TO_AND_FRO_M].map(|off_m| before(hallway, side, middle_m + off_m)),
            })
        })
    })
}

/// The arena's world with somebody who stands before a door for as long as the run takes.
pub fn with_person_before(arena: &Arena, door: &PassedDoor) -> World {
    let [from, to] = door.before_in_map;
    let text = format!(
        "{}\n[[person]]\npath = [[{:.3}, {:.3}], [{:.3}, {:.3}]]\nspeed = 0.02\n",
        arena.text, from.x, from.y, to.x, to.y
    );
    World::parse(&text, "arena.toml").unwrap_or_else(|faults| panic!("{faults}"))
}

/// Along the axis of a hallway, and across it.
fn in_hallway(axis: Axis, at: Pose) -> (f64, f64) {
    match axis {
        Axis::X => (at.x_m, at.y_m),
        Axis::Y => (at.y_m, at.x_m),
    }
}

fn is_along(hallway: &Hallway, robot_in_map: Pose) -> bool {
    let (along_m, across_m) = in_hallway(hallway.axis, robot_in_map);
    let is_within = |(from_mm, to_mm): (i64, i64), at_m: f64| (from_mm as f64..=to_mm as f64).contains(&(at_m * 1e3));
    let looks_along_x = libm::cos(robot_in_map.heading_rad).abs() > 0.7;
    is_within(hallway.along_mm, along_m)
        && is_within(hallway.across_mm, across_m)
        && looks_along_x == (hallway.axis == Axis::X)
}

/// Before the wall on a side of a hallway. Along x, larger y is left; along y, larger x is right.
fn before(hallway: &Hallway, side: Side, along_m: f64) -> Point {
    let (from_m, to_m) = (hallway.across_mm.0 as f64 / 1e3, hallway.across_mm.1 as f64 / 1e3);
    let is_larger = (side == Side::Left) == (hallway.axis == Axis::X);
    let across_m = if is_larger { to_m - BEFORE_M } else { from_m + BEFORE_M };
    match hallway.axis {
        Axis::X => Point::new(along_m, across_m),
        Axis::Y => Point::new(across_m, along_m),
    }
}
