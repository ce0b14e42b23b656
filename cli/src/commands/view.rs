//! `rpl view FILE…`: a run that is over, in a browser; two of them side by side.

use crate::commands::replay;
use crate::commands::run::{self, Output};
use crate::version::BUILD;
use anyhow::{Context, Result, anyhow, bail};
use clap::ValueHint;
use rpl_drive::events;
use rpl_drive::hosts::{self, Use};
use rpl_drive::journal::{self, JournalEnd, KeptRun, checkpoint_times};
use rpl_drive::onlooker::Onlooker;
use rpl_drive::prepared_run::{PreparedRun, WrittenAtEnd};
use rpl_drive::run_driver::Pace;
use rpl_drive::run_record::Records;
use rpl_drive::seen::{Feed, LiveArguments, SeenRun, head, plan_texts, stay, title};
use rpl_drive::trace::{Header, TraceReader};
use rpl_link::recording::RecordedTurns;
use rpl_page::report::{report, run_in};
use rpl_page::series::{Series, Text};
use rpl_robot::avoidance::DriveLimits;
use rpl_robot::sensors::RangeSensors;
use rpl_shell::files::module_files::ModuleVoices;
use rpl_shell::files::outputs::OutputFile;
use rpl_shell::files::shown::Shown;
use rpl_shell::files::{inputs, plans, robot_files, world_files};
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Bytes at the beginning of a file that tell what it is.
const BEGINNING_BYTES: u64 = 512;

/// Show a finished run in a browser, or two traces or reports side by side
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Trace (`rpl run --trace`), report (`--report`), folder of a journal (`--journal`), or recording (`--record`)
    #[arg(value_name = "FILE", value_hint = ValueHint::AnyPath)]
    pub file: PathBuf,
    /// Another trace or report, to show beside it
    #[arg(value_name = "OTHER", value_hint = ValueHint::FilePath)]
    pub other: Option<PathBuf>,
    /// Address of the page: [HOST][:PORT] (default: localhost, this machine only)
    #[arg(long, value_name = "ADDRESS", default_value = "localhost", hide_default_value = true, value_hint = ValueHint::Hostname)]
    pub at: String,
    /// Open the page in a browser
    #[arg(long)]
    pub open: bool,
    /// Also show the robot's true pose
    #[arg(long)]
    pub truth: bool,
    /// Write the page as one HTML file instead of serving it
    #[arg(long, value_name = "FILE.html", value_hint = ValueHint::FilePath, conflicts_with_all = ["at", "open"])]
    pub report: Option<PathBuf>,
}

impl Arguments {
    /// The same as of a run.
    fn live(&self) -> LiveArguments {
        LiveArguments {
            live: self.report.is_none().then(|| self.at.clone()),
            open: self.open,
            control: false,
            truth: self.truth,
            report: self.report.clone(),
        }
    }
}

/// Shows it.
///
/// # Errors
/// There is no such file, it is none of these, or the page cannot be served.
pub fn run(arguments: &Arguments, command_line: clap::Command, console: &mut Console) -> Result<Status> {
    if arguments.file.is_dir() {
        return match arguments.other {
            Some(_) => {
                bail!("a journal is computed again, and shown alone; two traces or reports can be shown side by side")
            }
            None => view_journal(arguments, console),
        };
    }
    let first = past(&arguments.file, arguments.truth, console)?;
    let Some((name, first)) = first else {
        if arguments.other.is_some() {
            bail!("a recording is computed again, and shown alone; two traces or reports can be shown side by side");
        }
        let output = Output { live: arguments.live(), ..Output::default() };
        let replayed = replay::Arguments { file: arguments.file.clone(), plan: None, prompt: false, output };
        return replay::run(&replayed, command_line, console);
    };
    let mut runs = vec![first];
    if let Some(other) = &arguments.other {
        let Some((_, other)) = past(other, arguments.truth, console)? else {
            bail!("`{}` is neither a trace nor a report", other.shown());
        };
        runs.push(other);
    }
    let html = report(&name, &runs.iter().collect::<Vec<_>>())?;
    let live = arguments.live();
    match live.report {
        Some(path) => OutputFile::open(&path, "the report")?.write(html.as_bytes())?,
        None => {
            let mut server = live.serve(html, String::new(), console)?;
            stay(|| server.as_mut()?.trouble(), console);
        }
    }
    Ok(Status::Succeeded)
}

