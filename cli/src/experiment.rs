//! `rpl experiment NAME`: a plan over many seeds, in parallel, as a table.

mod barn;
mod calibration;
mod catalogue;
mod chart;
mod choices;
mod day;
mod doors;
mod row_result;
mod sensing;
mod statistics;
mod trial;
mod trials;
mod worlds;

pub use row_result::NOTHING;
pub use statistics::{Share, Spread};

use crate::completion;
use crate::console::Console;
use crate::files::{self, PlanText};
use crate::mission::{self, Site};
use crate::outputs::OutputFolder;
use crate::page::Block;
use crate::status::Status;
use crate::time::parse_duration_us;
use anyhow::{Result, bail};
use catalogue::{EXPERIMENTS, Experiment, Report, Row};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use row_result::{RowResult, comparison};
use rpl_lang::suggest::suggest;
use rpl_robot::localization::{Calibration, LocalizationParameters};
use rpl_robot::office::OfficeSettings;
use rpl_runtime::run::system::System;
use serde_json::{Map, Value, json};
use std::io::IsTerminal;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use trial::{Goal, Trial, one_trial};
use trials::{raw_rows, run_all, sample_rows};

/// Arguments of `rpl experiment`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// `rotated`, `kidnapped`, `global`, `false-alarms`, `calibration`, `deviations`, `choices`,
    /// `sensing`, `people`, `office`, `worlds`, `doors`, `barn`, or a plan of your own; `-` for standard
    /// input
    #[arg(value_name = "NAME", add = ArgValueCompleter::new(completion::experiments))]
    name: String,
    /// How many seeds
    #[arg(long, value_name = "N", default_value = "20", value_parser = runs)]
    runs: NonZero<u32>,
    /// How many runs at a time; as many as there are cores without
    #[arg(long, value_name = "J", value_parser = jobs_at_a_time)]
    jobs: Option<NonZero<usize>>,
    /// The first seed
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// The world, for a plan of your own
    #[arg(long, value_name = "W", add = ArgValueCompleter::new(completion::worlds))]
    world: Option<String>,
    /// What happens on the way: a plan with hands in the world
    #[arg(long, value_name = "FILE", add = ArgValueCompleter::new(completion::scenarios))]
    scenario: Option<String>,
    /// Only this row of the table
    #[arg(long, value_name = "ROW", add = ArgValueCompleter::new(completion::rows))]
    row: Option<String>,
    /// Writes every run as a line of `runs.csv`, and charts, into this folder
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    results: Option<PathBuf>,
    /// A run that takes longer, in the plan's time, counts as failed
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us, default_value = "1h")]
    until: u64,
    /// Writes every figure of the tables as one JSON object to standard output instead
    #[arg(long)]
    json: bool,
}

/// What an experiment has found.
struct Findings {
    status: Status,
    /// For people.
    blocks: Vec<Block>,
    /// For programs: the same figures.
    figures: Value,
}

/// More runs than this do not fit into a table, and more jobs than this are more than any machine has
/// cores.
const MOST_RUNS: u32 = 10_000_000;
const MOST_JOBS: usize = 1_024;

fn runs(text: &str) -> Result<NonZero<u32>, String> {
    let runs = text.parse().ok().filter(|runs: &NonZero<u32>| runs.get() <= MOST_RUNS);
    runs.ok_or_else(|| format!("a whole number from 1 to {MOST_RUNS} is expected"))
}

fn jobs_at_a_time(text: &str) -> Result<NonZero<usize>, String> {
    let jobs = text.parse().ok().filter(|jobs: &NonZero<usize>| jobs.get() <= MOST_JOBS);
    jobs.ok_or_else(|| format!("a whole number from 1 to {MOST_JOBS} is expected"))
}

/// Runs the experiment.
///
/// # Errors
/// No experiment or plan has the name, the plan's text is wrong, or the results cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    // Nobody waits for results that cannot be kept.
    results_folder(arguments)?;
    let findings = find_out(arguments, console)?;
    if arguments.json {
        console.print(&as_json(arguments, findings.figures).to_string())?;
    } else {
        findings.blocks.iter().try_for_each(|block| console.block(block))?;
    }
    Ok(findings.status)
}

/// The figures, behind what they are of.
fn as_json(arguments: &Arguments, figures: Value) -> Value {
    let mut object = Map::new();
    object.insert("experiment".to_string(), json!(arguments.name));
    object.insert("runs".to_string(), json!(arguments.runs));
    object.insert("seed".to_string(), json!(arguments.seed));
    if let Value::Object(figures) = figures {
        object.extend(figures);
    }
    Value::Object(object)
}

