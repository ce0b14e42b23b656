//! `behaviours`: how well a robot drives by what it retrieves, and how good that is.

use super::Building;
use crate::experiment::conduct::chosen;
use crate::experiment::findings::Findings;
use crate::experiment::kind::{ExperimentKind, Run};
use crate::experiment::request::ExperimentRequest;
use crate::experiment::statistics::{Proportion, Summary};
use crate::status::Status;
use crate::terminal::page::Block;
use crate::terminal::table::{NOTHING, Table};
use anyhow::Result;
use rpl_robot::simulator::{SimulatorModel, SimulatorSettings};
use rpl_rupart::memory::CaseMemory;
use rpl_rupart::places::Places;
use rpl_rupart::trial::{Driven, Driver, DrivingGround, Quality};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::Arc;

/// Drives a memory is trained on.
const TRAINED_ON: u32 = 30;

/// Of so many drives the retrievals of one are judged, which takes fifty times as long as the drive.
const JUDGED_EVERY: u64 = 4;

/// A row: what the robot drives by.
pub struct BehaviourRow {
    /// What it is called.
    pub name: &'static str,
    /// What it retrieves from.
    pub driver: Driver,
    /// Whether it brakes before what it hears.
    pub is_braked: bool,
    /// Whether retrievals are judged.
    pub judges: bool,
}

/// All rows.
pub static ROWS: [BehaviourRow; 4] = [
    BehaviourRow { name: "learned", driver: Driver::Learned(TRAINED_ON), is_braked: true, judges: true },
    BehaviourRow { name: "tuned alone", driver: Driver::Tuned, is_braked: true, judges: true },
    BehaviourRow { name: "nine by hand", driver: Driver::HandMade, is_braked: true, judges: true },
    BehaviourRow { name: "tuned, not braked", driver: Driver::Tuned, is_braked: false, judges: false },
];

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    ROWS.iter().map(|row| row.name).collect()
}

/// Drives by behaviour cases, row by row; all rows drive the same routes.
pub struct Behaviours {
    request: ExperimentRequest,
    rows: Vec<&'static BehaviourRow>,
}

impl Behaviours {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let rows = chosen(&request, &ROWS, |row| row.name)?;
        Ok(Self { request, rows })
    }
}

/// Where is driven, and by what.
pub struct Driveway {
    model: Arc<SimulatorModel>,
    places: Places,
    memory: CaseMemory,
}

/// A drive, if a route could be drawn for it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BehaviourDrive {
    /// Cases of the memory by which it was driven.
    cases: usize,
    driven: Option<Driven>,
}

impl ExperimentKind for Behaviours {
    type Ground = Driveway;
    type Record = BehaviourDrive;
    type Tally = Vec<BehaviourDrive>;

    fn series(&self) -> Vec<String> {
        self.rows.iter().map(|row| row.name.to_string()).collect()
    }

    fn ground(&self, series: usize) -> Result<Driveway> {
        let Building { world, robot, places } = Building::of(&self.request)?;
        let model = Arc::new(SimulatorModel::new(Arc::new(world), SimulatorSettings::of(robot)));
        let memory = DrivingGround { model: &model, places: &places }.memory(self.rows[series].driver);
        Ok(Driveway { model, places, memory })
    }

    fn run(&self, series: usize, Driveway { model, places, memory }: &Driveway, run: Run) -> Result<BehaviourDrive> {
        let BehaviourRow { is_braked, judges, .. } = self.rows[series];
        let judges = *judges && run.seed.is_multiple_of(JUDGED_EVERY);
        let driven = DrivingGround { model, places }.drive(memory, *is_braked, judges, run.seed);
        Ok(BehaviourDrive { cases: memory.len(), driven })
    }

    fn head(&self, _: &BehaviourDrive) -> String {
        "row,seed,arrived,time_s,length_m,contacts,retrievals".to_string()
    }

    fn lines(&self, series: &str, run: Run, drive: &BehaviourDrive) -> String {
        let Some(Driven { has_arrived, time_s, length_m, contacts, qualities }) = &drive.driven else {
            return String::new();
        };
        let (arrived, judged) = (u8::from(*has_arrived), qualities.len());
        format!("\"{series}\",{},{arrived},{time_s:.2},{length_m:.2},{contacts},{judged}\n", run.seed)
    }

    fn findings(&self, tallies: Vec<Vec<BehaviourDrive>>, _: bool) -> Result<Findings> {
        let cases = |drives: &[BehaviourDrive]| drives.first().map_or(0, |drive| drive.cases);
        let driven = |drives: Vec<BehaviourDrive>| drives.into_iter().map(|drive| drive.driven).collect();
        let rows = self.rows.iter().zip(tallies).map(|(row, drives)| (row, cases(&drives), driven(drives)));
        let rows: Vec<(&&BehaviourRow, usize, Vec<Option<Driven>>)> = rows.collect();
        let tuned = rows.iter().find(|(row, ..)| row.driver == Driver::Tuned && row.is_braked);
        let tuned = tuned.map(|(.., driven)| driven.as_slice());
        let results: Vec<BehaviourResult> =
            rows.iter().map(|(row, cases, driven)| BehaviourResult::of(row.name, *cases, driven, tuned)).collect();
        let (blocks, figures) = (blocks(&results), json!({ "rows": results }));
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings: Vec::new() })
    }
}

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
