//! Arenas: offices of the kind of the Office Delivery event, drawn from a seed, with a list of instructions
//! and the truth about both.
//!
//! Hallways of 2 to 2.5 m in a grid, some of them missing or ending blind; rooms along them with doors of
//! 0.9 to 1 m, open or closed; foyers; a start room and a goal room; boxes and people. The list leads from
//! one room to the other, and may contain an error (Gutierrez-Osuna and Luo, first page). An arena is a
//! function of its seed and its settings, and its text is a world file like any other.
//!
//! Lengths are whole millimetres inside, so that the text says exactly what the truth says.
//!
//! Read in this order: `hallway` (the truth about a hallway's sides), `floor_plan` (hallways, rooms and
//! walls, with `bands` and `blocks`), `route` and `fault` (instructions), `furniture`, `text`;
//! `topological` (the complete map).

mod area;
mod bands;
mod blocks;
mod fault;
mod floor_plan;
mod furniture;
mod hallway;
mod interval;
mod route;
mod settings;
mod single_hallway;
#[cfg(test)]
mod tests;
mod text;
mod topological;
mod walls;

pub use fault::{Fault, FaultKind, Finding};
pub use hallway::{Hallway, LeadsTo, SideFeature};
pub use interval::Millimetres;
pub use route::Standpoint;
pub use settings::{ARENAS, ArenaSettings};
pub use single_hallway::SingleHallway;

use crate::instruction::Instruction;
use floor_plan::FloorPlan;
use furniture::{Furniture, Start};
use route::Route;
use rpl_random::Stream;
use rpl_robot::geometry::Pose;
use rpl_robot::world::{Rect, World};
use text::Titles;

/// An office and how to find a room in it, with the truth about it.
#[derive(Clone, Debug, PartialEq)]
pub struct Arena {
    /// The world file.
    pub text: String,
    /// The same, read.
    pub world: World,
    /// What the robot is told: from the start room into the goal room, but for the fault.
    pub instructions: Vec<Instruction>,
    /// What is wrong with that, if anything.
    pub fault: Option<Fault>,
    /// The hallways, each with all that is on its sides.
    pub hallways: Vec<Hallway>,
    /// Where who does as told, without the fault, begins with each instruction after the leaving.
    pub standpoints: Vec<Standpoint>,
    /// The floor of the room the robot starts in.
    pub start_room: Rect,
    /// The floor of the room it is to find.
    pub goal_room: Rect,
}

impl Arena {
    /// The arena of a seed. Cost: about a millisecond.
    pub fn draw(seed: u64, settings: &ArenaSettings) -> Self {
        let (plan, route) = plan_and_route(seed, settings);
        Self::of(seed, settings, &plan, route, None)
    }

    /// The same arena with an error in its instructions.
    pub fn draw_with_fault(seed: u64, settings: &ArenaSettings) -> Self {
        let (plan, route) = plan_and_route(seed, settings);
        let fault = Fault::draw(&mut Stream::new(seed, "arena fault"), &plan, &route);
        Self::of(seed, settings, &plan, route, Some(fault))
    }

    fn of(seed: u64, settings: &ArenaSettings, plan: &FloorPlan, route: Route, fault: Option<Fault>) -> Self {
        let mut instructions = route.instructions.clone();
        if let Some(fault) = &fault {
            instructions[fault.number - 1] = fault.given;
        }
        let start = Start::Room(route.start_room);
        let furniture = Furniture::draw(&mut Stream::new(seed, "arena furniture"), plan, start, settings);
        let head = head(seed, &instructions);
        let titles = Titles {
            name: "arena",
            head: &head,
            named: &[(route.start_room, "start"), (route.goal_room, "goal")],
            people: settings.people,
        };
        let text = text::write(plan, &furniture, &titles);
        Self {
            start_room: plan.floor(route.start_room),
            goal_room: plan.floor(route.goal_room),
            standpoints: route.standpoints,
            hallways: plan.hallways.clone(),
            world: read(&text),
            text,
            instructions,
            fault,
        }
    }

    /// Whether a robot here has arrived: its middle is on the floor of the goal room.
    pub fn is_goal(&self, robot_in_map: Pose) -> bool {
        self.goal_room.contains(robot_in_map.point())
    }

    /// What the robot is told, as the event writes it.
    pub fn told(&self) -> String {
        told(&self.instructions)
    }

    /// The list without its error.
    pub fn right_instructions(&self) -> Vec<Instruction> {
        let mut right = self.instructions.clone();
        if let Some(fault) = &self.fault {
            right[fault.number - 1] = fault.right;
        }
        right
    }
}

fn plan_and_route(seed: u64, settings: &ArenaSettings) -> (FloorPlan, Route) {
    let mut layout = Stream::new(seed, "arena layout");
    let mut way = Stream::new(seed, "arena route");
    // Most floor plans have a route of the length that was drawn.
    loop {
        let plan = FloorPlan::draw(&mut layout, settings.walls_mm);
        if let Some(route) = Route::draw(&mut way, &plan) {
            return (plan, route);
        }
    }
}

/// The comments at the head of an arena.
fn head(seed: u64, instructions: &[Instruction]) -> Vec<String> {
    vec![
        format!("An office of the kind of the Office Delivery event, drawn from seed {seed}."),
        format!("The way from the room `start` into the room `goal`: {}.", told(instructions)),
    ]
}

fn told(instructions: &[Instruction]) -> String {
    let told: Vec<String> = instructions.iter().map(Instruction::to_string).collect();
    told.join(", ")
}

/// The world that a text describes.
fn read(text: &str) -> World {
    match World::parse(text, "arena.toml") {
        Ok(world) => world,
        Err(faults) => unreachable!("an arena is a world without faults: {faults}"),
    }
}
