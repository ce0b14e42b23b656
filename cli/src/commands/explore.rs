//! `rpl explore FILE`: a plan in every order of the tasks that are ready at the same time.

use crate::commands::run::load;
use anyhow::{Context, Result, bail};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_drive::show::event_line::event_line;
use rpl_explore::finding::{Fault, Finding};
use rpl_explore::schedule_text;
use rpl_explore::search::{Bounds, Left, Searched, explore};
use rpl_explore::story::{Standing, Turn, story};
use rpl_lang::source::Sources;
use rpl_lang::visible::{shortened, visible};
use rpl_mission::libraries;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::canonical::Visible;
use rpl_runtime::run::system::System;
use rpl_runtime::state::trace::Event;
use rpl_shell::arguments::completion;
use rpl_shell::arguments::duration::parse_duration_us;
use rpl_shell::arguments::site::FIRST_SEED;
use rpl_shell::files::outputs::OutputFile;
use rpl_shell::files::plans;
use rpl_shell::interrupt;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::ops::ControlFlow::{Break, Continue};
use std::path::PathBuf;

/// Run a plan without a robot in every order of the tasks that are ready at the same time
#[derive(clap::Args, Clone, Debug)]
#[command(
    after_help = "Exit status: 0 nothing is wrong in any order, 1 something is, 2 the text or the command line is \
                        wrong, 3 nothing was found within the bounds, 130 interrupted."
)]
pub struct Arguments {
    /// Plan file or built-in example; `-` for standard input
    #[arg(value_name = "FILE", add = ArgValueCompleter::new(completion::plans))]
    file: String,
    /// Explore this test of the file instead of its forms
    #[arg(long, value_name = "NAME")]
    test: Option<String>,
    /// Go this many choices away from the usual order, at most (default: all orders)
    #[arg(long, value_name = "K")]
    deviations: Option<u32>,
    /// Look at this many states, at most
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    states: u64,
    /// Go as far as this time of the plan
    #[arg(long, value_name = "TIME", default_value = "1h", value_parser = parse_duration_us)]
    until: u64,
    /// Every order must print and return the same
    #[arg(long)]
    deterministic: bool,
    /// Write the order that was found to this file; `rpl run FILE --schedule` repeats it
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    schedule: Option<PathBuf>,
    /// Set the initial value of a variable of the plan; can be repeated
    #[arg(long, value_name = "NAME=EXPR", add = ArgValueCompleter::new(completion::variables))]
    set: Vec<String>,
    /// Seed of every random stream
    #[arg(long, value_name = "N", default_value_t = FIRST_SEED)]
    seed: u64,
}

/// Searches for an order in which something goes wrong, and tells its story.
///
/// # Errors
/// The command line is wrong, or a file cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let plan = plans::plan(&arguments.file)?;
    let library = libraries::library_without_robot(Vec::new())?;
    let Some(mut loaded) = load(&library, plan, &arguments.set, console)? else {
        console.note("plans are explored without a robot: `rpl explore` knows no names of robots and scenarios");
        return Ok(Status::Wrong);
    };
    if let Some(name) = &arguments.test {
        let test = loaded.tests.iter().find(|test| *test.name == **name);
        let Some(test) = test else {
            let known: Vec<&str> = loaded.tests.iter().map(|test| &*test.name).collect();
            bail!("there is no test `{}` in it; there {}", visible(name), said(&known));
        };
        if test.options.world.is_some() {
            bail!("the test `{name}` is in a world, and what is explored has no robot");
        }
        loaded.main = test.code;
    }
    let out = arguments.schedule.as_deref().map(|path| OutputFile::open(path, "the schedule")).transpose()?;
    let _stops = interrupt::stops_runs();
    let visible = Visible::by(&loaded, &library);
    let bounds = Bounds {
        deviations: arguments.deviations.unwrap_or(u32::MAX),
        states: arguments.states,
        until_us: arguments.until,
        deterministic: arguments.deterministic,
    };
    let start = System::new(library.clone(), loaded.clone(), NoRobot, arguments.seed);
    console.begin_status();
    let searched = explore(&start, visible, bounds, |searched| {
        console.status(&format!("{} states, up to {}", searched.states, deviations(searched.deviations)));
        if interrupt::is_asked() { Break(()) } else { Continue(()) }
    });
    console.end_status();
    let Some(finding) = &searched.finding else {
        console.explain(&nothing(&searched, bounds))?;
        return Ok(match &searched.left[..] {
            [] => Status::Succeeded,
            left if left.contains(&Left::Stopped) => Status::Interrupted,
            _ => Status::TimeUp,
        });
    };
    let own = loaded.program.codes[loaded.main as usize].span.source;
    let sources = loaded.program.sources.clone();
    let start = System::traced(library, loaded, NoRobot, arguments.seed);
    let story = story(start, &finding.deviations, own, finding.time_us);
    console.explain(&headline(finding))?;
    if story.turns.is_empty() {
        tell_events(&story.usual[story.usual.len().saturating_sub(EVENTS_TOLD)..], console)?;
    }
    for turn in &story.turns {
        console.explain("")?;
        tell_turn(turn, &sources, console)?;
    }
    console.explain("")?;
    console.explain(&format!(
        "found with {}, after {}",
        deviations(finding.deviations.len() as u32),
        effort(&searched)
    ))?;
    if let Some(out) = out {
        out.write(schedule_text::write(&finding.deviations).as_bytes())?;
    }
    Ok(Status::Failed)
}

