//! `rpl run FILE`: a mission from its first form to its end.

use crate::version::BUILD;
use anyhow::{Context, Result, anyhow, bail};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_drive::hosts::{HostArguments, HostSource, Use};
use rpl_drive::journal::{KeptRun, KeptText, RunJournal, Writing};
use rpl_drive::mcap::McapRecording;
use rpl_drive::observed::Observed;
use rpl_drive::onlooker::Onlooker;
use rpl_drive::prepared_run::{PreparedRun, WrittenAtEnd};
use rpl_drive::recorded_run::{RecordedRun, RecordedText};
use rpl_drive::run_driver::Pace;
use rpl_drive::run_record::Records;
use rpl_drive::seen::{LiveArguments, SeenRun, plan_texts};
use rpl_drive::show::figures;
use rpl_drive::trace::TraceFile;
use rpl_explore::schedule_text;
use rpl_lang::visible::visible;
use rpl_mission::robot::Robot;
use rpl_mission::site::Site;
use rpl_robot::world::World;
use rpl_runtime::run::library::{Library, Loaded};
use rpl_runtime::run::system::System;
use rpl_runtime::state::schedule::{Deviation, Schedule};
use rpl_shell::arguments::completion;
use rpl_shell::arguments::duration::parse_duration_us;
use rpl_shell::arguments::journal::JournalArguments;
use rpl_shell::arguments::site::SiteArguments;
use rpl_shell::files::inputs;
use rpl_shell::files::module_files::{GoingBack, ModuleVoices};
use rpl_shell::files::outputs::OutputFile;
use rpl_shell::files::overrides::{Overrides, OverridingLoader};
use rpl_shell::files::plans;
use rpl_shell::files::plans::PlanText;
use rpl_shell::files::project_file::Project;
use rpl_shell::files::shown::Shown;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Run a plan
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Plan file, built-in example, or the `rpl.toml` of a project; `-` for standard input (default: the plan and world
    /// of the nearest `rpl.toml`, in this folder or above)
    #[arg(value_name = "FILE", add = ArgValueCompleter::new(completion::plans))]
    pub file: Option<String>,
    #[command(flatten)]
    pub site: SiteArguments,
    #[command(flatten)]
    pub host: HostArguments,
    /// Set the initial value of a variable of the plan; can be repeated
    #[arg(long, value_name = "NAME=EXPR", add = ArgValueCompleter::new(completion::variables))]
    pub set: Vec<String>,
    /// Stop at this time of the plan, such as 90s or 5min
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us)]
    pub until: Option<u64>,
    /// Run in real time, or FACTOR times as fast
    #[arg(long, value_name = "FACTOR", num_args = 0..=1, default_missing_value = "1", value_parser = parse_factor)]
    pub realtime: Option<f64>,
    /// Limit of the steps of all tasks in one instant; beyond it the plan fails as a runaway
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub max_steps: Option<u32>,
    /// Run the tasks that are ready at the same time in the order of this file, which `rpl explore` has written
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub schedule: Option<PathBuf>,
    /// Case memory of the robot: read at the start if the file exists, written at the end
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub cases: Option<PathBuf>,
    #[command(flatten)]
    pub journal: JournalArguments,
    #[command(flatten)]
    pub output: Output,
}

/// What is written of a run.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Output {
    /// Write the events of the run to this file, as JSON Lines
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub trace: Option<PathBuf>,
    /// Add the robot's true pose, its estimate and its certainty to the trace, N times a second
    #[arg(long, value_name = "N", requires = "trace", value_parser = parse_rate)]
    pub trace_poses: Option<f64>,
    /// Write a recording for ROS tools: map, frames, sensors, estimate, belief, commands, targets, log and events
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub mcap: Option<PathBuf>,
    /// Print one JSON object to standard output at the end
    #[arg(long)]
    pub json: bool,
    /// Draw map, paths and belief as SVG and PNG into this folder
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub figures: Option<PathBuf>,
    /// Also draw each choice of active localization: occupancy, cost, entropy and pay-off of all target points
    #[arg(long, requires = "figures")]
    pub choices: bool,
    #[command(flatten)]
    pub live: LiveArguments,
    /// Print only the plan's own output, and failures
    #[arg(short, long)]
    pub quiet: bool,
}

