//! Failures.

use crate::state::failure::Raise;
use crate::state::value::Value;
use crate::step::construct::outcome::all_failed;
use crate::step::native::NativeCode::Plain;
use crate::step::native::{Call, Effect, Native, Reply};

pub(super) const NATIVES: &[Native] = &[
    Native {
        name: "%fail",
        parameters: "class message &rest slots",
        doc: "Fails with a class, a message and slots; the form `fail` is made of it.",
        effect: Effect::None,
        code: Plain(fail),
    },
    Native {
        name: "fail-composite",
        parameters: "parts &optional message",
        doc: "Fails with a `composite-failure` that holds these failures; a message says more than how many ways there were.",
        effect: Effect::None,
        code: Plain(fail_composite),
    },
    Native {
        name: "failure-class",
        parameters: "failure",
        doc: "The class of a failure, a symbol.",
        effect: Effect::None,
        code: Plain(|call| {
            let failure = failure(call)?;
            Ok(Reply::Value(Value::Symbol(call.machine.heap.failures[failure].class)))
        }),
    },
    Native {
        name: "failure-message",
        parameters: "failure",
        doc: "The message of a failure, a string.",
        effect: Effect::None,
        code: Plain(|call| {
            let failure = failure(call)?;
            let message = call.machine.heap.failures[failure].message.clone();
            Ok(Reply::Value(call.machine.heap.string(&message)))
        }),
    },
    Native {
        name: "failure-slot",
        parameters: "failure name",
        doc: "The value of a slot of a failure, or nil.",
        effect: Effect::None,
        code: Plain(slot),
    },
    Native {
        name: "failure-parts",
        parameters: "failure",
        doc: "The failures a `composite-failure` is made of.",
        effect: Effect::None,
        code: Plain(|call| {
            let failure = failure(call)?;
            let parts = call.machine.heap.failures[failure].parts.clone();
            Ok(Reply::Value(call.machine.heap.list(&parts)))
        }),
    },
    Native {
        name: "failure-while-cleaning-up",
        parameters: "failure",
        doc: "The failures of clean-ups that ran because of a failure.",
        effect: Effect::None,
        code: Plain(|call| {
            let failure = failure(call)?;
            let later = call.machine.heap.failures[failure].while_cleaning_up.clone();
            Ok(Reply::Value(call.machine.heap.list(&later)))
        }),
    },
    Native {
        name: "failure-is?",
        parameters: "failure class",
        doc: "Whether a failure is of a class or of one below it.",
        effect: Effect::None,
        code: Plain(is_of_class),
    },
];

fn failure(call: &Call<'_, '_>) -> Result<u32, Raise> {
    match call.argument(0) {
        Value::Failure(failure) => Ok(failure),
        _ => Err(call.wrong_type(0)),
    }
}

fn fail(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    if let Value::Failure(_) = call.argument(0) {
        return Err(Raise::Again(call.argument(0)));
    }
    let Value::Symbol(class) = call.argument(0) else {
        return Err(call.wrong_type(0));
    };
    if !call.around.program.failure_classes.contains_key(&class) {
        let name = call.machine.symbols.name(class).to_string();
        return Err(Raise::type_error(format!("there is no failure class `{name}`; define it with `def-failure`")));
    }
    let message = call.machine.show(call.around.program, call.argument(1));
    let given = &call.arguments[2..];
    // Most failures have none.
    let known = if given.is_empty() { Vec::new() } else { call.around.program.failure_slots(class) };
    let mut slots = Vec::new();
    for pair in given.chunks(2) {
        match *pair {
            [Value::Keyword(name), value] if known.contains(&name) => slots.push((name, value)),
            [Value::Keyword(name), _] => {
                let (slot, class) = (call.machine.symbols.name(name), call.machine.symbols.name(class));
                return Err(Raise::type_error(format!("the class `{class}` has no slot `{slot}`")));
            }
            [found, ..] => return Err(call.machine.wrong_type("a slot of a failure", "a keyword with a value", found)),
            [] => {}
        }
    }
    Err(Raise::Again(call.machine.new_failure(call.machine.current, class, message, slots)))
}

fn fail_composite(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let parts = call.list(0)?;
    let message = match call.argument(1) {
        Value::Nil => all_failed(parts.len()),
        message => call.machine.show(call.around.program, message),
    };
    Err(Raise::Again(call.machine.composite(call.machine.current, message, parts)))
}

fn slot(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let failure = failure(call)?;
    let name = call.name(1)?;
    let record = &call.machine.heap.failures[failure];
    let value = record.slots.iter().find(|(slot, _)| call.machine.symbols.name(*slot) == name);
    Ok(Reply::Value(value.map_or(Value::Nil, |&(_, value)| value)))
}

fn is_of_class(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let failure = failure(call)?;
    let Value::Symbol(class) = call.argument(1) else {
        return Err(call.wrong_type(1));
    };
    let own = call.machine.heap.failures[failure].class;
    Ok(Reply::Value(Value::truth(call.around.program.is_failure_subclass(own, class))))
}
