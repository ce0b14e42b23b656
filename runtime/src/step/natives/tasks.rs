//! Tasks and time.

use crate::state::failure::Raise;
use crate::state::fluent::{Fluent, Origin};
use crate::state::machine::SCRATCH_TASK;
use crate::state::slab::NONE;
use crate::state::task::{TaskFluents, Waiting};
use crate::state::value::Value;
use crate::step::native::NativeCode::Plain;
use crate::step::native::{Call, Effect, Native, Reply};

pub(super) const NATIVES: &[Native] = &[
    Native {
        name: "status",
        parameters: "task",
        doc: "A fluent that holds the state of a task, such as `running` or `succeeded`.",
        effect: Effect::None,
        code: Plain(|call| about(call, |fluents| &mut fluents.status)),
    },
    Native {
        name: "result",
        parameters: "task",
        doc: "A fluent that holds the value or the failure of a task once it is dead.",
        effect: Effect::None,
        code: Plain(|call| about(call, |fluents| &mut fluents.result)),
    },
    Native {
        name: "begin-task",
        parameters: "task",
        doc: "A fluent that is true from the moment a task has begun.",
        effect: Effect::None,
        code: Plain(|call| about(call, |fluents| &mut fluents.begin)),
    },
    Native {
        name: "end-task",
        parameters: "task",
        doc: "A fluent that is true from the moment a task is dead.",
        effect: Effect::None,
        code: Plain(|call| about(call, |fluents| &mut fluents.end)),
    },
    Native {
        name: "evaporate",
        parameters: "task",
        doc: "Ends a task and all below it; returns when it is dead, clean-ups included.",
        effect: Effect::Waits,
        code: Plain(evaporate),
    },
    Native {
        name: "suspend",
        parameters: "task",
        doc: "Suspends a task and all below it; suspensions count.",
        effect: Effect::Waits,
        code: Plain(suspend),
    },
    Native {
        name: "resume",
        parameters: "task",
        doc: "Takes one suspension of a task back; a surplus one does nothing.",
        effect: Effect::Waits,
        code: Plain(resume),
    },
    Native {
        name: "this-task",
        parameters: "",
        doc: "The task that evaluates this.",
        effect: Effect::None,
        code: Plain(this_task),
    },
    Native {
        name: "%suspended?",
        parameters: "task",
        doc: "Whether a task lives and is suspended now.",
        effect: Effect::None,
        code: Plain(|call| {
            let task = call.named_task(0)?;
            let tasks = &call.machine.tasks;
            Ok(Reply::Value(Value::truth(tasks.find_alive(task).is_some_and(|task| tasks[task].is_held()))))
        }),
    },
    Native {
        name: "task",
        parameters: "path",
        doc: "The living task with this path, or nil.",
        effect: Effect::None,
        code: Plain(task_at),
    },
    Native {
        name: "task-path",
        parameters: "task",
        doc: "The path of a task as a string.",
        effect: Effect::None,
        code: Plain(task_path),
    },
    Native {
        name: "now",
        parameters: "",
        doc: "Seconds of virtual time since the start.",
        effect: Effect::None,
        code: Plain(|call| Ok(Reply::Value(Value::Float(call.machine.now_s())))),
    },
    Native {
        name: "wait-time",
        parameters: "seconds &optional clock",
        doc: "Blocks for a time; 0 goes to the end of the line of its priority. With `:active` behind it only the time counts in which the task is not suspended.",
        effect: Effect::Waits,
        code: Plain(wait_time),
    },
    Native {
        name: "at-time",
        parameters: "time",
        doc: "Blocks until the clock shows a time; not at all if that is past.",
        effect: Effect::Waits,
        code: Plain(at_time),
    },
];

fn about(call: &mut Call<'_, '_>, which: impl Fn(&mut TaskFluents) -> &mut Option<u32>) -> Result<Reply, Raise> {
    let task = call.named_task(0)?;
    let Some(index) = call.machine.tasks.find(task) else {
        return Err(Raise::type_error("this task ended long ago, and nothing is known of it any more"));
    };
    if let Some(fluent) = which(&mut call.machine.tasks[index].rare().fluents) {
        return Ok(Reply::Value(Value::Fluent(*fluent)));
    }
    let created = call.machine.create_fluent(Fluent::new(None, Value::Nil, Origin::System));
    if let Value::Fluent(fluent) = created {
        *which(&mut call.machine.tasks[index].rare().fluents) = Some(fluent);
    }
    call.machine.update_task_fluents(call.around, index);
    Ok(Reply::Value(created))
}

