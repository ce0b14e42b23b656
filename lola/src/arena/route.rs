//! Routes: from the start room into the goal room, as instructions.

use super::floor_plan::{Doorway, FloorPlan, Opening};
use super::hallway::{Hallway, LeadsTo, SideFeature};
use super::interval::Millimetres;
use super::walls::{overlap, shrunk};
use crate::feature::{Feature, Side};
use crate::instruction::{Instruction, MOST_ORDINAL};
use rpl_random::Stream;
use rpl_robot::world::Axis;

/// Where somebody stands who carries out instructions: in a hallway, from where on openings are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standpoint {
    /// In which hallway.
    pub hallway: usize,
    /// Where along its axis.
    pub at_mm: Millimetres,
    /// Whether looking in the direction of its axis.
    pub forwards: bool,
    /// Whether the end of the hallway was gone to: then what is beside the end is counted, and nothing else.
    pub at_end: bool,
}

/// What an instruction comes to for somebody who counts right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// On to another standpoint.
    To(Standpoint),
    /// Into a room.
    Into(usize),
    /// There are fewer openings than counted, no foyer, or no end that one could not pass.
    NoSuchOpening,
    /// The opening is of another kind: no hallway to turn into, or no open door to enter by.
    AnotherKind(Feature),
}

/// A way from room to room, with what it is called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Route {
    /// The room it begins in, by its number.
    pub start_room: usize,
    /// The room it leads into.
    pub goal_room: usize,
    /// The list, the leaving first.
    pub instructions: Vec<Instruction>,
    /// Where each of the instructions after the leaving begins.
    pub standpoints: Vec<Standpoint>,
}

/// Instructions after the leaving (lola.md).
const INSTRUCTIONS: (usize, usize) = (2, 5);

/// Routes that are tried in a floor plan.
const TRIES: usize = 100;

/// What lies across from the start door, or beside the far end of a foyer, must be so far off: whether it is
/// behind or ahead would be a matter of taste.
const UNDOUBTED_MM: Millimetres = 900;

/// An opening is beside the end of a hallway if no more wall than this is between them.
const BESIDE_END_MM: Millimetres = 300;

impl Route {
    /// A route with two to five instructions after the leaving; none if none was found.
    pub fn draw(stream: &mut Stream, plan: &FloorPlan) -> Option<Self> {
        let (least, most) = INSTRUCTIONS;
        let count = least + stream.index(most - least + 1);
        (0..TRIES).find_map(|_| Self::attempt(stream, plan, count))
    }

    fn attempt(stream: &mut Stream, plan: &FloorPlan, count: usize) -> Option<Self> {
        let start_room = stream.index(plan.rooms.len());
        let Opening::Door(door) = plan.rooms[start_room].opening else { return None };
        if !door.open || !is_clear_across(plan, &door) {
            return None;
        }
        let side = Side::ALL[stream.index(2)];
        let mut route = Self {
            start_room,
            goal_room: start_room,
            instructions: vec![Instruction::Leave(side)],
            standpoints: vec![],
        };
        let mut at = left(plan, &door, side);
        while route.instructions.len() < count {
            let (instruction, next) = chosen(stream, &plan.onward(at, count - route.instructions.len()))?;
            route.instructions.push(instruction);
            route.standpoints.push(at);
            at = next;
        }
        let doors: Vec<(Instruction, usize)> =
            plan.enterable(at).into_iter().filter(|(_, room)| *room != start_room).collect();
        let (instruction, room) = *doors.get(stream.index(doors.len().max(1)))?;
        route.instructions.push(instruction);
        route.standpoints.push(at);
        route.goal_room = room;
        Some(route)
    }
}

/// One of several ways on; hallways and doors are many, so that a foyer and an end are taken more readily.
fn chosen(stream: &mut Stream, ways: &[(Instruction, Standpoint)]) -> Option<(Instruction, Standpoint)> {
    let weight = |instruction: &Instruction| match instruction {
        Instruction::GoPastFoyer | Instruction::GoHallwayEnd => 3,
        Instruction::Leave(_) | Instruction::Turn { .. } | Instruction::Enter { .. } => 2,
    };
    let lots: Vec<(Instruction, Standpoint)> =
        ways.iter().flat_map(|way| std::iter::repeat_n(*way, weight(&way.0))).collect();
    (!lots.is_empty()).then(|| lots[stream.index(lots.len())])
}

/// Nothing on the other side is beside the door.
fn is_clear_across(plan: &FloorPlan, door: &Doorway) -> bool {
    let middle_mm = door.middle_mm();
    let beside_mm = (middle_mm - UNDOUBTED_MM, middle_mm + UNDOUBTED_MM);
    let across = plan.hallways[door.hallway].side(door.side.other());
    !across.iter().any(|found| overlap((found.from_mm, found.to_mm), beside_mm))
}

/// Before the door of a room, having left it to a side.
fn left(plan: &FloorPlan, door: &Doorway, side: Side) -> Standpoint {
    // Who comes out of a door on the left looks to the right of the axis.
    let out = turned(forwards_heading(plan.hallways[door.hallway].axis, true), door.side.other());
    let forwards = is_forwards(turned(out, side));
    Standpoint { hallway: door.hallway, at_mm: door.middle_mm(), forwards, at_end: false }
}

/// East, north, west, south are 0 to 3.
fn forwards_heading(axis: Axis, forwards: bool) -> u8 {
    match (axis, forwards) {
        (Axis::X, true) => 0,
        (Axis::Y, true) => 1,
        (Axis::X, false) => 2,
        (Axis::Y, false) => 3,
    }
}

