//! How an experiment of any kind is done: its runs are driven here, or read from parts that others have written; their
//! records become a table, or a part.

use super::any_kind::{AnyKind, AnyRecord, AnyTally};
use super::findings::Findings;
use super::kind::Run;
use super::part::identity::{Identity, Input};
use super::part::merging::Parts;
use super::part::shard::Shard;
use super::part::writer::PartWriter;
use super::request::ExperimentRequest;
use super::runs_file::RunsFile;
use super::seeds::{Seeds, run_in_order};
use anyhow::{Context, Result, bail};
use rpl_shell::files::outputs::OutputFolder;
use rpl_shell::files::shown::Shown;
use rpl_shell::interrupt;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::progress::Runs;
use serde_json::Value;
use std::path::PathBuf;
use std::sync::Arc;

/// Where the runs of an experiment come from.
pub enum RunSource {
    /// They are driven by this process.
    Seeds(Shard),
    /// Others have driven them.
    Parts(Box<Parts>),
}

/// How an experiment is done.
pub struct Conduct {
    /// Where its runs come from.
    pub source: RunSource,
    /// The part its records go to, instead of a table.
    pub out: Option<PathBuf>,
}

/// What becomes of the records of an experiment.
enum Sink {
    Table(Tabulation),
    Part(PartWriter),
}

/// A table that grows, and every run as a line of `runs.csv`.
struct Tabulation {
    tallies: Vec<AnyTally>,
    folder: Option<OutputFolder>,
    runs: RunsFile,
}

/// Does an experiment.
///
/// # Errors
/// Something cannot be read, driven or written.
pub fn conduct(
    kind: &Arc<dyn AnyKind>,
    request: &ExperimentRequest,
    how: Conduct,
    console: &mut Console,
) -> Result<Findings> {
    let shards = match &how.source {
        RunSource::Seeds(shard) => Some(shard.of),
        RunSource::Parts(parts) => parts.identity.shards,
    };
    let mut sink = match &how.out {
        Some(path) => Sink::Part(PartWriter::begin(path, &Identity::of(request, shards))?),
        None => Sink::Table(Tabulation {
            tallies: Vec::new(),
            folder: request.results_folder()?,
            runs: RunsFile::default(),
        }),
    };
    let (lacking, inputs) = match how.source {
        RunSource::Seeds(shard) => (drive(kind, request, shard, &mut sink, console)?, None),
        RunSource::Parts(mut parts) => (read(&**kind, &mut parts, &mut sink, console)?, Some(parts.inputs())),
    };
    let findings = match sink {
        Sink::Table(tabulation) => tabulation.findings(&**kind)?,
        Sink::Part(part) => {
            let inputs = inputs.map_or_else(Input::read_so_far, Ok)?;
            let count = part.end(inputs)?;
            let path = how.out.unwrap_or_default();
            let runs = if count == 1 { "run" } else { "runs" };
            let told = Block::Lines(format!("{count} {runs} written to {}", path.shown()));
            Findings { status: Status::Succeeded, blocks: vec![told], figures: Value::Null, drawings: Vec::new() }
        }
    };
    Ok(Findings { status: lacking.unwrap_or(findings.status), ..findings })
}

impl Sink {
    fn next_series(&mut self, kind: &dyn AnyKind) -> Result<()> {
        match self {
            Self::Table(table) => table.tallies.push(kind.tally()),
            Self::Part(part) => part.next_series()?,
        }
        Ok(())
    }

    fn take(&mut self, kind: &dyn AnyKind, series: &str, run: Run, record: AnyRecord) -> Result<()> {
        match self {
            Self::Table(table) => table.take(kind, series, run, record),
            Self::Part(part) => {
                let line = kind.line(run, &record).context("a record cannot be written down")?;
                part.add(run, line)
            }
        }
    }
}

