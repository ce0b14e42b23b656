//! `rpl run FILE`: a mission from its first form to its end.

use crate::completion;
use crate::console::Console;
use crate::drive::{Ending, Pace, Records, drive};
use crate::failure_report::{FailureRecord, PLAN_FAILED, Reporter, SCENARIO_FAILED};
use crate::figures;
use crate::files::{self, PlanText};
use crate::interrupt;
use crate::mission::{Account, Robot};
use crate::outputs::OutputFile;
use crate::overrides::{Overrides, OverridingLoader};
use crate::setting::Setting;
use crate::status::Status;
use crate::time::parse_duration_us;
use crate::trace::{self, Header, TraceFile};
use anyhow::{Context, Result};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_runtime::run::library::Loaded;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::value::Value;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Characters of the plan's value that are shown.
const LONGEST_VALUE: usize = 500;

/// Arguments of `rpl run`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// A plan file, or a built-in example; `-` for standard input
    #[arg(value_name = "FILE", add = ArgValueCompleter::new(completion::plans))]
    pub file: String,
    #[command(flatten)]
    pub setting: Setting,
    /// Another first value for a variable of the plan
    #[arg(long, value_name = "NAME=EXPR", add = ArgValueCompleter::new(completion::variables))]
    pub set: Vec<String>,
    /// Stops at this time of the plan, such as 90s or 5min
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us)]
    pub until: Option<u64>,
    /// Writes what happens as JSON Lines
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub trace: Option<PathBuf>,
    /// The trace also tells where the robot is, N times a second: its true pose, the estimate, and
    /// how certain that is
    #[arg(long, value_name = "N", requires_all = ["trace", "world"], value_parser = parse_rate)]
    pub trace_poses: Option<f64>,
    /// Writes one JSON object to standard output at the end
    #[arg(long)]
    pub json: bool,
    /// Draws map, paths and belief as SVG into this folder
    #[arg(long, value_name = "DIR", requires = "world", value_hint = ValueHint::DirPath)]
    pub figures: Option<PathBuf>,
    /// Keeps pace with the wall clock, or FACTOR times as fast
    #[arg(long, value_name = "FACTOR", num_args = 0..=1, default_missing_value = "1", value_parser = parse_factor)]
    pub realtime: Option<f64>,
    /// Steps a task may make in one instant before it counts as a runaway
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_steps: Option<u32>,
    /// Writes only what the plan prints, and failures
    #[arg(short, long)]
    pub quiet: bool,
}

fn parse_factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(factor) if factor.is_finite() && factor > 0.0 => Ok(factor),
        _ => Err("the factor must be a number above 0".to_string()),
    }
}

/// The robot makes no more steps in a second.
const MAX_POSES_PER_S: f64 = 20.0;

fn parse_rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if rate > 0.0 && rate <= MAX_POSES_PER_S => Ok(rate),
        _ => Err(format!("a number above 0 and at most {MAX_POSES_PER_S} is expected")),
    }
}

/// What `--json` writes.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    outcome: &'static str,
    value: Option<String>,
    time_s: f64,
    failure: Option<FailureRecord>,
    scenario_failure: Option<FailureRecord>,
    #[serde(flatten)]
    account: Account,
    relocalizations: u64,
    wall_s: f64,
    seed: u64,
}

