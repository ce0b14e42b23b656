//! Projection: how plans would probably go from here. Each run is a fork of the whole run in which the same
//! interpreter runs the plan, with a robot that is made of what the robot knows; its output and its trace
//! come to nothing, and what it leaves to chance follows from a seed of its own.
//!
//! The projected robot is stepped by events (`Outside::next_event_us`); `Outside::foresee` makes it. Code that one fork
//! has compiled is found by the next.

use crate::robot::thinking::{Insight, Thought, Ticket};
use crate::robot::{ForeseenRobot, Outside};
use crate::run::macro_host::Macros;
use crate::run::projection_record::{Ended, Projection, RunEnd};
use crate::run::race::Race;
use crate::run::session::Answer;
use crate::run::system::{SLICE_STEPS, System, Turn};
use crate::state::failure::{CLASSES, Raise};
use crate::state::figures::{Figures, Foresight};
use crate::state::limits::Spent;
use crate::state::machine::Machine;
use crate::state::projected::{Answered, Grain, ProjectedRun, Question};
use crate::state::slab::NONE;
use crate::state::task::{State, Waiting, Wake};
use crate::state::value::{TaskRef, Value};
use crate::step::exec::turn::Ran;
use rpl_lang::compile::NoFiles;
use rpl_random::Stream;
use std::fmt;
use std::sync::Arc;

/// The class of failures of projecting.
const FAILURE: &str = "projection-failure";

/// Steps that a projected run takes in one instant before its task runs away, and in all before it is
/// given up.
const STEPS_IN_AN_INSTANT: u32 = 1_000_000;
const STEPS_OF_A_RUN: u64 = 5_000_000;

/// Instants of a projected run before it is given up.
const INSTANTS_OF_A_RUN: u64 = 1_000_000;

/// The runs by which plans are compared at first, if one does not tell all; then twice as many.
const FIRST_RUNS: u32 = 8;

/// Why there is no answer.
enum NoAnswer {
    /// A plan is none, or a projected run came to need something of which there is no model.
    Failed(Raise),
    /// It is not wanted any more.
    GivenUp,
}

impl NoAnswer {
    fn told(self) -> String {
        match self {
            NoAnswer::Failed(raise) => told(raise),
            NoAnswer::GivenUp => "it was given up".to_string(),
        }
    }
}

/// Who wants an answer, however long it takes.
const WANTED: &dyn Fn() -> bool = &|| false;

/// A question, with the run as it was when it was asked.
struct Asking {
    base: System<ForeseenRobot>,
    question: Question,
    /// The task whose end counts.
    watched: TaskRef,
    /// Of the seeds of the runs.
    seed: u64,
}

impl fmt::Debug for Asking {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Asking").field("question", &self.question).field("seed", &self.seed).finish_non_exhaustive()
    }
}

impl Thought for Asking {
    fn checksum(&self) -> u32 {
        let System { machine, program, .. } = &self.base;
        let Question { plans, task, runs, horizon_us, grain, stake } = &self.question;
        let plans: Vec<String> = plans.iter().map(|&plan| machine.write(program, plan)).collect();
        let worth = stake.and_then(|stake| stake.worth).map(|worth| machine.symbols.name(worth));
        let stake = stake.map(|stake| (stake.margin.to_bits(), stake.standard_errors.to_bits()));
        crc32fast::hash(
            format!("{plans:?} {task:?} {runs} {horizon_us} {grain:?} {stake:?} {worth:?} {}", self.seed).as_bytes(),
        )
    }

    fn think(&self, is_given_up: &dyn Fn() -> bool) -> Option<Insight> {
        match self.base.clone().foresee(self, is_given_up) {
            Ok(foresight) => Some(Insight::Found(foresight)),
            Err(NoAnswer::GivenUp) => None,
            Err(NoAnswer::Failed(raise)) => Some(failed(raise)),
        }
    }
}

/// A fork of a session for projecting it, on whatever thread.
pub struct ProjectableRun {
    base: System<ForeseenRobot>,
    grain: Grain,
}

