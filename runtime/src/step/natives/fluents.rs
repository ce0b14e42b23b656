//! Fluents.

use crate::state::failure::Raise;
use crate::state::fluent::{Fluent, Origin};
use crate::state::value::Value;
use crate::step::native::NativeCode::Plain;
use crate::step::native::{Call, Effect, Native, Reply};

pub(super) const NATIVES: &[Native] = &[
    Native {
        name: "create-fluent",
        parameters: "initial",
        doc: "A new fluent that holds this value.",
        effect: Effect::None,
        code: Plain(create_fluent),
    },
    Native {
        name: "value",
        parameters: "fluent",
        doc: "The value of a fluent now; assign it with `(setf (value fluent) v)`.",
        effect: Effect::None,
        code: Plain(value),
    },
    Native {
        name: "%set-value",
        parameters: "fluent value",
        doc: "Assigns a fluent.",
        effect: Effect::Acts,
        code: Plain(set_value),
    },
    Native {
        name: "%setf-together",
        parameters: "&rest arguments",
        doc: "Assigns fluents as one: each argument but every second one is a fluent, the one behind it its value.",
        effect: Effect::Acts,
        code: Plain(set_together),
    },
    Native {
        name: "%named-fluent",
        parameters: "name initial",
        doc: "A new fluent that holds this value and is told by a name in traces and messages.",
        effect: Effect::None,
        code: Plain(named_fluent),
    },
    Native {
        name: "%look",
        parameters: "function",
        doc: "What a function without parameters gives if it does no more than a network may.",
        effect: Effect::None,
        code: Plain(look),
    },
    Native {
        name: "pulse",
        parameters: "fluent",
        doc: "Makes a fluent true for one propagation without changing its value.",
        effect: Effect::Acts,
        code: Plain(pulse),
    },
    Native {
        name: "pulsed",
        parameters: "fluent",
        doc: "A fluent that is true in the propagation of a pulse.",
        effect: Effect::None,
        code: Plain(|call| derived(call, Origin::Pulsed)),
    },
    Native {
        name: "changed",
        parameters: "fluent",
        doc: "A fluent that is true in the propagation of a change.",
        effect: Effect::None,
        code: Plain(|call| derived(call, Origin::Changed)),
    },
    Native {
        name: "count-pulses",
        parameters: "fluent",
        doc: "A fluent that counts the pulses of another from now on.",
        effect: Effect::None,
        code: Plain(|call| derived(call, Origin::Count)),
    },
    Native {
        name: "%pulsed-now",
        parameters: "fluent",
        doc: "Whether the propagation under way is a pulse of this fluent.",
        effect: Effect::None,
        code: Plain(|call| event_now(call, |fluent| fluent.is_pulsed)),
    },
    Native {
        name: "%changed-now",
        parameters: "fluent",
        doc: "Whether the propagation under way changed this fluent.",
        effect: Effect::None,
        code: Plain(|call| event_now(call, |fluent| fluent.is_changed)),
    },
];

fn create_fluent(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let initial = call.argument(0);
    Ok(Reply::Value(call.machine.create_fluent(Fluent::new(None, initial, Origin::Plan))))
}

fn value(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let fluent = call.fluent(0)?;
    Ok(Reply::Value(call.machine.read_fluent(fluent)?))
}

fn set_value(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (fluent, value) = (call.argument(0), call.argument(1));
    call.machine.assign_fluent(call.around, fluent, value)?;
    Ok(Reply::Value(value))
}

fn set_together(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let mut values: Vec<(u32, Value)> = Vec::new();
    for pair in call.arguments.chunks(2) {
        if let &[fluent, value] = pair {
            let fluent = call.machine.assignable(fluent)?;
            match values.iter_mut().find(|(known, _)| *known == fluent) {
                Some((_, known)) => *known = value,
                None => values.push((fluent, value)),
            }
        }
    }
    call.machine.assign_all(call.around, &values);
    Ok(Reply::Value(call.arguments.last().copied().unwrap_or_default()))
}

fn named_fluent(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let name = call.name(0)?;
    let name = call.machine.symbols.intern(&name);
    let initial = call.argument(1);
    Ok(Reply::Value(call.machine.create_fluent(Fluent::new(Some(name), initial, Origin::Plan))))
}

fn look(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (code, captured) = match call.argument(0) {
        Value::Function(code) => (code, Vec::new()),
        Value::Closure(closure) => {
            let closure = &call.machine.heap.closures[closure];
            (closure.code, closure.captured.to_vec())
        }
        _ => return Err(call.wrong_type(0)),
    };
    let seen = call.machine.evaluate_code(call.around, code, &captured);
    Ok(Reply::Value(seen.map_err(Raise::Again)?))
}

fn pulse(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let fluent = call.fluent(0)?;
    call.machine.pulse_fluent(call.around, fluent)?;
    Ok(Reply::Value(Value::Nil))
}

fn derived(call: &mut Call<'_, '_>, origin: Origin) -> Result<Reply, Raise> {
    let fluent = call.fluent(0)?;
    Ok(Reply::Value(call.machine.derived_fluent(fluent, origin)))
}

fn event_now(call: &mut Call<'_, '_>, is_event: fn(&Fluent) -> bool) -> Result<Reply, Raise> {
    let fluent = call.fluent(0)?;
    call.machine.read_fluent(fluent)?;
    call.machine.scratch.reads_event = true;
    Ok(Reply::Value(Value::truth(is_event(&call.machine.fluents[fluent]))))
}
