//! What the library makes projections of: the question, and the end of a projected plan.

use crate::state::failure::Raise;
use crate::state::fluent::Origin;
use crate::state::machine::Machine;
use crate::state::projected::{Asked, Grain, MOST_STEPS, Question, Stake};
use crate::state::time::{LAST_INSTANT_US, microseconds};
use crate::state::value::Value;
use crate::step::native::NativeCode::Plain;
use crate::step::native::{Call, Effect, Native, Reply, Surroundings};
use std::collections::BTreeSet;

/// More runs of a plan are refused: they tell no more, and would take hours.
const MOST_RUNS: i64 = 10_000;

pub(super) const NATIVES: &[Native] = &[
    Native {
        name: "%project",
        parameters: "list count seconds value value &optional number number symbol",
        doc: "How plans would go from here: what `project` and its like are made of.",
        effect: Effect::Waits,
        code: Plain(project),
    },
    Native {
        name: "%end-projection",
        parameters: "value",
        doc: "Notes how a projected plan has ended: nil, or its failure.",
        effect: Effect::Acts,
        code: Plain(|call| {
            if let Some(run) = &mut call.machine.projected {
                run.ended.get_or_insert(call.arguments[0]);
            }
            Ok(Reply::Value(Value::Nil))
        }),
    },
    Native {
        name: "%basis",
        parameters: "",
        doc: "What a projection rests on: the values of named fluents but those that change in every step.",
        effect: Effect::None,
        code: Plain(|call| Ok(Reply::Value(call.machine.basis(call.around)))),
    },
    Native {
        name: "projecting?",
        parameters: "",
        doc: "Whether this is only projected, and not done.",
        effect: Effect::None,
        code: Plain(|call| Ok(Reply::Value(Value::truth(call.machine.projected.is_some())))),
    },
];

fn refused(why: impl Into<String>) -> Raise {
    Raise::new("projection-failure", why)
}

fn project(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    if call.machine.projected.is_some() {
        return Err(refused(
            "this is a projected run, and none is projected inside another; ask `(projecting?)` before",
        ));
    }
    if call.machine.cleans_up(call.machine.current) {
        return Err(refused("a clean-up cannot wait for a projection; project before what it cleans up after"));
    }
    let plans = call.list(0)?;
    let runs = call.integer(1)?;
    if !(1..=MOST_RUNS).contains(&runs) {
        return Err(refused(format!("{runs} runs cannot be projected; write `:runs` 1 to {MOST_RUNS}")));
    }
    let horizon_us = microseconds(call.number(2)?).filter(|&horizon_us| horizon_us > 0);
    let horizon_us = horizon_us.filter(|&us| call.machine.now_us.saturating_add(us) <= LAST_INSTANT_US);
    let Some(horizon_us) = horizon_us else {
        let horizon = call.machine.show(call.around.program, call.argument(2));
        return Err(refused(format!(
            "nothing can be projected for {horizon} s; write a time such as `:horizon 20min`"
        )));
    };
    let task = match call.argument(3) {
        Value::Nil => None,
        Value::Task(task) => Some(task),
        _ => return Err(call.wrong_type(3)),
    };
    let grain = grain(call)?;
    let stake = match call.argument(5) {
        Value::Nil => None,
        _ => {
            let worth = match call.argument(7) {
                Value::Symbol(name) => Some(name),
                _ => None,
            };
            Some(Stake { margin: call.number(5)?, standard_errors: call.number(6)?, worth })
        }
    };
    call.machine.make_room_for_forks()?;
    let question = Question { plans, task, runs: runs as u32, horizon_us, grain, stake };
    Ok(Reply::Ask(Asked::Projection(Box::new(question))))
}

/// The grain that was asked for.
fn grain(call: &Call<'_, '_>) -> Result<Grain, Raise> {
    let named = match call.argument(4) {
        Value::Keyword(name) => Grain::ALL.into_iter().find(|grain| grain.name() == call.machine.symbols.name(name)),
        _ => None,
    };
    named.ok_or_else(|| {
        let found = call.machine.show(call.around.program, call.argument(4));
        refused(format!(
            "there is no grain {found}; write `:grain :abstract`, in events, or `:grain :simulated`, step by step"
        ))
    })
}

impl Machine {
    /// Whether a task cleans up, or is a part of what does.
    fn cleans_up(&self, task: u32) -> bool {
        let mut at = task;
        while let Some(record) = self.tasks.get(at) {
            if record.is_protected() {
                return true;
            }
            at = record.parent;
        }
        false
    }

    /// What a projection rests on.
    pub(crate) fn basis(&mut self, around: &Surroundings<'_>) -> Value {
        let specs = around.outside.tables().fluents.iter().enumerate();
        let follow_time: BTreeSet<u32> = specs
            .filter(|(_, spec)| spec.continuous)
            .filter_map(|(number, _)| self.robot_fluent(around.robot, number))
            .collect();
        let is_set = |origin: &Origin| matches!(origin, Origin::Plan | Origin::System);
        let named = self.fluents.iter().filter(|(_, fluent)| fluent.name.is_some() && is_set(&fluent.origin));
        let values: Vec<Value> =
            named.filter(|(index, _)| !follow_time.contains(index)).map(|(_, fluent)| fluent.value).collect();
        self.heap.list(&values)
    }

    /// Notes that a tagged step has begun in a projected run.
    pub(crate) fn note_step_of_projection(&mut self, task: u32) {
        let (path, now_us) = (self.path(task), self.now_us);
        if let Some(run) = &mut self.projected
            && run.begun.len() < MOST_STEPS
        {
            run.begun.push((path, now_us));
        }
    }
}
