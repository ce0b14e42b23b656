//! The search through all orders, by the number of deviations from the usual one.
//!
//! Level by level: all runs with no deviation, then all with one, and so on. Each goes on in the usual order up to
//! its end or to a state that was seen; at each choice on its way a run with one deviation more is laid aside for the
//! next level. A state that is come upon again was searched with at least as many deviations left.

use crate::finding::{Fault, Finding, failure, warning};
use rpl_runtime::robot::Outside;
use rpl_runtime::run::canonical::{StateHash, Visible};
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::schedule::{Deviation, Schedule};
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// How far the search goes.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// Deviations of a run, at most.
    pub deviations: u32,
    /// States, at most.
    pub states: u64,
    /// Time of the plan, at most.
    pub until_us: u64,
    /// Whether value and output have to be those of the usual order.
    pub deterministic: bool,
}

/// Why a search is not complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    /// Runs with more deviations.
    Deviations,
    /// More states.
    States,
    /// What comes later.
    Time,
    /// It was told to stop.
    Stopped,
}

/// What came of a search.
#[derive(Clone, Debug)]
pub struct Searched {
    /// The first finding, with the fewest deviations.
    pub finding: Option<Finding>,
    /// What was left out; nothing if all orders were tried.
    pub left: Vec<Left>,
    /// States that differ.
    pub states: u64,
    /// Turns of tasks and steps of the clock.
    pub transitions: u64,
    /// Runs that came to their end.
    pub ends: u64,
    /// The most deviations that were tried.
    pub deviations: u32,
}

/// A run on its way.
#[derive(Clone)]
struct Run<O> {
    system: System<O>,
    deviations: Vec<Deviation>,
    /// What it has printed so far, where that matters.
    output: String,
    /// Turns since its state was looked at.
    turns: u32,
}

/// A run's state is looked at where it has a choice or goes to another instant, and after so many turns of one task.
const MAX_TURNS: u32 = 64;

/// Bytes of runs that are laid aside whole, at most: those beyond are made again from the start when their turn comes,
/// so that the memory a search takes is bounded.
const MAX_KEPT_BYTES: usize = 256 << 20;

/// Bytes of a small run: its program's names and tables.
const SMALL_RUN_BYTES: usize = 32 << 10;

/// A run that is laid aside for the next level.
enum Aside<O> {
    Kept(Box<Run<O>>),
    Again(Vec<Deviation>),
}

struct Search<'s, O> {
    start: &'s System<O>,
    visible: Visible,
    bounds: Bounds,
    seen: BTreeSet<StateHash>,
    next: Vec<Aside<O>>,
    kept_bytes: usize,
    usual: Option<String>,
    searched: Searched,
}

/// Tries all orders of a run that has not begun, within bounds. `look` is asked now and then, with the number of states,
/// whether to go on. Cost: the states, each a few microseconds and what its canonical bytes take.
pub fn explore<O: Outside + Clone>(
    start: &System<O>,
    visible: Visible,
    bounds: Bounds,
    mut look: impl FnMut(&Searched) -> ControlFlow<()>,
) -> Searched {
    let searched = Searched { finding: None, left: Vec::new(), states: 0, transitions: 0, ends: 0, deviations: 0 };
    let mut search = Search {
        start,
        visible,
        bounds,
        seen: BTreeSet::new(),
        next: Vec::new(),
        kept_bytes: 0,
        usual: None,
        searched,
    };
    search.next.push(Aside::Again(Vec::new()));
    for level in 0.. {
        let runs = std::mem::take(&mut search.next);
        search.kept_bytes = 0;
        if runs.is_empty() {
            break;
        }
        search.searched.deviations = level;
        for run in runs {
            let run = search.taken_up(run);
            let gone = search.go(run, level < bounds.deviations, &mut look);
            if search.searched.finding.is_some() || gone.is_break() {
                return search.searched;
            }
        }
    }
    search.searched
}

