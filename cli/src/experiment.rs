//! `rpl experiment NAME`: a plan over many seeds, in parallel, as a table.

mod statistics;
mod trials;

use crate::console::Console;
use crate::drive::{Ending, Pace, Records, drive};
use crate::files;
use crate::mission::{self, Robot, Site};
use crate::status::Status;
use crate::time::parse_duration_us;
use anyhow::{Context, Result, bail};
use indicatif::{ProgressBar, ProgressDrawTarget};
use rpl_lang::suggest::suggest;
use rpl_runtime::system::{Outcome, System};
use std::io::IsTerminal;
use std::num::NonZero;
use trials::{Trial, run_all, table};

/// Arguments of `rpl experiment`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// An experiment, or a plan of your own
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

/// An experiment with a name.
struct Experiment {
    name: &'static str,
    plan: &'static str,
    world: &'static str,
    scenario: Option<&'static str>,
}

const EXPERIMENTS: &[Experiment] =
    &[Experiment { name: "rotated", plan: "delivery.rpl", world: "dept", scenario: Some("rotated.rpl") }];

/// Runs the experiment.
///
/// # Errors
/// No experiment or plan has the name, or the plan's text is wrong.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let experiment = EXPERIMENTS.iter().find(|known| known.name == arguments.name);
    let plan_name = experiment.map_or(arguments.name.as_str(), |experiment| experiment.plan);
    let world = arguments.world.as_deref().or(experiment.map(|experiment| experiment.world));
    let plan = files::plan(plan_name).map_err(|error| {
        match suggest(&arguments.name, EXPERIMENTS.iter().map(|known| known.name)) {
            Some(meant) => {
                error.context(format!("no experiment is called `{}`; did you mean `{meant}`?", arguments.name))
            }
            None => error,
        }
    })?;
    let world = world.map(mission::world).transpose()?;
    let scenario_name = arguments.scenario.as_deref().or(experiment.and_then(|experiment| experiment.scenario));
    let scenario = scenario_name.map(files::scenario).transpose()?;
    let site = Site::new(world, scenario)?;
    let loaded = match site.library.load(&plan.name, &plan.text, &mut plan.folder.clone()) {
        Ok(loaded) => loaded,
        Err(rejected) => bail!("{}", rejected.render(console.colour).trim_end()),
    };

    let seeds: Vec<u64> = (0..u64::from(arguments.runs.get())).map(|run| arguments.seed.wrapping_add(run)).collect();
    let jobs = arguments.jobs.or_else(|| std::thread::available_parallelism().ok()).map_or(1, NonZero::get);
    let bar = progress(seeds.len() as u64, console);
    let one = |seed: u64| -> Result<Trial> {
        let system = System::traced(site.library.clone(), loaded.clone(), site.robot(seed));
        one_trial(system, seed, arguments.until)
    };
    let trials = run_all(&seeds, jobs, one, || bar.inc(1));
    bar.finish_and_clear();
    let trials = trials.into_iter().collect::<Result<Vec<Trial>>>()?;
    console.print(&table(&arguments.name, &trials))?;
    Ok(if trials.iter().all(|trial| trial.succeeded) { Status::Succeeded } else { Status::Failed })
}

fn progress(runs: u64, console: &Console) -> ProgressBar {
    let is_shown = !console.quiet && std::io::stderr().is_terminal();
    let target = if is_shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    ProgressBar::with_draw_target(Some(runs), target)
}

fn one_trial(mut system: System<Robot>, seed: u64, until_us: u64) -> Result<Trial> {
    let mut records = Records::default();
    let mut silent = Console::silent();
    let pace = Pace { until_us: Some(until_us), factor: None };
    let ending = drive(&mut system, pace, &mut silent, &mut records).context("a run could not be driven")?;
    let account = system.outside.account();
    let mut measures = vec![("time [s]", system.machine.now_s())];
    if let Some(account) = account {
        measures.push(("distance [m]", account.distance_m));
        measures.push(("contacts", f64::from(account.contacts)));
        measures.push(("relocalizations", records.relocalizations as f64));
    }
    Ok(Trial { seed, succeeded: matches!(ending, Ending::Outcome(Outcome::Succeeded(_))), measures })
}