fn said(names: &[&str]) -> String {
    match names {
        [] => "is none".to_string(),
        [one] => format!("is `{one}`"),
        several => format!("are `{}`", several.join("`, `")),
    }
}

fn deviations(count: u32) -> String {
    match count {
        1 => "1 deviation from the usual order".to_string(),
        count => format!("{count} deviations from the usual order"),
    }
}

fn effort(searched: &Searched) -> String {
    format!("{} states and {} turns", searched.states, searched.transitions)
}

/// What was searched without a finding.
fn nothing(searched: &Searched, bounds: Bounds) -> String {
    let effort = effort(searched);
    if searched.left.is_empty() {
        return format!("nothing is wrong in any order: {effort}, {} ends", searched.ends);
    }
    let left = searched.left.iter().map(|left| match left {
        Left::Deviations => format!("orders with more than {}", deviations(bounds.deviations)),
        Left::States => format!("what lies behind {} states (`--states`)", bounds.states),
        Left::Time => format!("what comes after {} s (`--until`)", bounds.until_us as f64 / 1e6),
        Left::Stopped => "what was not reached before the interruption".to_string(),
    });
    format!("nothing was found in {effort}; not searched: {}", left.collect::<Vec<_>>().join("; "))
}

fn headline(finding: &Finding) -> String {
    let order = if finding.deviations.is_empty() { "in the usual order" } else { "in another order" };
    let time_s = finding.time_us as f64 / 1e6;
    match &finding.fault {
        Fault::Fails(why) => format!("it fails {order}, at {time_s:.3} s: {why}"),
        Fault::Warns(why) => format!("a clean-up or a task that was ended fails {order}, at {time_s:.3} s: {why}"),
        Fault::Differs { usual, found } => {
            format!("it ends otherwise {order}: `{}`, and usually `{}`", shortened(found), shortened(usual))
        }
    }
}

/// Events that are told of what follows a deviation, at the beginning and at the end.
const EVENTS_TOLD: usize = 12;

fn tell_turn(turn: &Turn, sources: &Sources, console: &mut Console) -> Result<()> {
    let does = if turn.is_timeout { "its timeout ends before that of" } else { "runs before" };
    let others: Vec<&str> = turn.before.iter().map(|other| other.path.as_str()).collect();
    let time_s = turn.time_us as f64 / 1e6;
    console.explain(&format!("at {time_s:.3} s {} {does} {}", turn.taken.path, others.join(", ")))?;
    for standing in std::iter::once(&turn.taken).chain(&turn.before) {
        if let Some(line) = form_line(standing, sources) {
            console.explain(&line)?;
        }
    }
    let (first, last) = told(&turn.events);
    tell_events(first, console)?;
    let passed_over = turn.events.len() - first.len() - last.len();
    if passed_over > 0 {
        console.explain(&format!("{:>10}  {passed_over} events", "…"))?;
    }
    tell_events(last, console)
}

fn tell_events(events: &[Event], console: &mut Console) -> Result<()> {
    let colour = console.out_colour();
    events.iter().try_for_each(|event| console.explain(&event_line(event, colour))).context("standard output is closed")
}

/// The first and the last of many events.
fn told(events: &[Event]) -> (&[Event], &[Event]) {
    match events.len() > 2 * EVENTS_TOLD {
        true => (&events[..EVENTS_TOLD], &events[events.len() - EVENTS_TOLD..]),
        false => (events, &[]),
    }
}

fn form_line(standing: &Standing, sources: &Sources) -> Option<String> {
    let form = standing.form?;
    let text = sources.text_of(form).split_whitespace().collect::<Vec<_>>().join(" ");
    Some(format!("  {} goes on in {}  at {}", standing.path, shortened(&text), sources.place(form)))
}
