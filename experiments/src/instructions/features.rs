//! `hallway-features`: whether what is beside hallways is perceived as what it is.

use super::course::{Course, drive};
use super::figures;
use super::setting::{CALM, CROWDED, CROWDED_MARKED, EXACT, Ground, MARKED, NOMAD, Setting, THICK, THIN, UNREGISTERED};
use crate::conduct::chosen;
use crate::failed_runs::FailedRun;
use crate::findings::Findings;
use crate::kind::{ExperimentKind, Run};
use crate::request::ExperimentRequest;
use crate::statistics::Proportion;
use anyhow::Result;
use rpl_lola::feature::Feature;
use rpl_lola::features::score::Confusion;
use rpl_lola::state_set::{Matrix, USUAL_DISTANCE_M};
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// The rows of `hallway-features`.
static FEATURES: [Setting; 9] = [CALM, MARKED, THIN, THICK, CROWDED, CROWDED_MARKED, EXACT, UNREGISTERED, NOMAD];

/// The matrices of state-set progression, each with the rows of `hallway-features` that measure it together.
const MATRICES: [(&str, [&str; 2]); 2] = [
    ("sonar alone, calm and crowded", [CALM.name, CROWDED.name]),
    ("with markers", [MARKED.name, CROWDED_MARKED.name]),
];

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    FEATURES.iter().map(|setting| setting.name).collect()
}

/// Drives along hallways, row by row.
pub struct HallwayFeatures {
    request: ExperimentRequest,
    settings: Vec<&'static Setting>,
}

impl HallwayFeatures {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let settings = chosen(&request, &FEATURES, |setting| setting.name)?;
        Ok(Self { request, settings })
    }
}

/// What a drive was worth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scored {
    seed: u64,
    confusion: Confusion,
    /// The same without closed doors before which something stood.
    shown: Confusion,
    /// How far the axis was off, at equal distances along the way; nothing before it was registered.
    axis_off_deg: Vec<f64>,
    contacts: u32,
    /// Why it did not get to the end, if it did not.
    failure: Option<FailedRun>,
}

impl ExperimentKind for HallwayFeatures {
    type Ground = Ground;
    type Record = Scored;
    type Tally = Vec<Scored>;

    fn series(&self) -> Vec<String> {
        self.settings.iter().map(|setting| setting.name.to_string()).collect()
    }

    fn ground(&self, series: usize) -> Result<Ground> {
        Ground::new(self.settings[series], &self.request.robot)
    }

    fn run(&self, series: usize, ground: &Ground, run: Run) -> Result<Scored> {
        let course = drive(ground, &self.settings[series].arena, run.seed, self.request.until_us)?;
        let (confusion, shown, failure) = (course.confusion(), course.shown(), course.failure());
        let Course { seed, axis_off_deg, contacts, .. } = course;
        Ok(Scored { seed, confusion, shown, axis_off_deg, contacts, failure })
    }

    fn head(&self, _: &Scored) -> String {
        "row,seed,features,right,false alarms,doubled,driven [m],axis off 95 % [deg],contacts,fault".to_string()
    }

    fn lines(
        &self,
        series: &str,
        _: Run,
        Scored { seed, confusion, axis_off_deg, contacts, failure, .. }: &Scored,
    ) -> String {
        let alarms: u32 = confusion.false_alarms.iter().sum();
        let off = AxisOff::of(axis_off_deg.clone()).map_or(String::new(), |off| off.most_deg.to_string());
        format!(
            "\"{series}\",{seed},{},{},{alarms},{},{:.2},{off},{contacts},{}\n",
            confusion.features(),
            confusion.right(),
            confusion.doubled,
            confusion.driven_m,
            failure.as_ref().map_or("", |failure| failure.fault.as_str()),
        )
    }

