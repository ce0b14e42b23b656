//! `rpl experiment NAME`: a plan over many seeds, in parallel, as a table.

use crate::version::BUILD;
use anyhow::{Result, bail};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_experiments::experiment_file::ExperimentFile;
use rpl_experiments::part::merging::Parts;
use rpl_experiments::part::shard::Shard;
use rpl_experiments::{Conduct, ExperimentRequest, RunSource};
use rpl_shell::arguments::completion;
use rpl_shell::arguments::duration::parse_duration_us;
use rpl_shell::arguments::site::FIRST_SEED;
use rpl_shell::files::inputs::STANDARD_INPUT;
use rpl_shell::files::module_files::{self, GoingBack, ModuleVoices};
use rpl_shell::files::project_file::{Project, ProjectFile};
use rpl_shell::files::robot_files;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use serde_json::{Map, Value, json};
use std::env;
use std::ffi::OsStr;
use std::num::NonZero;
use std::path::{Path, PathBuf};

/// Run a plan with many seeds and print a table of the results
#[derive(clap::Args, Clone, Debug)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Arguments {
    #[command(subcommand)]
    merge: Option<Merge>,
    #[arg(value_name = "NAME", help = what_name_means(), add = ArgValueCompleter::new(known))]
    name: Option<String>,
    /// Number of seeds (default: 20)
    #[arg(long, value_name = "N", value_parser = runs)]
    runs: Option<NonZero<u32>>,
    /// Number of runs at a time (default: the number of cores)
    #[arg(long, value_name = "J", value_parser = jobs_at_a_time)]
    jobs: Option<NonZero<usize>>,
    /// First seed (default: 1)
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// World, for a plan of your own
    #[arg(long, value_name = "W", add = ArgValueCompleter::new(completion::worlds))]
    world: Option<String>,
    /// Robot: a built-in name or a .toml file (default: b21)
    #[arg(long, value_name = "R", add = ArgValueCompleter::new(completion::robots))]
    robot: Option<String>,
    /// A scenario, for a plan of your own: a second plan that disturbs the world (turns the robot, closes doors, sends
    /// messages)
    #[arg(long, value_name = "FILE", add = ArgValueCompleter::new(completion::scenarios))]
    scenario: Option<String>,
    /// Manifest of a module in another process, for a plan of your own; can be repeated
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    module: Vec<String>,
    /// Set the initial value of a variable of your plan; can be repeated
    #[arg(long, value_name = "NAME=EXPR")]
    set: Vec<String>,
    /// Compare your plan with itself for several initial values of a variable; can be repeated
    #[arg(long, value_name = "NAME=A,B")]
    vary: Vec<String>,
    /// Run only this row of the table
    #[arg(long, value_name = "ROW", add = ArgValueCompleter::new(rows))]
    row: Option<String>,
    /// Drive on the recorded maps below this folder, for `buildings`
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    maps: Option<PathBuf>,
    /// Case memory of the robot at the start of each run, for `rupart` and plans of your own
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    cases: Option<PathBuf>,
    /// Write `runs.csv`, with a line for each run, and charts into this folder
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    results: Option<PathBuf>,
    /// Time limit of a run, in the plan's time; a run that takes longer has failed (default: 1h)
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us)]
    until: Option<u64>,
    /// Writes every figure of the tables as one JSON object to standard output instead
    #[arg(long)]
    json: bool,
    /// Run only the I-th of K shards of the seeds, such as 3/8
    #[arg(long, value_name = "I/K", requires = "out")]
    shard: Option<Shard>,
    /// Write the runs to this file instead of a table, for `rpl experiment merge`
    #[arg(long, value_name = "PART", value_hint = ValueHint::FilePath, conflicts_with_all = ["json", "results"])]
    out: Option<PathBuf>,
}

/// What is done with runs that are there.
#[derive(clap::Subcommand, Clone, Debug)]
enum Merge {
    /// Print the table of runs that were done in shards
    Merge(MergeArguments),
}

