//! `rpl experiment NAME`: a plan over many seeds, in parallel, as a table.

mod statistics;
mod trials;

pub use statistics::{Spread, wilson_95};

use crate::console::Console;
use crate::drive::{Ending, Mark, Pace, Records, drive};
use crate::files::{self, PlanText};
use crate::mission::{self, Robot, Site};
use crate::status::Status;
use crate::time::parse_duration_us;
use anyhow::{Context, Result, bail};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rpl_lang::suggest::suggest;
use rpl_robot::geometry::Pose;
use rpl_robot::localization::LocalizationParameters;
use rpl_robot::office::OfficeSettings;
use rpl_runtime::system::{Outcome, System};
use std::io::IsTerminal;
use std::num::NonZero;
use trials::{Trial, comparison, run_all, table};

/// Arguments of `rpl experiment`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// `rotated`, or a plan of your own
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
    /// A run that takes longer, in the plan's time, counts as failed
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us, default_value = "1h")]
    until: u64,
}

/// An experiment with a name: a mission, and what it is compared with.
struct Experiment {
    name: &'static str,
    world: &'static str,
    /// Where the robot must really be at the end.
    goal: &'static str,
    /// The first is the experiment itself.
    rows: &'static [Row],
}

/// One row of a table.
#[derive(Clone, Copy)]
struct Row {
    name: &'static str,
    plan: &'static str,
    scenario: Option<&'static str>,
    /// Whether the filter follows the papers' equations to the letter.
    literal: bool,
}

const ROTATED: Row =
    Row { name: "rotated", plan: "delivery.rpl", scenario: Some("experiments/rotated.rpl"), literal: false };

const EXPERIMENTS: &[Experiment] = &[Experiment {
    name: "rotated",
    world: "dept",
    goal: "wolframs-shelf",
    rows: &[
        ROTATED,
        Row { name: "undisturbed", scenario: None, ..ROTATED },
        Row { name: "no relocalization", plan: "experiments/no-relocalization.rpl", ..ROTATED },
        Row { name: "literal equations", literal: true, ..ROTATED },
    ],
}];

/// How near to the goal the robot must really be.
const AT_GOAL_M: f64 = 0.5;

/// An estimate further off than this is wrong.
const WRONG_ESTIMATE_M: f64 = 1.0;

/// Runs the experiment.
///
/// # Errors
/// No experiment or plan has the name, or the plan's text is wrong.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let experiment = EXPERIMENTS.iter().find(|known| known.name == arguments.name);
    let Some(experiment) = experiment else {
        let trials = own_plan(arguments, console)?;
        console.print(&table(&arguments.name, &trials))?;
        return Ok(status(&trials));
    };
    let world = mission::world(arguments.world.as_deref().unwrap_or(experiment.world))?;
    let goal = Some(world.place(experiment.goal)?.pose_in_map);
    let mut rows = Vec::new();
    for row in experiment.rows {
        let scenario_name = row.scenario.map(|scenario| arguments.scenario.as_deref().unwrap_or(scenario));
        let scenario = scenario_name.map(files::scenario).transpose()?;
        let settings = settings(row.literal);
        let site = Site::new(Some(world.clone()), scenario, settings)?;
        let trials = all_trials(arguments, console, &site, &files::plan(row.plan)?, goal, row.name)?;
        rows.push((row.name, trials));
    }
    let (name, trials) = &rows[0];
    console.print(&table(name, trials))?;
    console.print("")?;
    console.print(&comparison(&rows))?;
    Ok(status(&rows[0].1))
}

fn status(trials: &[Trial]) -> Status {
    if trials.iter().all(|trial| trial.succeeded) { Status::Succeeded } else { Status::Failed }
}

fn settings(literal: bool) -> OfficeSettings {
    let localization = if literal { LocalizationParameters::literal() } else { LocalizationParameters::default() };
    OfficeSettings { localization, ..OfficeSettings::default() }
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
    let site = Site::new(world, scenario, settings(false))?;
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
    let seeds: Vec<u64> = (0..u64::from(arguments.runs.get())).map(|run| arguments.seed.wrapping_add(run)).collect();
    let jobs = arguments.jobs.or_else(|| std::thread::available_parallelism().ok()).map_or(1, NonZero::get);
    let bar = progress(seeds.len() as u64, console);
    bar.set_message(name.to_string());
    let one = |seed: u64| -> Result<Trial> {
        let mut system = System::traced(site.library.clone(), loaded.clone(), site.robot(seed));
        system.machine.seed_random(seed);
        one_trial(system, seed, arguments.until, goal)
    };
    let trials = run_all(&seeds, jobs, one, || bar.inc(1));
    bar.finish_and_clear();
    trials.into_iter().collect()
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

fn one_trial(mut system: System<Robot>, seed: u64, until_us: u64, goal_in_map: Option<Pose>) -> Result<Trial> {
    let mut records = Records::default();
    let mut silent = Console::silent();
    let pace = Pace { until_us: Some(until_us), factor: None };
    let ending = drive(&mut system, pace, &mut silent, &mut records).context("a run could not be driven")?;
    let mut succeeded = matches!(ending, Ending::Outcome(Outcome::Succeeded(_)));
    let mut measures = vec![("time [s]", Some(system.machine.now_s()))];
    if let (Some(account), Some(sight)) = (system.outside.account(), system.outside.sight()) {
        measures.push(("distance [m]", Some(account.distance_m)));
        measures.push(("contacts caused", Some(f64::from(account.contacts))));
        measures.push(("relocalizations", Some(records.relocalizations as f64)));
        measures.extend(disturbance(&records.marks));
        if let Some(goal_in_map) = goal_in_map {
            let off_m = sight.robot_in_map.distance_m(goal_in_map);
            succeeded &= off_m <= AT_GOAL_M;
            measures.push(("off the goal [m]", Some(off_m)));
        }
    }
    Ok(Trial { seed, succeeded, measures })
}

/// How far the robot drove from the scenario's deed until it noticed that it was lost, and how often
/// it then believed to have found its position where it was not.
fn disturbance(marks: &[Mark]) -> [(&'static str, Option<f64>); 2] {
    let deed = marks.iter().position(|mark| mark.what == "rotated by hand");
    let after = deed.map_or(&[][..], |deed| &marks[deed..]);
    let noticed = after.iter().find(|mark| mark.what == "position lost");
    let noticed_m = deed.zip(noticed).map(|(deed, noticed)| noticed.distance_m - marks[deed].distance_m);
    let is_wrong = |mark: &&Mark| {
        let off_m = mark.sight.estimate_in_map.distance_m(mark.sight.robot_in_map);
        mark.what == "position found" && off_m > WRONG_ESTIMATE_M
    };
    let wrong = deed.map(|_| after.iter().filter(is_wrong).count() as f64);
    [("noticed after [m]", noticed_m), ("wrong recoveries", wrong)]
}
