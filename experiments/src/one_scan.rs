//! `one-scan`: where a robot is by a single scan, from anywhere in a building, with a third of its beams on people.

use super::conduct::chosen;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::reliability::{self, Bin, Judged, SURE};
use super::request::ExperimentRequest;
use super::statistics::{Dispersion, Proportion, quantile};
use anyhow::{Result, anyhow};
use rpl_random::Stream;
use rpl_robot::description::RobotDescription;
use rpl_robot::localization::ScanParameters;
use rpl_robot::localization::once::ScanLocator;
use rpl_robot::localization::once::trial::{TrialGround, TrialSensor, Verdict};
use rpl_robot::sensors::LaserScanner;
use rpl_shell::files::world_files;
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::time::Instant;

/// Scans of a seed in each world.
const EACH: usize = 25;

/// The share of beams that end at people.
const ON_PEOPLE: f64 = 1.0 / 3.0;

/// The laser of the rows.
const LASER: LaserScanner = LaserScanner { readings: 360, resolution_deg: 1.0, range_m: 8.0 };

/// Edge of a cell of the map, and from its middle to the nearest thing at the least.
const CELL_M: f64 = 0.05;
const CLEARANCE_M: f64 = 0.2;

/// The worlds.
const WORLDS: [&str; 12] = [
    "dept",
    "olin-rice",
    "long-corridor",
    "two-wings",
    "hall",
    "flat",
    "small-office",
    "lab",
    "warehouse",
    "gallery",
    "ring",
    "school",
];

/// What can be asked for with `--row`.
pub(crate) fn row_names() -> Vec<&'static str> {
    WORLDS.to_vec()
}

/// Scans from random poses, world by world.
pub(crate) struct OneScans {
    worlds: Vec<String>,
}

/// A building, and what scans in it are compared with.
pub(crate) struct Building {
    ground: TrialGround,
    locator: ScanLocator,
    sensor: TrialSensor,
}

/// An answer to a scan, and how long it took.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Answer {
    verdict: Verdict,
    time_ms: f64,
}

impl OneScans {
    /// What is asked for: the worlds of the rows, or the one that is named.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: &ExperimentRequest) -> Result<Self> {
        let worlds = match &request.world {
            Some(world) => vec![world.clone()],
            None => chosen(request, &WORLDS, |world| world)?.into_iter().map(|world| world.to_string()).collect(),
        };
        Ok(Self { worlds })
    }
}

impl ExperimentKind for OneScans {
    type Ground = Building;
    type Record = Vec<Answer>;
    type Tally = Vec<Vec<Answer>>;

    fn series(&self) -> Vec<String> {
        self.worlds.clone()
    }

    fn ground(&self, series: usize) -> Result<Building> {
        let name = &self.worlds[series];
        let world = world_files::for_all_seeds(name, &RobotDescription::papers())?;
        let map = world.map_centred(CELL_M);
        let beam = ScanParameters::laser(&LASER).beam;
        let locator = ScanLocator::new(&map, &beam, CLEARANCE_M);
        let locator = locator.map_err(|error| anyhow!("the world `{name}` cannot be used: {error}"))?;
        Ok(Building { ground: TrialGround::new(map, CLEARANCE_M), locator, sensor: TrialSensor::laser(&LASER) })
    }

    fn run(&self, series: usize, building: &Building, run: Run) -> Result<Vec<Answer>> {
        let Building { ground, locator, sensor } = building;
        let mut stream = Stream::new(run.seed, &format!("one-scan {}", self.worlds[series]));
        let answer = |_| {
            let scan = ground.draw(sensor, ON_PEOPLE, &mut stream);
            let began = Instant::now();
            let located = locator.locate(&scan.beams);
            let time_ms = began.elapsed().as_secs_f64() * 1e3;
            Answer { verdict: Verdict::of(&located, scan.robot_in_map), time_ms }
        };
        Ok((0..EACH).map(answer).collect())
    }

    fn head(&self, _: &Vec<Answer>) -> String {
        "row,seed,probability,right,named,poses,elsewhere,nowhere,time [ms]".to_string()
    }

    fn lines(&self, series: &str, run: Run, answers: &Vec<Answer>) -> String {
        let line = |Answer { verdict, time_ms }: &Answer| {
            let Verdict { probability, is_right, is_named, poses, elsewhere, nowhere, .. } = verdict;
            format!(
                "\"{series}\",{},{probability},{is_right},{is_named},{poses},{elsewhere},{nowhere},{time_ms:.3}\n",
                run.seed
            )
        };
        answers.iter().map(line).collect()
    }

