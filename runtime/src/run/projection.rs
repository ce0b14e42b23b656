//! Projection: how plans would probably go from here. Each run is a fork of the whole run in which the same
//! interpreter runs the plan, with a robot that is made of what the robot knows; its output and its trace
//! come to nothing, and what it leaves to chance follows from a seed of its own.

use crate::robot::{ForeseenRobot, Grain, Outside};
use crate::run::macro_host::Macros;
use crate::run::projection_record::{Ended, Figures, Projection, RunEnd};
use crate::run::race::Race;
use crate::run::session::Answer;
use crate::run::system::{SLICE_STEPS, System, Turn};
use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::projected::{Answered, ProjectedRun, Question};
use crate::state::slab::NONE;
use crate::state::task::State;
use crate::state::value::{TaskRef, Value};
use crate::step::exec::turn::Ran;
use rpl_lang::compile::NoFiles;
use rpl_random::Stream;
use std::sync::Arc;

/// Steps that a projected run takes in one instant before its task runs away, and in all before it is
/// given up.
const STEPS_IN_AN_INSTANT: u32 = 1_000_000;
const STEPS_OF_A_RUN: u64 = 5_000_000;

/// Instants of a projected run before it is given up.
const INSTANTS_OF_A_RUN: u64 = 1_000_000;

/// Plans are compared by so many runs at first, if one does not tell all; then by twice as many.
const FIRST_RUNS: u32 = 8;

/// A projected run came to need something of which there is no model: one sentence.
struct Unforeseen(String);

impl<O: Outside> System<O> {
    /// Projects plans for the running task, which asked for it, and lets the task go on with the figures.
    pub(crate) fn project(&mut self, question: &Question) -> Ran {
        let answer = self.foresee(question);
        self.with_machine(|machine, around| machine.enter(around, answer.map(Answered::Value), 0))
    }

