//! `case-kinds`: whether the kind of case comes back that is needed.

use crate::experiment::statistics::Proportion;
use crate::terminal::page::Block;
use crate::terminal::table::{NOTHING, Table};
use rpl_rupart::trial::{KindRetrieved, Phase, Reason, Telling};
use serde::Serialize;

/// Situations of a seed for each reason.
pub const EACH: usize = 25;

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
pub const ROWS: [KindRow; 6] = [
    row("weighted", Telling::Certain, Phase::Second),
    row("unit weights", Telling::UnitWeights, Phase::Second),
    row("first phase, weighted", Telling::Certain, Phase::First),
    row("first phase, unit weights", Telling::UnitWeights, Phase::First),
    row("first phase, missing ignored", Telling::MissingIgnored, Phase::First),
    row("first phase, nothing foreign", Telling::NothingForeign, Phase::First),
];

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
        let share = |is_meant: &dyn Fn(Reason) -> bool| {
            let meant = || retrieved.iter().flatten().filter(|found| is_meant(found.reason));
            Proportion::new(meant().filter(|found| found.kind == found.reason.needed()).count(), meant().count())
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
    let mut head = vec!["", "right", "95 % interval"];
    head.extend(Reason::ALL.map(Reason::name));
    let mut table = Table::new(&head);
    let percent = |share: &Proportion| share.rate.map_or(NOTHING.to_string(), |rate| format!("{:.1} %", 100.0 * rate));
    for row in rows {
        let first = [row.name.clone(), percent(&row.right), row.right.interval()];
        table.row(first.into_iter().chain(row.by_reason.iter().map(percent)));
    }
    vec![Block::Table(table)]
}

/// Every retrieval as a line of comma-separated values.
pub fn raw_rows(seeds: &[u64], rows: &[(&str, Vec<Vec<KindRetrieved>>)]) -> String {
    let mut text = String::from("row,seed,reason,kind\n");
    for (name, retrieved) in rows {
        for (seed, found) in
            seeds.iter().zip(retrieved).flat_map(|(seed, found)| found.iter().map(move |one| (seed, one)))
        {
            text += &format!("\"{name}\",{seed},\"{}\",{}\n", found.reason.name(), found.kind.name());
        }
    }
    text
}
