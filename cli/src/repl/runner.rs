//! Lets the run of a session go on, until it ends, arrives, or is stopped.

use super::breakpoint::Breakpoint;
use super::session::{Halt, Session, Until};
use super::view::is_shown;
use crate::console::Console;
use crate::events;
use crate::interrupt;
use rpl_runtime::stepping::{Stepped, Stop};
use rpl_runtime::timeline::Position;
use std::io;
use std::time::Instant;

/// Lets a run go on.
pub struct Runner<'a> {
    session: &'a mut Session,
    until: &'a Until,
    console: &'a mut Console,
    /// Since when the present instant is computed.
    computed: Instant,
}

impl<'a> Runner<'a> {
    /// Of a session, that has stood still until now.
    pub fn new(session: &'a mut Session, until: &'a Until, console: &'a mut Console) -> Self {
        Self { session, until, console, computed: Instant::now() }
    }

    /// Goes on until there is a reason to stand still.
    ///
    /// # Errors
    /// Standard output is closed.
    pub fn run(&mut self) -> io::Result<Halt> {
        let start = self.session.branch.stop.take();
        let stops_at_forms = self.stops_at_forms();
        interrupt::forget();
        loop {
            if interrupt::is_asked() {
                interrupt::forget();
                return Ok(Halt::Interrupted);
            }
            let stepped = match stops_at_forms {
                true => self.session.branch.system.step_form(),
                false if self.session.branch.system.step_task() => Stepped::Ran,
                false => Stepped::Settled,
            };
            if self.session.branch.system.machine.is_output_full() || stepped == Stepped::Settled {
                self.session.hand_on(self.console)?;
            }
            match stepped {
                Stepped::Before(stop) => {
                    self.session.branch.timeline.position.step += 1;
                    if let Some(halt) = self.halt_before(&stop, start.as_ref()) {
                        self.session.branch.stop = Some(stop);
                        self.session.hand_on(self.console)?;
                        return Ok(halt);
                    }
                }
                Stepped::Ran => {}
                Stepped::Settled => {
                    if let Some(halt) = self.settled() {
                        return Ok(halt);
                    }
                }
            }
        }
    }

    /// Whether the run must be looked at form by form, which is slower.
    fn stops_at_forms(&self) -> bool {
        let is_place = |breakpoint: &Breakpoint| breakpoint.condition().is_none();
        match self.until {
            Until::Step | Until::Next | Until::Out => true,
            Until::Place(place) if is_place(place) => true,
            _ => self.session.breakpoints.iter().any(is_place),
        }
    }

    fn halt_before(&self, stop: &Stop, start: Option<&Stop>) -> Option<Halt> {
        let system = &self.session.branch.system;
        if !is_shown(system, stop) {
            return None;
        }
        let is_here = |place: &Breakpoint| place.is_at(system, stop, self.session.file.as_deref());
        let same_task = start.is_none_or(|start| start.task == stop.task);
        let was_depth = start.map_or(u32::MAX, |start| start.depth);
        let has_arrived = match self.until {
            Until::Step => true,
            Until::Next => same_task && stop.depth <= was_depth,
            Until::Out => same_task && stop.depth < was_depth,
            Until::Place(place) => is_here(place),
            Until::End | Until::Time(_) | Until::Clock { .. } => false,
        };
        if has_arrived {
            return Some(Halt::Arrived);
        }
        let breakpoint = self.session.breakpoints.iter().find(|place| is_here(place))?;
        Some(Halt::Breakpoint(breakpoint.to_string()))
    }

    /// All tasks are blocked: the form has ended, or the clock moves.
    fn settled(&mut self) -> Option<Halt> {
        self.session.branch.timeline.position.step = Position::END;
        if self.session.branch.is_running
            && let Some(answer) = self.session.branch.system.answer()
        {
            return Some(Halt::Answered(answer));
        }
        if let Some(halt) = self.condition_met() {
            return Some(halt);
        }
        let branch = &mut self.session.branch;
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
        branch.timeline.next_instant(&branch.system, self.computed.elapsed());
        self.computed = Instant::now();
        if let Some(room) = self.console.status_room() {
            let sight = branch.system.outside.sight();
            let line = events::status_line(&branch.system.machine, &branch.system.outside, sight, room);
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
