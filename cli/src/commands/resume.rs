//! `rpl resume DIR`: a run that was killed, or stood still, goes on from its journal.

use crate::commands::run::{self, parse_factor};
use crate::version::BUILD;
use anyhow::{Context, Result, anyhow, bail};
use clap::ValueHint;
use rpl_drive::hosts::{self, HostLines, HostSource, Use};
use rpl_drive::journal::{
    self, Change, DriverState, EndKind, GoingOn, JournalEnd, KeptRun, Outside, Resumption, RunJournal,
};
use rpl_drive::observed::Observed;
use rpl_drive::prepared_run::{PreparedRun, WrittenAtEnd};
use rpl_drive::run_driver::Pace;
use rpl_drive::run_record::Records;
use rpl_drive::trace::TraceFile;
use rpl_link::journal::inputs::PastInputs;
use rpl_link::journal::own_file;
use rpl_link::recording::RecordedTurns;
use rpl_runtime::run::system::System;
use rpl_shell::arguments::duration::parse_duration_us;
use rpl_shell::arguments::journal::SyncArgument;
use rpl_shell::arguments::token::TokenArgument;
use rpl_shell::files::module_files::{GoingBack, ModuleVoices, Modules};
use rpl_shell::files::outputs::OutputFile;
use rpl_shell::files::shown::Shown;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Resume a run with a journal (`rpl run --journal`) after a crash, or after `--until`
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Folder of the journal
    #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub journal: PathBuf,
    /// Stop at this time of the plan, such as 90s or 5min (default: the time given to the run)
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us)]
    pub until: Option<u64>,
    /// Address of the host that moves the robot (default: its last address)
    #[arg(long, value_name = "ADDRESS", value_hint = ValueHint::Hostname)]
    pub host: Option<String>,
    #[command(flatten)]
    pub token: TokenArgument,
    /// Take new definitions from changed texts of the plan; they are used for calls from then on
    #[arg(long)]
    pub changed: bool,
    /// Resume a journal that may be somebody else's without asking: it can start programs and write files
    #[arg(long)]
    pub foreign: bool,
    /// Continue the trace as a copy in this file, because two copies of a journal cannot write the same one
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub trace: Option<PathBuf>,
    /// Run in real time, or FACTOR times as fast (default: like the run)
    #[arg(long, value_name = "FACTOR", num_args = 0..=1, default_missing_value = "1", value_parser = parse_factor)]
    pub realtime: Option<f64>,
    /// Print one JSON object to standard output at the end
    #[arg(long)]
    pub json: bool,
    /// Print only the plan's own output, and failures
    #[arg(short, long)]
    pub quiet: bool,
}

