//! Lets the run of a session go on, until it ends, arrives, or is stopped.

use super::breakpoint::Breakpoint;
use super::halt::{Halt, Until};
use super::own_text::{is_hidden, is_own};
use super::session::Session;
use crate::interrupt;
use crate::show::situation::is_within;
use crate::show::whereabouts::whereabouts;
use crate::terminal::console::Console;
use rpl_lang::source::Span;
use rpl_runtime::run::stepping::{Stepped, Stop};
use rpl_runtime::run::system::Turn;
use rpl_runtime::run::timeline::TimelinePosition;
use std::collections::BTreeMap;
use std::io;
use std::time::Instant;

impl Session {
    /// Lets the form that runs go on.
    ///
    /// # Errors
    /// Standard output is closed.
    pub fn go_on(&mut self, until: &Until, console: &mut Console) -> io::Result<Halt> {
        if !matches!(until, Until::Clock { .. }) {
            console.begin_status();
        }
        let halt = Runner::new(self, until, console).run();
        console.end_status();
        let halt = halt?;
        if matches!(halt, Halt::Answered(_)) {
            self.branch.is_running = false;
            self.branch.stop = None;
        }
        Ok(halt)
    }

    /// Gives up the form that runs; its clean-ups run.
    ///
    /// # Errors
    /// Standard output is closed.
    pub fn give_up(&mut self, console: &mut Console) -> io::Result<Halt> {
        let branch = &mut self.branch;
        branch.system.give_up_form();
        branch.stop = None;
        branch.timeline.handed_in(&branch.system);
        let breakpoints = std::mem::take(&mut self.breakpoints);
        let halt = self.go_on(&Until::End, console);
        self.breakpoints = breakpoints;
        halt
    }
}

/// Lets a run go on.
struct Runner<'a> {
    session: &'a mut Session,
    until: &'a Until,
    console: &'a mut Console,
    /// Since when the present instant is computed.
    computed: Instant,
    /// How deep in calls, and in which body, each task stood when it was looked at last.
    looked_at: BTreeMap<(u32, u32), (u32, Span)>,
}

impl<'a> Runner<'a> {
    /// Of a session, that has stood still until now.
    fn new(session: &'a mut Session, until: &'a Until, console: &'a mut Console) -> Self {
        Self { session, until, console, computed: Instant::now(), looked_at: BTreeMap::new() }
    }

    /// Goes on until there is a reason to stand still.
    ///
    /// # Errors
    /// Standard output is closed.
    fn run(&mut self) -> io::Result<Halt> {
        let start = self.session.branch.stop.take();
        if let Some(start) = &start {
            self.enters(start);
        }
        let stops_at_forms = self.stops_at_forms();
        loop {
            if interrupt::is_asked() {
                return Ok(Halt::Interrupted);
            }
            let mut is_cut = false;
            let stepped = match stops_at_forms {
                true => self.session.branch.system.step_form(),
                false => match self.session.branch.system.step_slice() {
                    Turn::Idle => Stepped::Settled,
                    Turn::Over => Stepped::Ran,
                    Turn::Cut => {
                        is_cut = true;
                        Stepped::Ran
                    }
                },
            };
            let is_much = self.session.branch.system.machine.is_output_full();
            if is_much || is_cut || stepped == Stepped::Settled {
                self.session.hand_on(self.console)?;
            }
            match stepped {
                Stepped::Before(mut stop) => {
                    self.session.branch.timeline.position.step += 1;
                    stop.is_entry = self.enters(&stop);
                    if let Some(halt) = self.halt_before(&stop, start.as_ref()) {
                        self.session.branch.stop = Some(stop);
                        self.session.hand_on(self.console)?;
                        return Ok(halt);
                    }
                }
                Stepped::Ran => {
                    // Something may be typed in the middle of a long instant.
                    if let &Until::Clock { before, .. } = self.until
                        && Instant::now() >= before
                    {
                        self.session.hand_on(self.console)?;
                        return Ok(Halt::Arrived);
                    }
                }
                Stepped::Settled => {
                    if self.session.intervene(self.console) {
                        continue;
                    }
                    if let Some(halt) = self.settled() {
                        return Ok(halt);
                    }
                }
            }
        }
    }

    /// Whether the run must be looked at form by form, which is slower.
    fn stops_at_forms(&self) -> bool {
        match self.until {
            Until::Step | Until::Into | Until::Next | Until::Out => true,
            Until::Place(place) if place.is_place() => true,
            Until::End | Until::Time(_) | Until::Place(_) | Until::Clock { .. } => {
                self.session.breakpoints.iter().any(Breakpoint::is_place)
            }
        }
    }