impl ProjectableRun {
    /// How the forms would go; none if it was given up, which is asked every few milliseconds.
    ///
    /// # Errors
    /// Something is needed for which there is no model: one sentence.
    pub fn figures(
        mut self,
        runs: u32,
        horizon_us: u64,
        seed: u64,
        is_given_up: &dyn Fn() -> bool,
    ) -> Option<Result<Figures, String>> {
        match self.base.projected_to_end(runs, horizon_us, self.grain, seed, is_given_up) {
            Err(NoAnswer::GivenUp) => None,
            figures => Some(figures.map_err(NoAnswer::told)),
        }
    }
}

impl<O: Outside> System<O> {
    /// Projects plans for the running task, which asked for it: at once, and the task goes on with the figures, or
    /// beside the run, and it waits for them.
    pub(crate) fn project(&mut self, question: Question) -> Ran {
        let ticket = self.machine.next_ticket();
        let asked = self.asking(question).and_then(|asking| self.outside.think(ticket, Arc::new(asking)));
        let answer = match asked {
            Ok(None) => return self.with_machine(Machine::await_answer),
            Ok(Some(thought)) => thought.think(WANTED),
            Err(raise) => Some(failed(raise)),
        };
        let answer = answer.map_or(Ok(Value::Nil), |insight| self.machine.value_of(insight, None));
        self.with_machine(|machine, around| machine.enter(around, answer.map(Answered::Value), 0))
    }

    /// The question, with a fork of the run.
    fn asking(&mut self, question: Question) -> Result<Asking, Raise> {
        let watched = question.task.unwrap_or_else(|| self.machine.tasks.reference(self.machine.current));
        if self.machine.tasks.find_alive(watched).is_none() {
            return Err(Raise::new(FAILURE, "the task is dead: how it goes on is known"));
        }
        let seed = self.machine.foresight.seed();
        Ok(Asking { base: self.forked(question.grain)?, question, watched, seed })
    }

    /// How this run would go on from here, between two instants: until its main task ends, and at most for a
    /// time. Asked from outside it takes no time, and the run goes on as if nobody had asked.
    ///
    /// # Errors
    /// The robot cannot be projected, or something is needed for which there is no model: one sentence.
    pub fn project_rest(&self, runs: u32, horizon_us: u64, grain: Grain, seed: u64) -> Result<Figures, String> {
        self.forked(grain).map_err(told)?.wanted_to_end(runs, horizon_us, grain, seed)
    }

    /// The same with another robot in the projections, which is abstract: for somebody who believes something else.
    ///
    /// # Errors
    /// Something is needed for which there is no model: one sentence.
    pub fn project_rest_with(
        &self,
        robot: ForeseenRobot,
        runs: u32,
        horizon_us: u64,
        seed: u64,
    ) -> Result<Figures, String> {
        self.forked_with(robot).map_err(told)?.wanted_to_end(runs, horizon_us, Grain::Abstract, seed)
    }

    /// A fork for projecting forms that a session, which waits for some, would run; without a text those that it
    /// runs now.
    ///
    /// # Errors
    /// The robot cannot be projected; or the text is wrong, and this is what was found.
    pub fn fork_to_project(&self, text: Option<(&str, &str)>, grain: Grain) -> Result<ProjectableRun, String> {
        let mut base = self.forked(grain).map_err(told)?;
        if let Some((name, text)) = text {
            base.submit(name, text, &mut NoFiles).map_err(|rejected| rejected.render(false))?;
        }
        Ok(ProjectableRun { base, grain })
    }

    /// What projected runs are forked from: this run, silent, with the robot that is foreseen.
    fn forked(&self, grain: Grain) -> Result<System<ForeseenRobot>, Raise> {
        self.forked_with(self.outside.foresee(self.machine.now_us, self.machine.phases(), grain)?)
    }

