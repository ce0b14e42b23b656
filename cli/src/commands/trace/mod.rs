//! `rpl trace FILE`: a recorded run, read again, filtered, explained, and compared with another.

mod diff;
mod filter;
mod named;

use anyhow::{Context, Result, bail};
use clap::ValueHint;
use filter::Filter;
use named::Named;
use rpl_drive::show::event_line::event_line;
use rpl_drive::show::situation::Situation;
use rpl_drive::show::{figures, why};
use rpl_drive::trace::{TraceLine, TraceReader, TracedPose};
use rpl_shell::files::{robot_files, world_files};
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// Show a recorded run: its events, why a task waited or failed, how it differs from another
///
/// `rpl run FILE --trace T` records a run.
#[derive(clap::Args, Clone, Debug)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct Arguments {
    /// Trace from `rpl run --trace FILE`; `-` for standard input
    #[arg(value_name = "FILE", required = true, value_hint = ValueHint::FilePath)]
    file: Option<String>,
    #[command(flatten)]
    filter: Filter,
    /// Show only the last N of the selected events
    #[arg(short = 'n', long, value_name = "N")]
    last: Option<usize>,
    /// Instead of events, explain why a task waits, at the end or at the time --to, or how it ended
    #[arg(long, value_name = "PATH", conflicts_with_all = ["task", "fluent", "from", "last", "json"])]
    why: Option<String>,
    /// Print the events as they are in the file
    #[arg(long)]
    json: bool,
    /// Instead of events, draw the paths of the robot into this folder, from the poses in the trace
    #[arg(long, value_name = "DIR", conflicts_with_all = ["task", "fluent", "last", "json", "why"])]
    figures: Option<PathBuf>,
    #[command(subcommand)]
    comparison: Option<TraceCommand>,
}

#[derive(clap::Subcommand, Clone, Debug)]
enum TraceCommand {
    /// Show the first event that differs. Exit status: 0 same, 1 different, 2 trouble
    Diff {
        /// Trace
        #[arg(value_name = "A", value_hint = ValueHint::FilePath)]
        left: String,
        /// Trace to compare it with
        #[arg(value_name = "B", value_hint = ValueHint::FilePath)]
        right: String,
    },
}

/// Shows, explains or compares.
///
/// # Errors
/// There is no such trace, or standard output is closed.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    if let Some(TraceCommand::Diff { left, right }) = &arguments.comparison {
        return diff::diff(left, right, console);
    }
    let mut reader = TraceReader::open(arguments.file.as_deref().unwrap_or("-"))?;
    if let Some(caution) = reader.caution() {
        console.note(&format!("note: {caution}"));
    }
    match (&arguments.why, &arguments.figures) {
        (Some(path), _) => explain(&mut reader, path, &arguments.filter, console)?,
        (None, Some(folder)) => draw(&mut reader, folder, &arguments.filter)?,
        (None, None) => show(&mut reader, arguments, console)?,
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
    let text = |line: TraceLine| if arguments.json { line.text } else { event_line(&line.event, colour) };
    let mut tell = |line: &str| if arguments.json { console.print(line) } else { console.explain(line) };
    let filter = &arguments.filter;
    let mut kept = VecDeque::new();
    let mut named = Named::default();
    for line in reader {
        // What is asked for may come later: that it is there at all is worth the reading.
        if filter.is_over(&line.event) && named.has_all(filter) {
            break;
        }
        named.note(&line.event, filter);
        if !filter.admits(&line.event) {
            continue;
        }
        match arguments.last {
            None => tell(&text(line))?,
            Some(last) => {
                kept.push_back(text(line));
                kept.drain(..kept.len().saturating_sub(last));
            }
        }
    }
    kept.iter().try_for_each(|line| tell(line))?;
    named.missing(filter).map_or(Ok(()), |missing| bail!(missing))
}

/// Draws the paths that the poses of a trace tell of.
fn draw(reader: &mut TraceReader, folder: &Path, filter: &Filter) -> Result<()> {
    let name = reader.name.clone();
    let Some(world) = reader.header.as_ref().and_then(|header| header.world.clone()) else {
        bail!("the trace `{name}` names no world to draw the paths in");
    };
    let seed = reader.header.as_ref().map_or(0, |header| header.seed);
    let robot = reader.header.as_ref().and_then(|header| header.robot.clone());
    let robot =
        robot_files::named(robot.as_deref()).with_context(|| format!("the robot of the trace `{name}` is missing"))?;
    let world = world_files::named(&world, &robot, seed)
        .with_context(|| format!("the world of the trace `{name}` is missing"))?;
    let mut folder = figures::open_folder(folder)?;
    reader.by_ref().for_each(drop);
    let is_wanted = |seen: &&TracedPose| {
        filter.from.is_none_or(|from_us| seen.time_us >= from_us) && filter.to.is_none_or(|to_us| seen.time_us <= to_us)
    };
    let poses: Vec<TracedPose> = reader.poses.iter().filter(is_wanted).copied().collect();
    if poses.is_empty() {
        bail!(
            "the trace `{name}` has no poses there; `rpl run FILE --world W --trace {name} --trace-poses 5` records some"
        );
    }
    figures::write_paths(&mut folder, &world, robot.radius_m, &poses)
}

fn explain(reader: &mut TraceReader, path: &str, filter: &Filter, console: &mut Console) -> Result<()> {
    let mut situation = Situation::default();
    reader.take_while(|line| !filter.is_over(&line.event)).for_each(|line| situation.add(&line.event));
    match why::why(&situation, path) {
        Ok(lines) => Ok(lines.iter().try_for_each(|line| console.explain(line))?),
        Err(reason) => bail!(reason),
    }
}
