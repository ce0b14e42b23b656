//! Its fluents.

use super::state::Lola;
use crate::feature::{Percept, Side};
use rpl_robot::office::{Moment, Phase, Telling, continuous, counter, fluent, fluent_number};
use rpl_runtime::robot::FluentSpec;
use rpl_runtime::robot::reading::{Reading, ReadingList};

/// The table.
pub(super) const FLUENTS: &[FluentSpec] = &[
    continuous("hallway-axis*", "The direction of the hallway, in radians in the frame of the odometry, or nil."),
    fluent("hallway-registered?*", "Whether the axis of the hallway is known by its walls."),
    continuous("left-distance*", "From the middle of the robot to the hallway's wall on the left, in metres, or nil."),
    continuous(
        "right-distance*",
        "From the middle of the robot to the hallway's wall on the right, in metres, or nil.",
    ),
    fluent(
        "last-percepts*",
        "What was perceived beside the hallway last, at most five lists (number side kind from to), the newest first.",
    ),
    counter("percept-count*", "How many openings were perceived beside the hallway."),
    fluent("hallway-end?*", "Whether the hallway ends just ahead."),
    continuous(
        "state-set*",
        "The certainty of each node of the instruction: the start, each opening, what lies beyond; or nil.",
    ),
    continuous(
        "instruction-certainty*",
        "The certainty that the goal of the instruction is the percept that is likeliest to be it, or nil.",
    ),
    fluent(
        "doorway*",
        "The doorway the robot came through last: a list (x y heading) in the frame of the odometry, the heading the way it came, or nil.",
    ),
];

const HALLWAY_AXIS: usize = fluent_number(FLUENTS, "hallway-axis*");
const HALLWAY_REGISTERED: usize = fluent_number(FLUENTS, "hallway-registered?*");
const LEFT_DISTANCE: usize = fluent_number(FLUENTS, "left-distance*");
const RIGHT_DISTANCE: usize = fluent_number(FLUENTS, "right-distance*");
const LAST_PERCEPTS: usize = fluent_number(FLUENTS, "last-percepts*");
const PERCEPT_COUNT: usize = fluent_number(FLUENTS, "percept-count*");
const HALLWAY_END: usize = fluent_number(FLUENTS, "hallway-end?*");
const STATE_SET: usize = fluent_number(FLUENTS, "state-set*");
const INSTRUCTION_CERTAINTY: usize = fluent_number(FLUENTS, "instruction-certainty*");
const DOORWAY: usize = fluent_number(FLUENTS, "doorway*");

/// How many percepts are told, the last ones.
const LAST: usize = 5;

impl Lola {
    /// Tells plans how things stand, if there is anything new.
    pub(super) fn tell(&mut self, now: &Moment<'_>, tell: &mut Telling<'_>) {
        let is_at_work = now.phases.contains(&Phase::Active);
        if !std::mem::take(&mut self.has_news) && !is_at_work {
            return;
        }
        let hallway = self.hallway.as_ref();
        let here = now.percept.odometry_in_odom;
        let wall = |side: Side| number(hallway.and_then(|hallway| hallway.wall_distance_m(here, side)));
        let percepts = hallway.map_or(&[][..], |hallway| &hallway.percepts);
        tell.fluent(
            HALLWAY_AXIS,
            number(hallway.and_then(|hallway| hallway.axis()).map(|axis| axis.heading_in_odom_rad)),
        );
        tell.fluent(HALLWAY_REGISTERED, Reading::Truth(hallway.is_some_and(|hallway| hallway.axis().is_some())));
        tell.fluent(LEFT_DISTANCE, wall(Side::Left));
        tell.fluent(RIGHT_DISTANCE, wall(Side::Right));
        tell.fluent(LAST_PERCEPTS, list(percepts.iter().rev().take(LAST).map(percept).collect()));
        tell.fluent(PERCEPT_COUNT, Reading::Int(percepts.len() as i64));
        tell.fluent(HALLWAY_END, Reading::Truth(hallway.is_some_and(|hallway| hallway.is_at_end())));
        let state_set = self.counting.as_ref().map(|counting| &counting.state_set);
        let certainties = state_set.map_or(Vec::new(), |state_set| state_set.certainties());
        tell.fluent(STATE_SET, list(certainties.into_iter().map(Reading::Float).collect()));
        tell.fluent(INSTRUCTION_CERTAINTY, number(state_set.and_then(|set| set.best()).map(|best| best.certainty)));
        let doorway = self.doorway.map(|doorway| doorway.middle_in_odom);
        let pose =
            |pose: rpl_robot::geometry::Pose| [pose.x_m, pose.y_m, pose.heading_rad].map(Reading::Float).to_vec();
        tell.fluent(DOORWAY, list(doorway.map_or(Vec::new(), pose)));
    }
}

fn number(value: Option<f64>) -> Reading {
    value.map_or(Reading::Truth(false), Reading::Float)
}

/// Lists here are nested once.
fn list(items: Vec<Reading>) -> Reading {
    ReadingList::new(items).map_or(Reading::Truth(false), Reading::List)
}

fn percept(percept: &Percept) -> Reading {
    let symbol = |name: &str| Reading::Symbol(name.to_string());
    list(vec![
        Reading::Int(i64::try_from(percept.number).unwrap_or(i64::MAX)),
        symbol(percept.side.in_words()),
        symbol(percept.seen.name()),
        Reading::Float(percept.from_m),
        Reading::Float(percept.to_m),
    ])
}