    fn findings(&self, tallies: Vec<Vec<Scored>>, wants_drawings: bool) -> Result<Findings> {
        let mut drawings = Vec::new();
        for (series, (setting, drives)) in self.settings.iter().zip(&tallies).enumerate() {
            if let Some(first) = drives.first().filter(|_| wants_drawings) {
                let course = drive(&self.ground(series)?, &setting.arena, first.seed, self.request.until_us)?;
                drawings.push(figures::contour(setting.name, &course));
            }
        }
        let driven: Vec<(&str, Vec<Scored>)> = self.settings.iter().map(|setting| setting.name).zip(tallies).collect();
        let rows: Vec<FeatureRow> = driven.iter().map(|(name, drives)| FeatureRow::of(name, drives)).collect();
        let measured = MATRICES.iter().filter_map(|(name, needed)| MeasuredMatrix::of(name, needed, &driven));
        let matrices: Vec<MeasuredMatrix> = measured.collect();
        let status = if rows.iter().all(|row| row.failures.is_empty()) { Status::Succeeded } else { Status::Failed };
        let (blocks, figures) = (blocks(&rows, &matrices), json!({ "rows": rows, "matrices": matrices }));
        Ok(Findings { status, blocks, figures, drawings })
    }
}

/// What came of the drives of a row.
#[derive(Clone, Debug, Serialize)]
pub struct FeatureRow {
    /// What the row is called.
    pub name: String,
    /// Drives.
    pub runs: usize,
    /// Features taken for what they are.
    pub right: Proportion,
    /// Percepts of nothing, and of something that was told of before, in 100 m.
    pub false_in_100_m: f64,
    /// What features were taken for.
    #[serde(flatten)]
    pub confusion: Confusion,
    /// How far the axis of the hallway was off along the way; none if it never was registered.
    pub axis_off: Option<AxisOff>,
    /// Contacts the robot caused.
    pub contacts: u32,
    /// Drives that did not get to the end, with the reason.
    pub failures: Vec<FailedRun>,
}

/// How far the axis was off, over equal distances of all drives.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AxisOff {
    /// The middle one.
    pub median_deg: f64,
    /// What 95 % do not exceed.
    pub most_deg: f64,
    /// The largest.
    pub largest_deg: f64,
    /// The share within 2°.
    pub within_2_deg: f64,
}

/// Registration is to be right to within this (lola.md).
const RIGHT_AXIS_DEG: f64 = 2.0;

impl AxisOff {
    fn of(mut off_deg: Vec<f64>) -> Option<Self> {
        off_deg.sort_by(f64::total_cmp);
        let at = |share: f64| off_deg.get((off_deg.len() as f64 * share) as usize).copied();
        Some(Self {
            median_deg: at(0.5)?,
            most_deg: at(0.95)?,
            largest_deg: *off_deg.last()?,
            within_2_deg: off_deg.iter().filter(|off| **off <= RIGHT_AXIS_DEG).count() as f64 / off_deg.len() as f64,
        })
    }
}

impl FeatureRow {
    /// The figures of some drives.
    pub fn of(name: &str, courses: &[Scored]) -> Self {
        let mut confusion = Confusion::default();
        courses.iter().for_each(|course| confusion.add(&course.confusion));
        Self {
            name: name.to_string(),
            runs: courses.len(),
            right: Proportion::new(confusion.right() as usize, confusion.features() as usize),
            false_in_100_m: confusion.false_in_100_m(),
            axis_off: AxisOff::of(courses.iter().flat_map(|course| course.axis_off_deg.iter().copied()).collect()),
            contacts: courses.iter().map(|course| course.contacts).sum(),
            failures: courses.iter().filter_map(|course| course.failure.clone()).collect(),
            confusion,
        }
    }

