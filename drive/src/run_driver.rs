//! Drives a system to its end: output, trace, pace, the status line, and signals from outside.

use crate::events::{self, LineKind};
use crate::journal::RunJournal;
use crate::observed::RunEnd;
use crate::onlooker::Happened;
use crate::run_record::Records;
use crate::seen::{SteeredTurn, Steering};
use crate::show::whereabouts::whereabouts;
use crate::trace::{TraceFile, TracedPose};
use rpl_link::journal::ledger::Written;
use rpl_link::recording::Typed;
use rpl_mission::robot::Robot;
use rpl_mission::site::Site;
use rpl_runtime::run::system::{System, Turn};
use rpl_shell::interrupt;
use rpl_shell::terminal::console::Console;
use std::io;
use std::time::{Duration, Instant};

/// The longest nap of a paced run, so that Ctrl-C is noticed.
const NAP: Duration = Duration::from_millis(50);

/// How long a run that is held sleeps before it looks whether it is to go on.
const HOLD_NAP: Duration = Duration::from_millis(10);

/// How often the robot is looked at for the drawing of its path.
const TRACK_EVERY_US: u64 = 100_000;

/// How long the clean-ups of a run that was told to stop may compute without coming to the end of
/// their instant. What they wait for may take as long as it takes.
const CLEAN_UP_PATIENCE: Duration = Duration::from_secs(1);

/// How a recording tells that a run was told to stop.
const STOP: &str = ":stop";

/// How a run is driven.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// Virtual time at which the run is cut off.
    pub until_us: Option<u64>,
    /// Virtual time at which a run that is repeated was told to stop.
    pub stopped_us: Option<u64>,
    /// Virtual seconds for each second of the wall clock; as fast as possible without.
    pub factor: Option<f64>,
}

impl Pace {
    /// How fast a run goes by the clock at a site if this is asked for: where what is outside does not wait, as fast as
    /// the clock.
    pub fn factor_at(site: &Site, asked: Option<f64>) -> Option<f64> {
        asked.or_else(|| site.goes_by_clock().then_some(1.0))
    }
}

/// What becomes of a run that was told to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
enum RunState {
    /// It was not.
    Runs,
    /// Its clean-ups run; those of this instant until then.
    CleansUp(Instant),
}

/// Runs a system to its end.
///
/// A signal stops it if the command has said so ([`interrupt::stops_runs`]).
///
/// # Errors
/// Standard output or the trace cannot be written; the system was stopped, and its clean-ups have
/// run.
pub fn drive(
    system: &mut System<Robot>,
    pace: Pace,
    console: &mut Console,
    records: &mut Records,
) -> io::Result<RunEnd> {
    console.begin_status();
    let (began, from_us) = (Instant::now(), system.machine.now_us);
    let state = RunState::Runs;
    let mut driver = RunDriver { system, pace, console, records, began, from_us, track_due_us: 0, state };
    let ending = driver.run();
    driver.console.end_status();
    ending
}

struct RunDriver<'a> {
    system: &'a mut System<Robot>,
    pace: Pace,
    console: &'a mut Console,
    records: &'a mut Records,
    /// When the run went on, and where it stood then.
    began: Instant,
    from_us: u64,
    track_due_us: u64,
    state: RunState,
}