/// Runs the plan.
///
/// # Errors
/// The text or the command line is wrong, or a file cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let began = Instant::now();
    let plan = files::plan(&arguments.file)?;
    let mut overrides = Overrides::parse(&arguments.set)?;
    let (site, world) = arguments.setting.site()?;
    let Some(loaded) = load(&site.library, plan, &mut overrides, console) else { return Ok(Status::Wrong) };
    overrides.check_all_used()?;

    let figures = arguments.figures.as_deref().map(figures::open_folder).transpose()?;
    let scenes = arguments.figures.is_some().then(Vec::new);
    let pose_every_us = arguments.trace_poses.map(|rate| (1e6 / rate).round() as u64);
    let mut records = Records { trace: create_trace(arguments)?, pose_every_us, scenes, ..Records::default() };
    let wants_events = records.trace.is_some() || world.is_some();
    let seed = arguments.setting.seed;
    let (library, robot) = (site.library.clone(), site.robot(seed));
    let mut system = match wants_events {
        true => System::traced(library, loaded, robot, seed),
        false => System::new(library, loaded, robot, seed),
    };
    if let Some(steps) = arguments.max_steps {
        system.machine.limits.steps = steps;
    }
    let pace = Pace { until_us: arguments.until, factor: arguments.realtime };
    let ending = {
        let _stops = interrupt::stops_runs();
        drive(&mut system, pace, console, &mut records)?
    };
    if let Some(trace) = &mut records.trace {
        trace.finish().context("the trace cannot be written")?;
    }
    if let (Some(mut folder), Some(world)) = (figures, &world) {
        figures::write_mission(&mut folder, world, &records, system.outside.belief().as_ref())?;
    }
    let summary = summarize(&system, ending, &records, arguments.setting.seed, began);
    report(&system, ending, &summary, console);
    if arguments.json {
        console.print(&summary.as_json()?)?;
    }
    console.flush()?;
    Ok(status(&system, ending))
}

/// Compiles a plan, and shows what was found. None if it cannot run.
fn load(
    library: &rpl_runtime::run::library::Library,
    plan: PlanText,
    overrides: &mut Overrides,
    console: &mut Console,
) -> Option<Loaded> {
    let PlanText { name, text, mut folder } = plan;
    let text = overrides.apply(text);
    let mut loader = OverridingLoader { inner: &mut folder, overrides };
    match library.load(&name, &text, &mut loader) {
        Ok(loaded) => {
            if !loaded.warnings.is_empty() && !console.quiet {
                let sources = &loaded.program.sources;
                console.note(rpl_lang::diagnostic::render(&loaded.warnings, sources, console.colour).trim_end());
            }
            Some(loaded)
        }
        Err(rejected) => {
            console.note(rejected.render(console.colour).trim_end());
            None
        }
    }
}

fn create_trace(arguments: &Arguments) -> Result<Option<TraceFile>> {
    let Some(path) = &arguments.trace else { return Ok(None) };
    let header = Header {
        version: trace::VERSION,
        rpl: Some(env!("CARGO_PKG_VERSION").to_string()),
        plan: arguments.file.clone(),
        world: arguments.setting.world.clone(),
        map: arguments.setting.world.is_some().then(|| arguments.setting.map.name().to_string()),
        scenario: arguments.setting.scenario.clone(),
        seed: arguments.setting.seed,
    };
    let file = OutputFile::open(path, "the trace")?.begin()?;
    let trace =
        TraceFile::begin(file, &header).with_context(|| format!("cannot write the trace `{}`", path.display()))?;
    Ok(Some(trace))
}

/// The exit status an ending means. What a plan did beside a scenario that failed is not what it was
/// to show.
pub fn status(system: &System<Robot>, ending: Ending) -> Status {
    match ending {
        Ending::Outcome(Outcome::Succeeded(_)) if system.outside.failed_scenario().is_some() => Status::Failed,
        Ending::Outcome(Outcome::Succeeded(_)) => Status::Succeeded,
        Ending::Outcome(Outcome::Failed(_) | Outcome::Evaporated) => Status::Failed,
        Ending::TimeUp => Status::TimeUp,
        Ending::Interrupted | Ending::GivenUp => Status::Interrupted,
    }
}

fn reporter<'a>(system: &'a System<Robot>, console: &Console) -> Reporter<'a> {
    Reporter { machine: &system.machine, program: &system.program, colour: console.colour }
}

impl Summary {
    /// The summary as one JSON object.
    ///
    /// # Errors
    /// A fault of the program.
    pub fn as_json(&self) -> Result<String> {
        serde_json::to_string(self).context("the summary cannot be written as JSON")
    }
}