impl Tabulation {
    fn take(&mut self, kind: &dyn AnyKind, series: &str, run: Run, record: AnyRecord) -> Result<()> {
        if let Some(folder) = &self.folder {
            self.runs.add(folder, kind, series, run, &record)?;
        }
        if let Some(tally) = self.tallies.last_mut() {
            kind.add(tally, record);
        }
        Ok(())
    }

    fn findings(self, kind: &dyn AnyKind) -> Result<Findings> {
        let Self { tallies, folder, runs } = self;
        let findings = kind.findings(tallies, folder.is_some())?;
        if let Some(mut folder) = folder {
            runs.end(&folder)?;
            findings.drawings.iter().try_for_each(|(name, text)| match name.ends_with(".svg") {
                true => folder.draw(name, text),
                false => folder.write(name, text),
            })?;
        }
        Ok(findings)
    }
}

/// Drives the runs of a shard, series by series. Answers the status of one that was interrupted.
fn drive(
    kind: &Arc<dyn AnyKind>,
    request: &ExperimentRequest,
    shard: Shard,
    sink: &mut Sink,
    console: &mut Console,
) -> Result<Option<Status>> {
    let seeds = Seeds { numbers: shard.runs(request.runs), first_seed: request.first_seed };
    let names = kind.series();
    let all = (seeds.numbers.end - seeds.numbers.start) * names.len() as u64;
    let mut done = 0;
    let mut is_whole = true;
    // Before the first ground stands nothing is done that could be kept.
    let mut ends = None;
    for (series, name) in names.iter().enumerate() {
        if !is_whole {
            sink.next_series(&**kind)?;
            continue;
        }
        let ground = kind.ground(series)?;
        ends.get_or_insert_with(interrupt::ends_experiment);
        sink.next_series(&**kind)?;
        let driver = kind.clone();
        let mut progress = Runs::new(seeds.numbers.end - seeds.numbers.start, name, console);
        let one = move |run: Run| driver.run(series, &ground, run);
        is_whole = run_in_order(&seeds, kind.jobs(request.jobs), one, |run, record: Result<AnyRecord>| {
            progress.one_more(console);
            done += 1;
            sink.take(&**kind, name, run, record?)
        })?;
        progress.end();
    }
    if !is_whole {
        console.note(&format!("interrupted: {done} of {all} runs are done"));
    }
    Ok((!is_whole).then_some(Status::Interrupted))
}

/// Reads the runs of parts, series by series. Answers the status of a table that lacks some.
fn read(kind: &dyn AnyKind, parts: &mut Parts, sink: &mut Sink, console: &mut Console) -> Result<Option<Status>> {
    for doubled in parts.doubled() {
        console.note(&format!("`{doubled}` has no run that the other parts do not have; each run counts once"));
    }
    let names = kind.series();
    let missing = parts.missing(&names);
    for (series, name) in names.iter().enumerate() {
        sink.next_series(kind)?;
        let mut progress = Runs::new(parts.count(series), name, console);
        parts.read(series, kind, |run, record| {
            progress.one_more(console);
            sink.take(kind, name, run, record)
        })?;
        progress.end();
    }
    match sink {
        // What is put together further lacks something by its nature.
        Sink::Part(_) => Ok(None),
        Sink::Table(_) => {
            missing.iter().for_each(|runs| console.note(&format!("missing: {runs}")));
            Ok((!missing.is_empty()).then_some(Status::Failed))
        }
    }
}

/// The names that are asked for with `--row`, or all.
///
/// # Errors
/// There is none of that name.
pub fn chosen<'a, T>(
    request: &ExperimentRequest,
    all: &'a [T],
    name: impl Fn(&T) -> &'static str,
) -> Result<Vec<&'a T>> {
    let Some(wanted) = request.row.as_deref() else { return Ok(all.iter().collect()) };
    let found: Vec<&T> = all.iter().filter(|row| name(row) == wanted).collect();
    if found.is_empty() {
        bail!(request.no_row(wanted, &all.iter().map(&name).collect::<Vec<_>>()));
    }
    Ok(found)
}
