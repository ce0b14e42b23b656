//! Valves, where `with-valve` is not enough.

use crate::state::failure::Raise;
use crate::state::task::Waiting;
use crate::state::value::Value;
use crate::step::native::NativeCode::Plain;
use crate::step::native::{Call, Effect, Native, Reply};

pub(super) const NATIVES: &[Native] = &[
    Native {
        name: "request-valve",
        parameters: "valve",
        doc: "Waits for a valve and keeps it until `release-valve`; prefer `with-valve`.",
        effect: Effect::Waits,
        code: Plain(request),
    },
    Native {
        name: "release-valve",
        parameters: "valve",
        doc: "Gives a valve back that this task has requested.",
        effect: Effect::Acts,
        code: Plain(release),
    },
    Native {
        name: "holds-valve?",
        parameters: "valve",
        doc: "Whether this task, or one around it, holds a valve now.",
        effect: Effect::None,
        code: Plain(holds),
    },
];

fn valve(call: &Call<'_, '_>) -> Result<u32, Raise> {
    match call.argument(0) {
        Value::Valve(valve) => Ok(valve),
        _ => Err(call.wrong_type(0)),
    }
}

fn request(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let valve = valve(call)?;
    let current = call.machine.current;
    if call.machine.request_valve(call.around, current, valve)? {
        return Ok(Reply::Value(Value::Nil));
    }
    debug_assert_eq!(call.machine.tasks[current].waiting(), Some(Waiting::Valve(valve)));
    Ok(Reply::Wait)
}

fn release(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let valve = valve(call)?;
    let current = call.machine.current;
    if call.machine.place_taken_by(current, valve).is_none() {
        let name = call.machine.valve_name(valve);
        return Err(Raise::new("valve-error", format!("this task does not hold the valve `{name}`")));
    }
    call.machine.release_valve(call.around, current, valve);
    Ok(Reply::Value(Value::Nil))
}

fn holds(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let valve = valve(call)?;
    Ok(Reply::Value(Value::truth(call.machine.holds_valve(call.machine.current, valve))))
}