    fn findings(&self, tallies: Vec<Vec<Vec<Answer>>>, _: bool) -> Result<Findings> {
        let rows = self.worlds.iter().zip(&tallies).map(|(world, runs)| RowResult::of(world, runs));
        let mut rows: Vec<RowResult> = rows.collect();
        let all: Vec<Vec<Answer>> = tallies.into_iter().flatten().collect();
        if rows.len() > 1 {
            rows.push(RowResult::of("all", &all));
        }
        let bins = bins(&all);
        let mut blocks = vec![Block::Table(table(&rows))];
        if !bins.is_empty() {
            blocks.push(Block::Table(reliability::table(&bins)));
        }
        let figures = json!({ "rows": rows, "bins": bins });
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings: Vec::new() })
    }

    /// What is measured is time.
    fn jobs(&self, _: usize) -> usize {
        1
    }
}

/// What the probability of the likeliest pose is worth, where it is not sure.
pub fn bins(runs: &[Vec<Answer>]) -> Vec<Bin> {
    let judged = |(group, run): (usize, &Vec<Answer>)| {
        let judged = move |answer: &Answer| {
            let Verdict { probability, is_right, .. } = answer.verdict;
            Judged { group, certainty: probability, is_right }
        };
        run.iter().map(judged).collect::<Vec<_>>()
    };
    reliability::bins(runs.iter().enumerate().flat_map(judged))
}

/// What came of the scans of a row.
#[derive(Clone, Debug, Serialize)]
pub struct RowResult {
    name: String,
    /// The likeliest pose was right.
    right: Proportion,
    /// The right pose was among those named.
    named: Proportion,
    /// How often the likeliest had a probability of 0.99 or more.
    sure: Proportion,
    /// The likeliest was right where it did.
    right_when_sure: Proportion,
    /// Poses that were named.
    poses: Option<Dispersion>,
    time_ms: Option<Dispersion>,
    /// What 95 % of the answers did not take longer than.
    time_95_ms: Option<f64>,
}

impl RowResult {
    /// The figures of some runs.
    pub fn of(name: &str, runs: &[Vec<Answer>]) -> Self {
        let answers: Vec<&Answer> = runs.iter().flatten().collect();
        let share = |is_meant: &dyn Fn(&Verdict) -> bool, is_so: &dyn Fn(&Verdict) -> bool| {
            let meant = || answers.iter().map(|answer| &answer.verdict).filter(|verdict| is_meant(verdict));
            Proportion::new(meant().filter(|verdict| is_so(verdict)).count(), meant().count())
        };
        let is_sure = |verdict: &Verdict| verdict.probability >= SURE;
        let of =
            |number: &dyn Fn(&Answer) -> f64| -> Vec<f64> { answers.iter().map(|answer| number(answer)).collect() };
        let mut times_ms = of(&|answer| answer.time_ms);
        times_ms.sort_by(f64::total_cmp);
        Self {
            name: name.to_string(),
            right: share(&|_| true, &|verdict| verdict.is_right),
            named: share(&|_| true, &|verdict| verdict.is_named),
            sure: share(&|_| true, &is_sure),
            right_when_sure: share(&is_sure, &|verdict| verdict.is_right),
            poses: Dispersion::of(&of(&|answer| answer.verdict.poses as f64)),
            time_ms: Dispersion::of(&times_ms),
            time_95_ms: quantile(&times_ms, 0.95),
        }
    }
}

/// A line for each row.
pub fn table(rows: &[RowResult]) -> Table {
    let head = ["", "scans", "named", "right", "≥ 0.99", "of these right", "poses", "time [ms]", "95 % [ms]"];
    let mut table = Table::new(&head);
    let percent = |share: &Proportion| share.rate.map_or(NOTHING.to_string(), |rate| format!("{:.2} %", 100.0 * rate));
    let median = |numbers: &Option<Dispersion>| numbers.map_or(NOTHING.to_string(), |of| format!("{:.1}", of.median));
    for row in rows {
        table.row([
            row.name.clone(),
            row.right.of.to_string(),
            percent(&row.named),
            percent(&row.right),
            percent(&row.sure),
            row.right_when_sure.fraction(),
            median(&row.poses),
            median(&row.time_ms),
            row.time_95_ms.map_or(NOTHING.to_string(), |time_ms| format!("{time_ms:.1}")),
        ]);
    }
    table
}

/// An answer to a scan that was judged beside the truth.
pub fn answer(verdict: Verdict, time_ms: f64) -> Answer {
    Answer { verdict, time_ms }
}
