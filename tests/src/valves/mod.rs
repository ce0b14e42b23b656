//! Programs of a few tasks that share valves: all of them, in the runtime and in a small model of the
//! rules, with everything that can happen to each task at each step.

pub mod model;
pub mod program;

use crate::{detail, library};
use model::{Blow, Id, Model, Told, What};
use program::Program;
use rpl_lang::compile::NoFiles;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::disturbance::Disturbance;
use rpl_runtime::run::system::System;
use rpl_runtime::state::trace::{Event, EventKind};
use rpl_runtime::state::value::TaskRef;

/// A run has more steps than any of the programs needs.
const MOST_STEPS: usize = 1_000;

/// How many programs and runs were compared.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Programs.
    pub programs: u64,
    /// Runs.
    pub runs: u64,
}

/// Steps after which a suspended task is resumed.
const RESUMED_AFTER: [usize; 3] = [1, 4, 9];

/// The same run in both.
#[derive(Clone)]
struct Both<'p> {
    system: System<NoRobot>,
    model: Model<'p>,
    /// Paths of the tasks, in the order of beginning, and what the system told.
    paths: Vec<String>,
    told: Vec<Told>,
    steps: usize,
}

fn what(event: &Event) -> Option<What> {
    let valve = if detail(event, "valve") == "v0" { 0 } else { 1 };
    match (event.kind, detail(event, "what"), detail(event, "state")) {
        (EventKind::Valve, "granted", _) => Some(What::Granted(valve)),
        (EventKind::Valve, "released", _) => Some(What::Released(valve)),
        (EventKind::Valve, "pre-empted", _) => Some(What::Taken(valve)),
        (EventKind::Valve, "returned", _) => Some(What::Returned(valve)),
        (EventKind::Suspended, ..) => Some(What::Suspended),
        (EventKind::Resumed, ..) => Some(What::Resumed),
        (EventKind::End, _, "succeeded") => Some(What::Succeeded),
        (EventKind::End, _, "failed") => Some(What::Failed),
        (EventKind::End, _, "evaporated") => Some(What::Evaporated),
        _ => None,
    }
}