/// Goes on with the run.
///
/// # Errors
/// There is no journal, somebody has it, what it belongs to has changed, or it cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let began = Instant::now();
    let path = &arguments.journal;
    let kept = KeptRun::read(path, BUILD)?;
    let Some(plan) = kept.head.plan.as_ref().filter(|_| !kept.is_session()) else {
        let shown = path.shown();
        bail!("`{shown}` is the journal of a session at the prompt: `rpl repl --journal {shown}` goes on with it");
    };
    journal::ask_about_foreign(path, &kept, arguments.foreign, console)?;
    let folder = journal::take(path)?;
    let end = JournalEnd::read(path)?;
    if let Some(end) = end.as_ref().filter(|end| end.how != EndKind::Until) {
        return over(end, arguments, console);
    }
    let begun = || GoingOn { until_us: kept.head.run.until_us, trace: kept.head.trace.clone() };
    let before = journal::went_on(path)?.unwrap_or_else(begun);
    let going_on = GoingOn {
        until_us: arguments.until.or(before.until_us.filter(|_| end.is_none())),
        trace: trace(&kept, before.trace, arguments, console)?,
    };
    let changes = changes(&kept, arguments, console)?;
    let source = reach(&kept, &plan.name, arguments)?;
    let (site, world, modules) = kept.site(ModuleVoices::Processes(GoingBack::Never))?;
    let wants_events = going_on.trace.is_some() || site.period_us().is_some();
    let Some(loaded) = run::load(&site.library, kept.text(plan), &kept.head.run.set, console)? else {
        return Ok(Status::Wrong);
    };
    let seed = kept.head.run.seed;
    if !arguments.quiet {
        modules.tell(console);
    }
    modules.start(&site, seed, None)?;
    let (robot, host_lines) = source.robot(&site, seed, Use::Run, None)?;
    let load = |bytes: &[u8]| Ok(System::load(bytes, site.library.clone(), loaded.clone(), robot.clone())?);
    let mut damage = Vec::new();
    let told = &mut |line: &str| damage.push(line.to_string());
    let Resumption { reached, from, number, ledgers } =
        journal::newest(path, kept.checksum, going_on.trace.as_deref(), load, told)?;
    damage.iter().for_each(|line| console.note(line));
    let outside = hear_again(&kept, path, from, &modules, host_lines.as_ref())?;
    let outlives_power = kept.head.sync != SyncArgument::Never;
    journal::go_on(&folder, &going_on, outlives_power)
        .with_context(|| format!("cannot write the journal `{}`", path.shown()))?;
    let is_at_start = reached.is_none();
    let (system, state) = match reached {
        Some((system, state)) => (system, Some(state)),
        None => (run::begun(&site, loaded.clone(), robot, seed, kept.head.run.max_steps, wants_events), None),
    };
    if let Some(new) = changes.iter().find(|change| change.instant.is_none()) {
        new.apply(&mut system.clone()).context("the new definitions cannot be taken")?;
    }
    tell_place(state.as_ref(), arguments, console);
    let (mut journal, trace) = RunJournal::of(folder, &kept, ledgers, outside, number);
    if is_at_start {
        journal.instant_begun(&system);
    }
    let journal = journal.with_changes(changes, state.as_ref().map_or(0, |state| state.changes));
    let header = is_at_start.then(|| kept.head.run.trace_header());
    let trace = trace.map(|ledger| TraceFile::with_ledger(ledger, header.as_ref())).transpose()?;
    let relocalizations = state.as_ref().map_or(0, |state| state.relocalizations);
    let observed = Observed { relocalizations, ..Observed::default() };
    let records = Records {
        journal: Some(journal),
        trace,
        pose_every_us: kept.head.pose_every_us,
        pose_due_us: state.as_ref().map_or(0, |state| state.pose_due_us),
        observed,
        ..Records::default()
    };
    let factor = Pace::factor_at(&site, arguments.realtime.or(kept.head.factor));
    let pace = Pace { until_us: going_on.until_us, stopped_us: None, factor };
    let written_at_end = WrittenAtEnd { json: arguments.json, ..WrittenAtEnd::default() };
    PreparedRun { site, world, system, seed, pace, records, host_lines, modules, written_at_end, began }.drive(console)
}

/// Who moves the robot from now on.
///
/// # Errors
/// The host cannot be reached, or there was none.
fn reach(kept: &KeptRun, plan: &str, arguments: &Arguments) -> Result<HostSource> {
    let (Some(then), Some(place)) = (&kept.head.run.host, &kept.place) else {
        return match (&arguments.host, &arguments.token.token_file) {
            (None, Some(_)) => {
                bail!("the robot of this run is simulated, and has no token; leave `--token-file` away")
            }
            (Some(_), _) => {
                bail!("the robot of this run is simulated, and the simulation is in the journal; leave `--host` away")
            }
            (None, None) => Ok(HostSource::Simulated),
        };
    };
    let address = arguments.host.as_ref().unwrap_or(&then.address);
    let source = hosts::reach(address, place.settings.robot.name.to_string(), plan, arguments.token.read()?)?;
    Ok(source.starting_as(then))
}

/// What came from other processes is heard again, and what comes is written behind it; none if the run has no
/// other processes.
///
/// # Errors
/// What came is not all there.
fn hear_again(
    kept: &KeptRun,
    path: &Path,
    from: Option<u64>,
    modules: &Modules,
    host_lines: Option<&HostLines>,
) -> Result<Option<Outside>> {
    if !kept.head.has_outside() {
        return Ok(None);
    }
    let shown = path.shown();
    let past = PastInputs::read(path, from).with_context(|| format!("the journal `{shown}` cannot be gone on with"))?;
    let outside = Outside::go_on(path, &past, from)?;
    let unread = || format!("what came from outside in the journal `{shown}` cannot be read");
    let turns = RecordedTurns::of_journal(past.turns).with_context(unread)?;
    let recorder = outside.recorder();
    if let Some(lines) = host_lines {
        lines.go_on(&turns, recorder.clone()).with_context(unread)?;
    }
    modules.go_on(&turns, &recorder).with_context(unread)?;
    Ok(Some(outside))
}