fn evaporate(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let task = call.named_task(0)?;
    let Some(index) = call.machine.tasks.find_alive(task) else { return Ok(Reply::Value(Value::Nil)) };
    let current = call.machine.current;
    let is_own = call.machine.is_within(current, index);
    call.machine.evaporate(call.around, index);
    if is_own {
        return Ok(Reply::Leave);
    }
    if call.machine.tasks.find_alive(task).is_none() {
        return Ok(Reply::Value(Value::Nil));
    }
    call.machine.check_circle(call.around.program, current, Waiting::Death(index))?;
    call.machine.join_line(current, index, |rare| &mut rare.mourners);
    call.machine.tasks[current].wait(Waiting::Death(index));
    Ok(Reply::Wait)
}

fn suspend(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let task = call.named_task(0)?;
    if let Some(index) = call.machine.tasks.find_alive(task) {
        call.machine.suspend(call.around, index, call.machine.current);
        if call.machine.wait_for_rest(index) {
            return Ok(Reply::Wait);
        }
    }
    Ok(Reply::Value(Value::Nil))
}

fn resume(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let task = call.named_task(0)?;
    if let Some(index) = call.machine.tasks.find_alive(task) {
        call.machine.resume(call.around, index);
    }
    Ok(Reply::Value(Value::Nil))
}

fn this_task(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let current = call.machine.current;
    Ok(Reply::Value(call.machine.expose(current)))
}

fn task_at(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let path = call.name(0)?;
    let found = call
        .machine
        .tasks
        .iter()
        .filter(|(index, task)| *index != SCRATCH_TASK && !task.state().is_dead())
        .map(|(index, _)| index)
        .find(|&index| call.machine.path(index) == path);
    Ok(Reply::Value(match found {
        Some(index) => call.machine.expose(index),
        None => Value::Nil,
    }))
}

fn task_path(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let task = call.named_task(0)?;
    let Some(index) = call.machine.tasks.find(task) else {
        return Err(Raise::type_error("this task ended long ago, and nothing is known of it any more"));
    };
    let path = call.machine.path(index);
    Ok(Reply::Value(call.machine.heap.string(&path)))
}

fn wait_time(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let due_us = call.machine.instant_after(call.argument(0), || call.which(0))?;
    let seconds = call.number(0)?;
    if seconds < 0.0 {
        let (what, found) = (call.which(0), call.machine.described(call.argument(0)));
        return Err(Raise::type_error(format!("{what} must not be negative, and it is {found}")));
    }
    let is_active = counts_active(call)?;
    let current = call.machine.current;
    call.machine.tasks[current].wait(Waiting::Time);
    if seconds == 0.0 {
        call.machine.give_way(Value::Nil);
    } else if is_active {
        call.machine.wait_active(current, due_us);
    } else {
        call.machine.set_wake_timer(current, due_us);
    }
    Ok(Reply::Wait)
}

/// Whether a wait counts only the time worked.
fn counts_active(call: &Call<'_, '_>) -> Result<bool, Raise> {
    match call.arguments.get(1) {
        None => Ok(false),
        Some(&Value::Keyword(clock)) if call.machine.symbols.name(clock) == "active" => Ok(true),
        Some(&other) => {
            let (what, found) = (call.which(1), call.machine.described(other));
            Err(Raise::type_error(format!("{what} can only be `:active`, and it is {found}")))
        }
    }
}

fn at_time(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let due_us = call.machine.instant_at(call.argument(0), || call.which(0))?;
    if due_us <= call.machine.now_us {
        return Ok(Reply::Value(Value::Nil));
    }
    let current = call.machine.current;
    debug_assert_ne!(current, NONE, "natives run in a task");
    call.machine.tasks[current].wait(Waiting::Time);
    call.machine.set_wake_timer(current, due_us);
    Ok(Reply::Wait)
}
