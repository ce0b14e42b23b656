//! Lets the run of a session go on, until it ends, arrives, or is stopped.

use super::clock::Clock;
use super::session::Session;
use rpl_drive::show::whereabouts::whereabouts;
use rpl_drive::stopping::halt::{Halt, Until};
use rpl_drive::stopping::{Places, Stopping, condition_met};
use rpl_runtime::run::stepping::Stepped;
use rpl_runtime::run::system::Turn;
use rpl_runtime::run::timeline::TimelinePosition;
use rpl_shell::interrupt;
use rpl_shell::terminal::console::Console;
use std::io;
use std::thread;
use std::time::{Duration, Instant};

/// The longest nap of a run that goes by the clock, so that Ctrl-C is noticed.
const NAP: Duration = Duration::from_millis(50);

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
    stopping: Stopping,
    /// By which time passes, where what is outside does not wait.
    clock: Option<Clock>,
}

impl<'a> Runner<'a> {
    /// Of a session, that has stood still until now.
    fn new(session: &'a mut Session, until: &'a Until, console: &'a mut Console) -> Self {
        let clock = session.goes_by_clock.then(|| Clock::new(1.0, session.branch.system.machine.now_us));
        Self { session, until, console, computed: Instant::now(), stopping: Stopping::default(), clock }
    }

    /// Goes on until there is a reason to stand still.
    ///
    /// # Errors
    /// Standard output is closed.
    fn run(&mut self) -> io::Result<Halt> {
        self.stopping = Stopping::from(self.session.branch.stop.take());
        let stops_at_forms = self.places().need_forms();
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
                    stop.is_entry = self.stopping.enters(&stop);
                    let system = &self.session.branch.system;
                    if let Some(halt) = self.stopping.halt_before(system, &stop, self.places()) {
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

    fn places(&self) -> Places<'_> {
        let Session { breakpoints, file, .. } = &*self.session;
        Places { until: self.until, breakpoints, file: file.as_deref() }
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
        if !self.has_clock_come() {
            return Some(Halt::Interrupted);
        }
        let branch = &mut self.session.branch;
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

    /// Waits for the next instant by the clock, where that is how time passes. Whether it has come, and nobody has stopped
    /// the run meanwhile.
    fn has_clock_come(&mut self) -> bool {
        let (Some(clock), Some(next_us)) = (self.clock, self.session.branch.system.next_instant_us()) else {
            return true;
        };
        while clock.due_us() < next_us {
            if interrupt::is_asked() {
                return false;
            }
            interrupt::beat();
            thread::sleep(clock.wait_for(Some(next_us)).min(NAP));
        }
        true
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
        condition_met(&mut branch.system, breakpoints)
    }
}