    /// What each feature was taken for, in the layout of DERVISH's table.
    fn matrix(&self) -> Table {
        let heads: Vec<&str> = Feature::ALL.into_iter().skip(1).map(Feature::name).collect();
        let mut table = Table::new(&[&["perceived as"][..], &heads, &["false in 100 m"]].concat());
        for percept in Feature::ALL {
            let shares = Feature::ALL.into_iter().skip(1).map(|feature| {
                let of: u32 = self.confusion.taken[feature as usize].iter().sum();
                let count = self.confusion.taken[feature as usize][percept as usize];
                if of == 0 { NOTHING.to_string() } else { format!("{:.3}", f64::from(count) / f64::from(of)) }
            });
            let name = if percept == Feature::Wall { "nothing" } else { percept.name() };
            let alarms = match percept {
                Feature::Wall => NOTHING.to_string(),
                _ => format!(
                    "{:.2}",
                    f64::from(self.confusion.false_alarms[percept as usize]) * 100.0
                        / self.confusion.driven_m.max(1e-9)
                ),
            };
            table.row([name.to_string()].into_iter().chain(shares).chain([alarms]));
        }
        table
    }
}

/// The matrix that state-set progression goes by, as rows together measure it. Closed doors before which something
/// stood have no part in it: a state set knows of them by the walls that were hidden.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredMatrix {
    /// What it is of.
    pub name: &'static str,
    /// `certainties[percept][feature]`.
    #[serde(flatten)]
    pub matrix: Matrix,
}

/// What each count of a matrix is raised by.
const PRIOR: f64 = 0.5;

impl MeasuredMatrix {
    /// Of these rows, if all of them were driven.
    pub fn of(name: &'static str, needed: &[&str], rows: &[(&str, Vec<Scored>)]) -> Option<Self> {
        let mut together = Confusion::default();
        for needed in needed {
            let (_, courses) = rows.iter().find(|(row, courses)| row == needed && !courses.is_empty())?;
            courses.iter().for_each(|course| together.add(&course.shown));
        }
        Some(Self { name, matrix: Matrix::measured(&together.certainties(PRIOR, USUAL_DISTANCE_M)) })
    }

    fn blocks(&self) -> [Block; 2] {
        let heads: Vec<&str> = Feature::ALL.into_iter().map(Feature::name).collect();
        let mut table = Table::new(&[&["percept"][..], &heads].concat());
        for (percept, certainties) in Feature::ALL.into_iter().zip(&self.matrix.certainties) {
            let shares = certainties.iter().map(|certainty| format!("{certainty:.4}"));
            table.row([percept.name().to_string()].into_iter().chain(shares));
        }
        [Block::Lines(format!("\n{}: C(percept | feature)", self.name)), Block::Table(table)]
    }
}

/// A line for each row, what its features were perceived as, and the matrices that follow from them.
pub fn blocks(rows: &[FeatureRow], matrices: &[MeasuredMatrix]) -> Vec<Block> {
    let heads =
        ["", "drives", "right", "95 % interval", "false in 100 m", "axis off: median", "95 %", "largest", "contacts"];
    let mut table = Table::new(&heads);
    for row in rows {
        let degrees = |of: fn(&AxisOff) -> f64| {
            row.axis_off.as_ref().map_or(NOTHING.to_string(), |off| format!("{:.2}°", of(off)))
        };
        table.row([
            row.name.clone(),
            row.runs.to_string(),
            row.right.fraction(),
            row.right.interval(),
            format!("{:.2}", row.false_in_100_m),
            degrees(|off| off.median_deg),
            degrees(|off| off.most_deg),
            degrees(|off| off.largest_deg),
            row.contacts.to_string(),
        ]);
    }
    let mut blocks = vec![Block::Table(table)];
    for row in rows {
        blocks.push(Block::Lines(format!("\n{}: what features were perceived as", row.name)));
        blocks.push(Block::Table(row.matrix()));
        blocks.extend(failed_drives(&row.failures).map(Block::Lines));
    }
    blocks.extend(matrices.iter().flat_map(MeasuredMatrix::blocks));
    blocks
}

/// Which drives did not get to the end, if any.
pub fn failed_drives(failures: &[FailedRun]) -> Option<String> {
    let failed: Vec<String> = failures.iter().map(|run| format!("{} ({})", run.seed, run.fault)).collect();
    (!failed.is_empty()).then(|| format!("did not get to the end with seed {}", failed.join(", ")))
}