/// The parts of an experiment, and what is to become of them.
#[derive(clap::Args, Clone, Debug)]
struct MergeArguments {
    /// Files from `rpl experiment NAME --shard I/K --out PART`, in any order
    #[arg(value_name = "PART", required = true, value_hint = ValueHint::FilePath)]
    parts: Vec<PathBuf>,
    /// Writes every run as a line of `runs.csv`, and charts, into this folder
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    results: Option<PathBuf>,
    /// Writes every figure of the tables as one JSON object to standard output instead
    #[arg(long)]
    json: bool,
    /// Write the runs into one part instead of a table
    #[arg(long, value_name = "PART", value_hint = ValueHint::FilePath, conflicts_with_all = ["json", "results"])]
    out: Option<PathBuf>,
}

/// The runs that are made where nothing else is said.
const USUAL_RUNS: u32 = 20;

/// The time of a plan after which a run counts as failed where nothing else is said.
const USUAL_UNTIL_US: u64 = 3_600_000_000;

/// More runs than this do not fit into a table, and more jobs than this are more than any machine has
/// cores.
const MOST_RUNS: u32 = 10_000_000;
const MOST_JOBS: usize = 1_024;

fn what_name_means() -> String {
    let names: Vec<String> = rpl_experiments::names().map(|(name, _)| format!("`{name}`")).collect();
    format!(
        "{}, a plan of your own, or an experiment file (.toml) that compares variants of a plan; `-` for standard input \
         (default: the plan and world of the nearest `rpl.toml`)",
        names.join(", ")
    )
}

fn runs(text: &str) -> Result<NonZero<u32>, String> {
    let runs = text.parse().ok().filter(|runs: &NonZero<u32>| runs.get() <= MOST_RUNS);
    runs.ok_or_else(|| format!("a whole number from 1 to {MOST_RUNS} is expected"))
}

fn jobs_at_a_time(text: &str) -> Result<NonZero<usize>, String> {
    let jobs = text.parse().ok().filter(|jobs: &NonZero<usize>| jobs.get() <= MOST_JOBS);
    jobs.ok_or_else(|| format!("a whole number from 1 to {MOST_JOBS} is expected"))
}

/// Runs the experiment, or makes its table of what others have run.
///
/// # Errors
/// No experiment or plan has the name, the plan's text is wrong, a part does not fit, or the results cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let colour = console.colour;
    let (request, how, json) = match &arguments.merge {
        Some(Merge::Merge(merge)) => {
            let (request, how) = merge.request(colour)?;
            (request, how, merge.json)
        }
        None => {
            let source = RunSource::Seeds(arguments.shard.unwrap_or(Shard::WHOLE));
            let (asked, project) = arguments.in_project(console)?;
            let request = asked.request(project.as_ref(), colour)?;
            (request, Conduct { source, out: arguments.out.clone() }, arguments.json)
        }
    };
    let findings = rpl_experiments::run(&request, how, console)?;
    if json {
        console.print(&as_json(&request, findings.figures).to_string())?;
    } else {
        findings.blocks.iter().try_for_each(|block| console.block(block))?;
    }
    Ok(findings.status)
}

/// The experiment file of a name; none if it is that of a plan or an experiment.
fn experiment_file(name: &str) -> Result<Option<ExperimentFile>> {
    ExperimentFile::is_named(name).then(|| ExperimentFile::read(Path::new(name))).transpose()
}

fn jobs(asked: Option<NonZero<usize>>) -> usize {
    asked.or_else(|| std::thread::available_parallelism().ok()).map_or(1, NonZero::get)
}

impl Arguments {
    /// With what the project of the plan says. What they say themselves holds; of an experiment file, what the file says,
    /// too.
    fn in_project(&self, console: &mut Console) -> Result<(Self, Option<ProjectFile>)> {
        let mut arguments = self.clone();
        let named = arguments.name.as_slice();
        let Some(project) = Project::of(named, ("experiment", "experiment"), console)? else {
            return Ok((arguments, None));
        };
        let name = project.plan_or(arguments.name.take())?;
        let is_file = ExperimentFile::is_named(&name);
        if !is_file {
            arguments.set = project.first_values(&name, &arguments.set);
            let or = |mine: &mut Option<String>, its: &Option<String>| *mine = mine.take().or_else(|| its.clone());
            or(&mut arguments.world, &project.says.world);
            if arguments.world.is_some() {
                or(&mut arguments.robot, &project.says.robot);
                or(&mut arguments.scenario, &project.says.scenario);
            }
            arguments.seed = arguments.seed.or(project.says.seed);
            arguments.runs = arguments.runs.or(project.says.runs);
        }
        if arguments.module.is_empty() {
            arguments.module.clone_from(&project.says.modules);
            let (modules, _) = module_files::named(&arguments.module, ModuleVoices::Processes(GoingBack::Never))?;
            modules.tell(console);
        }
        arguments.name = Some(name);
        Ok((arguments, is_file.then_some(project.says)))
    }

