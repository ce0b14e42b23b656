//! `rpl experiment NAME`: a plan over many seeds, in parallel, as a table.

mod barn;
mod calibration;
mod catalogue;
mod chart;
mod choices;
mod day;
mod sensing;
mod statistics;
mod trial;
mod trials;
mod worlds;

pub use statistics::{Spread, wilson_95};

use crate::console::Console;
use crate::files::{self, PlanText};
use crate::mission::{self, Site};
use crate::outputs::OutputFolder;
use crate::status::Status;
use crate::time::parse_duration_us;
use anyhow::{Result, bail};
use catalogue::{EXPERIMENTS, Experiment, Report, Row};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rpl_lang::suggest::suggest;
use rpl_robot::geometry::Pose;
use rpl_robot::localization::{Calibration, LocalizationParameters};
use rpl_robot::office::OfficeSettings;
use rpl_runtime::system::System;
use std::io::IsTerminal;
use std::num::NonZero;
use std::path::PathBuf;
use trial::{Trial, one_trial};
use trials::{comparison, raw_rows, run_all, sample_rows, table};

/// Arguments of `rpl experiment`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// `rotated`, `kidnapped`, `global`, `false-alarms`, `calibration`, `deviations`, `choices`,
    /// `sensing`, `people`, `office`, `worlds`, `barn`, or a plan of your own
    #[arg(value_name = "NAME")]
    name: String,
    /// How many seeds
    #[arg(long, value_name = "N", default_value = "20")]
    runs: NonZero<u32>,
    /// How many runs at a time; as many as there are cores without
    #[arg(long, value_name = "J")]
    jobs: Option<NonZero<usize>>,
    /// The first seed
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// The world, for a plan of your own
    #[arg(long, value_name = "W")]
    world: Option<String>,
    /// What happens on the way: a plan with hands in the world
    #[arg(long, value_name = "FILE")]
    scenario: Option<String>,
    /// Only this row of the table
    #[arg(long, value_name = "ROW")]
    row: Option<String>,
    /// Writes every run as a line of `runs.csv`, and charts, into this folder
    #[arg(long, value_name = "FOLDER")]
    results: Option<PathBuf>,
    /// A run that takes longer, in the plan's time, counts as failed
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us, default_value = "1h")]
    until: u64,
}

/// Runs the experiment.
///
/// # Errors
/// No experiment or plan has the name, the plan's text is wrong, or the results cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    // Nobody waits for results that cannot be kept.
    results_folder(arguments)?;
    let experiment = EXPERIMENTS.iter().find(|known| known.name == arguments.name);
    let Some(experiment) = experiment else {
        let trials = own_plan(arguments, console)?;
        console.print(&table(&arguments.name, &trials))?;
        write_results(arguments, &[(arguments.name.as_str(), trials.clone())], &[])?;
        return Ok(status(&trials));
    };
    let chosen = || rows(experiment, arguments.row.as_deref());
    match experiment.report {
        Report::Barn => barn::run(arguments, console),
        Report::Worlds => worlds::run(arguments, console),
        Report::Sensing => sensing::run(arguments, console),
        Report::Choices => choices::run(arguments, &chosen()?, console),
        Report::Success => {
            let rows = missions(arguments, &chosen()?, console)?;
            let (name, first) = &rows[0];
            console.print(&table(name, first))?;
            console.print("")?;
            console.print(&comparison(&rows))?;
            write_results(arguments, &rows, &[("error.svg", chart::error_over_time(&rows))])?;
            Ok(status(first))
        }
        Report::Comparison => {
            let rows = missions(arguments, &chosen()?, console)?;
            console.print(&comparison(&rows))?;
            write_results(arguments, &rows, &[])?;
            Ok(whether_measured(&rows))
        }
        Report::Calibration => {
            let rows = missions(arguments, &chosen()?, console)?;
            let all: Vec<&Trial> =
                rows.iter().flat_map(|(_, trials)| trials).filter(|trial| trial.is_measured()).collect();
            let used = LocalizationParameters::default().calibration.unwrap_or_else(|| Calibration::new(&[]));
            console.print(&calibration::table(&all, &used))?;
            console.print("")?;
            console.print(&comparison(&rows))?;
            let diagram = chart::reliability(&calibration::bins(&all));
            write_results(arguments, &rows, &[("reliability.svg", diagram), ("samples.csv", sample_rows(&rows))])?;
            Ok(whether_measured(&rows))
        }
    }
}

/// The runs of each row.
fn missions(
    arguments: &Arguments,
    rows: &[&'static Row],
    console: &mut Console,
) -> Result<Vec<(&'static str, Vec<Trial>)>> {
    rows.iter().map(|row| Ok((row.name, trials_of(arguments, console, row)?))).collect()
}

/// All rows of an experiment, or the one that is asked for.
fn rows(experiment: &Experiment, name: Option<&str>) -> Result<Vec<&'static Row>> {
    let Some(name) = name else { return Ok(experiment.rows.iter().collect()) };
    let found: Vec<&Row> = experiment.rows.iter().filter(|row| row.name == name).collect();
    if found.is_empty() {
        let names: Vec<&str> = experiment.rows.iter().map(|row| row.name).collect();
        bail!("the experiment `{}` has no row `{name}`; it has {}", experiment.name, names.join(", "));
    }
    Ok(found)
}