    /// Whether a task has just come into the body it stands in: by a call, which is deeper, or by one
    /// in tail position, which is as deep. Which of its forms comes first depends on conditions.
    fn enters(&mut self, stop: &Stop) -> bool {
        let task = (stop.task.index, stop.task.generation);
        let before = self.looked_at.insert(task, (stop.depth, stop.body));
        let is_called = |(depth, body): (u32, Span)| depth < stop.depth || depth == stop.depth && body != stop.body;
        stop.is_entry || before.is_some_and(is_called)
    }

    fn halt_before(&self, stop: &Stop, start: Option<&Stop>) -> Option<Halt> {
        let system = &self.session.branch.system;
        if is_hidden(system, stop.span) {
            return None;
        }
        let is_here = |place: &Breakpoint| place.is_at(system, stop, self.session.file.as_deref());
        let same_task = start.is_none_or(|start| start.task == stop.task);
        let was_depth = start.map_or(u32::MAX, |start| start.depth);
        let is_wanted = is_own(system, stop.span) || start.is_some_and(|start| self.is_asked_for(start, stop));
        let has_arrived = match self.until {
            Until::Place(place) => is_here(place),
            _ if !is_wanted => false,
            Until::Step | Until::Into => true,
            Until::Next => same_task && stop.depth <= was_depth,
            Until::Out => same_task && stop.depth < was_depth,
            Until::End | Until::Time(_) | Until::Clock { .. } => false,
        };
        if has_arrived {
            return Some(Halt::Arrived);
        }
        let breakpoint = self.session.breakpoints.iter().find(|place| is_here(place))?;
        Some(Halt::Breakpoint(breakpoint.to_string()))
    }

    /// Whether the user wants to see a place in the library: somebody who went into it, goes on in
    /// it.
    fn is_asked_for(&self, start: &Stop, stop: &Stop) -> bool {
        let system = &self.session.branch.system;
        let is_called = stop.depth >= start.depth && stop.body != start.body && !is_own(system, stop.body);
        let goes_in = *self.until == Until::Into && start.task == stop.task && is_called;
        let path = |task| system.machine.tasks.find_alive(task).map(|task| system.machine.path(task));
        let was_in = !is_own(system, start.span)
            && match (path(start.task), path(stop.task)) {
                (Some(start), Some(stop)) => is_within(&stop, &start) || is_within(&start, &stop),
                _ => false,
            };
        goes_in || was_in
    }

    /// All tasks are blocked: the form has ended, or the clock moves.
    fn settled(&mut self) -> Option<Halt> {
        self.session.branch.timeline.position.step = TimelinePosition::END;
        if self.session.branch.is_running
            && let Some(answer) = self.session.branch.system.answer()
        {
            return Some(Halt::Answered(answer));
        }
        if let Some(halt) = self.condition_met() {
            return Some(halt);
        }
        let horizon_us = self.session.horizon_us;
        let branch = &mut self.session.branch;
        if let (Some(horizon_us), Some(next_us)) = (horizon_us, branch.system.next_instant_us())
            && next_us > horizon_us
        {
            return Some(Halt::Interrupted);
        }
        let has_arrived = match (self.until, branch.system.next_instant_us()) {
            (&Until::Time(time_us), Some(next_us)) => next_us > time_us,
            // Where nothing can happen by itself, something may still be typed.
            (Until::Clock { .. }, None) => true,
            (&Until::Clock { due_us, before }, Some(next_us)) => next_us > due_us || Instant::now() >= before,
            _ => false,
        };
        if has_arrived {
            return Some(Halt::Arrived);
        }
        branch.system.next_instant();
        interrupt::beat();
        branch.timeline.next_instant(&branch.system, self.computed.elapsed());
        self.computed = Instant::now();
        if let Some(room) = self.console.status_room() {
            let sight = branch.system.outside.sight();
            let line = whereabouts(&branch.system.machine, &branch.system.outside, sight, room);
            self.console.status(&line);
        }
        None
    }

    /// A condition that has become true since the last instant.
    fn condition_met(&mut self) -> Option<Halt> {
        let Session { branch, breakpoints, .. } = &mut *self.session;
        if let Until::Place(place) = self.until
            && let Some(condition) = place.condition()
            && branch.system.holds(condition).unwrap_or(false)
        {
            return Some(Halt::Arrived);
        }
        let mut met = None;
        for breakpoint in breakpoints.iter_mut() {
            let Some(condition) = breakpoint.condition() else { continue };
            let holds = branch.system.holds(condition).unwrap_or(false);
            if breakpoint.becomes(holds) && met.is_none() {
                met = Some(Halt::Breakpoint(breakpoint.to_string()));
            }
        }
        met
    }
}