    fn request(&self, project: Option<&ProjectFile>, colour: bool) -> Result<ExperimentRequest> {
        let name = self.name.clone().unwrap_or_default();
        if name == STANDARD_INPUT && self.out.is_some() {
            bail!("a part names its plan, and standard input has no name; write the plan into a file");
        }
        let mut file = experiment_file(&name)?;
        if let (Some(file), Some(project)) = (&mut file, project) {
            file.in_project(project);
        }
        let of_file = file.as_ref();
        let until_us = of_file.map(ExperimentFile::until_us).transpose()?.flatten();
        Ok(ExperimentRequest {
            build: BUILD,
            name,
            runs: self.runs.or(of_file.and_then(|file| file.runs)).map_or(USUAL_RUNS, NonZero::get),
            jobs: jobs(self.jobs),
            first_seed: self.seed.or(of_file.and_then(|file| file.seed)).unwrap_or(FIRST_SEED),
            world: self.world.clone(),
            robot: robot_files::named(self.robot.as_deref())?,
            robot_name: self.robot.clone(),
            file,
            modules: self.module.clone(),
            set: self.set.clone(),
            vary: self.vary.clone(),
            scenario: self.scenario.clone(),
            row: self.row.clone(),
            maps: self.maps.clone(),
            cases: self.cases.clone(),
            results: self.results.clone(),
            until_us: self.until.or(until_us).unwrap_or(USUAL_UNTIL_US),
            colour,
        })
    }
}

impl MergeArguments {
    /// What was asked for when the parts were made.
    fn request(&self, colour: bool) -> Result<(ExperimentRequest, Conduct)> {
        let parts = Parts::open(&self.parts, BUILD)?;
        let asked = parts.identity.clone();
        let request = ExperimentRequest {
            build: BUILD,
            file: experiment_file(&asked.experiment)?,
            name: asked.experiment,
            runs: asked.runs,
            jobs: jobs(None),
            first_seed: asked.first_seed,
            world: asked.world,
            robot: robot_files::named(asked.robot.as_deref())?,
            robot_name: asked.robot,
            scenario: asked.scenario,
            modules: asked.modules,
            set: asked.set,
            vary: asked.vary,
            row: asked.row,
            maps: asked.maps,
            cases: asked.cases,
            results: self.results.clone(),
            until_us: asked.until_us,
            colour,
        };
        Ok((request, Conduct { source: RunSource::Parts(Box::new(parts)), out: self.out.clone() }))
    }
}

/// The figures, behind what they are of.
fn as_json(request: &ExperimentRequest, figures: Value) -> Value {
    let mut object = Map::new();
    object.insert("experiment".to_string(), json!(request.name));
    object.insert("runs".to_string(), json!(request.runs));
    object.insert("seed".to_string(), json!(request.first_seed));
    if let Value::Object(figures) = figures {
        object.extend(figures);
    }
    Value::Object(object)
}

/// Experiments with a name, and plans.
fn known(typed: &OsStr) -> completion::Offers {
    let mut found =
        completion::beginning_with(typed, rpl_experiments::names().map(|(name, _)| (name, "an experiment")));
    found.extend(completion::plans(typed));
    found
}

/// The rows of the experiment that stands in the line.
fn rows(typed: &OsStr) -> completion::Offers {
    let words: Vec<String> = env::args().skip_while(|word| word != "experiment").collect();
    let asked = rpl_experiments::names().filter(|(name, _)| words.iter().skip(1).any(|word| word == name));
    asked.flat_map(|(_, rows)| completion::beginning_with(typed, rows.into_iter().map(|row| (row, "")))).collect()
}
