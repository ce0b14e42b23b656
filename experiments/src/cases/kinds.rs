//! `case-kinds`: whether the kind of case comes back that is needed.

use super::Building;
use crate::conduct::chosen;
use crate::findings::Findings;
use crate::kind::{ExperimentKind, Run};
use crate::request::ExperimentRequest;
use crate::statistics::Proportion;
use anyhow::Result;
use rpl_rupart::trial::{KindGround, KindRetrieved, Phase, Reason, Telling};
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::Serialize;
use serde_json::json;

/// Situations of a seed for each reason.
const EACH: usize = 25;

/// A row: how kinds are told apart.
pub struct KindRow {
    /// What it is called.
    pub name: &'static str,
    /// How.
    pub telling: Telling,
    /// Of which kinds.
    pub phase: Phase,
}

const fn row(name: &'static str, telling: Telling, phase: Phase) -> KindRow {
    KindRow { name, telling, phase }
}

/// All rows.
pub static ROWS: [KindRow; 6] = [
    row("weighted", Telling::Certain, Phase::Second),
    row("unit weights", Telling::UnitWeights, Phase::Second),
    row("first phase, weighted", Telling::Certain, Phase::First),
    row("first phase, unit weights", Telling::UnitWeights, Phase::First),
    row("first phase, missing ignored", Telling::MissingIgnored, Phase::First),
    row("first phase, nothing foreign", Telling::NothingForeign, Phase::First),
];

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    ROWS.iter().map(|row| row.name).collect()
}

/// Retrieves cases for every reason, row by row.
pub struct Kinds {
    request: ExperimentRequest,
    rows: Vec<&'static KindRow>,
}

impl Kinds {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let rows = chosen(&request, &ROWS, |row| row.name)?;
        Ok(Self { request, rows })
    }
}

impl ExperimentKind for Kinds {
    type Ground = KindGround;
    type Record = Vec<KindRetrieved>;
    type Tally = Vec<Vec<KindRetrieved>>;

    fn series(&self) -> Vec<String> {
        self.rows.iter().map(|row| row.name.to_string()).collect()
    }

    fn ground(&self, _: usize) -> Result<KindGround> {
        let Building { world, robot, places } = Building::of(&self.request)?;
        Ok(KindGround::new(world, places, robot))
    }

    fn run(&self, series: usize, ground: &KindGround, run: Run) -> Result<Vec<KindRetrieved>> {
        let KindRow { telling, phase, .. } = self.rows[series];
        Ok(ground.retrieve(*telling, *phase, EACH, run.seed))
    }

    fn head(&self, _: &Vec<KindRetrieved>) -> String {
        "row,seed,reason,kind".to_string()
    }

    fn lines(&self, series: &str, run: Run, retrieved: &Vec<KindRetrieved>) -> String {
        lines(series, run.seed, retrieved)
    }

    fn findings(&self, tallies: Vec<Vec<Vec<KindRetrieved>>>, _: bool) -> Result<Findings> {
        let results = self.rows.iter().zip(&tallies).map(|(row, retrieved)| KindResult::of(row.name, retrieved));
        let results: Vec<KindResult> = results.collect();
        let (blocks, figures) = (blocks(&results), json!({ "rows": results }));
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings: Vec::new() })
    }
}

/// What came of the retrievals of a row.
#[derive(Clone, Debug, Serialize)]
pub struct KindResult {
    /// What the row is called.
    pub name: String,
    /// Retrievals of the kind that was needed.
    pub right: Proportion,
    /// The same for each reason, in the order of the table.
    pub by_reason: Vec<Proportion>,
}

impl KindResult {
    /// The figures of the retrievals of some seeds.
    pub fn of(name: &str, retrieved: &[Vec<KindRetrieved>]) -> Self {
        // Those of a seed are from the same memory.
        let share = |is_meant: &dyn Fn(Reason) -> bool| {
            let of_seed = |found: &Vec<KindRetrieved>| {
                let meant = || found.iter().filter(|found| is_meant(found.reason));
                (meant().filter(|found| found.kind == found.reason.needed()).count(), meant().count())
            };
            Proportion::in_groups(&retrieved.iter().map(of_seed).collect::<Vec<_>>())
        };
        Self {
            name: name.to_string(),
            right: share(&|_| true),
            by_reason: Reason::ALL.map(|asked| share(&|reason| reason == asked)).to_vec(),
        }
    }
}

/// A line for each row.
pub fn blocks(rows: &[KindResult]) -> Vec<Block> {
    let mut head = vec!["", "retrievals", "right", "95 % interval"];
    head.extend(Reason::ALL.map(Reason::name));
    let mut table = Table::new(&head);
    let percent = |share: &Proportion| share.rate.map_or(NOTHING.to_string(), |rate| format!("{:.1} %", 100.0 * rate));
    for row in rows {
        let first = [row.name.clone(), row.right.of.to_string(), percent(&row.right), row.right.interval()];
        table.row(first.into_iter().chain(row.by_reason.iter().map(percent)));
    }
    vec![Block::Table(table)]
}

/// The retrievals of a run as lines of comma-separated values.
fn lines(row: &str, seed: u64, found: &[KindRetrieved]) -> String {
    let line = |one: &KindRetrieved| format!("\"{row}\",{seed},\"{}\",{}\n", one.reason.name(), one.kind.name());
    found.iter().map(line).collect()
}
