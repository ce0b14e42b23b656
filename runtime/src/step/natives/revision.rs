//! Plans given to tasks that run others.

use crate::state::failure::Raise;
use crate::state::projected::Asked;
use crate::state::value::Value;
use crate::step::native::NativeCode::Plain;
use crate::step::native::{Call, Effect, Native, Reply};
use rpl_lang::kind::Kind;

/// Steps that giving a plan to a task takes.
const STEPS_A_SWAP: usize = 500;

pub(super) const NATIVES: &[Native] = &[
    Native {
        name: "%compile-plan",
        parameters: "datum",
        doc: "A function without parameters that runs a quoted plan.",
        effect: Effect::Calls,
        code: Plain(|call| Ok(Reply::Ask(Asked::Function(call.argument(0))))),
    },
    Native {
        name: "%swap-plan",
        parameters: "task function list",
        doc: "Gives a task the plan of a function to run, and lets it keep valves: t when it has begun it, nil if it could not yet or has ended.",
        effect: Effect::Waits,
        code: Plain(swap_plan),
    },
    Native {
        name: "%finished?",
        parameters: "symbol",
        doc: "Whether the last run of a tag succeeded.",
        effect: Effect::Acts,
        code: Plain(finished),
    },
    Native {
        name: "%trace-decision",
        parameters: "task string plist",
        doc: "Writes to the trace what foresight has decided about a task, with figures.",
        effect: Effect::Acts,
        code: Plain(trace_decision),
    },
];

fn trace_decision(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (task, what) = (call.named_task(0)?, call.text(1)?);
    let mut figures = Vec::new();
    for pair in call.list(2)?.chunks_exact(2) {
        if let Value::Symbol(name) = pair[0] {
            figures.push((name, pair[1]));
        }
    }
    if let Some(task) = call.machine.tasks.find_alive(task) {
        call.machine.trace_decided(call.around.program, task, &what, &figures);
    }
    Ok(Reply::Value(Value::Nil))
}

fn swap_plan(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let task = call.named_task(0)?;
    let Value::Function(code) = call.argument(1) else { return Err(call.wrong_type(1)) };
    let mut kept = Vec::new();
    for valve in call.list(2)? {
        let Value::Valve(valve) = valve else {
            return Err(call.machine.wrong_type("each of `:keep` of `swap-plan`", Kind::Valve.noun(), valve));
        };
        kept.push(valve);
    }
    call.burn(STEPS_A_SWAP);
    call.machine.swap_plan(call.around, task, code, kept)
}

fn finished(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let Value::Symbol(name) = call.argument(0) else { return Err(call.wrong_type(0)) };
    Ok(Reply::Value(Value::truth(call.machine.has_finished(call.machine.current, name))))
}
