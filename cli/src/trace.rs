//! `rpl trace FILE`: a recorded run, read again, filtered, explained, and compared with another.

mod diff;
mod file;
mod filter;
mod reader;

pub use file::{Header, TraceFile, VERSION};

use crate::console::Console;
use crate::event_line::event_line;
use crate::situation::Situation;
use crate::status::Status;
use crate::why;
use anyhow::{Result, bail};
use clap::ValueHint;
use filter::Filter;
use reader::{Line, TraceReader};
use std::collections::VecDeque;

/// Arguments of `rpl trace`.
#[derive(clap::Args, Clone, Debug)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Arguments {
    /// A trace that `rpl run --trace FILE` wrote; `-` for standard input
    #[arg(value_name = "FILE", required = true, value_hint = ValueHint::FilePath)]
    file: Option<String>,
    #[command(flatten)]
    filter: Filter,
    /// Only the last N of these events
    #[arg(short = 'n', long, value_name = "N")]
    last: Option<usize>,
    /// Instead of events: why a task waits, at the end or at the time --to, or how it ended
    #[arg(long, value_name = "PATH", conflicts_with_all = ["task", "fluent", "from", "last", "json"])]
    why: Option<String>,
    /// The events as they stand in the file
    #[arg(long)]
    json: bool,
    #[command(subcommand)]
    comparison: Option<Comparison>,
}

#[derive(clap::Subcommand, Clone, Debug)]
enum Comparison {
    /// Names the first event that differs. Exit status: 0 the same, 1 they differ, 2 trouble
    Diff {
        /// A trace
        #[arg(value_name = "A", value_hint = ValueHint::FilePath)]
        left: String,
        /// Another
        #[arg(value_name = "B", value_hint = ValueHint::FilePath)]
        right: String,
    },
}

/// Shows, explains or compares.
///
/// # Errors
/// There is no such trace, or standard output is closed.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    if let Some(Comparison::Diff { left, right }) = &arguments.comparison {
        return diff::diff(left, right, console);
    }
    let mut reader = TraceReader::open(arguments.file.as_deref().unwrap_or("-"))?;
    if let Some(caution) = reader.caution() {
        console.note(&format!("note: {caution}"));
    }
    match &arguments.why {
        Some(path) => explain(&mut reader, path, &arguments.filter, console)?,
        None => show(&mut reader, arguments, console)?,
    }
    match &reader.damage {
        Some(damage) => {
            console.flush()?;
            console.note(&format!("note: {damage}"));
            Ok(Status::Wrong)
        }
        None => Ok(Status::Succeeded),
    }
}

fn show(reader: &mut TraceReader, arguments: &Arguments, console: &mut Console) -> Result<()> {
    let colour = console.out_colour();
    let text = |line: Line| if arguments.json { line.text } else { event_line(&line.event, colour) };
    let mut tell = |line: &str| if arguments.json { console.print(line) } else { console.explain(line) };
    let filter = &arguments.filter;
    let mut admitted =
        reader.take_while(|line| !filter.is_over(&line.event)).filter(|line| filter.admits(&line.event)).map(text);
    let Some(last) = arguments.last else { return Ok(admitted.try_for_each(|line| tell(&line))?) };
    let mut kept = VecDeque::new();
    for line in admitted {
        kept.push_back(line);
        kept.drain(..kept.len().saturating_sub(last));
    }
    Ok(kept.iter().try_for_each(|line| tell(line))?)
}

fn explain(reader: &mut TraceReader, path: &str, filter: &Filter, console: &mut Console) -> Result<()> {
    let mut situation = Situation::default();
    reader.take_while(|line| !filter.is_over(&line.event)).for_each(|line| situation.add(&line.event));
    match why::why(&situation, path) {
        Ok(lines) => Ok(lines.iter().try_for_each(|line| console.explain(line))?),
        Err(reason) => bail!(reason),
    }
}
