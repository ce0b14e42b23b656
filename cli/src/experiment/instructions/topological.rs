//! `topological-global`: where the robot is on a complete topological map, from an unknown start.

use crate::experiment::statistics::Proportion;
use crate::terminal::page::Block;
use crate::terminal::table::{NOTHING, Table};
use rpl_lola::arena::{Arena, ArenaSettings};
use rpl_lola::state_set::Matrix;
use rpl_lola::topological::{Step, drive};
use serde::Serialize;

/// A row: how percepts come about, and what they are taken for.
pub struct MapRow {
    /// What it is called.
    pub name: &'static str,
    /// What features are perceived as.
    pub truth: Matrix,
    /// What the robot believes of that.
    pub believed: Matrix,
}

/// All rows.
pub const ROWS: [MapRow; 3] = [
    MapRow { name: "sonar alone", truth: Matrix::SONAR, believed: Matrix::SONAR },
    MapRow { name: "with markers", truth: Matrix::MARKED, believed: Matrix::MARKED },
    MapRow { name: "DERVISH's matrix", truth: Matrix::SONAR, believed: Matrix::DERVISH },
];

/// So many percepts are looked at.
const PERCEPTS: usize = 12;

/// After so many the robot should know where it is (lola.md).
const KNOWN_AFTER: usize = 8;

/// From this certainty on it is sure.
const SURE: f64 = 0.95;

/// Drives about the arena of a seed.
pub fn drive_about(row: &MapRow, seed: u64) -> Vec<Step> {
    let map = Arena::draw(seed, &ArenaSettings::CALM).topological_map();
    drive(&map, &row.truth, &row.believed, seed, PERCEPTS)
}

/// What came of the drives of a row.
#[derive(Clone, Debug, Serialize)]
pub struct MapResult {
    /// What the row is called.
    pub name: String,
    /// Drives.
    pub runs: usize,
    /// Of each percept, from the first on: the likeliest state is the true one.
    pub right: Vec<Proportion>,
    /// After eight percepts: the robot is sure.
    pub sure: Proportion,
    /// After eight percepts: it is sure, and wrong.
    pub sure_but_wrong: Proportion,
}

impl MapResult {
    /// The figures of some drives.
    pub fn of(name: &str, drives: &[Vec<Step>]) -> Self {
        let after = |percepts: usize| drives.iter().filter_map(move |steps| steps.get(percepts - 1));
        let share = |percepts: usize, is_so: &dyn Fn(&Step) -> bool| {
            Proportion::new(after(percepts).filter(|step| is_so(step)).count(), after(percepts).count())
        };
        let is_right = |step: &Step| step.truth == step.believed;
        let is_sure = |step: &Step| step.certainty >= SURE;
        Self {
            name: name.to_string(),
            runs: drives.len(),
            right: (1..=PERCEPTS).map(|percepts| share(percepts, &is_right)).collect(),
            sure: share(KNOWN_AFTER, &is_sure),
            sure_but_wrong: share(KNOWN_AFTER, &|step| is_sure(step) && !is_right(step)),
        }
    }
}

/// A line for each row: how often the likeliest state is right after so many percepts.
pub fn blocks(rows: &[MapResult]) -> Vec<Block> {
    let shown = [1, 2, 3, 4, 6, KNOWN_AFTER, PERCEPTS];
    let counts = shown.map(|percepts| format!("after {percepts}"));
    let heads = [""].into_iter().chain(counts.iter().map(String::as_str)).chain([
        "95 % interval after 8",
        "sure after 8",
        "sure but wrong",
    ]);
    let mut table = Table::new(&heads.collect::<Vec<_>>());
    for row in rows {
        let share = |share: &Proportion| share.rate.map_or(NOTHING.to_string(), |rate| format!("{rate:.3}"));
        let right = shown.into_iter().map(|percepts| share(&row.right[percepts - 1]));
        let ends = [row.right[KNOWN_AFTER - 1].interval(), share(&row.sure), row.sure_but_wrong.fraction()];
        table.row([row.name.clone()].into_iter().chain(right).chain(ends));
    }
    vec![Block::Table(table)]
}

/// A seed, and the drive it gave.
pub type SeededDrive = (u64, Vec<Step>);

/// Every step of every drive as a line of comma-separated values.
pub fn raw_rows(rows: &[(&str, Vec<SeededDrive>)]) -> String {
    let mut text = String::from("row,seed,percept,right,certainty\n");
    for (name, drives) in rows {
        for (seed, steps) in drives {
            for (at, step) in (1..).zip(steps) {
                let right = step.truth == step.believed;
                text += &format!("\"{name}\",{seed},{at},{right},{:.4}\n", step.certainty);
            }
        }
    }
    text
}