/// A factor of time.
///
/// # Errors
/// It is no number above 0.
pub fn parse_factor(text: &str) -> Result<f64, String> {
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

/// Runs the plan.
///
/// # Errors
/// The text or the command line is wrong, or a file cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    if arguments.journal.journal.is_some() && arguments.output.figures.is_some() {
        bail!(
            "figures are of a whole run, and one with a journal may go on in another process; the same run without \
             `--journal` draws the same ones"
        );
    }
    if arguments.journal.journal.is_some() && arguments.output.mcap.is_some() {
        bail!(
            "an MCAP recording is of a whole run, and one with a journal may go on in another process; the same run without \
             `--journal` records the same"
        );
    }
    if arguments.schedule.is_some() && (arguments.journal.journal.is_some() || arguments.host.record.is_some()) {
        bail!(
            "a run in another order is not gone on with or replayed; leave `--schedule` away, or `--journal` and `--record`"
        );
    }
    if arguments.output.live.control && (arguments.journal.journal.is_some() || arguments.host.record.is_some()) {
        bail!(
            "a run that is gone on with or replayed is not steered by hand; leave `--control` away, or `--journal` and `--record`"
        );
    }
    if arguments.journal.journal.is_some() && arguments.output.live.report.is_some() {
        bail!(
            "a report is of a whole run, and one with a journal may go on in another process; `rpl view` shows a journal"
        );
    }
    if arguments.cases.is_some() && (arguments.journal.journal.is_some() || arguments.host.record.is_some()) {
        bail!(
            "a case file changes with each run, and a run that is gone on with or replayed must find it as it was; leave \
             `--cases` away, or `--journal` and `--record`"
        );
    }
    let arguments = in_project(arguments, console)?;
    let source = arguments.host.reach(&arguments.site, arguments.file.as_deref().unwrap_or_default())?;
    run_on(&arguments, source, ModuleVoices::Processes(GoingBack::Never), None, console)
}

/// The arguments, with what the project of the plan says. What they say themselves holds.
fn in_project(arguments: &Arguments, console: &mut Console) -> Result<Arguments> {
    let mut arguments = arguments.clone();
    let named = arguments.file.as_slice();
    let Some(project) = Project::of(named, ("run", "plan"), console)? else { return Ok(arguments) };
    let plan = project.plan_or(arguments.file.take())?;
    arguments.set = project.first_values(&plan, &arguments.set);
    arguments.file = Some(plan);
    arguments.site.in_project(&project.says);
    if arguments.host.host.is_some() {
        // Nothing happens to a robot there but what happens.
        arguments.site.scenario = None;
    }
    Ok(arguments)
}

/// Runs the plan on a host, with these voices of its modules, up to where it was told to stop if it is
/// repeated.
///
/// # Errors
/// As for [`run`].
pub fn run_on(
    arguments: &Arguments,
    source: HostSource,
    voices: ModuleVoices<'_>,
    stopped_us: Option<u64>,
    console: &mut Console,
) -> Result<Status> {
    let began = Instant::now();
    let file = arguments.file.as_deref().context("there is no plan to run")?;
    let plan = plans::plan(file)?;
    let (recorded_plan, kept_plan) = (RecordedText::of(file, &plan), KeptText::of(&plan));
    let output = &arguments.output;
    let schedule = arguments.schedule.as_deref().map(deviations_in).transpose()?;
    let (site, world, modules, cases) = arguments.site.build_with(voices, arguments.cases.as_deref())?;
    if world.is_none() && (output.figures.is_some() || output.trace_poses.is_some()) {
        bail!("without a robot there are no poses and no figures; add `--world dept`");
    }
    let checked = (!source.is_recording() && !console.quiet && io::stderr().is_terminal()).then(|| plan.clone());
    let Some(loaded) = load(&site.library, plan, &arguments.set, console)? else { return Ok(Status::Wrong) };
    if let Some(plan) = checked {
        tell_warnings(&site.library, &plan, file, loaded.warnings.len(), console);
    }

    let figures = output.figures.as_deref().map(figures::open_folder).transpose()?;
    let observed = Observed::with_scenes(output.figures.is_some());
    let pose_every_us = output.trace_poses.map(|rate| (1e6 / rate).round() as u64);
    let seed = arguments.site.seed();
    let recorded = RecordedRun {
        plan: Some(recorded_plan),
        set: arguments.set.clone(),
        until_us: arguments.until,
        max_steps: arguments.max_steps,
        host: source.heard(),
        ..RecordedRun::at(&arguments.site, world.as_ref())?
    };
    let recorder = arguments.host.record(&recorded)?;
    let texts = plan_texts(&loaded.program);
    let (seen, steering) =
        SeenRun::begin(&output.live, &recorded.trace_header(), texts, (&site, world.as_ref()), console)?;
    let (mut journal, trace) = match &arguments.journal.journal {
        Some(path) => {
            let (journal, trace) = begin_journal(path, arguments, recorded, kept_plan, (&site, world.as_ref()))?;
            (Some(journal), trace)
        }
        None => (None, create_trace(output, &recorded)?),
    };
    let mcap = output.mcap.as_ref().map(|path| OutputFile::open(path, "the MCAP recording")?.begin()).transpose()?;
    let mut onlookers: Vec<Box<dyn Onlooker>> = Vec::new();
    if let Some(file) = mcap {
        onlookers.push(Box::new(McapRecording::begin(file, site.office())?));
    }
    onlookers.extend(seen.map(|seen| Box::new(seen) as Box<dyn Onlooker>));
    let wants_events = trace.is_some() || site.period_us().is_some() || !onlookers.is_empty();
    let hearing = recorder.clone().or_else(|| journal.as_ref().and_then(RunJournal::recorder));
    if arguments.site.tells_modules {
        modules.tell(console);
    }
    modules.start(&site, seed, hearing.as_ref())?;
    let (robot, host_lines) = source.robot(&site, seed, Use::Run, hearing)?;
    let mut system = begun(&site, loaded, robot, seed, arguments.max_steps, wants_events);
    system.machine.schedule = schedule.map(|deviations| Box::new(Schedule::new(deviations)));
    if let Some(journal) = &mut journal {
        journal.instant_begun(&system);
    }
    let records =
        Records { trace, journal, recorder, pose_every_us, steering, observed, onlookers, ..Records::default() };
    let factor = Pace::factor_at(&site, arguments.realtime);
    let pace = Pace { until_us: arguments.until, stopped_us, factor };
    let written_at_end = WrittenAtEnd { cases, figures, draws_choices: output.choices, json: output.json };
    PreparedRun { site, world, system, seed, pace, records, host_lines, modules, written_at_end, began }.drive(console)
}