impl Both<'_> {
    fn take_events(&mut self) {
        for event in self.system.machine.trace.take() {
            if event.kind == EventKind::Begin {
                self.paths.push(event.path);
                continue;
            }
            let task = self.paths.iter().position(|path| *path == event.path);
            if let (Some(task), Some(what)) = (task, what(&event)) {
                self.told.push((event.time_us / 1_000_000, task, what));
            }
        }
    }

    /// One step of both; tells whether there was anything to do.
    fn step(&mut self) -> Result<bool, String> {
        self.steps += 1;
        let mut has_gone_on = self.system.outcome().is_none();
        if has_gone_on && !self.system.step_task() {
            has_gone_on = self.system.next_instant_us().is_some();
            if has_gone_on {
                self.system.next_instant();
            }
        }
        self.take_events();
        let expected = self.model.lives(0) && self.model.step();
        let is_equal = has_gone_on == expected;
        if is_equal { Ok(has_gone_on) } else { Err(format!("goes on: {has_gone_on}, in the model: {expected}")) }
    }

    /// The task with a path, as the system knows it.
    fn task(&self, task: Id) -> Option<TaskRef> {
        let machine = &self.system.machine;
        let path = self.paths.get(task)?;
        let found = machine.living_tasks().into_iter().find(|&index| machine.path(index) == *path)?;
        Some(machine.tasks.reference(found))
    }

    fn strike(&mut self, blow: Blow) {
        let (Blow::Evaporate(task) | Blow::Suspend(task) | Blow::Resume(task) | Blow::Fail(task)) = blow;
        if let Some(reference) = self.task(task) {
            self.system.disturb(match blow {
                Blow::Evaporate(_) => Disturbance::Evaporate(reference),
                Blow::Suspend(_) => Disturbance::Suspend(reference),
                Blow::Resume(_) => Disturbance::Resume(reference),
                Blow::Fail(_) => Disturbance::Fail(reference),
            });
        }
        self.take_events();
        self.model.strike(blow);
    }

    /// Runs on to the end and compares what was told: of each task, and of each valve.
    fn finish(mut self, later: Option<(usize, Blow)>) -> Result<(), String> {
        let mut left = MOST_STEPS;
        let outcome = loop {
            if let Some((_, blow)) = later.filter(|&(step, _)| step == self.steps) {
                self.strike(blow);
            }
            match self.step() {
                Ok(true) if left > 0 => left -= 1,
                Ok(_) => break self.compare(),
                Err(what) => break self.compare().and(Err(what)),
            }
        };
        outcome?;
        self.system.machine.check_invariants()
    }

    fn compare(&self) -> Result<(), String> {
        for task in 0..self.paths.len().max(self.model.tasks()) {
            let is_meant = |told: &&Told| told.1 == task;
            self.same(|told| told.iter().filter(is_meant).copied().collect())?;
        }
        for valve in 0..2 {
            let is_meant = |told: &&Told| {
                [What::Granted(valve), What::Released(valve), What::Taken(valve), What::Returned(valve)]
                    .contains(&told.2)
            };
            self.same(|told| told.iter().filter(is_meant).copied().collect())?;
        }
        Ok(())
    }

    fn same(&self, part: impl Fn(&[Told]) -> Vec<Told>) -> Result<(), String> {
        let (told, expected) = (part(&self.told), part(&self.model.told));
        if told == expected {
            return Ok(());
        }
        let at = told.iter().zip(&expected).take_while(|(told, expected)| told == expected).count();
        let show = |told: &[Told]| match told.get(at) {
            Some((time, task, what)) => {
                format!("{time} {} {what:?}", self.paths.get(*task).map_or("?", String::as_str))
            }
            None => "nothing".to_string(),
        };
        Err(format!("`{}`, and the model says `{}`", show(&told), show(&expected)))
    }
}

/// Compares a program as it is and, if wanted, with each blow at each step.
///
/// # Errors
/// The first difference, with the blow.
pub fn judge(program: &Program, with_blows: bool, tally: &mut Tally) -> Result<(), String> {
    let text = program.text();
    let loaded = library()
        .load("valves.rpl", &text, &mut NoFiles)
        .map_err(|rejected| format!("{text}\n{}", rejected.render(false)))?;
    let system = System::traced(library().clone(), loaded, NoRobot, 1);
    let mut both = Both { system, model: Model::new(program), paths: Vec::new(), told: Vec::new(), steps: 0 };
    both.take_events();
    tally.programs += 1;
    tally.runs += 1;
    both.clone().finish(None).map_err(|what| format!("{text}\n{what}"))?;
    if !with_blows {
        return Ok(());
    }
    loop {
        strike_each(&both, &text, tally)?;
        if !both.step()? {
            return Ok(());
        }
    }
}

/// Lets everything happen to each living task, in a run of its own.
fn strike_each(both: &Both<'_>, text: &str, tally: &mut Tally) -> Result<(), String> {
    for task in (1..both.model.tasks()).filter(|&task| both.model.lives(task)) {
        let suspended =
            RESUMED_AFTER.map(|after| (Blow::Suspend(task), Some((both.steps + after, Blow::Resume(task)))));
        let others = [(Blow::Evaporate(task), None), (Blow::Fail(task), None)];
        for (blow, later) in others.into_iter().chain(suspended) {
            let mut struck = both.clone();
            struck.strike(blow);
            tally.runs += 1;
            let (path, steps) = (&both.paths[task], both.steps);
            struck
                .finish(later)
                .map_err(|what| format!("{text}\n{blow:?} ({path}) at step {steps}, then {later:?}: {what}"))?;
        }
    }
    Ok(())
}
