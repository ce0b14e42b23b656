//! Missions over seeds: the runs of each row of an experiment.

use super::calibration::Reliability;
use super::catalogue::Row;
use super::chart;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run, Tally};
use super::over_time::OverTime;
use super::request::ExperimentRequest;
use super::row_result::{RowResult, RowTally, comparison};
use super::samples::Sample;
use super::trial::{Goal, MissionTrial, one_trial};
use anyhow::{Result, bail};
use rpl_mission::site::{Setup, Site};
use rpl_robot::description::RobotDescription;
use rpl_robot::localization::{Calibration, LocalizationParameters};
use rpl_robot::office::OfficeSettings;
use rpl_robot::world::World;
use rpl_runtime::run::library::Loaded;
use rpl_rupart::RupartSettings;
use rpl_shell::files::case_files::CaseGround;
use rpl_shell::files::plans;
use rpl_shell::files::world_files;
use rpl_shell::sites;
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use serde_json::json;

/// A place with a plan that is to run there.
pub struct Mission {
    /// Where.
    pub site: Site,
    /// What.
    pub loaded: Loaded,
    /// Where its robot must be at the end.
    pub goal: Option<Goal>,
}

impl Mission {
    /// Of a row.
    ///
    /// # Errors
    /// A file cannot be read or has faults, or the world cannot be used.
    pub fn of(request: &ExperimentRequest, row: &Row) -> Result<Self> {
        let world = world_files::for_all_seeds(request.world.as_deref().unwrap_or(row.world), &request.robot)?;
        let place = row.goal.map(|goal| world.place(goal)).transpose()?;
        let goal = place.map(|place| Goal { pose_in_map: place.pose_in_map, item: row.item });
        let scenario_name = row.scenario.map(|scenario| request.scenario.as_deref().unwrap_or(scenario));
        let scenario = scenario_name.map(plans::scenario).transpose()?;
        let mut settings = OfficeSettings::of(request.robot.clone());
        (row.change)(&mut settings);
        let rupart =
            RupartSettings { is_braked: row.is_braked, ..remembering(request, Some(&world), &settings.robot)? };
        let setup = Setup { world: Some(world), settings, rupart, ..Setup::default() };
        let site = sites::build(setup, scenario, Vec::new())?;
        let loaded = sites::load(&site, &plans::plan(row.plan)?, request.colour)?;
        Ok(Self { site, loaded, goal })
    }

    /// A run, with all its moments.
    ///
    /// # Errors
    /// What is measured of it cannot be computed.
    pub fn run(&self, request: &ExperimentRequest, seed: u64) -> Result<MissionTrial> {
        one_trial(self.site.start_traced(self.loaded.clone(), seed), seed, request.until_us, self.goal)
    }
}

/// What the robot of each run remembers at its start.
pub fn remembering(
    request: &ExperimentRequest,
    world: Option<&World>,
    robot: &RobotDescription,
) -> Result<RupartSettings> {
    let Some(path) = &request.cases else { return Ok(RupartSettings::default()) };
    let Some(world) = world else {
        bail!("`--cases` is what a robot remembers, and there is none; add `--world olin-rice`");
    };
    let memory = CaseGround::new(world, robot).read(path)?;
    Ok(RupartSettings { memory: Some(memory), ..RupartSettings::default() })
}

/// The rows of an experiment that are missions.
pub struct Missions<L> {
    /// What is asked for.
    pub request: ExperimentRequest,
    /// What is run.
    pub rows: Vec<&'static Row>,
    /// What is looked at.
    pub look: L,
}

/// What is looked at in missions.
pub trait Look: Send + Sync + Sized + 'static {
    /// What is kept of the runs of a row.
    type Tally: Tally<MissionTrial>;

    /// What is written down of a run.
    fn record(trial: MissionTrial) -> MissionTrial;

    /// The table, one tally for each row.
    fn findings(missions: &Missions<Self>, tallies: Vec<Self::Tally>, wants_drawings: bool) -> Findings;
}

impl<L: Look> ExperimentKind for Missions<L> {
    type Ground = Mission;
    type Record = MissionTrial;
    type Tally = L::Tally;

    fn series(&self) -> Vec<String> {
        self.rows.iter().map(|row| row.name.to_string()).collect()
    }

    fn ground(&self, series: usize) -> Result<Mission> {
        Mission::of(&self.request, self.rows[series])
    }

    fn run(&self, _: usize, mission: &Mission, run: Run) -> Result<MissionTrial> {
        Ok(L::record(mission.run(&self.request, run.seed)?))
    }

    fn head(&self, first: &MissionTrial) -> String {
        head(first)
    }

    fn lines(&self, series: &str, _: Run, trial: &MissionTrial) -> String {
        line(series, trial)
    }

    fn findings(&self, tallies: Vec<L::Tally>, wants_drawings: bool) -> Result<Findings> {
        Ok(L::findings(self, tallies, wants_drawings))
    }
}

/// How missions end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MissionTable {
    /// The first row as a table of its own, and charts over time.
    FirstRow,
    /// A line for each row alone.
    Lines,
}

impl Look for MissionTable {
    type Tally = RowTally;

    fn record(trial: MissionTrial) -> MissionTrial {
        trial.without_samples()
    }