fn find_out(arguments: &Arguments, console: &mut Console) -> Result<Findings> {
    let experiment = EXPERIMENTS.iter().find(|known| known.name == arguments.name);
    let Some(experiment) = experiment else { return own_plan(arguments, console) };
    let chosen = || rows(experiment, arguments.row.as_deref());
    match experiment.report {
        Report::Barn => barn::run(arguments, console),
        Report::Worlds => worlds::run(arguments, console),
        Report::Doors => doors::run(arguments, console),
        Report::Sensing => sensing::run(arguments, console),
        Report::Choices => choices::run(arguments, &chosen()?, console),
        Report::Success => {
            let rows = missions(arguments, &chosen()?, console)?;
            let results = results(&rows);
            write_results(arguments, &rows, &over_time(&rows))?;
            let mut blocks = results[0].blocks();
            blocks.push(Block::Lines(String::new()));
            blocks.extend(comparison(&results));
            Ok(Findings { status: status(&rows[0].1), blocks, figures: json!({ "rows": results }) })
        }
        Report::Comparison => {
            let rows = missions(arguments, &chosen()?, console)?;
            let results = results(&rows);
            write_results(arguments, &rows, &[])?;
            let blocks = comparison(&results);
            Ok(Findings { status: whether_measured(&rows), blocks, figures: json!({ "rows": results }) })
        }
        Report::Calibration => {
            let rows = missions(arguments, &chosen()?, console)?;
            let results = results(&rows);
            let all: Vec<&Trial> =
                rows.iter().flat_map(|(_, trials)| trials).filter(|trial| trial.is_measured()).collect();
            let used = LocalizationParameters::default().calibration.unwrap_or_else(|| Calibration::new(&[]));
            let reliability = calibration::Reliability::of(&all, &used);
            let diagram = chart::reliability(&reliability.bins);
            write_results(arguments, &rows, &[("reliability.svg", diagram), ("samples.csv", sample_rows(&rows))])?;
            let mut blocks = reliability.blocks();
            blocks.push(Block::Lines(String::new()));
            blocks.extend(comparison(&results));
            let figures = json!({ "reliability": reliability, "rows": results });
            Ok(Findings { status: whether_measured(&rows), blocks, figures })
        }
    }
}

fn results(rows: &[(&str, Vec<Trial>)]) -> Vec<RowResult> {
    rows.iter().map(|(name, trials)| RowResult::of(name, trials)).collect()
}

/// The charts of missions: how many have succeeded by which time, and, where there is a robot, how
/// far its estimate is off.
fn over_time(rows: &[(&str, Vec<Trial>)]) -> Vec<(&'static str, String)> {
    let measured = |trials: &[Trial]| trials.iter().filter(|trial| trial.is_measured()).cloned().collect();
    let rows: &[(&str, Vec<Trial>)] = &rows.iter().map(|(name, trials)| (*name, measured(trials))).collect::<Vec<_>>();
    let has_robot = rows.iter().flat_map(|(_, trials)| trials).any(|trial| !trial.samples.is_empty());
    let mut charts = vec![("success.svg", chart::success_over_time(rows))];
    charts.extend(has_robot.then(|| ("error.svg", chart::error_over_time(rows))));
    charts
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
        bail!(no_row(experiment.name, name, &row_names(experiment)));
    }
    Ok(found)
}

/// What is said of a row that an experiment does not have.
fn no_row(experiment: &str, name: &str, rows: &[&str]) -> String {
    let meant = suggest(name, rows.iter().copied()).map_or(String::new(), |meant| format!("; did you mean `{meant}`?"));
    let stop = if meant.is_empty() { ";" } else { "" };
    format!("the experiment `{experiment}` has no row `{name}`{meant}{stop} it has {}", quoted(rows))
}

fn quoted(names: &[&str]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// What can be asked for with `--row`.
fn row_names(experiment: &Experiment) -> Vec<&'static str> {
    match experiment.report {
        Report::Barn => barn::row_names(),
        Report::Worlds => catalogue::WORLDS.to_vec(),
        Report::Doors => doors::WORLDS.to_vec(),
        Report::Sensing => sensing::row_names(),
        Report::Success | Report::Comparison | Report::Calibration | Report::Choices => {
            experiment.rows.iter().map(|row| row.name).collect()
        }
    }
}

/// The experiments with a name, each with its rows.
pub fn names() -> impl Iterator<Item = (&'static str, Vec<&'static str>)> {
    EXPERIMENTS.iter().map(|experiment| (experiment.name, row_names(experiment)))
}

fn trials_of(arguments: &Arguments, console: &mut Console, row: &Row) -> Result<Vec<Trial>> {
    let (site, goal) = site_of(arguments, row)?;
    all_trials(arguments, console, &site, &files::plan(row.plan)?, goal, row.name)
}

/// Where a row takes place, and where its robot must be at the end.
fn site_of(arguments: &Arguments, row: &Row) -> Result<(Site, Option<Goal<'static>>)> {
    let world = mission::world(arguments.world.as_deref().unwrap_or(row.world))?;
    let place = row.goal.map(|goal| world.place(goal)).transpose()?;
    let goal = place.map(|place| Goal { pose_in_map: place.pose_in_map, item: row.item });
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
fn own_plan(arguments: &Arguments, console: &mut Console) -> Result<Findings> {
    if let Some(row) = &arguments.row {
        bail!("`--row {row}` is for the experiments with a name; a plan of your own has one row");
    }
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
    let trials = all_trials(arguments, console, &site, &plan, None, &arguments.name)?;
    let result = RowResult::of(&arguments.name, &trials);
    let (status, blocks) = (status(&trials), result.blocks());
    let stem =
        Path::new(&arguments.name).file_stem().map_or(arguments.name.as_str().into(), |stem| stem.to_string_lossy());
    let charts = over_time(&[(&stem, trials.clone())]);
    write_results(arguments, &[(&arguments.name, trials)], &charts)?;
    Ok(Findings { status, blocks, figures: json!({ "rows": [result] }) })
}

fn all_trials(
    arguments: &Arguments,
    console: &mut Console,
    site: &Site,
    plan: &PlanText,
    goal: Option<Goal<'_>>,
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
