//! `count-openings`: whether the so-manieth opening is chosen, by several rules and the same percepts.

use super::course::Course;
use crate::experiment::statistics::Proportion;
use crate::terminal::page::Block;
use crate::terminal::table::{NOTHING, Table};
use rpl_lola::feature::{Feature, Percept, Side};
use rpl_lola::features::score::TrueFeature;
use rpl_lola::instruction::{Goal, MOST_ORDINAL};
use rpl_lola::state_set::{Inference, StateSet};
use serde::Serialize;

/// The so-manieth opening of a hallway's side that was asked for, and what came of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Of the drive.
    pub seed: u64,
    /// What was asked for.
    pub goal: Goal,
    /// What came of it.
    pub outcome: ChoiceOutcome,
}

/// What came of asking for an opening.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChoiceOutcome {
    /// It was the one that was chosen.
    Right,
    /// Another one was, or a wall.
    Wrong,
    /// None was: the hallway ended before.
    None,
}

/// What is asked for of a drive: every opening on both sides that an instruction can lead to.
pub fn choices(course: &Course, inference: &Inference) -> Vec<Choice> {
    let of_side = |side| {
        let openings = course.openings(side).into_iter().zip(1..=MOST_ORDINAL);
        let can_be_goal = |found: &TrueFeature| matches!(found.is, Feature::Hallway | Feature::OpenDoor);
        openings.filter(move |(found, _)| can_be_goal(found)).map(move |(found, ordinal)| {
            let goal = Goal { ordinal, side, kind: found.is };
            let outcome = match chosen(goal, course, inference) {
                None => ChoiceOutcome::None,
                Some(percept) if is_of(&percept, &found) => ChoiceOutcome::Right,
                Some(_) => ChoiceOutcome::Wrong,
            };
            Choice { seed: course.seed, goal, outcome }
        })
    };
    Side::ALL.into_iter().flat_map(of_side).collect()
}

/// The percept that is taken for the goal, as soon as one is.
fn chosen(goal: Goal, course: &Course, inference: &Inference) -> Option<Percept> {
    let mut state_set = StateSet::start(goal.instruction())?;
    course.percepts.iter().find_map(|percept| {
        state_set.progress(inference, &[*percept], &course.hidden);
        state_set.arrived()
    })
}

/// Whether the robot that turns at the middle of a percept turns into this opening.
fn is_of(percept: &Percept, found: &TrueFeature) -> bool {
    percept.side == found.side && (found.from_m..found.to_m).contains(&percept.middle_m())
}

/// What came of the choices of a row.
#[derive(Clone, Debug, Serialize)]
pub struct ChoiceRow {
    /// What the row is called.
    pub name: String,
    /// Drives.
    pub runs: usize,
    /// Right choices among those of each ordinal, from the first on.
    pub by_ordinal: Vec<Proportion>,
    /// Among the first five.
    pub first_five: Proportion,
    /// Among all.
    pub all: Proportion,
    /// How often none was chosen.
    pub none: usize,
}

impl ChoiceRow {
    /// The figures of some choices.
    pub fn of(name: &str, runs: usize, choices: &[Choice]) -> Self {
        let among = |is_meant: &dyn Fn(u8) -> bool| {
            let meant = choices.iter().filter(|choice| is_meant(choice.goal.ordinal));
            let right = meant.clone().filter(|choice| choice.outcome == ChoiceOutcome::Right).count();
            Proportion::new(right, meant.count())
        };
        Self {
            name: name.to_string(),
            runs,
            by_ordinal: (1..=MOST_ORDINAL).map(|ordinal| among(&|other| other == ordinal)).collect(),
            first_five: among(&|ordinal| ordinal <= 5),
            all: among(&|_| true),
            none: choices.iter().filter(|choice| choice.outcome == ChoiceOutcome::None).count(),
        }
    }
}

/// A line for each row: the share of right choices by ordinal.
pub fn blocks(rows: &[ChoiceRow]) -> Vec<Block> {
    let ordinals: Vec<String> = (1..=MOST_ORDINAL).map(|ordinal| ordinal.to_string()).collect();
    let heads: Vec<&str> = [""]
        .into_iter()
        .chain(ordinals.iter().map(String::as_str))
        .chain(["first five", "95 % interval", "all", "none"])
        .collect();
    let mut table = Table::new(&heads);
    for row in rows {
        let share = |share: &Proportion| share.rate.map_or(NOTHING.to_string(), |rate| format!("{rate:.3}"));
        let cells = row.by_ordinal.iter().map(share);
        let ends = [share(&row.first_five), row.first_five.interval(), share(&row.all), row.none.to_string()];
        table.row([row.name.clone()].into_iter().chain(cells).chain(ends));
    }
    let asked: Vec<String> =
        rows.first().map_or(Vec::new(), |row| row.by_ordinal.iter().map(|share| share.of.to_string()).collect());
    vec![
        Block::Table(table),
        Block::Lines(format!("openings asked for, from the first to the tenth: {}", asked.join(", "))),
    ]
}

/// Every choice as a line of comma-separated values.
pub fn raw_rows(rows: &[(&str, usize, Vec<Choice>)]) -> String {
    let mut text = String::from("row,seed,ordinal,side,kind,outcome\n");
    for (name, _, choices) in rows {
        for Choice { seed, goal, outcome } in choices {
            let outcome = match outcome {
                ChoiceOutcome::Right => "right",
                ChoiceOutcome::Wrong => "wrong",
                ChoiceOutcome::None => "none",
            };
            let (side, kind) = (goal.side.in_words(), goal.kind.name());
            text += &format!("\"{name}\",{seed},{},{side},{kind},{outcome}\n", goal.ordinal);
        }
    }
    text
}
