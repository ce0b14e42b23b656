//! `rupart`: errands by cases as missions, and the days of a robot that learns.

use super::cases::days::{self, DayBuilding, DayResult, RobotDays};
use super::catalogue::Row;
use super::conduct::chosen;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run, Tally};
use super::missions::{Mission, head, line, results, whether_measured};
use super::request::ExperimentRequest;
use super::row_result::{RowTally, comparison};
use super::trial::{AT_GOAL_M, MissionTrial};
use anyhow::{Result, bail};
use rpl_shell::terminal::page::Block;
use serde::{Deserialize, Serialize};
use serde_json::json;

/// A row of `rupart`.
#[derive(Clone, Copy)]
enum ErrandRow {
    Mission(&'static Row),
    Days,
}

impl ErrandRow {
    fn name(&self) -> &'static str {
        match self {
            Self::Mission(row) => row.name,
            Self::Days => days::ROW,
        }
    }

    fn all(missions: &'static [Row]) -> Vec<Self> {
        missions.iter().map(Self::Mission).chain([Self::Days]).collect()
    }
}

/// What can be asked for with `--row`.
pub fn row_names(missions: &'static [Row]) -> Vec<&'static str> {
    ErrandRow::all(missions).iter().map(ErrandRow::name).collect()
}

/// Errands by cases, row by row, and the days of a robot that learns.
pub struct Errands {
    request: ExperimentRequest,
    rows: Vec<ErrandRow>,
}

impl Errands {
    /// What is asked for, with the rows that are missions; without a name all of these, and no days.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest, missions: &'static [Row]) -> Result<Self> {
        let all = ErrandRow::all(missions);
        let mut rows: Vec<ErrandRow> = chosen(&request, &all, ErrandRow::name)?.into_iter().copied().collect();
        if request.row.is_none() {
            // A robot's days take as long as a hundred errands of the other rows.
            rows.retain(|row| matches!(row, ErrandRow::Mission(_)));
        }
        if request.cases.is_some() && matches!(rows[..], [ErrandRow::Days]) {
            bail!("a robot of `ten days` begins with nothing learned; leave `--cases` away, or take another row");
        }
        Ok(Self { request, rows })
    }
}

/// Where the errands of a row are.
pub enum ErrandGround {
    /// One in each run.
    Mission(Box<Mission>),
    /// Days full of them.
    Days(Box<DayBuilding>),
}

/// An errand, or days of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum ErrandRecord {
    /// One errand.
    Mission(MissionTrial),
    /// What a robot did in some days.
    Days(RobotDays),
}

/// What is kept of the runs of a row, whichever they are.
#[derive(Default)]
pub struct ErrandTally {
    missions: RowTally,
    robots: Vec<RobotDays>,
}

impl Tally<ErrandRecord> for ErrandTally {
    fn add(&mut self, record: ErrandRecord) {
        match record {
            ErrandRecord::Mission(trial) => self.missions.add(trial),
            ErrandRecord::Days(robot) => self.robots.push(robot),
        }
    }
}

/// A robot that takes itself to be where it was to go is really there only if its estimate is right.
fn really_there(trial: MissionTrial) -> MissionTrial {
    let is_wrong = trial.succeeded() && trial.samples.last().is_some_and(|last| f64::from(last.off_m) > AT_GOAL_M);
    if is_wrong { MissionTrial { fault: Some("wrong place".to_string()), ..trial } } else { trial }
}

impl ExperimentKind for Errands {
    type Ground = ErrandGround;
    type Record = ErrandRecord;
    type Tally = ErrandTally;

    fn series(&self) -> Vec<String> {
        self.rows.iter().map(|row| row.name().to_string()).collect()
    }

    fn ground(&self, series: usize) -> Result<ErrandGround> {
        Ok(match self.rows[series] {
            ErrandRow::Mission(row) => ErrandGround::Mission(Box::new(Mission::of(&self.request, row)?)),
            ErrandRow::Days => ErrandGround::Days(Box::new(DayBuilding::of(&self.request)?)),
        })
    }

    fn run(&self, _: usize, ground: &ErrandGround, run: Run) -> Result<ErrandRecord> {
        Ok(match ground {
            ErrandGround::Mission(mission) => {
                ErrandRecord::Mission(really_there(mission.run(&self.request, run.seed)?).without_samples())
            }
            ErrandGround::Days(ground) => ErrandRecord::Days(ground.days(run.seed)),
        })
    }

    fn head(&self, first: &ErrandRecord) -> String {
        match first {
            ErrandRecord::Mission(trial) => head(trial),
            ErrandRecord::Days(_) => String::new(),
        }
    }

    /// Days are lines of a file of their own.
    fn lines(&self, series: &str, _: Run, record: &ErrandRecord) -> String {
        match record {
            ErrandRecord::Mission(trial) => line(series, trial),
            ErrandRecord::Days(_) => String::new(),
        }
    }

    fn findings(&self, tallies: Vec<ErrandTally>, wants_drawings: bool) -> Result<Findings> {
        let (mut names, mut missions, mut robots) = (Vec::new(), Vec::new(), None);
        for (row, tally) in self.rows.iter().zip(tallies) {
            match row {
                ErrandRow::Mission(row) => {
                    names.push(row.name.to_string());
                    missions.push(tally.missions);
                }
                ErrandRow::Days => robots = Some(tally.robots),
            }
        }
        let results = results(&names, &missions);
        let mut blocks = if results.is_empty() { Vec::new() } else { comparison(&results) };
        let (mut days, mut drawings) = (Vec::new(), Vec::new());
        if let Some(robots) = robots {
            days = DayResult::of(&robots);
            blocks.push(Block::Lines("ten days of errands, learning by day and by night".to_string()));
            blocks.extend(days::blocks(&days));
            if wants_drawings {
                drawings.push(("days.csv".to_string(), days::lines(&robots)));
            }
        }
        let figures = json!({ "rows": results, "days": days });
        Ok(Findings { status: whether_measured(&missions), blocks, figures, drawings })
    }
}
