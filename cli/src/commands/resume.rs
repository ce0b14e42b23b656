//! `rpl resume DIR`: a run that was killed, or stood still, goes on from its journal.

use crate::arguments::duration::parse_duration_us;
use crate::arguments::journal::SyncArgument;
use crate::commands::run::{self, parse_factor};
use crate::drive::Pace;
use crate::files::module_files::Modules;
use crate::journal::{self, Change, DriverState, EndKind, JournalEnd, KeptRun, Resumption, RunJournal};
use crate::prepared_run::PreparedRun;
use crate::run_record::Records;
use crate::status::Status;
use crate::terminal::console::Console;
use crate::trace::TraceFile;
use anyhow::{Context, Result, bail};
use clap::ValueHint;
use rpl_runtime::run::system::System;
use std::path::PathBuf;
use std::time::Instant;

/// Goes on with a run (`rpl run --journal`) that was killed, or stood still at `--until`
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// The folder of its journal
    #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub journal: PathBuf,
    /// Stops at this time of the plan, such as 90s or 5min; without, where the run was to stop
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us)]
    pub until: Option<u64>,
    /// Takes new definitions from the texts of the plan that have changed: calls that are made from then on are of
    /// them
    #[arg(long)]
    pub changed: bool,
    /// Keeps pace with the wall clock, or FACTOR times as fast; without, as the run did
    #[arg(long, value_name = "FACTOR", num_args = 0..=1, default_missing_value = "1", value_parser = parse_factor)]
    pub realtime: Option<f64>,
    /// Writes one JSON object to standard output at the end
    #[arg(long)]
    pub json: bool,
    /// Writes only what the plan prints, and failures
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
    let kept = KeptRun::read(path)?;
    let folder = journal::take(path)?;
    let until_us = match JournalEnd::read(path)? {
        Some(end) if end.how == EndKind::Until => arguments.until,
        Some(end) => return over(&end, arguments, console),
        None => {
            let was_to_stop_us = journal::went_on_until(path)?.unwrap_or(kept.head.run.until_us);
            arguments.until.or(was_to_stop_us)
        }
    };
    let changes = changes(&kept, arguments, console)?;
    let (site, world) = kept.site()?;
    let wants_events = kept.head.trace.is_some() || kept.place.is_some();
    let Some(loaded) = run::load(&site.library, kept.text(&kept.head.plan), &kept.head.run.set, console)? else {
        return Ok(Status::Wrong);
    };
    let seed = kept.head.run.seed;
    let load = |bytes: &[u8]| Ok(System::load(bytes, site.library.clone(), loaded.clone(), site.robot(seed))?);
    let mut damage = Vec::new();
    let told = &mut |line: &str| damage.push(line.to_string());
    let Resumption { reached, number, ledgers } =
        journal::newest(path, kept.checksum, kept.head.trace.as_deref(), load, told)?;
    damage.iter().for_each(|line| console.note(line));
    let outlives_power = kept.head.sync != SyncArgument::Never;
    journal::go_on(&folder, until_us, outlives_power)
        .with_context(|| format!("cannot write the journal `{}`", path.display()))?;
    let is_at_start = reached.is_none();
    let (system, state) = match reached {
        Some((system, state)) => (system, Some(state)),
        None => {
            (run::begun(&site, loaded.clone(), site.robot(seed), seed, kept.head.run.max_steps, wants_events), None)
        }
    };
    if let Some(new) = changes.iter().find(|change| change.instant.is_none()) {
        new.apply(&mut system.clone()).context("the new definitions cannot be taken")?;
    }
    tell_place(state.as_ref(), arguments, console);
    let (journal, trace) = RunJournal::of(folder, &kept, ledgers, number);
    let journal = journal.with_changes(changes, state.as_ref().map_or(0, |state| state.changes));
    let header = is_at_start.then(|| kept.head.run.trace_header());
    let trace = trace.map(|ledger| TraceFile::with_ledger(ledger, header.as_ref())).transpose()?;
    let records = Records {
        journal: Some(journal),
        trace,
        pose_every_us: kept.head.pose_every_us,
        pose_due_us: state.as_ref().map_or(0, |state| state.pose_due_us),
        relocalizations: state.as_ref().map_or(0, |state| state.relocalizations),
        ..Records::default()
    };
    let pace = Pace { until_us, stopped_us: None, factor: arguments.realtime.or(kept.head.factor) };
    let (modules, transcript, figures) = (Modules::default(), None, None);
    let json = arguments.json;
    PreparedRun { site, world, system, seed, pace, records, figures, transcript, modules, json, began }.drive(console)
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
    let changed = kept.changed_files(&changes);
    if changed.is_empty() {
        return Ok(changes);
    }
    if !arguments.changed {
        let names: Vec<String> = changed.iter().map(|path| format!("`{}`", path.display())).collect();
        let shown = arguments.journal.display();
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
