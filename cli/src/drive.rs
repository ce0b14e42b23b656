//! Drives a system to its end: output, trace, pace, the status line, and signals from outside.

use crate::console::Console;
use crate::events;
use crate::interrupt;
use crate::mission::{CONTINUOUS_FLUENTS, Robot, Sight};
use crate::trace_file::TraceFile;
use rpl_runtime::machine::Output;
use rpl_runtime::system::{Outcome, Progress, System};
use rpl_runtime::trace::{Event, EventKind};
use rpl_runtime::value::Value;
use std::io;
use std::time::{Duration, Instant};

/// The longest nap of a paced run, so that Ctrl-C is noticed.
const NAP: Duration = Duration::from_millis(50);

/// How a run is driven.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// Virtual time at which the run is cut off.
    pub until_us: Option<u64>,
    /// Virtual seconds for each second of the wall clock; as fast as possible without.
    pub factor: Option<f64>,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// By itself.
    Outcome(Outcome),
    /// The time given was up.
    TimeUp,
    /// It was told to stop, and its clean-ups have run.
    Interrupted,
}

/// What is kept of a run while it goes on.
#[derive(Default)]
pub struct Records {
    /// Where the trace goes.
    pub trace: Option<TraceFile>,
    /// What was seen of the robot, once for every tenth of a second.
    pub track: Vec<Sight>,
    /// How often active localization was started.
    pub relocalizations: u64,
}

/// Runs a system to its end.
///
/// # Errors
/// Standard output or the trace cannot be written; the system was stopped, and its clean-ups have
/// run.
pub fn drive(
    system: &mut System<Robot>,
    pace: Pace,
    console: &mut Console,
    records: &mut Records,
) -> io::Result<Ending> {
    silence_continuous_fluents(system);
    console.begin_status();
    let mut driver = Driver { system, pace, console, records, began: Instant::now(), track_due_us: 0 };
    let ending = driver.run();
    driver.console.end_status();
    ending
}

struct Driver<'a> {
    system: &'a mut System<Robot>,
    pace: Pace,
    console: &'a mut Console,
    records: &'a mut Records,
    began: Instant,
    track_due_us: u64,
}

impl Driver<'_> {
    fn run(&mut self) -> io::Result<Ending> {
        let mut stopped = false;
        loop {
            self.settle().inspect_err(|_| self.stop_quietly())?;
            if let Some(outcome) = self.system.outcome() {
                return Ok(if stopped { Ending::Interrupted } else { Ending::Outcome(outcome) });
            }
            if interrupt::is_asked() && !stopped {
                stopped = true;
                self.system.stop();
                continue;
            }
            if let Some(next_us) = self.system.next_instant_us() {
                if !stopped && self.pace.until_us.is_some_and(|until_us| next_us > until_us) {
                    return Ok(Ending::TimeUp);
                }
                if !self.wait_for_clock(next_us, stopped) {
                    continue;
                }
            }
            if self.system.advance() == Progress::Running {
                self.look_at_robot();
            }
        }
    }

    /// Runs every ready task until it blocks, handing on what it prints.
    fn settle(&mut self) -> io::Result<()> {
        self.hand_on()?;
        while self.system.step_task() {
            self.hand_on()?;
        }
        self.console.flush()
    }

    fn hand_on(&mut self) -> io::Result<()> {
        if !self.system.machine.trace.events.is_empty() {
            for event in self.system.machine.trace.take() {
                self.record(&event)?;
            }
        }
        if !self.system.machine.output.is_empty() {
            for output in std::mem::take(&mut self.system.machine.output) {
                match output {
                    Output::Print(text) => self.console.print(&text)?,
                    Output::Log(text) => self.console.note(&text),
                }
            }
        }
        Ok(())
    }

    fn record(&mut self, event: &Event) -> io::Result<()> {
        if events::is_relocalization(event) {
            self.records.relocalizations += 1;
        }
        if !self.console.quiet
            && let Some(line) = events::line(event, self.system.outside.sight())
        {
            self.console.note(&line);
        }
        match &mut self.records.trace {
            Some(trace) => trace.write(event),
            None => Ok(()),
        }
    }

    /// Waits until the wall clock has come as far as the plan. False if something happened before.
    fn wait_for_clock(&self, next_us: u64, stopped: bool) -> bool {
        let Some(factor) = self.pace.factor else { return true };
        let due = Duration::from_secs_f64(next_us as f64 / 1e6 / factor);
        while let Some(left) = due.checked_sub(self.began.elapsed()).filter(|left| !left.is_zero()) {
            if interrupt::is_asked() && !stopped {
                return false;
            }
            std::thread::sleep(left.min(NAP));
        }
        true
    }

    fn look_at_robot(&mut self) {
        let now_us = self.system.machine.now_us;
        let sight = self.system.outside.sight();
        if let Some(sight) = sight
            && now_us >= self.track_due_us
        {
            self.records.track.push(sight);
            self.track_due_us = now_us + 100_000;
        }
        if self.console.wants_status() {
            let text = events::status_line(&self.system.machine, &self.system.outside, sight);
            self.console.status(text);
        }
    }

    /// Nobody reads any more: the clean-ups run, what they print is lost.
    fn stop_quietly(&mut self) {
        self.system.stop();
        while self.system.outcome().is_none() {
            self.system.advance();
            self.system.machine.output.clear();
            self.system.machine.trace.events.clear();
        }
    }
}

fn silence_continuous_fluents(system: &mut System<Robot>) {
    let fluents: Vec<u32> = CONTINUOUS_FLUENTS.iter().filter_map(|name| robot_fluent(system, name)).collect();
    system.machine.trace.quiet.extend(fluents);
    // The first step of the robot was traced before anybody could say which fluents are quiet.
    system.machine.trace.events.retain(|event| {
        event.kind != EventKind::Fluent
            || !event
                .details
                .iter()
                .any(|(name, value)| name == "fluent" && CONTINUOUS_FLUENTS.contains(&value.as_str()))
    });
}

fn robot_fluent(system: &System<Robot>, name: &str) -> Option<u32> {
    let symbol = system.machine.symbols.find(name)?;
    let global = *system.program.names.get(&symbol)?;
    match system.machine.globals.get(global as usize)? {
        Value::Fluent(fluent) => Some(*fluent),
        _ => None,
    }
}
