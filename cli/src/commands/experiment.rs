//! `rpl experiment NAME`: a plan over many seeds, in parallel, as a table.

use crate::arguments::completion;
use crate::arguments::duration::parse_duration_us;
use crate::experiment::{self, ExperimentRequest};
use crate::files::robot_files;
use crate::status::Status;
use crate::terminal::console::Console;
use anyhow::Result;
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use serde_json::{Map, Value, json};
use std::num::NonZero;
use std::path::PathBuf;

/// Runs a plan with many seeds and makes a table
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// `rotated`, `kidnapped`, `global`, `false-alarms`, `calibration`, `deviations`, `choices`,
    /// `sensing`, `people`, `office`, `worlds`, `doors`, `barn`, `marker-detection`, `hallway-features`,
    /// `count-openings`, `office-delivery`, `topological-global`, `routes`, `case-kinds`, `behaviours`, `rupart`, or a plan of your own; `-` for standard
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
    /// The robot: a built-in name, or a .toml file; `b21` without
    #[arg(long, value_name = "R", add = ArgValueCompleter::new(completion::robots))]
    robot: Option<String>,
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
    let request = arguments.request()?;
    // Nobody waits for results that cannot be kept.
    request.results_folder()?;
    let findings = experiment::run(&request, console)?;
    if arguments.json {
        console.print(&as_json(arguments, findings.figures).to_string())?;
    } else {
        findings.blocks.iter().try_for_each(|block| console.block(block))?;
    }
    Ok(findings.status)
}

impl Arguments {
    fn request(&self) -> Result<ExperimentRequest> {
        let as_many_as_cores = || std::thread::available_parallelism().ok();
        Ok(ExperimentRequest {
            name: self.name.clone(),
            runs: self.runs.get(),
            jobs: self.jobs.or_else(as_many_as_cores).map_or(1, NonZero::get),
            first_seed: self.seed,
            world: self.world.clone(),
            robot: robot_files::named(self.robot.as_deref())?,
            scenario: self.scenario.clone(),
            row: self.row.clone(),
            results: self.results.clone(),
            until_us: self.until,
        })
    }
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