/// What came of a run.
pub fn summarize(system: &System<Robot>, ending: Ending, records: &Records, seed: u64, began: Instant) -> Summary {
    let value = match ending {
        Ending::Outcome(Outcome::Succeeded(value)) => Some(system.machine.write(&system.program, value)),
        _ => None,
    };
    let failure = match ending {
        Ending::Outcome(Outcome::Failed(failure)) => {
            Reporter { machine: &system.machine, program: &system.program, colour: false }.record(failure)
        }
        _ => None,
    };
    Summary {
        outcome: match ending {
            Ending::Outcome(Outcome::Succeeded(_)) => "succeeded",
            Ending::Outcome(Outcome::Failed(_) | Outcome::Evaporated) => "failed",
            Ending::TimeUp => "timeout",
            Ending::Interrupted | Ending::GivenUp => "interrupted",
        },
        value,
        scenario_failure: system.outside.failed_scenario().and_then(|(scenario, failure)| {
            Reporter { machine: &scenario.machine, program: &scenario.program, colour: false }.record(failure)
        }),
        time_s: system.machine.now_s(),
        failure,
        account: system.outside.account().unwrap_or_default(),
        relocalizations: records.relocalizations,
        wall_s: (began.elapsed().as_secs_f64() * 1e3).round() / 1e3,
        seed,
    }
}

/// Tells a person how it went.
fn report(system: &System<Robot>, ending: Ending, summary: &Summary, console: &mut Console) {
    if let Ending::Outcome(Outcome::Failed(failure)) = ending {
        let text = reporter(system, console).text(PLAN_FAILED, failure);
        console.note(text.trim_end());
    }
    tell_failed_scenario(system, console);
    if console.quiet {
        return;
    }
    if let (Ending::Outcome(Outcome::Succeeded(value)), Some(text)) = (ending, &summary.value)
        && value != Value::Nil
    {
        console.note(&format!("value: {}", beginning(text)));
    }
    // A plan without a robot that succeeded has nothing else to say.
    let is_plain_success =
        matches!(ending, Ending::Outcome(Outcome::Succeeded(_))) && system.outside.account().is_none();
    if is_plain_success {
        return;
    }
    let how = match ending {
        Ending::Outcome(Outcome::Succeeded(_)) => format!("succeeded after {:.1} s", summary.time_s),
        Ending::Outcome(Outcome::Failed(_)) => format!("failed after {:.1} s", summary.time_s),
        Ending::Outcome(Outcome::Evaporated) => format!("ended itself after {:.1} s", summary.time_s),
        Ending::TimeUp => format!("cut off by --until, the last instant at {:.1} s", summary.time_s),
        Ending::Interrupted => format!("interrupted at {:.1} s, clean-ups done", summary.time_s),
        Ending::GivenUp => {
            format!("interrupted at {:.1} s, a clean-up that computed without end given up", summary.time_s)
        }
    };
    let robot = system.outside.account().map_or(String::new(), |account| describe(account, summary.relocalizations));
    let scenario = if summary.scenario_failure.is_some() { ", beside a scenario that failed" } else { "" };
    console.note(&format!("{how}{scenario}{robot} ({:.1} s of computing)", summary.wall_s));
}

/// Tells of the failure of the scenario, if it has failed.
pub fn tell_failed_scenario(system: &System<Robot>, console: &mut Console) {
    if let Some((scenario, failure)) = system.outside.failed_scenario() {
        let reporter = Reporter { machine: &scenario.machine, program: &scenario.program, colour: console.colour };
        console.note(reporter.text(SCENARIO_FAILED, failure).trim_end());
    }
}

/// As much of a value as a person wants to see; `--json` has all of it.
fn beginning(text: &str) -> String {
    match text.char_indices().nth(LONGEST_VALUE) {
        Some((end, _)) => format!("{}… ({} characters; `--json` has them all)", &text[..end], text.chars().count()),
        None => text.to_string(),
    }
}

fn describe(account: Account, relocalizations: u64) -> String {
    let plural = |count: u64, noun: &str| match count {
        0 => format!("no {noun}"),
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    };
    format!(
        ", {:.1} m driven, {}, {}",
        account.distance_m,
        plural(u64::from(account.contacts), "contact"),
        plural(relocalizations, "relocalization")
    )
}