    /// The figures as a list: what they rest on, the comparisons of the first plan with the others, and each plan's.
    fn foresee(&mut self, question: &Question) -> Result<Value, Raise> {
        let watched = question.task.unwrap_or_else(|| self.machine.tasks.reference(self.machine.current));
        if self.machine.tasks.find_alive(watched).is_none() {
            return Err(Raise::new("projection-failure", "the task is dead: how it goes on is known"));
        }
        let mut seeds = Stream::new(self.machine.foresight.seed(), "runs");
        let mut base = self.forked(question.grain)?;
        let mut entries = Vec::new();
        for &plan in &question.plans {
            let entry = base.entry(plan, question.task.is_some())?;
            entries.push(entry);
        }
        let until_us = self.machine.now_us + question.horizon_us;
        let mut projections: Vec<Projection> =
            entries.iter().map(|_| Projection::new(question.horizon_us, question.grain, &base.machine)).collect();
        // Where nothing is left to chance, the first run tells all.
        let mut race = Race::new(projections.len(), question);
        let mut aim = 1;
        loop {
            while projections.first().is_some_and(|first| (first.runs.len() as u32) < aim) {
                let seed = seeds.seed();
                for &plan in race.runners() {
                    let run = base.projected_run(Some(entries[plan]), watched, seed, until_us);
                    projections[plan].runs.push(run.map_err(|Unforeseen(why)| Raise::new("projection-failure", why))?);
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
        let basis = self.with_machine(|machine, around| machine.basis(around));
        let comparisons: Vec<Value> = race
            .comparisons(&projections)
            .into_iter()
            .map(|comparison| comparison.to_value(&mut self.machine))
            .collect();
        let mut parts = vec![basis, self.machine.heap.list(&comparisons)];
        for projection in &projections {
            let figures = projection.figures(&base.machine.symbols);
            parts.push(figures.to_value(&mut self.machine));
        }
        Ok(self.machine.heap.list(&parts))
    }

    /// How this run would go on from here, between two instants: until its main task ends, and at most for a
    /// time. Asked from outside it takes no time, and the run goes on as if nobody had asked.
    ///
    /// # Errors
    /// The robot cannot be projected, or something is needed for which there is no model: one sentence.
    pub fn project_rest(&self, runs: u32, horizon_us: u64, grain: Grain, seed: u64) -> Result<Figures, String> {
        self.forked(grain).map_err(told)?.projected_to_end(runs, horizon_us, grain, seed)
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
        self.forked_with(robot).projected_to_end(runs, horizon_us, Grain::Abstract, seed)
    }

    /// The same for forms that a session, which waits for some, would run; without a text for those that it
    /// runs now.
    ///
    /// # Errors
    /// As for [`System::project_rest`]; or the text is wrong, and this is what was found.
    pub fn project_form(
        &self,
        text: Option<(&str, &str)>,
        runs: u32,
        horizon_us: u64,
        grain: Grain,
        seed: u64,
    ) -> Result<Figures, String> {
        let mut base = self.forked(grain).map_err(told)?;
        if let Some((name, text)) = text {
            base.submit(name, text, &mut NoFiles).map_err(|rejected| rejected.render(false))?;
        }
        base.projected_to_end(runs, horizon_us, grain, seed)
    }

    /// What projected runs are forked from: this run, silent, with the robot that is foreseen.
    fn forked(&self, grain: Grain) -> Result<System<ForeseenRobot>, Raise> {
        Ok(self.forked_with(self.outside.foresee(self.machine.now_us, self.machine.phases(), grain)?))
    }

    fn forked_with(&self, outside: ForeseenRobot) -> System<ForeseenRobot> {
        let mut machine = self.machine.clone();
        machine.heap.share_vectors();
        machine.trace.enabled = false;
        machine.trace.events = Vec::new();
        machine.output = Vec::new();
        machine.limits.steps = STEPS_IN_AN_INSTANT;
        machine.projected = Some(Box::default());
        System {
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
        }
    }
}

/// Why a robot is not foreseen.
fn told(raise: Raise) -> String {
    match raise {
        Raise::New { message, .. } => message,
        Raise::Again(_) | Raise::NoRoom(_) => "the robot does not say why".to_string(),
    }
}

impl System<ForeseenRobot> {
    /// Projects what runs to the end of the main task, or of the form of a session.
    fn projected_to_end(&mut self, runs: u32, horizon_us: u64, grain: Grain, seed: u64) -> Result<Figures, String> {
        let main = self.machine.tasks.reference(self.machine.main);
        let mut projection = Projection::new(horizon_us, grain, &self.machine);
        let (mut seeds, until_us) = (Stream::new(seed, "runs"), self.machine.now_us + horizon_us);
        for _ in 0..runs {
            let run = self.projected_run(None, main, seeds.seed(), until_us);
            projection.runs.push(run.map_err(|Unforeseen(why)| why)?);
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
    ) -> Result<RunEnd, Unforeseen> {
        let mut run = self.clone();
        run.outside.begin_run(seed);
        run.machine.random = Stream::new(seed, "plan");
        let (begun_us, steps, mut instants) = (run.machine.now_us, run.machine.steps, 0);
        if let Some(entry) = entry {
            let ran = run.with_machine(|machine, around| machine.enter(around, Ok(Answered::Code(entry)), 0));
            run.answer_asked(ran);
        }
        let ended = loop {
            let is_quiet = run.settle_within(steps + STEPS_OF_A_RUN);
            if let Some(why) = run.outside.unforeseen() {
                return Err(Unforeseen(why.to_string()));
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
        match self.tasks.get(task).map(|record| (record.state(), record.value)) {
            Some((State::Succeeded, _)) => Some(Ended::Succeeded),
            Some((State::Failed, failure)) => Some(Ended::Failed(failure)),
            Some((State::Evaporated, _)) | None => Some(Ended::Evaporated),
            Some((State::Created | State::Ready | State::Running | State::Blocked, _)) => None,
        }
    }
}