    fn findings(missions: &Missions<Self>, tallies: Vec<RowTally>, wants_drawings: bool) -> Findings {
        let results = results(&missions.series(), &tallies);
        let figures = json!({ "rows": results });
        let (status, blocks, drawings) = match missions.look {
            Self::Lines => (whether_measured(&tallies), comparison(&results), Vec::new()),
            Self::FirstRow => {
                let mut blocks = results[0].blocks();
                blocks.push(Block::Lines(String::new()));
                blocks.extend(comparison(&results));
                let rows: Vec<(&str, &OverTime)> = missions
                    .rows
                    .iter()
                    .map(|row| row.name)
                    .zip(tallies.iter().map(|tally| &tally.over_time))
                    .collect();
                (status(&tallies[0]), blocks, if wants_drawings { over_time(&rows) } else { Vec::new() })
            }
        };
        Findings { status, blocks, figures, drawings }
    }
}

/// Every moment: what the certainty is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EveryMoment;

/// A row of which every moment counts.
#[derive(Default)]
pub struct MomentTally {
    row: RowTally,
    trials: Vec<MissionTrial>,
}

impl Tally<MissionTrial> for MomentTally {
    fn add(&mut self, trial: MissionTrial) {
        self.trials.push(trial.clone());
        self.row.add(trial);
    }
}

impl Look for EveryMoment {
    type Tally = MomentTally;

    fn record(trial: MissionTrial) -> MissionTrial {
        trial
    }

    fn findings(missions: &Missions<Self>, tallies: Vec<MomentTally>, wants_drawings: bool) -> Findings {
        let (rows, trials): (Vec<RowTally>, Vec<Vec<MissionTrial>>) =
            tallies.into_iter().map(|tally| (tally.row, tally.trials)).unzip();
        let results = results(&missions.series(), &rows);
        let measured: Vec<&MissionTrial> = trials.iter().flatten().filter(|trial| trial.is_measured()).collect();
        let robot = &missions.request.robot;
        let used = LocalizationParameters::of(robot).calibration.unwrap_or_else(|| Calibration::new(&[]));
        let reliability = Reliability::of(&measured, &used);
        let mut drawings = Vec::new();
        if wants_drawings {
            drawings.push(("reliability.svg".to_string(), chart::reliability(&reliability.bins)));
            let names = missions.rows.iter().map(|row| row.name);
            drawings.push(("samples.csv".to_string(), sample_lines(names.zip(&trials))));
        }
        let mut blocks = reliability.blocks();
        blocks.push(Block::Lines(String::new()));
        blocks.extend(comparison(&results));
        let figures = json!({ "reliability": reliability, "rows": results });
        Findings { status: whether_measured(&rows), blocks, figures, drawings }
    }
}

/// The figures of each row.
pub fn results<'t>(names: &[String], tallies: impl IntoIterator<Item = &'t RowTally>) -> Vec<RowResult> {
    names.iter().zip(tallies).map(|(name, tally)| RowResult::of(name, tally)).collect()
}

/// The charts of missions: how many have succeeded by which time, and, where there is a robot, how
/// far its estimate is off.
pub fn over_time(rows: &[(&str, &OverTime)]) -> Vec<(String, String)> {
    let mut charts = vec![("success.svg".to_string(), chart::success_over_time(rows))];
    charts.extend(chart::error_over_time(rows).map(|chart| ("error.svg".to_string(), chart)));
    charts
}

pub fn status(tally: &RowTally) -> Status {
    if tally.has_succeeded() { Status::Succeeded } else { Status::Failed }
}

/// The status of a comparison, in which runs may fail, but must count.
pub fn whether_measured<'t>(tallies: impl IntoIterator<Item = &'t RowTally>) -> Status {
    if tallies.into_iter().all(RowTally::is_measured) { Status::Succeeded } else { Status::Failed }
}

/// The names of the values of [`line`].
pub fn head(first: &MissionTrial) -> String {
    let names: Vec<&str> = first.measures.iter().map(|(quantity, _)| quantity.name()).collect();
    format!("row,seed,succeeded,fault,{}", names.join(","))
}

/// A run as a line of comma-separated values.
pub fn line(row: &str, trial: &MissionTrial) -> String {
    let value = |value: &Option<f64>| value.map_or(String::new(), |value| value.to_string());
    let values: Vec<String> = trial.measures.iter().map(|(_, measured)| value(measured)).collect();
    format!("\"{row}\",{},{},{}\n", trial.seed, trial.outcome(), values.join(","))
}

/// Every sample of every run, ten a second, as lines of comma-separated values.
fn sample_lines<'t>(rows: impl Iterator<Item = (&'static str, &'t Vec<MissionTrial>)>) -> String {
    let mut text = String::from("row,seed,sample,certainty,off_m,off_deg,right\n");
    for (row, trials) in rows {
        for trial in trials {
            for (at, Sample { certainty, off_m, off_rad, is_right }) in trial.samples.iter().enumerate() {
                let (off_deg, right) = (off_rad.to_degrees(), u8::from(*is_right));
                text += &format!("\"{row}\",{},{at},{certainty:.4},{off_m:.3},{off_deg:.2},{right}\n", trial.seed);
            }
        }
    }
    text
}