fn turned(heading: u8, side: Side) -> u8 {
    match side {
        Side::Left => (heading + 1) % 4,
        Side::Right => (heading + 3) % 4,
    }
}

fn is_forwards(heading: u8) -> bool {
    heading < 2
}

impl FloorPlan {
    /// What an instruction comes to.
    pub fn step(&self, at: Standpoint, instruction: Instruction) -> Step {
        match instruction {
            Instruction::Leave(_) => Step::NoSuchOpening,
            Instruction::GoPastFoyer => self.past_foyer(at).map_or(Step::NoSuchOpening, Step::To),
            Instruction::GoHallwayEnd => Step::To(Standpoint { at_end: true, ..at }),
            Instruction::Turn { ordinal, side } => match self.opening(at, side, ordinal) {
                None => Step::NoSuchOpening,
                Some(found) => match found.leads_to {
                    LeadsTo::Hallway(hallway) => Step::To(self.turned_into(at, hallway, side)),
                    LeadsTo::Room(_) => Step::AnotherKind(found.feature),
                },
            },
            Instruction::Enter { ordinal, side } => match self.opening(at, side, ordinal) {
                None => Step::NoSuchOpening,
                Some(SideFeature { feature: Feature::OpenDoor, leads_to: LeadsTo::Room(room), .. }) => Step::Into(room),
                Some(found) => Step::AnotherKind(found.feature),
            },
        }
    }

    /// What is counted on a side from a standpoint on, in order.
    pub fn openings(&self, at: Standpoint, side: Side) -> Vec<SideFeature> {
        let hallway = &self.hallways[at.hallway];
        let is_counted = |found: &SideFeature| Feature::OPENINGS.contains(&found.feature);
        if !at.at_end {
            return hallway.ahead(side, at.at_mm, at.forwards).into_iter().filter(is_counted).collect();
        }
        let end_mm = hallway.end_mm(at.forwards);
        let at_end = |found: &&SideFeature| {
            let far_mm = if at.forwards { found.to_mm } else { found.from_mm };
            found.feature == Feature::Hallway && (end_mm - far_mm).abs() <= BESIDE_END_MM
        };
        hallway.side(Hallway::side_in_map(side, at.forwards)).iter().filter(at_end).copied().collect()
    }

    fn opening(&self, at: Standpoint, side: Side, ordinal: u8) -> Option<SideFeature> {
        self.openings(at, side).get(usize::from(ordinal).checked_sub(1)?).copied()
    }

    /// In a hallway that was turned into.
    fn turned_into(&self, at: Standpoint, hallway: usize, side: Side) -> Standpoint {
        let from = &self.hallways[at.hallway];
        let forwards = is_forwards(turned(forwards_heading(from.axis, at.forwards), side));
        let at_mm = if forwards { from.across_mm.1 } else { from.across_mm.0 };
        Standpoint { hallway, at_mm, forwards, at_end: false }
    }

    /// Beside the far end of the next foyer; none if there is none, or if it cannot be said what is beyond it.
    fn past_foyer(&self, at: Standpoint) -> Option<Standpoint> {
        let hallway = &self.hallways[at.hallway];
        let foyers = Side::ALL.into_iter().flat_map(|side| hallway.ahead(side, at.at_mm, at.forwards));
        let far_mm = |found: SideFeature| if at.forwards { found.to_mm } else { found.from_mm };
        let ends = foyers.filter(|found| found.feature == Feature::Foyer).map(far_mm);
        let at_mm = ends.min_by_key(|end_mm| (end_mm - at.at_mm).abs())?;
        Some(Standpoint { at_mm, ..at })
    }

    /// Whether it is beyond doubt what is ahead of a standpoint.
    fn is_undoubted(&self, at: Standpoint) -> bool {
        let around = shrunk((at.at_mm, at.at_mm), -UNDOUBTED_MM);
        let features = self.hallways[at.hallway].sides.iter().flatten();
        !features
            .into_iter()
            .any(|found| found.feature != Feature::Foyer && overlap((found.from_mm, found.to_mm), around))
    }

    /// The instructions that lead on and not into a room, each with where to; `left` are still to be given.
    fn onward(&self, at: Standpoint, left: usize) -> Vec<(Instruction, Standpoint)> {
        let mut ways = Vec::new();
        for side in Side::ALL {
            let openings = self.openings(at, side);
            for (ordinal, found) in (1..=MOST_ORDINAL).zip(openings) {
                if let LeadsTo::Hallway(hallway) = found.leads_to {
                    ways.push((Instruction::Turn { ordinal, side }, self.turned_into(at, hallway, side)));
                }
            }
        }
        if !at.at_end {
            let foyer = self.past_foyer(at).filter(|at| self.is_undoubted(*at));
            ways.extend(foyer.map(|at| (Instruction::GoPastFoyer, at)));
            let end = Standpoint { at_end: true, ..at };
            let goes_on = Side::ALL.into_iter().any(|side| !self.openings(end, side).is_empty());
            // The end is gone to in order to turn there, and that takes two.
            if goes_on && left > 1 {
                ways.push((Instruction::GoHallwayEnd, end));
            }
        }
        ways
    }

    /// The open doors that can be named from a standpoint, each with its room.
    fn enterable(&self, at: Standpoint) -> Vec<(Instruction, usize)> {
        let doors = Side::ALL.into_iter().flat_map(|side| {
            let openings = (1..=MOST_ORDINAL).zip(self.openings(at, side));
            openings.filter_map(move |(ordinal, found)| match (found.feature, found.leads_to) {
                (Feature::OpenDoor, LeadsTo::Room(room)) => Some((Instruction::Enter { ordinal, side }, room)),
                _ => None,
            })
        });
        doors.collect()
    }
}