/// A run that is over, with its title, from a trace or a report; none if the file is neither.
fn past(file: &Path, truth: bool, console: &mut Console) -> Result<Option<(String, Series)>> {
    let shown = file.shown();
    let mut start = Vec::new();
    let opened = inputs::open(file).map_err(|why| anyhow!("cannot read `{shown}`: {why}"))?;
    opened.take(BEGINNING_BYTES).read_to_end(&mut start).with_context(|| format!("cannot read `{shown}`"))?;
    let start = String::from_utf8_lossy(&start);
    if start.trim_start().to_ascii_lowercase().starts_with("<!doctype html") {
        let text = inputs::read_text(file).map_err(|why| anyhow!("cannot read the report `{shown}`: {why}"))?;
        let run = run_in(&text).with_context(|| format!("cannot read the report `{shown}`"))?;
        return Ok(Some((format!("{shown} – RPL"), run)));
    }
    // The first line of a recording tells of much more.
    if !start.starts_with("{\"trace\":") && !start.starts_with("{\"time_s\":") {
        return Ok(None);
    }
    let mut reader = TraceReader::open(&file.to_string_lossy())?;
    if let Some(caution) = reader.caution() {
        console.note(&format!("note: {caution}"));
    }
    let header = reader.header.clone().unwrap_or_default();
    let series = of_trace(&mut reader, &header, truth, console)?;
    if let Some(damage) = &reader.damage {
        console.note(&format!("note: {damage}"));
    }
    Ok(Some((title(&header), series)))
}

/// What is seen of a run that a trace tells of: all that happened, and the robot as far as the trace has its poses.
fn of_trace(reader: &mut TraceReader, header: &Header, truth: bool, console: &mut Console) -> Result<Series> {
    let robot = robot_files::named(header.robot.as_deref()).context("the robot of the trace is missing")?;
    let world = header.world.as_deref().map(|world| world_files::named(world, &robot, header.seed));
    let world = world.transpose().unwrap_or_else(|error| {
        console.note(&format!("note: without a map: {error:#}"));
        None
    });
    let texts = plans::plan(&header.plan).map(|plan| Text { name: plan.name, text: plan.text });
    let limits = DriveLimits::of(&robot);
    let sensors = RangeSensors { sonars: None, laser: None };
    let robot = world.is_some().then_some((&sensors, &limits));
    let head = head(header, texts.into_iter().collect(), world.as_ref(), robot, truth);
    let mut feed = Feed::new(Some(Series::new(&head)), None, truth);
    let mut poses = 0;
    while let Some(line) = reader.next() {
        // Poses that stand before a line were read with it.
        reader.poses[poses..].iter().for_each(|pose| feed.pose(pose));
        poses = reader.poses.len();
        let event = [line.event];
        feed.events(&event);
        let time_us = event[0].time_us;
        events::in_order(&event, Vec::new(), false).iter().for_each(|told| feed.told(time_us, told));
    }
    reader.poses[poses..].iter().for_each(|pose| feed.pose(pose));
    Ok(feed.into_kept().unwrap_or_default())
}

/// A run with a journal is computed again as far as it came, and shown meanwhile. The journal stays as it is.
fn view_journal(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let began = Instant::now();
    let path = &arguments.file;
    let shown = path.shown();
    let kept = KeptRun::read(path, BUILD)?;
    let Some(plan) = kept.head.plan.as_ref().filter(|_| !kept.is_session()) else {
        bail!("`{shown}` is the journal of a session at the prompt: `rpl repl {shown}` goes through it");
    };
    let past = kept.head.has_outside().then(|| journal::inputs_from_start(path)).transpose()?;
    if past.as_ref().is_some_and(|past| !past.resumed_at.is_empty()) {
        bail!(
            "the run in `{shown}` was gone on with after it had died; `rpl view` shows its trace, and `rpl repl {shown}` goes through it"
        );
    }
    if !journal::changes(path)?.is_empty() {
        bail!(
            "the run in `{shown}` was given new definitions on the way; `rpl view` shows its trace, and `rpl repl {shown}` goes through it"
        );
    }
    let reached_us = match JournalEnd::read(path)? {
        Some(end) => Some(end.time_us),
        None => match &past {
            Some(past) => past.reached_us,
            None => checkpoint_times(path, kept.checksum)?.into_iter().map(|(time_us, _)| time_us).max(),
        },
    };
    let turns = RecordedTurns::of_journal(past.map_or(Vec::new(), |past| past.turns))
        .with_context(|| format!("what came from outside in the journal `{shown}` cannot be read"))?;
    let (site, world, modules) = kept.site(ModuleVoices::Recording(&turns))?;
    console.quiet = true;
    let Some(loaded) = run::load(&site.library, kept.text(plan), &kept.head.run.set, console)? else {
        return Ok(Status::Wrong);
    };
    let seed = kept.head.run.seed;
    let (texts, header) = (plan_texts(&loaded.program), kept.head.run.trace_header());
    let (robot, host_lines) = hosts::heard(kept.head.run.host.as_ref(), &turns)?.robot(&site, seed, Use::Run, None)?;
    let (seen, steering) = SeenRun::begin(&arguments.live(), &header, texts, (&site, world.as_ref()), console)?;
    let system = run::begun(&site, loaded, robot, seed, kept.head.run.max_steps, true);
    let onlookers = seen.map(|seen| Box::new(seen) as Box<dyn Onlooker>).into_iter().collect();
    let records = Records { steering, onlookers, ..Records::default() };
    let pace = Pace { until_us: reached_us.or(kept.head.run.until_us), stopped_us: None, factor: None };
    let written_at_end = WrittenAtEnd::default();
    PreparedRun { site, world, system, seed, pace, records, host_lines, modules, written_at_end, began }.drive(console)
}