/// The deviations of a schedule.
fn deviations_in(path: &Path) -> Result<Vec<Deviation>> {
    let read = inputs::read_text(path).and_then(|text| schedule_text::read(&text));
    read.map_err(|why| anyhow!("`{}`: {why}", path.shown()))
}

/// A run at its start.
pub fn begun(
    site: &Site,
    loaded: Loaded,
    robot: Robot,
    seed: u64,
    max_steps: Option<u32>,
    wants_events: bool,
) -> System<Robot> {
    let mut system = match wants_events {
        true => site.start_traced_with(robot, loaded, seed),
        false => System::new(site.library.clone(), loaded, robot, seed),
    };
    if let Some(steps) = max_steps {
        system.machine.limits.steps = steps;
    }
    system
}

/// The journal of a run that is about to begin, and its trace.
fn begin_journal(
    path: &Path,
    arguments: &Arguments,
    recorded: RecordedRun,
    plan: KeptText,
    (site, world): (&Site, Option<&World>),
) -> Result<(RunJournal, Option<TraceFile>)> {
    let output = &arguments.output;
    if let Some(trace) = &output.trace
        && trace.metadata().is_ok_and(|known| !known.is_file())
    {
        bail!("the trace of a run with a journal is a file, and `{}` is none", trace.shown());
    }
    let trace = output.trace.as_deref();
    let writing = Writing {
        trace: trace.map(std::path::absolute).transpose().context("the working folder is gone")?,
        pose_every_us: output.trace_poses.map(|rate| (1e6 / rate).round() as u64),
        factor: arguments.realtime,
        sync: arguments.journal.sync,
        must: arguments.journal.journal_must,
    };
    let kept = KeptRun::new(BUILD, recorded, Some(plan), site, world, writing)?;
    let file = trace.map(|trace| OutputFile::open(trace, "the trace")).transpose()?;
    let (journal, ledger) = RunJournal::begin(path, &kept, file)?;
    let trace = ledger.map(|ledger| TraceFile::with_ledger(ledger, Some(&kept.head.run.trace_header()))).transpose()?;
    Ok((journal, trace))
}

/// Compiles a plan with other first values for its variables, and shows what was found. None if it cannot run.
///
/// # Errors
/// The first values are wrong.
pub fn load(library: &Library, plan: PlanText, set: &[String], console: &mut Console) -> Result<Option<Loaded>> {
    let mut overrides = Overrides::parse(set)?;
    let PlanText { name, text, mut folder } = plan;
    let text = overrides.apply(text);
    let mut loader = OverridingLoader { inner: &mut folder, overrides: &mut overrides };
    match library.load(&name, &text, &mut loader) {
        Ok(loaded) => {
            if !loaded.warnings.is_empty() && !console.quiet {
                let sources = &loaded.program.sources;
                console.note(rpl_lang::diagnostic::render(&loaded.warnings, sources, console.colour).trim_end());
            }
            overrides.check_all_used()?;
            Ok(Some(loaded))
        }
        Err(rejected) => {
            console.note(rejected.render(console.colour).trim_end());
            Ok(None)
        }
    }
}

/// Somebody who watches is told that `rpl check` would find something; a script is not.
fn tell_warnings(library: &Library, plan: &PlanText, file: &str, shown: usize, console: &mut Console) {
    let (findings, _) = library.check(&plan.name, &plan.text, None, &mut plan.folder.clone());
    match findings.len().saturating_sub(shown) {
        0 => {}
        1 => console.note(&format!("1 warning; `rpl check {}` shows it", visible(file))),
        count => console.note(&format!("{count} warnings; `rpl check {}` shows them", visible(file))),
    }
}

fn create_trace(output: &Output, recorded: &RecordedRun) -> Result<Option<TraceFile>> {
    let Some(path) = &output.trace else { return Ok(None) };
    let file = OutputFile::open(path, "the trace")?.begin()?;
    let trace = TraceFile::begin(file, &recorded.trace_header())
        .with_context(|| format!("cannot write the trace `{}`", path.shown()))?;
    Ok(Some(trace))
}
