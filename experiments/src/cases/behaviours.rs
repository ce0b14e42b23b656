//! `behaviours`: how well a robot drives by what it retrieves, and how good that is.

use super::{Building, control_figures};
use crate::conduct::chosen;
use crate::findings::Findings;
use crate::kind::{ExperimentKind, Run};
use crate::request::ExperimentRequest;
use crate::statistics::{Proportion, Summary};
use anyhow::Result;
use rpl_robot::simulator::{SimulatorModel, SimulatorSettings};
use rpl_rupart::memory::CaseMemory;
use rpl_rupart::places::Places;
use rpl_rupart::trial::{Driven, Driver, DrivingGround, Quality};
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::Arc;

/// Drives a memory is trained on.
const TRAINED_ON: u32 = 30;

/// Of this many drives the retrievals of one are judged, which takes fifty times as long as the drive.
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
        let Some(Driven { has_arrived, time_s, length_m, contacts, qualities, .. }) = &drive.driven else {
            return String::new();
        };
        let (arrived, judged) = (u8::from(*has_arrived), qualities.len());
        format!("\"{series}\",{},{arrived},{time_s:.2},{length_m:.2},{contacts},{judged}\n", run.seed)
    }

    fn findings(&self, tallies: Vec<Vec<BehaviourDrive>>, wants_drawings: bool) -> Result<Findings> {
        let cases = |drives: &[BehaviourDrive]| drives.first().map_or(0, |drive| drive.cases);
        let driven = |drives: Vec<BehaviourDrive>| drives.into_iter().map(|drive| drive.driven).collect();
        let rows = self.rows.iter().zip(tallies).map(|(row, drives)| (row, cases(&drives), driven(drives)));
        let rows: Vec<(&&BehaviourRow, usize, Vec<Option<Driven>>)> = rows.collect();
        let tuned = rows.iter().find(|(row, ..)| row.driver == Driver::Tuned && row.is_braked);
        let tuned = tuned.map(|(.., driven)| driven.as_slice());
        let results: Vec<BehaviourResult> =
            rows.iter().map(|(row, cases, driven)| BehaviourResult::of(row.name, *cases, driven, tuned)).collect();
        let (blocks, figures) = (blocks(&results), json!({ "rows": results }));
        let drawings = match rows.first() {
            Some((row, _, driven)) if wants_drawings => control_figures::files(row.name, driven),
            _ => Vec::new(),
        };
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings })
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
    /// The same, as a share of what the tuned parameters took on the average.
    pub longer: Option<Summary>,
    /// Shares of the retrievals that were optimal, near-optimal, fair and poor; none were judged if empty. Those of a
    /// drive hang together.
    pub qualities: Vec<Proportion>,
    /// Those that were optimal or near-optimal; none if none were judged.
    pub good: Option<Proportion>,
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
        let pairs = pairs.filter_map(|(one, other)| one.as_ref().zip(other.as_ref()));
        let both: Vec<(f64, f64)> = pairs
            .filter(|(one, other)| one.has_arrived && other.has_arrived)
            .map(|(one, other)| (one.time_s, other.time_s))
            .collect();
        let tuned_s = both.iter().map(|(_, other_s)| other_s).sum::<f64>() / both.len().max(1) as f64;
        let longer_s: Vec<f64> = both.iter().map(|(one_s, other_s)| one_s - other_s).collect();
        let longer: Vec<f64> = longer_s.iter().map(|longer_s| longer_s / tuned_s).collect();
        let of_quality = |is_meant: &dyn Fn(Quality) -> bool| {
            let of_drive = |drive: &&Driven| {
                let meant = drive.qualities.iter().filter(|one| is_meant(**one)).count();
                (meant, drive.qualities.len())
            };
            Proportion::in_groups(&all.iter().map(of_drive).collect::<Vec<_>>())
        };
        let is_judged = all.iter().any(|drive| !drive.qualities.is_empty());
        let qualities = if is_judged { Quality::ALL.as_slice() } else { &[] };
        Self {
            name: name.to_string(),
            cases,
            arrived: count(&|driven| driven.has_arrived),
            without_contact: count(&|driven| driven.contacts == 0),
            time_s: Summary::of(&times_s),
            longer_s: Summary::of(&longer_s),
            longer: Summary::of(&longer),
            qualities: qualities.iter().map(|quality| of_quality(&|one| one == *quality)).collect(),
            good: is_judged.then(|| of_quality(&|one| one <= Quality::NearOptimal)),
        }
    }
}

/// Drives and retrievals: two tables with a line for each row.
pub fn blocks(rows: &[BehaviourResult]) -> Vec<Block> {
    let mut drives = Table::new(&[
        "",
        "cases",
        "arrived",
        "95 % interval",
        "no contact",
        "95 % interval",
        "time",
        "longer than tuned",
        "",
    ]);
    let mut retrievals = Table::new(&["", "retrievals", "optimal", "near", "fair", "poor", "optimal or near"]);
    let percent = |share: &Proportion| share.rate.map_or(NOTHING.to_string(), |rate| format!("{:.1} %", 100.0 * rate));
    let with_interval = |share: &Proportion| format!("{} ({})", percent(share), share.interval());
    let told = |summary: Option<Summary>, scale: f64, unit: &str| {
        summary.map_or(NOTHING.to_string(), |summary| format!("{} {unit}", summary.told(scale, 1)))
    };
    for row in rows {
        drives.row([
            row.name.clone(),
            row.cases.to_string(),
            row.arrived.fraction(),
            row.arrived.interval(),
            row.without_contact.fraction(),
            row.without_contact.interval(),
            told(row.time_s, 1.0, "s"),
            told(row.longer_s, 1.0, "s"),
            told(row.longer, 100.0, "%"),
        ]);
        let [optimal, near, fair, poor] = row.qualities.as_slice() else { continue };
        retrievals.row([
            row.name.clone(),
            optimal.of.to_string(),
            with_interval(optimal),
            percent(near),
            percent(fair),
            percent(poor),
            row.good.as_ref().map_or(NOTHING.to_string(), with_interval),
        ]);
    }
    let mut blocks = vec![Block::Table(drives)];
    if rows.iter().any(|row| row.good.is_some()) {
        let title = "how good what was retrieved on the way was, beside the best of all candidates";
        blocks.extend([Block::Lines(String::new()), Block::Lines(title.to_string()), Block::Table(retrievals)]);
    }
    blocks
}
