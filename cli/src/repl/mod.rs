//! `rpl` and `rpl step`: the prompt at which plans are written, run, stopped, looked at, stepped
//! through and taken back.

mod breakpoint;
mod clock;
mod command;
mod editor;
mod live;
mod living;
mod map;
mod session;
mod terminal;
mod view;
mod vocabulary;

use crate::console::Console;
use crate::doc;
use crate::event_line::event_line;
use crate::failure_report::Reporter;
use crate::files::{self, Folder, PlanText};
use crate::interrupt;
use crate::mission::{self, Robot, Site};
use crate::status::Status;
use crate::time::parse_duration_us;
use crate::why::{self, shortened};
use anyhow::Result;
use breakpoint::Breakpoint;
use clock::Clock;
use command::Verb;
use rpl_lang::compile::NoFiles;
use rpl_lang::diagnostic;
use rpl_lang::reader::{Completeness, completeness};
use rpl_robot::occupancy::OccupancyGrid;
use rpl_robot::office::OfficeSettings;
use rpl_runtime::library::Rejected;
use rpl_runtime::session::{Answer, Submitted};
use rpl_runtime::timeline::Past;
use session::{Halt, Session, Until};
use std::io::{self, IsTerminal, Read};

/// Edge of a cell of the map that `:map` draws.
const MAP_CELL_M: f64 = 0.1;

/// Events that `:trace` shows.
const LAST_EVENTS: usize = 20;

/// Arguments of `rpl repl` and `rpl step`.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct Arguments {
    /// A plan file to begin with, or a built-in example
    #[arg(value_name = "FILE")]
    pub file: Option<String>,
    /// The world the robot is in: a built-in name, or a .toml file
    #[arg(long, value_name = "W")]
    pub world: Option<String>,
    /// Seed of every random stream
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// What happens on the way: a plan with hands in the world
    #[arg(long, value_name = "FILE")]
    pub scenario: Option<String>,
}

/// Runs a session. With `stops_at_start` the file is loaded and stands before its first form.
///
/// # Errors
/// The command line is wrong, or standard output is closed.
pub fn run(arguments: &Arguments, stops_at_start: bool, console: &mut Console) -> Result<Status> {
    interrupt::catch_for_prompt();
    let world = arguments.world.as_deref().map(mission::world).transpose()?;
    let scenario = arguments.scenario.as_deref().map(files::scenario).transpose()?;
    let places = world.as_ref().map_or_else(Vec::new, |world| {
        let rooms = world.rooms.iter().map(|room| room.name.to_string());
        rooms.chain(world.places.iter().map(|place| place.name.to_string())).collect()
    });
    let map = world.as_ref().map(|world| world.map(MAP_CELL_M));
    let site = Site::new(world, scenario, OfficeSettings::default())?;
    let plan = arguments.file.as_deref().map(files::plan).transpose()?;
    let mut prompt = Prompt {
        session: Session::new(&site, arguments.seed)?,
        map,
        places,
        console,
        clock: None,
        is_interactive: io::stdin().is_terminal(),
        repeated: None,
        worst: Status::Succeeded,
    };
    if let Some(plan) = plan {
        prompt.load(plan, if stops_at_start { Until::Step } else { Until::End })?;
    }
    if prompt.is_interactive {
        prompt.converse()?
    } else {
        prompt.read_all()?
    }
    prompt.console.flush()?;
    Ok(prompt.worst)
}

/// Whether the session goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    Another,
    Quit,
}

struct Prompt<'a> {
    session: Session,
    map: Option<OccupancyGrid>,
    /// Names of rooms and places in the world.
    places: Vec<String>,
    console: &'a mut Console,
    /// The clock by which the run goes on while something is typed.
    clock: Option<Clock>,
    /// Somebody sits at a terminal.
    is_interactive: bool,
    /// The stepping command that an empty line repeats.
    repeated: Option<String>,
    /// What the exit status says when nobody sat at the prompt.
    worst: Status,
}