impl RunDriver<'_> {
    fn run(&mut self) -> io::Result<RunEnd> {
        let factor = self.pace.factor;
        if let Some(steering) = self.records.steering.as_mut() {
            steering.begin_at(factor);
        }
        self.record_pose()?;
        let ending = self.go()?;
        if ending == RunEnd::TimeUp {
            self.stand_still();
        }
        // Where it came to, whenever the next look was due.
        self.records.pose_due_us = 0;
        self.record_pose()?;
        Ok(ending)
    }

    fn go(&mut self) -> io::Result<RunEnd> {
        loop {
            self.settle().inspect_err(|_| self.stop_quietly())?;
            self.hold_at_conditions();
            if let Some(outcome) = self.system.outcome() {
                return Ok(match self.state {
                    RunState::Runs => RunEnd::Outcome(outcome),
                    RunState::CleansUp(_) => RunEnd::Interrupted,
                });
            }
            match self.state {
                RunState::Runs if interrupt::is_asked() || self.was_stopped() || self.is_ended_by_hand() => {
                    self.stop();
                    continue;
                }
                RunState::CleansUp(until) if Instant::now() >= until => return Ok(RunEnd::GivenUp),
                RunState::Runs | RunState::CleansUp(_) => {}
            }
            if self.state == RunState::Runs && self.resumes() {
                continue;
            }
            self.take_changes().inspect_err(|_| self.stop_quietly())?;
            if self.state == RunState::Runs && self.write_journal() {
                self.stop();
                continue;
            }
            if let Some(next_us) = self.system.next_instant_us() {
                let is_late = self.pace.until_us.is_some_and(|until_us| next_us > until_us);
                if is_late && self.state == RunState::Runs {
                    return Ok(RunEnd::TimeUp);
                }
                if !self.wait_for_clock(next_us) {
                    continue;
                }
            }
            self.next_instant();
            self.tell_step().inspect_err(|_| self.stop_quietly())?;
            self.look_at_robot().inspect_err(|_| self.stop_quietly())?;
            self.record_pose().inspect_err(|_| self.stop_quietly())?;
        }
    }

    /// The journal has a checkpoint from which the run goes on as if it had not stood still.
    fn stand_still(&mut self) {
        let Records { journal, trace, pose_due_us, observed, .. } = &mut *self.records;
        if let Some(journal) = journal {
            let trace = trace.as_mut().and_then(TraceFile::ledger);
            journal.stand_still(self.system, trace, *pose_due_us, observed.relocalizations);
        }
    }

    /// A run whose host or modules are in other processes has come to where it died, now or once before: from here
    /// on these are others, and the world has not waited. Whether that is here.
    fn resumes(&mut self) -> bool {
        let now_us = self.system.machine.now_us;
        let resumes = self.records.journal.as_mut().is_some_and(|journal| journal.resumes(self.system));
        if resumes {
            self.system.renew_outside();
            (self.began, self.from_us) = (Instant::now(), now_us);
        }
        resumes
    }

    /// New definitions that a run with a journal has been given take effect when it has come to where it was.
    fn take_changes(&mut self) -> io::Result<()> {
        let Records { journal, trace, .. } = &mut *self.records;
        let Some(journal) = journal else { return Ok(()) };
        let trace = trace.as_mut().and_then(TraceFile::ledger);
        journal.take_changes(self.system, trace).map_err(io::Error::other)
    }

    /// Writes a checkpoint if it is time for one. Whether the journal must be written and cannot.
    fn write_journal(&mut self) -> bool {
        let Records { journal, trace, pose_due_us, observed, .. } = &mut *self.records;
        let Some(journal) = journal else { return false };
        if journal.is_due(self.system.machine.now_us) {
            let trace = trace.as_mut().and_then(TraceFile::ledger);
            journal.checkpoint(self.system, trace, *pose_due_us, observed.relocalizations);
        }
        if let Some(note) = journal.take_note() {
            self.console.note(&note);
        }
        journal.stops_run()
    }

    /// Tells the trace where the robot is, if it is to know and it is time.
    fn record_pose(&mut self) -> io::Result<()> {
        let time_us = self.system.machine.now_us;
        if let (Some(trace), Some(every_us)) = (&mut self.records.trace, self.records.pose_every_us)
            && time_us >= self.records.pose_due_us
            && let Some(sight) = self.system.outside.sight()
        {
            self.records.pose_due_us = time_us + every_us;
            trace.write_pose(&TracedPose { time_us, sight })?;
        }
        Ok(())
    }

    /// Tells all that look on of another instant.
    fn tell_step(&mut self) -> io::Result<()> {
        let (robot, now_us) = (&mut self.system.outside, self.system.machine.now_us);
        let mut onlookers = self.records.onlookers();
        onlookers.try_for_each(|onlooker| onlooker.stepped(now_us, robot)).map_err(io::Error::other)
    }

    /// Whether the run that is repeated was told to stop in this instant.
    fn was_stopped(&self) -> bool {
        self.pace.stopped_us.is_some_and(|stopped_us| self.system.machine.now_us >= stopped_us)
    }

    fn stop(&mut self) {
        if let Some(recorder) = &self.records.recorder {
            recorder.typed(&Typed { typed: STOP.to_string(), time_us: self.system.machine.now_us });
        }
        if let Some(journal) = &mut self.records.journal {
            journal.stopped();
        }
        self.state = RunState::CleansUp(Instant::now() + CLEAN_UP_PATIENCE);
        self.system.stop();
    }

    fn next_instant(&mut self) {
        let before_us = self.system.machine.now_us;
        self.system.next_instant();
        if let Some(journal) = &mut self.records.journal {
            journal.instant_begun(self.system);
        }
        if let RunState::CleansUp(until) = &mut self.state
            && self.system.machine.now_us > before_us
        {
            *until = Instant::now() + CLEAN_UP_PATIENCE;
            interrupt::beat();
        }
    }

    /// Whether the instant is to be left before its end.
    fn is_cut_short(&self) -> bool {
        match self.state {
            // What is recorded stops where all tasks are blocked: only that can be repeated.
            RunState::Runs => {
                interrupt::is_asked() && self.records.recorder.is_none() && self.records.journal.is_none()
            }
            RunState::CleansUp(until) => Instant::now() >= until,
        }
    }

    /// Runs every ready task until it blocks, or until the process is told to stop.
    fn settle(&mut self) -> io::Result<()> {
        loop {
            // What happens in one instant is told together, unless it grows too long.
            match self.turn() {
                SteeredTurn::Halted => {
                    self.write_out()?;
                    self.hold();
                }
                SteeredTurn::Turned(Turn::Idle) => break,
                SteeredTurn::Turned(Turn::Over) if !self.system.machine.is_output_full() => {}
                SteeredTurn::Turned(Turn::Over) => self.write_out()?,
                SteeredTurn::Turned(Turn::Cut) => {
                    self.write_out()?;
                    // An instant without end is left all the same.
                    if self.state == RunState::Runs && interrupt::is_asked() {
                        break;
                    }
                }
            }
            if self.is_cut_short() {
                break;
            }
        }
        self.write_out()
    }

    /// One turn of a ready task; a run that is stepped through comes back before a form.
    fn turn(&mut self) -> SteeredTurn {
        match self.records.steering.as_mut() {
            Some(steering) => steering.turn(self.system),
            None => SteeredTurn::Turned(self.system.step_slice()),
        }
    }

    /// Does what the page asks for, and stands still for as long as it wants.
    fn attend(&mut self) {
        if let Some(steering) = self.records.steering.as_mut() {
            steering.attend(self.system);
        }
        self.tell_trouble();
        self.hold();
    }

    /// Says why the page does not answer.
    fn tell_trouble(&mut self) {
        if let Some(trouble) = self.records.steering.as_mut().and_then(Steering::trouble) {
            self.console.note(&trouble.to_string());
        }
    }

    /// Stands still until the page lets the run go on, or the process is told to stop; then the clock begins anew.
    fn hold(&mut self) {
        let mut was_held = false;
        while !interrupt::is_asked()
            && let Some(steering) = self.records.steering.as_mut().filter(|steering| steering.is_held())
        {
            was_held = true;
            if !steering.attend(self.system) {
                std::thread::sleep(HOLD_NAP);
            }
            self.tell_trouble();
        }
        let pace = self.records.steering.as_mut().and_then(Steering::take_pace);
        if let Some(factor) = pace {
            self.pace.factor = factor;
        }
        if was_held || pace.is_some() {
            (self.began, self.from_us) = (Instant::now(), self.system.machine.now_us);
        }
    }

    /// Stands still where a condition has become true that the page has named.
    fn hold_at_conditions(&mut self) {
        if let Some(steering) = self.records.steering.as_mut() {
            steering.settled(self.system);
        }
        self.attend();
    }

    fn is_ended_by_hand(&self) -> bool {
        self.records.steering.as_ref().is_some_and(Steering::is_stop_asked)
    }

    /// Hands on what happened and what plans wrote; then the journal notes that it was.
    fn write_out(&mut self) -> io::Result<()> {
        self.hand_on()?;
        self.console.flush()?;
        if let Some(journal) = &mut self.records.journal {
            let trace = self.records.trace.as_mut().and_then(TraceFile::ledger);
            journal.flush(trace, self.system.machine.now_us);
        }
        Ok(())
    }

    fn hand_on(&mut self) -> io::Result<()> {
        let machine = &mut self.system.machine;
        if machine.trace.events.is_empty() && machine.output.is_empty() {
            return Ok(());
        }
        let (events, output) = (machine.trace.take(), std::mem::take(&mut machine.output));
        let is_lost = !events.is_empty() && self.system.outside.is_lost();
        let now_us = self.system.machine.now_us;
        let told = events::in_order(&events, output, is_lost);
        let happened = Happened { now_us, events: &events, told: &told, is_lost };
        let robot = &mut self.system.outside;
        self.records
            .onlookers()
            .try_for_each(|onlooker| onlooker.happened(&happened, robot))
            .map_err(io::Error::other)?;
        for told in &told {
            let line = told.line();
            let is_print = told.kind == LineKind::Print;
            let written = self.records.journal.as_mut().map_or(Written::Now, |journal| match is_print {
                true => journal.printed(&line),
                false => journal.told(&line),
            });
            match (told.kind, written) {
                // It was handed out before the run was killed.
                (_, Written::Before) => {}
                (LineKind::Event, Written::Now) if self.console.quiet => {}
                (LineKind::Event | LineKind::Log, Written::Now) => self.console.note(&line),
                (LineKind::Print, Written::Now) => self.console.print(&line)?,
            }
        }
        match &mut self.records.trace {
            Some(trace) => events.iter().try_for_each(|event| trace.write(event)),
            None => Ok(()),
        }
    }

    /// Waits until the wall clock has come as far as the plan. False if something happened before.
    fn wait_for_clock(&mut self, next_us: u64) -> bool {
        let Some(factor) = self.pace.factor else { return true };
        if self.records.journal.as_ref().is_some_and(RunJournal::is_past) {
            return true;
        }
        let due = Duration::from_secs_f64(next_us.saturating_sub(self.from_us) as f64 / 1e6 / factor);
        while let Some(left) = due.checked_sub(self.began.elapsed()).filter(|left| !left.is_zero()) {
            match self.state {
                RunState::Runs if interrupt::is_asked() => return false,
                RunState::Runs => {}
                RunState::CleansUp(_) => interrupt::beat(),
            }
            if self.records.steering.as_mut().is_some_and(|steering| steering.attend(self.system)) {
                return false;
            }
            self.tell_trouble();
            std::thread::sleep(left.min(NAP));
        }
        true
    }

    fn look_at_robot(&mut self) -> io::Result<()> {
        let now_us = self.system.machine.now_us;
        let is_track_due = now_us >= self.track_due_us;
        let status_room = self.console.status_room();
        // Asking the filter for its estimate at every step would cost more than the step.
        if !is_track_due && status_room.is_none() {
            return Ok(());
        }
        let sight = self.system.outside.sight();
        if is_track_due {
            self.track_due_us = now_us + TRACK_EVERY_US;
        }
        if let Some(sight) = sight.filter(|_| is_track_due) {
            let robot = &mut self.system.outside;
            let mut onlookers = self.records.onlookers();
            onlookers.try_for_each(|onlooker| onlooker.seen(now_us, &sight, robot)).map_err(io::Error::other)?;
        }
        if let Some(room) = status_room {
            let text = whereabouts(&self.system.machine, &self.system.outside, sight, room);
            self.console.status(&text);
        }
        Ok(())
    }

    /// Nobody reads any more: the clean-ups run, what they print is lost. The trace goes on for as
    /// long as it can be written.
    fn stop_quietly(&mut self) {
        self.stop();
        loop {
            while !self.is_cut_short() && self.system.step_slice() != Turn::Idle {}
            self.system.machine.output.clear();
            for event in self.system.machine.trace.take() {
                if let Some(trace) = &mut self.records.trace
                    && trace.write(&event).is_err()
                {
                    self.records.trace = None;
                }
            }
            if self.system.outcome().is_some() || self.is_cut_short() {
                return;
            }
            self.next_instant();
        }
    }
}
