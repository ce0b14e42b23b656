//! `topological-global`: where the robot is on a complete topological map, from an unknown start.

use crate::conduct::chosen;
use crate::findings::Findings;
use crate::kind::{ExperimentKind, Run};
use crate::request::ExperimentRequest;
use crate::statistics::Proportion;
use anyhow::Result;
use rpl_lola::arena::{Arena, ArenaSettings};
use rpl_lola::state_set::Matrix;
use rpl_lola::topological::{Step, drive};
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use serde_json::json;

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
pub static ROWS: [MapRow; 3] = [
    MapRow { name: "sonar alone", truth: Matrix::SONAR, believed: Matrix::SONAR },
    MapRow { name: "with markers", truth: Matrix::MARKED, believed: Matrix::MARKED },
    MapRow { name: "DERVISH's matrix", truth: Matrix::SONAR, believed: Matrix::DERVISH },
];

/// Percepts that are looked at.
const PERCEPTS: usize = 12;

/// After this many the robot should know where it is (lola.md).
const KNOWN_AFTER: usize = 8;

/// From this certainty on it is sure.
const SURE: f64 = 0.95;

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    ROWS.iter().map(|row| row.name).collect()
}

/// Drives about complete maps, row by row.
pub struct TopologicalDrives {
    rows: Vec<&'static MapRow>,
}

impl TopologicalDrives {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: &ExperimentRequest) -> Result<Self> {
        Ok(Self { rows: chosen(request, &ROWS, |row| row.name)? })
    }
}

/// How things stood after a percept.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    /// Whether the likeliest state was the true one.
    is_right: bool,
    /// How certain the robot was of it.
    certainty: f64,
}

impl ExperimentKind for TopologicalDrives {
    type Ground = ();
    type Record = Vec<Standing>;
    type Tally = Vec<Vec<Standing>>;

    fn series(&self) -> Vec<String> {
        self.rows.iter().map(|row| row.name.to_string()).collect()
    }

    fn ground(&self, _: usize) -> Result<()> {
        Ok(())
    }

    fn run(&self, series: usize, _: &(), Run { seed, .. }: Run) -> Result<Vec<Standing>> {
        let MapRow { truth, believed, .. } = self.rows[series];
        let map = Arena::draw(seed, &ArenaSettings::CALM).topological_map();
        let steps = drive(&map, truth, believed, seed, PERCEPTS);
        let standing = |step: &Step| Standing { is_right: step.truth == step.believed, certainty: step.certainty };
        Ok(steps.iter().map(standing).collect())
    }

    fn head(&self, _: &Vec<Standing>) -> String {
        "row,seed,percept,right,certainty".to_string()
    }

    fn lines(&self, series: &str, run: Run, steps: &Vec<Standing>) -> String {
        let line = |(at, Standing { is_right, certainty }): (u32, &Standing)| {
            format!("\"{series}\",{},{at},{is_right},{certainty:.4}\n", run.seed)
        };
        (1..).zip(steps).map(line).collect()
    }

    fn findings(&self, tallies: Vec<Vec<Vec<Standing>>>, _: bool) -> Result<Findings> {
        let rows = self.rows.iter().zip(&tallies).map(|(row, drives)| MapResult::of(row.name, drives));
        let rows: Vec<MapResult> = rows.collect();
        let (blocks, figures) = (blocks(&rows), json!({ "rows": rows }));
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings: Vec::new() })
    }
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
    pub fn of(name: &str, drives: &[Vec<Standing>]) -> Self {
        let after = |percepts: usize| drives.iter().filter_map(move |steps| steps.get(percepts - 1));
        let share = |percepts: usize, is_so: &dyn Fn(&Standing) -> bool| {
            Proportion::new(after(percepts).filter(|step| is_so(step)).count(), after(percepts).count())
        };
        let is_right = |step: &Standing| step.is_right;
        let is_sure = |step: &Standing| step.certainty >= SURE;
        Self {
            name: name.to_string(),
            runs: drives.len(),
            right: (1..=PERCEPTS).map(|percepts| share(percepts, &is_right)).collect(),
            sure: share(KNOWN_AFTER, &is_sure),
            sure_but_wrong: share(KNOWN_AFTER, &|step| is_sure(step) && !is_right(step)),
        }
    }
}

/// A line for each row: how often the likeliest state is right after some numbers of percepts.
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
