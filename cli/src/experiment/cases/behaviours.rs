//! `behaviours`: how well a robot drives by what it retrieves, and how good that is.

use crate::experiment::statistics::{Proportion, Summary};
use crate::terminal::page::Block;
use crate::terminal::table::{NOTHING, Table};
use rpl_rupart::trial::{Driven, Driver, Quality};
use serde::Serialize;

/// Drives a memory is trained on.
const TRAINED_ON: u32 = 30;

/// A row: what the robot drives by.
pub struct BehaviourRow {
    /// What it is called.
    pub name: &'static str,
    /// What it retrieves from.
    pub driver: Driver,
    /// Whether it brakes before what it hears.
    pub is_braked: bool,
    /// Whether retrievals are judged, which takes most of the time.
    pub judges: bool,
}

/// All rows.
pub const ROWS: [BehaviourRow; 4] = [
    BehaviourRow { name: "learned", driver: Driver::Learned(TRAINED_ON), is_braked: true, judges: true },
    BehaviourRow { name: "tuned alone", driver: Driver::Tuned, is_braked: true, judges: true },
    BehaviourRow { name: "nine by hand", driver: Driver::HandMade, is_braked: true, judges: true },
    BehaviourRow { name: "tuned, not braked", driver: Driver::Tuned, is_braked: false, judges: false },
];

/// What came of the drives of a row.
#[derive(Clone, Debug, Serialize)]
pub struct BehaviourResult {
    /// What the row is called.
    pub name: String,
    /// Behaviour cases in the memory.
    pub cases: usize,
    /// Drives that came to the end of their route.
    pub arrived: Proportion,
    /// Drives without a contact that the robot caused.
    pub without_contact: Proportion,
    /// Seconds of the drives that arrived.
    pub time_s: Option<Summary>,
    /// Seconds more than the tuned parameters alone took, on drives where both arrived.
    pub longer_s: Option<Summary>,
    /// Shares of the retrievals that were optimal, near-optimal, fair and poor; none were judged if empty.
    pub qualities: Vec<Proportion>,
}

impl BehaviourResult {
    /// The figures of drives that were also made with the tuned parameters alone.
    pub fn of(name: &str, cases: usize, driven: &[Option<Driven>], tuned: Option<&[Option<Driven>]>) -> Self {
        let all: Vec<&Driven> = driven.iter().flatten().collect();
        let count = |is_so: &dyn Fn(&Driven) -> bool| {
            Proportion::new(all.iter().filter(|driven| is_so(driven)).count(), all.len())
        };
        let times_s: Vec<f64> = all.iter().filter(|driven| driven.has_arrived).map(|driven| driven.time_s).collect();
        let pairs = driven.iter().zip(tuned.unwrap_or_default());
        let both = pairs.filter_map(|(one, other)| one.as_ref().zip(other.as_ref()));
        let longer_s: Vec<f64> = both
            .filter(|(one, other)| one.has_arrived && other.has_arrived)
            .map(|(one, other)| one.time_s - other.time_s)
            .collect();
        let judged: Vec<Quality> = all.iter().flat_map(|driven| driven.qualities.iter().copied()).collect();
        let of_quality =
            |quality: Quality| Proportion::new(judged.iter().filter(|one| **one == quality).count(), judged.len());
        Self {
            name: name.to_string(),
            cases,
            arrived: count(&|driven| driven.has_arrived),
            without_contact: count(&|driven| driven.contacts == 0),
            time_s: Summary::of(&times_s),
            longer_s: Summary::of(&longer_s),
            qualities: if judged.is_empty() { Vec::new() } else { Quality::ALL.map(of_quality).to_vec() },
        }
    }
}

/// A line for each row.
pub fn blocks(rows: &[BehaviourResult]) -> Vec<Block> {
    let mut table = Table::new(&[
        "",
        "cases",
        "arrived",
        "no contact",
        "time",
        "longer than tuned",
        "optimal",
        "near",
        "fair",
        "poor",
    ]);
    let percent = |share: &Proportion| share.rate.map_or(NOTHING.to_string(), |rate| format!("{:.1} %", 100.0 * rate));
    let seconds = |summary: Option<Summary>| {
        summary.map_or(NOTHING.to_string(), |summary| format!("{:.1} ± {:.1} s", summary.spread.mean, summary.half_95))
    };
    for row in rows {
        let quality = |at: usize| row.qualities.get(at).map_or(NOTHING.to_string(), percent);
        table.row([
            row.name.clone(),
            row.cases.to_string(),
            row.arrived.fraction(),
            row.without_contact.fraction(),
            seconds(row.time_s),
            seconds(row.longer_s),
            quality(0),
            quality(1),
            quality(2),
            quality(3),
        ]);
    }
    vec![Block::Table(table)]
}

/// Every drive as a line of comma-separated values.
pub fn raw_rows(seeds: &[u64], rows: &[(&BehaviourRow, Vec<Option<Driven>>)]) -> String {
    let mut text = String::from("row,seed,arrived,time_s,length_m,contacts,retrievals\n");
    for (row, driven) in rows {
        for (seed, driven) in seeds.iter().zip(driven) {
            let Some(Driven { has_arrived, time_s, length_m, contacts, qualities }) = driven else { continue };
            let (arrived, judged) = (u8::from(*has_arrived), qualities.len());
            text += &format!("\"{}\",{seed},{arrived},{time_s:.2},{length_m:.2},{contacts},{judged}\n", row.name);
        }
    }
    text
}