    /// # Errors
    /// There is no room for copies of the run.
    fn forked_with(&self, outside: ForeseenRobot) -> Result<System<ForeseenRobot>, Raise> {
        let limit_bytes = self.machine.limit_of_fork().ok_or_else(|| self.machine.out_of_memory())?;
        let mut machine = self.machine.clone();
        machine.heap.share_vectors();
        machine.trace.enabled = false;
        machine.trace.events = Vec::new();
        machine.output = Vec::new();
        machine.limits.steps = STEPS_IN_AN_INSTANT;
        machine.spent = Spent::default();
        machine.limits.bytes = limit_bytes;
        machine.schedule = None;
        machine.projected = Some(Box::default());
        Ok(System {
            program: self.program.clone(),
            units: self.units.clone(),
            machine,
            outside,
            library: self.library.clone(),
            base: self.base.clone(),
            stepped_us: self.stepped_us,
            slice_steps: SLICE_STEPS,
            slice_left: SLICE_STEPS,
            macros: Macros::default(),
        })
    }
}

/// Why a robot is not foreseen.
fn told(raise: Raise) -> String {
    match raise {
        Raise::New { message, .. } => message,
        Raise::Again(_) | Raise::NoRoom(_) => "the robot does not say why".to_string(),
    }
}

/// An answer that says why there is none.
fn failed(raise: Raise) -> Insight {
    let (class, message) = match raise {
        Raise::New { class, message, .. } => (class, message),
        Raise::Again(_) | Raise::NoRoom(_) => (FAILURE, "the plan cannot be compiled".to_string()),
    };
    Insight::Failed { class: class.to_string(), message }
}

impl System<ForeseenRobot> {
    /// Projects the plans of a question; this run is the one in which it was asked.
    fn foresee(&mut self, asking: &Asking, is_given_up: &dyn Fn() -> bool) -> Result<Foresight, NoAnswer> {
        let Asking { question, watched, seed, .. } = asking;
        let mut seeds = Stream::new(*seed, "runs");
        let mut entries = Vec::new();
        for &plan in &question.plans {
            entries.push(self.entry(plan, question.task.is_some()).map_err(NoAnswer::Failed)?);
        }
        let until_us = self.machine.now_us + question.horizon_us;
        let mut projections: Vec<Projection> =
            entries.iter().map(|_| Projection::new(question.horizon_us, question.grain, &self.machine)).collect();
        // Where nothing is left to chance, the first run tells all.
        let mut race = Race::new(projections.len(), question);
        let mut aim = 1;
        loop {
            while projections.first().is_some_and(|first| (first.runs.len() as u32) < aim) {
                let seed = seeds.seed();
                for &plan in race.runners() {
                    let run = self.projected_run(Some(entries[plan]), *watched, seed, until_us, is_given_up)?;
                    projections[plan].runs.push(run);
                }
            }
            let is_certain = aim == 1 && projections.iter().all(Projection::is_certain);
            if is_certain {
                let runs = if question.stake.is_some() { FIRST_RUNS.min(question.runs) } else { question.runs };
                projections.iter_mut().for_each(|projection| projection.repeat(runs));
            }
            let is_last = is_certain || aim >= question.runs;
            if race.look(&projections, is_last) {
                break;
            }
            aim = match question.stake {
                Some(_) => aim.saturating_mul(2).max(FIRST_RUNS).min(question.runs),
                None => question.runs,
            };
        }
        let plans = projections.iter().map(|projection| projection.figures(&self.machine.symbols)).collect();
        Ok(Foresight { comparisons: race.comparisons(&projections), plans })
    }

    /// Projects what runs to the end of the main task.
    fn wanted_to_end(&mut self, runs: u32, horizon_us: u64, grain: Grain, seed: u64) -> Result<Figures, String> {
        self.projected_to_end(runs, horizon_us, grain, seed, WANTED).map_err(NoAnswer::told)
    }

    /// Projects what runs to the end of the main task, or of the form of a session.
    fn projected_to_end(
        &mut self,
        runs: u32,
        horizon_us: u64,
        grain: Grain,
        seed: u64,
        is_given_up: &dyn Fn() -> bool,
    ) -> Result<Figures, NoAnswer> {
        let main = self.machine.tasks.reference(self.machine.main);
        let mut projection = Projection::new(horizon_us, grain, &self.machine);
        let (mut seeds, until_us) = (Stream::new(seed, "runs"), self.machine.now_us + horizon_us);
        for _ in 0..runs {
            projection.runs.push(self.projected_run(None, main, seeds.seed(), until_us, is_given_up)?);
        }
        Ok(projection.figures(&self.machine.symbols))
    }