impl Prompt<'_> {
    /// Everything from standard input, form by form, without a person.
    fn read_all(&mut self) -> Result<()> {
        let mut bytes = Vec::new();
        io::stdin().read_to_end(&mut bytes)?;
        let text = files::text_of(bytes).map_err(|reason| anyhow::anyhow!("cannot read standard input: {reason}"))?;
        let mut waiting = String::new();
        for line in text.lines() {
            waiting.push_str(line);
            waiting.push('\n');
            let is_command = waiting.trim_start().starts_with(':');
            if !is_command && completeness(&waiting) != Completeness::Complete {
                continue;
            }
            if self.handle(&std::mem::take(&mut waiting))? == Next::Quit {
                return Ok(());
            }
        }
        if !waiting.trim().is_empty() {
            self.handle(&waiting)?;
        }
        Ok(())
    }

    fn prompt_text(&self) -> String {
        if self.clock.is_some() {
            return self.live_prompt();
        }
        let branch = &self.session.branch;
        let name = if self.session.name == "main" { String::new() } else { format!(" {}", self.session.name) };
        let time = match branch.system.machine.now_us {
            0 => String::new(),
            _ => format!(" {:.1}s", branch.system.machine.now_s()),
        };
        let state = if branch.is_running { " stopped" } else { "" };
        format!("rpl{name}{time}{state}> ")
    }

    fn handle(&mut self, text: &str) -> Result<Next> {
        if !text.trim_start().starts_with(':') {
            if !text.trim().is_empty() {
                self.forms(text, &Until::End)?;
            }
            return Ok(Next::Another);
        }
        match command::parse(text) {
            Ok((Verb::Quit, _)) => return Ok(Next::Quit),
            Ok((verb, rest)) => {
                let repeats = matches!(verb, Verb::Step | Verb::Next | Verb::Into | Verb::Out) && rest.is_empty();
                self.repeated = repeats.then(|| text.to_string());
                if verb.steers() && self.clock.take().is_some() {
                    self.console.keep(false);
                }
                self.command(verb, rest)?;
            }
            Err(reason) => self.wrong(&reason)?,
        }
        Ok(Next::Another)
    }

    fn command(&mut self, verb: Verb, rest: &str) -> Result<()> {
        match verb {
            Verb::Load => match files::plan(rest) {
                Ok(plan) => self.load(plan, Until::End)?,
                Err(error) => self.wrong(&format!("{error:#}"))?,
            },
            Verb::Run if rest.is_empty() => {
                self.wrong("`:run FORM`: a form is expected, such as `:run (deliver 'mail)`")?
            }
            Verb::Run => {
                let breakpoints = std::mem::take(&mut self.session.breakpoints);
                let done = self.forms(rest, &Until::End);
                self.session.breakpoints = breakpoints;
                done?;
            }
            Verb::Step if !rest.is_empty() => self.forms(rest, &Until::Step)?,
            Verb::Step | Verb::Into => self.go_on(&Until::Step)?,
            Verb::Next => self.go_on(&Until::Next)?,
            Verb::Out => self.go_on(&Until::Out)?,
            Verb::Continue => self.go_on(&Until::End)?,
            Verb::Until => self.until(rest)?,
            Verb::Go => self.go(rest)?,
            Verb::Stop => self.stop_clock()?,
            Verb::Break => self.set_break(rest)?,
            Verb::Delete => self.delete(rest)?,
            Verb::Watch if rest.is_empty() => self.session.watches.clear(),
            Verb::Watch => self.session.watches.push(rest.to_string()),
            Verb::Abort => self.abort()?,
            Verb::Back => self.back(rest)?,
            Verb::At => self.at(rest)?,
            Verb::Fork | Verb::Forks | Verb::Switch => self.forks(verb, rest)?,
            Verb::Why | Verb::Task | Verb::Tasks | Verb::Fluents | Verb::Valves | Verb::Map | Verb::Trace => {
                let lines = self.look(verb, rest);
                self.print(&lines)?;
            }
            Verb::Doc => drop(doc::run(Some(rest).filter(|name| !name.is_empty()), self.console)?),
            Verb::Help => self.print(&command::help())?,
            Verb::Quit => {}
        }
        Ok(())
    }

    fn print(&mut self, lines: &[String]) -> Result<()> {
        Ok(lines.iter().try_for_each(|line| self.console.print(line))?)
    }

    /// A command that cannot be done.
    fn wrong(&mut self, reason: &str) -> Result<()> {
        self.console.note(&format!("error: {reason}"));
        self.worst = Status::Wrong;
        Ok(())
    }

    fn look(&self, verb: Verb, rest: &str) -> Vec<String> {
        let system = &self.session.branch.system;
        let or = |lines: Vec<String>, nothing: &str| if lines.is_empty() { vec![nothing.to_string()] } else { lines };
        match verb {
            Verb::Why => why::why(&living::situation(&self.session), rest).unwrap_or_else(|reason| vec![reason]),
            Verb::Task => match view::living(system, rest) {
                Some(task) => view::task(system, task),
                None => vec![why::missing(&living::situation(&self.session), rest)],
            },
            Verb::Tasks => view::tasks(system),
            Verb::Fluents => or(view::fluents(system, rest), "no fluent has such a name"),
            Verb::Valves => or(view::valves(system), "there are no valves"),
            Verb::Map => {
                let (width, height) = editor::terminal_size();
                let drawn = self.map.as_ref().and_then(|map| {
                    map::map(map, &system.outside, width, height.saturating_sub(3), self.console.colour)
                });
                drawn.unwrap_or_else(|| vec!["there is no world; start `rpl --world dept`".to_string()])
            }
            _ => or(self.last_events(rest), "no such event"),
        }
    }

    fn last_events(&self, words: &str) -> Vec<String> {
        let words: Vec<&str> = words.split_whitespace().collect();
        let texts = self.session.branch.log.iter().rev().map(|event| event_line(event, self.console.out_colour()));
        let mut last: Vec<String> =
            texts.filter(|text| words.iter().all(|word| text.contains(word))).take(LAST_EVENTS).collect();
        last.reverse();
        last
    }

    /// A file: its forms are run in order.
    fn load(&mut self, plan: PlanText, until: Until) -> Result<()> {
        let PlanText { name, text, folder } = plan;
        self.session.file = Some(name.clone());
        if self.session.branch.is_running {
            return self.beside(&name, &text, Some(folder));
        }
        match self.session.submit(&name, &text, Some(folder)) {
            Ok(submitted) => {
                self.tell(&submitted);
                self.begin(&until)
            }
            Err(rejected) => {
                self.reject(&rejected);
                Ok(())
            }
        }
    }

    /// Forms that were typed.
    fn forms(&mut self, text: &str, until: &Until) -> Result<()> {
        let name = self.session.next_text_name();
        if self.session.branch.is_running {
            return self.beside(&name, text, None);
        }
        match self.session.submit(&name, text, None) {
            Ok(submitted) => {
                self.tell(&submitted);
                self.begin(until)
            }
            Err(rejected) => {
                self.reject(&rejected);
                Ok(())
            }
        }
    }

    /// A form was handed in: the clock lets it go on, if it runs.
    fn begin(&mut self, until: &Until) -> Result<()> {
        if self.clock.is_some() { Ok(()) } else { self.go_on(until) }
    }

    /// Forms typed while another one is under way: a task of their own.
    fn beside(&mut self, name: &str, text: &str, folder: Option<Folder>) -> Result<()> {
        let (submitted, aside) = match self.session.beside(name, text, folder) {
            Ok(beside) => beside,
            Err(rejected) => {
                self.reject(&rejected);
                return Ok(());
            }
        };
        self.tell(&submitted);
        self.session.hand_on(self.console)?;
        let system = &self.session.branch.system;
        match aside.answer {
            Some(Answer::Succeeded(value)) => self.console.print(&system.machine.write(&system.program, value))?,
            Some(Answer::Failed(failure)) => self.show_failure(failure),
            Some(Answer::GivenUp) => {}
            None => {
                if let Some(task) = system.machine.tasks.find_alive(aside.task) {
                    let (path, waits) = (system.machine.path(task), living::standing(system, task).condition());
                    self.console.note(&format!("{path} {waits}; it goes on with the run"));
                }
            }
        }
        let system = &self.session.branch.system;
        for &name in &aside.assigned {
            let name = system.machine.symbols.name(name);
            self.console.note(&format!("`{name}` counts from the next form on; the marked one has read its arguments"));
        }
        Ok(())
    }

    fn reject(&mut self, rejected: &Rejected) {
        self.console.note(rejected.render(self.console.colour).trim_end());
        self.worst = Status::Wrong;
    }

    /// Warnings, and what goes on in an old text.
    fn tell(&mut self, submitted: &Submitted) {
        let system = &self.session.branch.system;
        if !submitted.warnings.is_empty() {
            let sources = &system.program.sources;
            self.console.note(diagnostic::render(&submitted.warnings, sources, self.console.colour).trim_end());
        }
        for redefined in &submitted.redefined {
            let name = system.machine.symbols.name(redefined.name);
            match redefined.still_running.as_slice() {
                [] => self.console.note(&format!("`{name}` is defined anew")),
                paths => self.console.note(&format!(
                    "`{name}` is defined anew from its next call on; the old text still runs in {}",
                    paths.join(", ")
                )),
            }
        }
    }

    fn show_failure(&mut self, failure: rpl_runtime::value::Value) {
        let system = &self.session.branch.system;
        let reporter = Reporter { machine: &system.machine, program: &system.program, colour: self.console.colour };
        self.console.note(reporter.text("failed: ", failure).trim_end());
        if self.worst == Status::Succeeded {
            self.worst = Status::Failed;
        }
    }

    fn go_on(&mut self, until: &Until) -> Result<()> {
        if !self.session.branch.is_running {
            return self.wrong("nothing runs; type a form, or `:step FORM` to go through one");
        }
        if let Some(stop) = self.session.branch.stop.clone() {
            self.session.branch.system.want_value(&stop);
        }
        let halt = self.session.go_on(until, self.console)?;
        self.halted(halt)
    }

    fn halted(&mut self, halt: Halt) -> Result<()> {
        let value = self.session.branch.system.wanted_value();
        if let (Some(value), true) = (value, self.session.branch.stop.is_some()) {
            self.console.print(&format!("=> {}", shortened(&value)))?;
        }
        match halt {
            Halt::Answered(Answer::Succeeded(value)) => {
                let system = &self.session.branch.system;
                self.console.print(&system.machine.write(&system.program, value))?;
            }
            Halt::Answered(Answer::Failed(failure)) => self.show_failure(failure),
            Halt::Answered(Answer::GivenUp) => self.console.note("given up, clean-ups done"),
            Halt::Arrived => self.show_stop()?,
            Halt::Breakpoint(place) => {
                self.console.note(&format!("stopped at {place}"));
                self.show_stop()?;
            }
            Halt::Interrupted => {
                self.console.note("interrupted; `:continue` goes on, `:abort` gives up, `:why` tells what it does");
                self.show_stop()?;
            }
        }
        Ok(())
    }

    /// Where the run stands, and what is watched.
    fn show_stop(&mut self) -> Result<()> {
        let lines = match self.session.branch.stop.clone() {
            Some(stop) => {
                let width = if self.is_interactive { editor::terminal_size().0 } else { usize::MAX };
                view::stop(&self.session, &stop, self.console.colour, width)
            }
            None => vec![format!("{:.3} s", self.session.branch.system.machine.now_s())],
        };
        self.print(&lines)?;
        for watch in self.session.watches.clone() {
            // In a copy: what is watched must not touch the run.
            let mut copy = self.session.branch.system.clone();
            let shown = match copy.inspect("watch", &watch, &[], &mut NoFiles) {
                Ok((_, Ok(value))) => view::value_text(&copy, value),
                Ok((_, Err(failure))) => copy.machine.show(&copy.program, failure),
                Err(_) => "not a form that can be evaluated here".to_string(),
            };
            self.console.print(&format!("    {watch} = {shown}"))?;
        }
        Ok(())
    }

    fn until(&mut self, rest: &str) -> Result<()> {
        let until = match parse_duration_us(rest) {
            Ok(time_us) if !rest.chars().all(|c| c.is_ascii_digit()) => Until::Time(time_us),
            _ if rest.is_empty() => {
                return self.wrong("`:until` needs a time such as 12.5s, a line, a name or a condition");
            }
            _ => match Breakpoint::parse(rest, &mut self.session.branch.system, self.console.colour) {
                Ok(place) => Until::Place(place),
                Err(reason) => return self.wrong(&reason),
            },
        };
        self.go_on(&until)
    }

    fn set_break(&mut self, rest: &str) -> Result<()> {
        if rest.is_empty() {
            let places = self.session.breakpoints.iter().enumerate();
            let mut lines: Vec<String> = places.map(|(index, place)| format!("{}  {place}", index + 1)).collect();
            if lines.is_empty() {
                lines.push(
                    "no breakpoints; `:break NAME`, `:break 12` or `:break (< pos-certainty* 0.5)` sets one".into(),
                );
            }
            return self.print(&lines);
        }
        match Breakpoint::parse(rest, &mut self.session.branch.system, self.console.colour) {
            Ok(place) => {
                self.session.breakpoints.push(place);
                Ok(())
            }
            Err(reason) => self.wrong(&reason),
        }
    }

    fn delete(&mut self, rest: &str) -> Result<()> {
        let count = self.session.breakpoints.len();
        match rest.parse::<usize>() {
            _ if rest.is_empty() => self.session.breakpoints.clear(),
            Ok(number) if (1..=count).contains(&number) => drop(self.session.breakpoints.remove(number - 1)),
            _ => return self.wrong(&format!("there is no breakpoint `{rest}`; `:break` lists them")),
        }
        Ok(())
    }

    fn abort(&mut self) -> Result<()> {
        if !self.session.branch.is_running {
            return self.wrong("nothing runs");
        }
        let halt = self.session.give_up(self.console)?;
        self.halted(halt)
    }

    fn back(&mut self, rest: &str) -> Result<()> {
        let timeline = &self.session.branch.timeline;
        let now_us = self.session.branch.system.machine.now_us;
        let past = match (rest.parse::<usize>(), parse_duration_us(rest)) {
            _ if rest.is_empty() => timeline.steps_before(timeline.position, 1, view::is_shown),
            (Ok(steps), _) => timeline.steps_before(timeline.position, steps, view::is_shown),
            (_, Ok(time_us)) => timeline.at_time(now_us.saturating_sub(time_us)),
            _ => return self.wrong(&format!("`{rest}` is neither a number of steps nor a time such as 10s")),
        };
        self.go_back(past)
    }

    fn at(&mut self, rest: &str) -> Result<()> {
        match parse_duration_us(rest) {
            Ok(time_us) if time_us > self.session.branch.system.machine.now_us => {
                self.wrong(&format!("{rest} has not come yet; `:until {rest}` goes there"))
            }
            Ok(time_us) => {
                let past = self.session.branch.timeline.at_time(time_us);
                self.go_back(past)
            }
            Err(reason) => self.wrong(&reason),
        }
    }

    fn go_back(&mut self, past: Past<Robot>) -> Result<()> {
        let is_start = past.position.segment == 0;
        self.session.go_back_to(past);
        if is_start {
            self.console.note("this is the start");
        }
        self.show_stop()
    }

    fn forks(&mut self, verb: Verb, rest: &str) -> Result<()> {
        match verb {
            Verb::Fork if rest.is_empty() => return self.wrong("`:fork NAME`: a name is expected"),
            Verb::Fork if rest == self.session.name => {
                return self.wrong(&format!("this run is called `{rest}` already"));
            }
            Verb::Fork => {
                self.session.others.insert(rest.to_string(), self.session.branch.clone());
                self.console.note(&format!("kept as `{rest}`; `:switch {rest}` goes there"));
            }
            Verb::Switch => match self.session.others.remove(rest) {
                Some(branch) => {
                    let left = std::mem::replace(&mut self.session.branch, branch);
                    let name = std::mem::replace(&mut self.session.name, rest.to_string());
                    self.session.others.insert(name, left);
                    self.session.restore_conditions();
                    self.show_stop()?;
                }
                None => return self.wrong(&format!("no run is called `{rest}`; `:forks` lists them")),
            },
            _ => {
                let line = |mark: char, name: &str, branch: &session::Branch| {
                    format!("{mark} {name}  {:.1} s", branch.system.machine.now_s())
                };
                let mut lines = vec![line('*', &self.session.name, &self.session.branch)];
                lines.extend(self.session.others.iter().map(|(name, branch)| line(' ', name, branch)));
                self.print(&lines)?;
            }
        }
        Ok(())
    }
}