fn trials_of(arguments: &Arguments, console: &mut Console, row: &Row) -> Result<Vec<Trial>> {
    let (site, goal) = site_of(arguments, row)?;
    all_trials(arguments, console, &site, &files::plan(row.plan)?, goal, row.name)
}

/// Where a row takes place, and where its robot must be at the end.
fn site_of(arguments: &Arguments, row: &Row) -> Result<(Site, Option<Pose>)> {
    let world = mission::world(arguments.world.as_deref().unwrap_or(row.world))?;
    let goal = row.goal.map(|goal| world.place(goal)).transpose()?.map(|place| place.pose_in_map);
    let scenario_name = row.scenario.map(|scenario| arguments.scenario.as_deref().unwrap_or(scenario));
    let scenario = scenario_name.map(files::scenario).transpose()?;
    let mut settings = OfficeSettings::default();
    (row.change)(&mut settings);
    Ok((Site::new(Some(world), scenario, settings)?, goal))
}

/// Writes every run and the charts into the folder for results, if there is to be one.
fn write_results(arguments: &Arguments, rows: &[(&str, Vec<Trial>)], charts: &[(&str, String)]) -> Result<()> {
    let mut files: Vec<(String, String)> =
        charts.iter().map(|(name, text)| ((*name).to_string(), text.clone())).collect();
    files.push(("runs.csv".to_string(), raw_rows(rows)));
    write_files(arguments, &files)
}

/// The folder for results, if there is to be one, tried.
fn results_folder(arguments: &Arguments) -> Result<Option<OutputFolder>> {
    arguments.results.as_deref().map(|path| OutputFolder::open(path, "experiment")).transpose()
}

/// Writes texts into the folder for results, if there is to be one.
fn write_files(arguments: &Arguments, files: &[(String, String)]) -> Result<()> {
    let Some(mut folder) = results_folder(arguments)? else { return Ok(()) };
    files.iter().try_for_each(|(name, text)| match name.ends_with(".svg") {
        true => folder.draw(name, text),
        false => folder.write(name, text),
    })
}

fn status(trials: &[Trial]) -> Status {
    if trials.iter().all(|trial| trial.succeeded()) { Status::Succeeded } else { Status::Failed }
}

/// The status of a comparison, in which runs may fail, but must count.
fn whether_measured(rows: &[(&str, Vec<Trial>)]) -> Status {
    let is_measured = rows.iter().flat_map(|(_, trials)| trials).all(Trial::is_measured);
    if is_measured { Status::Succeeded } else { Status::Failed }
}

/// A plan of the user's own, over seeds.
fn own_plan(arguments: &Arguments, console: &mut Console) -> Result<Vec<Trial>> {
    let plan = files::plan(&arguments.name).map_err(|error| {
        // Somebody may have meant an experiment and not a plan.
        match suggest(&arguments.name, EXPERIMENTS.iter().map(|known| known.name)) {
            Some(meant) => {
                error.context(format!("no experiment is called `{}`; did you mean `{meant}`?", arguments.name))
            }
            None => error,
        }
    })?;
    let world = arguments.world.as_deref().map(mission::world).transpose()?;
    let scenario = arguments.scenario.as_deref().map(files::scenario).transpose()?;
    let site = Site::new(world, scenario, OfficeSettings::default())?;
    all_trials(arguments, console, &site, &plan, None, &arguments.name)
}

fn all_trials(
    arguments: &Arguments,
    console: &mut Console,
    site: &Site,
    plan: &PlanText,
    goal: Option<Pose>,
    name: &str,
) -> Result<Vec<Trial>> {
    let loaded = match site.library.load(&plan.name, &plan.text, &mut plan.folder.clone()) {
        Ok(loaded) => loaded,
        Err(rejected) => bail!("{}", rejected.render(console.colour).trim_end()),
    };
    let seeds = seeds(arguments);
    let bar = progress(seeds.len() as u64, console);
    bar.set_message(name.to_string());
    let one = |seed: u64| -> Result<Trial> {
        let system = System::traced(site.library.clone(), loaded.clone(), site.robot(seed), seed);
        one_trial(system, seed, arguments.until, goal)
    };
    let trials = run_all(&seeds, jobs(arguments), one, || bar.inc(1));
    bar.finish_and_clear();
    trials.into_iter().collect()
}

fn seeds(arguments: &Arguments) -> Vec<u64> {
    (0..u64::from(arguments.runs.get())).map(|run| arguments.seed.wrapping_add(run)).collect()
}

fn jobs(arguments: &Arguments) -> usize {
    arguments.jobs.or_else(|| std::thread::available_parallelism().ok()).map_or(1, NonZero::get)
}

fn progress(runs: u64, console: &Console) -> ProgressBar {
    let is_shown = !console.quiet && std::io::stderr().is_terminal();
    let target = if is_shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let style = ProgressStyle::with_template("{msg:18} {bar:30} {pos}/{len} {eta}");
    let bar = ProgressBar::with_draw_target(Some(runs), target);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
