//! Missions over seeds: the runs of each row of an experiment, or of a plan of the user's own, and what
//! is written of them.

use super::catalogue::{EXPERIMENTS, Row};
use super::chart;
use super::findings::ExperimentResult;
use super::request::ExperimentRequest;
use super::row_result::RowResult;
use super::trial::{Goal, MissionTrial, one_trial};
use super::trials::{raw_rows, run_all};
use crate::files::plans;
use crate::files::world_files;
use crate::sites;
use crate::status::Status;
use crate::terminal::console::Console;
use crate::terminal::progress;
use anyhow::{Result, bail};
use rpl_lang::suggest::suggest;
use rpl_mission::site::{Setup, Site};
use rpl_robot::office::OfficeSettings;
use rpl_runtime::run::library::Loaded;
use serde_json::json;
use std::path::Path;

pub(super) fn results(rows: &[(&str, Vec<MissionTrial>)]) -> Vec<RowResult> {
    rows.iter().map(|(name, trials)| RowResult::of(name, trials)).collect()
}

/// The charts of missions: how many have succeeded by which time, and, where there is a robot, how
/// far its estimate is off.
pub(super) fn over_time(rows: &[(&str, Vec<MissionTrial>)]) -> Vec<(&'static str, String)> {
    let measured = |trials: &[MissionTrial]| trials.iter().filter(|trial| trial.is_measured()).cloned().collect();
    let rows: &[(&str, Vec<MissionTrial>)] =
        &rows.iter().map(|(name, trials)| (*name, measured(trials))).collect::<Vec<_>>();
    let has_robot = rows.iter().flat_map(|(_, trials)| trials).any(|trial| !trial.samples.is_empty());
    let mut charts = vec![("success.svg", chart::success_over_time(rows))];
    charts.extend(has_robot.then(|| ("error.svg", chart::error_over_time(rows))));
    charts
}

/// The runs of each row.
pub(super) fn missions(
    request: &ExperimentRequest,
    rows: &[&'static Row],
    console: &mut Console,
) -> Result<Vec<(&'static str, Vec<MissionTrial>)>> {
    rows.iter().map(|row| Ok((row.name, trials_of(request, console, row)?))).collect()
}

fn trials_of(request: &ExperimentRequest, console: &mut Console, row: &Row) -> Result<Vec<MissionTrial>> {
    let (site, goal) = site_of(request, row)?;
    let loaded = sites::load(&site, &plans::plan(row.plan)?, console.colour)?;
    all_trials(request, console, |_| Ok((site.clone(), loaded.clone())), goal, row.name)
}

/// Where a row takes place, and where its robot must be at the end.
pub(super) fn site_of(request: &ExperimentRequest, row: &Row) -> Result<(Site, Option<Goal<'static>>)> {
    let world = world_files::for_all_seeds(request.world.as_deref().unwrap_or(row.world), &request.robot)?;
    let place = row.goal.map(|goal| world.place(goal)).transpose()?;
    let goal = place.map(|place| Goal { pose_in_map: place.pose_in_map, item: row.item });
    let scenario_name = row.scenario.map(|scenario| request.scenario.as_deref().unwrap_or(scenario));
    let scenario = scenario_name.map(plans::scenario).transpose()?;
    let mut settings = OfficeSettings::of(request.robot.clone());
    (row.change)(&mut settings);
    Ok((sites::build(Setup { world: Some(world), settings, ..Setup::default() }, scenario, Vec::new())?, goal))
}

/// Writes every run and the charts into the folder for results, if there is to be one.
pub(super) fn write_results(
    request: &ExperimentRequest,
    rows: &[(&str, Vec<MissionTrial>)],
    charts: &[(&str, String)],
) -> Result<()> {
    let mut files: Vec<(String, String)> =
        charts.iter().map(|(name, text)| ((*name).to_string(), text.clone())).collect();
    files.push(("runs.csv".to_string(), raw_rows(rows)));
    request.write(&files)
}

pub(super) fn status(trials: &[MissionTrial]) -> Status {
    if trials.iter().all(|trial| trial.succeeded()) { Status::Succeeded } else { Status::Failed }
}

/// The status of a comparison, in which runs may fail, but must count.
pub(super) fn whether_measured(rows: &[(&str, Vec<MissionTrial>)]) -> Status {
    let is_measured = rows.iter().flat_map(|(_, trials)| trials).all(MissionTrial::is_measured);
    if is_measured { Status::Succeeded } else { Status::Failed }
}

/// A plan of the user's own, over seeds.
pub(super) fn own_plan(request: &ExperimentRequest, console: &mut Console) -> Result<ExperimentResult> {
    if let Some(row) = &request.row {
        bail!("`--row {row}` is for the experiments with a name; a plan of your own has one row");
    }
    let plan = plans::plan(&request.name).map_err(|error| {
        // Somebody may have meant an experiment and not a plan.
        match suggest(&request.name, EXPERIMENTS.iter().map(|known| known.name)) {
            Some(meant) => {
                error.context(format!("no experiment is called `{}`; did you mean `{meant}`?", request.name))
            }
            None => error,
        }
    })?;
    let scenario = request.scenario.as_deref().map(plans::scenario).transpose()?;
    let colour = console.colour;
    let at = |seed: u64| {
        let world = request.world.as_deref().map(|name| world_files::named(name, &request.robot, seed)).transpose()?;
        let settings = OfficeSettings::of(request.robot.clone());
        let site = sites::build(Setup { world, settings, ..Setup::default() }, scenario.clone(), Vec::new())?;
        let loaded = sites::load(&site, &plan, colour)?;
        Ok((site, loaded))
    };
    let first = at(request.first_seed)?;
    let is_drawn = request.world.as_deref().is_some_and(world_files::is_drawn);
    let trials = match is_drawn {
        true => all_trials(request, console, at, None, &request.name)?,
        false => all_trials(request, console, |_| Ok(first.clone()), None, &request.name)?,
    };
    let result = RowResult::of(&request.name, &trials);
    let (status, blocks) = (status(&trials), result.blocks());
    let stem = Path::new(&request.name).file_stem().map_or(request.name.as_str().into(), |stem| stem.to_string_lossy());
    let charts = over_time(&[(&stem, trials.clone())]);
    write_results(request, &[(&request.name, trials)], &charts)?;
    Ok(ExperimentResult { status, blocks, figures: json!({ "rows": [result] }) })
}

/// The runs of a plan, each at a site that has it loaded.
fn all_trials(
    request: &ExperimentRequest,
    console: &mut Console,
    at: impl Fn(u64) -> Result<(Site, Loaded)> + Sync,
    goal: Option<Goal<'_>>,
    name: &str,
) -> Result<Vec<MissionTrial>> {
    let seeds = request.seeds();
    let bar = progress::runs(seeds.len() as u64, name, console);
    let one = |seed: u64| -> Result<MissionTrial> {
        let (site, loaded) = at(seed)?;
        let system = site.start_traced(loaded, seed);
        one_trial(system, seed, request.until_us, goal)
    };
    let trials = run_all(&seeds, request.jobs, one, || bar.inc(1));
    bar.finish_and_clear();
    trials.into_iter().collect()
}
