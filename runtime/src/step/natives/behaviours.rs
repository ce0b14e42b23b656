//! Behaviours of the robot.

use crate::state::failure::Raise;
use crate::state::value::Value;
use crate::step::native::NativeCode::Plain;
use crate::step::native::{Call, Effect, Native, Reply};

pub(super) const NATIVES: &[Native] = &[
    Native {
        name: "activate",
        parameters: "behaviour &rest arguments",
        doc: "Starts a behaviour with keyword arguments; one that drives needs its valve.",
        effect: Effect::Acts,
        code: Plain(activate),
    },
    Native {
        name: "deactivate",
        parameters: "behaviour",
        doc: "Stops a behaviour that this task or one below it has activated.",
        effect: Effect::Acts,
        code: Plain(deactivate),
    },
    Native {
        name: "await-signal",
        parameters: "behaviour",
        doc: "Waits for the signal of a behaviour: the value it succeeds with, `t` where it says none, or its failure.",
        effect: Effect::Waits,
        code: Plain(await_signal),
    },
];

fn activate(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let behaviour = call.behaviour(0)?;
    let mut arguments = Vec::new();
    for pair in call.arguments[1..].chunks(2) {
        match *pair {
            [Value::Keyword(key), value] => arguments.push((key, value)),
            [found, ..] => {
                return Err(call.machine.wrong_type("an argument of a behaviour", "a keyword with a value", found));
            }
            [] => {}
        }
    }
    call.machine.activate(call.around, behaviour, &arguments)?;
    Ok(Reply::Value(Value::Nil))
}

fn deactivate(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let behaviour = call.behaviour(0)?;
    call.machine.deactivate(call.around, behaviour);
    Ok(Reply::Value(Value::Nil))
}

fn await_signal(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let behaviour = call.behaviour(0)?;
    Ok(call.machine.await_signal(behaviour)?.map_or(Reply::Wait, Reply::Value))
}