/// Where the trace is: where it was, or in the file that is named now, which begins as a copy of it.
///
/// # Errors
/// The run has none, it is no trace of the run, or it cannot be copied.
fn trace(
    kept: &KeptRun,
    before: Option<PathBuf>,
    arguments: &Arguments,
    console: &mut Console,
) -> Result<Option<PathBuf>> {
    let Some(before) = before else {
        match arguments.trace {
            Some(_) => bail!("the run has no trace to go on with: it was begun without `--trace`"),
            None => return Ok(None),
        }
    };
    let header = serde_json::to_string(&kept.head.run.trace_header())? + "\n";
    let so_far = trace_so_far(&before, &header);
    let named =
        arguments.trace.as_deref().map(std::path::absolute).transpose().context("the working folder is gone")?;
    let Some(now) = named.filter(|now| *now != before) else {
        let shown = arguments.journal.shown();
        so_far.map_err(|why| anyhow!("{why:#}; move it, or go on elsewhere: `rpl resume {shown} --trace FILE`"))?;
        return Ok(Some(before));
    };
    let folder_of_trace = now.parent().and_then(|folder| folder.canonicalize().ok());
    if folder_of_trace.is_some() && folder_of_trace == arguments.journal.canonicalize().ok() {
        bail!("the trace cannot go into the folder of the journal, where `{}` lies; name another file", now.shown());
    }
    let mut out = OutputFile::open(&now, "the trace")?.begin()?;
    match so_far {
        Ok(Some(mut so_far)) => {
            io::copy(&mut so_far, &mut out).with_context(|| format!("cannot write the trace `{}`", now.shown()))?;
        }
        // What is missing is computed again.
        Ok(None) => {}
        Err(why) => console.note(&format!("{why:#}; the trace is computed anew")),
    }
    Ok(Some(now))
}

/// The trace of a run as it is, if it is there: a file that begins with the header of the run.
///
/// # Errors
/// It cannot be read, or begins otherwise.
fn trace_so_far(path: &Path, header: &str) -> Result<Option<File>> {
    let shown = path.shown();
    let mut file = match own_file::open_named(path, File::options().read(true)) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        opened => opened.with_context(|| format!("cannot read the trace `{shown}`"))?,
    };
    let mut begins = Vec::new();
    let read = file.by_ref().take(header.len() as u64).read_to_end(&mut begins).and_then(|_| file.rewind());
    read.with_context(|| format!("cannot read the trace `{shown}`"))?;
    if !header.as_bytes().starts_with(&begins) {
        bail!("`{shown}` is no trace of this run, and is not overwritten");
    }
    Ok(Some(file))
}

/// The run has ended already.
fn over(end: &JournalEnd, arguments: &Arguments, console: &mut Console) -> Result<Status> {
    if !arguments.quiet {
        let (how, time_s) = (end.how.told(), end.time_us as f64 / 1e6);
        console.note(&format!("the run is over: it {how}, at {time_s:.1} s; there is nothing to go on with"));
    }
    if arguments.json {
        console.print(&end.summary.to_string())?;
    }
    Ok(end.how.status())
}

/// The definitions that the run has been given on the way, and those that it is given now.
///
/// # Errors
/// A file of the run is another one now, and that was not meant, or cannot be.
fn changes(kept: &KeptRun, arguments: &Arguments, console: &mut Console) -> Result<Vec<Change>> {
    let mut changes = journal::changes(&arguments.journal)?;
    let changed = journal::changed_files(kept, &changes);
    if changed.is_empty() {
        return Ok(changes);
    }
    if !arguments.changed {
        let names: Vec<String> = changed.iter().map(|path| format!("`{}`", path.shown())).collect();
        let shown = arguments.journal.shown();
        bail!(
            "{} changed since the run began, which goes on with what it has in its journal; put back what was there \
             (`rpl journal {shown} --text NAME` shows it), or let the run take the new definitions with `--changed`",
            names.join(", ")
        )
    }
    let (change, without_effect) = Change::in_files(kept, &changes, &changed)?;
    for form in without_effect {
        console
            .note(&format!("{form}: only definitions of plans, functions and macros are taken by a run that goes on"));
    }
    changes.push(change);
    Ok(changes)
}

fn tell_place(state: Option<&DriverState>, arguments: &Arguments, console: &mut Console) {
    if arguments.quiet {
        return;
    }
    let place = match state {
        Some(state) => format!("from the checkpoint at {:.1} s", state.time_us as f64 / 1e6),
        None => "from its start".to_string(),
    };
    console.note(&format!("the run goes on {place}; what was printed before is not printed again"));
}