impl<O: Outside + Clone> Search<'_, O> {
    fn taken_up(&self, run: Aside<O>) -> Run<O> {
        match run {
            Aside::Kept(run) => *run,
            Aside::Again(deviations) => {
                let mut system = self.start.fork();
                system.machine.schedule = Some(Box::new(Schedule::new(deviations.iter().copied())));
                Run { system, deviations, output: String::new(), turns: 0 }
            }
        }
    }

    fn is_on_its_way(run: &Run<O>) -> bool {
        run.system.machine.schedule.as_ref().is_some_and(|schedule| schedule.left().next().is_some())
    }

    /// Follows a run in the usual order behind its deviations.
    fn go(
        &mut self,
        mut run: Run<O>,
        may_deviate: bool,
        look: &mut impl FnMut(&Searched) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        loop {
            if let Some(outcome) = run.system.outcome() {
                self.searched.ends += 1;
                let fault = failure(&run.system).or_else(|| self.difference(&run, outcome));
                self.note(&run, fault);
                return ControlFlow::Continue(());
            }
            let tasks = run.system.eligible_tasks().len();
            let choices = if tasks == 0 { run.system.eligible_timeouts().len() } else { tasks };
            // Before its last deviation a run goes where another has gone.
            if !Self::is_on_its_way(&run) && (choices > 1 || tasks == 0 || run.turns >= MAX_TURNS) {
                run.turns = 0;
                if !self.is_new(&run) {
                    return ControlFlow::Continue(());
                }
                if self.searched.states >= self.bounds.states {
                    self.leave(Left::States);
                    return ControlFlow::Break(());
                }
                if self.searched.states.is_multiple_of(1_024) && look(&self.searched).is_break() {
                    self.leave(Left::Stopped);
                    return ControlFlow::Break(());
                }
                if choices > 1 && !may_deviate {
                    self.leave(Left::Deviations);
                } else {
                    (1..choices as u32).for_each(|taken| self.lay_aside(&run, taken));
                }
            }
            self.searched.transitions += 1;
            run.turns += 1;
            if tasks > 0 {
                run.system.step_task();
            } else if run.system.next_instant_us().is_some_and(|next_us| next_us > self.bounds.until_us) {
                self.leave(Left::Time);
                return ControlFlow::Continue(());
            } else {
                run.system.next_instant();
            }
            let output = std::mem::take(&mut run.system.machine.output);
            if let Some(fault) = warning(&output) {
                self.note(&run, Some(fault));
                return ControlFlow::Continue(());
            }
            if self.bounds.deterministic {
                output.iter().for_each(|line| run.output.extend([line.text.as_str(), "\n"]));
            }
        }
    }

    fn is_new(&mut self, run: &Run<O>) -> bool {
        let mut bytes = run.system.canonical_bytes(self.visible);
        bytes.extend_from_slice(run.output.as_bytes());
        let is_new = self.seen.insert(StateHash::of(&bytes));
        self.searched.states += u64::from(is_new);
        is_new
    }

    fn lay_aside(&mut self, run: &Run<O>, taken: u32) {
        if self.next.len() as u64 >= self.bounds.states {
            return self.leave(Left::States);
        }
        let turn = run.system.machine.schedule.as_ref().map_or(0, |schedule| schedule.turns());
        let mut deviations = run.deviations.clone();
        deviations.push(Deviation { turn, taken });
        let machine = &run.system.machine;
        let bytes = SMALL_RUN_BYTES + machine.tasks.bytes() + machine.heap.live + machine.heap.allocated;
        if self.kept_bytes + bytes > MAX_KEPT_BYTES {
            return self.next.push(Aside::Again(deviations));
        }
        self.kept_bytes += bytes;
        let mut run = Run { deviations, ..run.clone() };
        if let Some(schedule) = &mut run.system.machine.schedule {
            schedule.deviate(taken);
        }
        self.next.push(Aside::Kept(Box::new(run)));
    }

    fn leave(&mut self, left: Left) {
        if !self.searched.left.contains(&left) {
            self.searched.left.push(left);
        }
    }

    /// Notes the first fault.
    fn note(&mut self, run: &Run<O>, fault: Option<Fault>) {
        if let (Some(fault), None) = (fault, &self.searched.finding) {
            let (deviations, time_us) = (run.deviations.clone(), run.system.machine.now_us);
            self.searched.finding = Some(Finding { fault, deviations, time_us });
        }
    }

    /// How the end differs from that of the usual order, where it has to be the same.
    fn difference(&mut self, run: &Run<O>, outcome: Outcome) -> Option<Fault> {
        if !self.bounds.deterministic {
            return None;
        }
        let found = match outcome {
            Outcome::Succeeded(value) => {
                format!("{}{}", run.output, run.system.machine.show(&run.system.program, value))
            }
            Outcome::Failed(_) | Outcome::Evaporated => return None,
        };
        match &self.usual {
            None => {
                self.usual = Some(found);
                None
            }
            Some(usual) if *usual == found => None,
            Some(usual) => Some(Fault::Differs { usual: usual.clone(), found }),
        }
    }
}