    /// The code of a plan whose end is noted: its own, or nobody's if another task's end counts.
    fn entry(&mut self, plan: Value, is_beside: bool) -> Result<u32, Raise> {
        let datum = self.machine.noted_plan(plan, is_beside);
        self.machine.keep_asked(datum);
        self.compile_datum(datum).0
    }

    /// One run of a plan: forked, entered, and gone on with until it has ended or the horizon is reached.
    fn projected_run(
        &mut self,
        entry: Option<u32>,
        watched: TaskRef,
        seed: u64,
        horizon_us: u64,
        is_given_up: &dyn Fn() -> bool,
    ) -> Result<RunEnd, NoAnswer> {
        let mut run = self.clone();
        run.outside.begin_run(seed);
        run.machine.random = Stream::new(seed, "plan");
        let (begun_us, steps, mut instants) = (run.machine.now_us, run.machine.steps, 0);
        if let Some(entry) = entry {
            let ran = run.with_machine(|machine, around| machine.enter(around, Ok(Answered::Code(entry)), 0));
            run.answer_asked(ran);
        }
        let ended = loop {
            if is_given_up() {
                return Err(NoAnswer::GivenUp);
            }
            let is_quiet = run.settle_within(steps + STEPS_OF_A_RUN);
            if let Some(why) = run.outside.unforeseen() {
                return Err(NoAnswer::Failed(Raise::new(FAILURE, why)));
            }
            if let Some(ended) = run.machine.end_of(watched).or_else(|| run.end_of_form()) {
                break ended;
            }
            instants += 1;
            if !is_quiet || instants > INSTANTS_OF_A_RUN {
                break Ended::GivenUp;
            }
            match run.next_instant_us() {
                Some(next_us) if next_us > horizon_us => break Ended::Open,
                Some(_) => run.next_instant(),
                // Without a robot nothing can come any more, and the main task fails.
                None if run.outcome().is_some() => break Ended::Open,
                None => run.next_instant(),
            }
        };
        let is_certain = run.machine.random == Stream::new(seed, "plan") && !run.outside.has_drawn();
        let end = RunEnd::new(&run.machine, &run.program, ended, seed, begun_us, instants, is_certain);
        self.learn_code(run);
        Ok(end)
    }

    /// How the form of a session has ended, once it has.
    fn end_of_form(&self) -> Option<Ended> {
        Some(match self.answer()? {
            Answer::Succeeded(_) => Ended::Succeeded,
            Answer::Failed(failure) => Ended::Failed(failure),
            Answer::GivenUp => Ended::Evaporated,
        })
    }

    /// Runs ready tasks until all are blocked, unless the run has taken too many steps: then false. What
    /// is printed meanwhile is dropped.
    fn settle_within(&mut self, most_steps: u64) -> bool {
        while self.step_slice() != Turn::Idle {
            self.machine.output.clear();
            if self.machine.steps > most_steps {
                return false;
            }
        }
        self.machine.output.clear();
        true
    }

    /// Takes over the code that a run has made, so that the next one finds it compiled: what it makes is the
    /// same in most runs.
    fn learn_code(&mut self, run: Self) {
        let is_new = !Arc::ptr_eq(&self.program, &run.program);
        // Where places in the program were used anew, tasks of the next run may still be in the old code.
        if !is_new || self.program.globals.len() != run.program.globals.len() || !run.units.extend(&self.units) {
            return;
        }
        let known = self.program.constants.len();
        let renewed: Vec<u32> = (0..known as u32)
            .filter(|&at| self.program.constants[at as usize] != run.program.constants[at as usize])
            .collect();
        let System { program, units, machine, .. } = run;
        self.machine.symbols = machine.symbols;
        (self.program, self.units) = (program, units);
        self.machine.renew_constants(&self.program, &renewed, &[]);
        self.machine.bring_up_to(&self.program, &[]);
    }
}

impl Machine {
    /// What the running task waits with if it waits now.
    fn next_ticket(&self) -> Ticket {
        let task = self.tasks.reference(self.current);
        Ticket { task, wait: self.waits.wrapping_add(1), asked_us: self.now_us }
    }

    /// Whether a task still waits for this answer.
    pub(crate) fn awaits(&self, ticket: Ticket) -> bool {
        self.tasks.find_alive(ticket.task).is_some_and(|task| {
            let record = &self.tasks[task];
            record.waiting() == Some(Waiting::Answer) && record.wait_number == ticket.wait
        })
    }

    /// Lets those go on whose questions are answered, if they still wait: with the answer, or to ask again where there
    /// is none.
    pub(crate) fn take_answers(&mut self, answers: Vec<(Ticket, Option<Insight>)>) {
        for (ticket, insight) in answers {
            if !self.awaits(ticket) {
                continue;
            }
            let task = ticket.task.index;
            let passed_s = (self.now_us - ticket.asked_us) as f64 / 1e6;
            let wake = match insight.map(|insight| self.value_of(insight, Some(passed_s))) {
                None => Wake::Value(Value::Nil),
                Some(Ok(value)) => Wake::Value(value),
                Some(Err(raise)) => Wake::Raise(self.failure_of(task, raise)),
            };
            self.wake(task, wake);
        }
    }

    /// An answer as plans have it, or the failure that it is.
    fn value_of(&mut self, insight: Insight, passed_s: Option<f64>) -> Result<Value, Raise> {
        match insight {
            Insight::Found(foresight) => Ok(foresight.to_value(self, passed_s)),
            Insight::Failed { class, message } => {
                let known = CLASSES.iter().find(|(name, ..)| *name == class);
                Err(Raise::new(known.map_or(FAILURE, |&(name, ..)| name), message))
            }
        }
    }

    /// A plan whose end is noted, and which goes no further than that.
    fn noted_plan(&mut self, plan: Value, is_beside: bool) -> Value {
        let [progn, handling, failure, variable, end, wait, create] =
            ["progn", "with-failure-handling", "failure", "%failure", "%end-projection", "wait-for", "create-fluent"]
                .map(|name| Value::Symbol(self.symbols.intern(name)));
        let heap = &mut self.heap;
        let fluent = heap.list(&[create, Value::Nil]);
        let stand_still = heap.list(&[wait, fluent]);
        if is_beside {
            return heap.list(&[progn, plan, stand_still]);
        }
        let bound = heap.list(&[variable]);
        let handler = heap.list(&[failure, bound, variable]);
        let handlers = heap.list(&[handler]);
        let handled = heap.list(&[handling, handlers, plan, Value::Nil]);
        let noted = heap.list(&[end, handled]);
        heap.list(&[progn, noted, stand_still])
    }

    /// Keeps a value alive where the answer to the running task will stand.
    fn keep_asked(&mut self, value: Value) {
        if let Some((place, register)) = self.scratch.asked {
            self.scratch.stack[place.frame.base as usize + usize::from(register)] = value;
        }
    }

    /// How a projected run has ended, if it has: by the plan, or by the death of the task.
    fn end_of(&self, watched: TaskRef) -> Option<Ended> {
        let noted = self.projected.as_deref().and_then(|run: &ProjectedRun| run.ended);
        if let Some(noted) = noted {
            return Some(if noted == Value::Nil { Ended::Succeeded } else { Ended::Failed(noted) });
        }
        let task = self.tasks.find(watched).unwrap_or(NONE);
        match self.tasks.get(task).map(|record| (record.state(), *record.value())) {
            Some((State::Succeeded, _)) => Some(Ended::Succeeded),
            Some((State::Failed, failure)) => Some(Ended::Failed(failure)),
            Some((State::Evaporated, _)) | None => Some(Ended::Evaporated),
            Some((State::Created | State::Ready | State::Running | State::Blocked, _)) => None,
        }
    }
}
