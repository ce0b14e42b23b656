//! Calls of function values, plans as data, chance, and output.

use crate::state::failure::Raise;
use crate::state::measures::MOST_MEASURES;
use crate::state::output::Channel;
use crate::state::projected::Asked;
use crate::state::value::Value;
use crate::step::native::NativeCode::Plain;
use crate::step::native::{Call, Effect, Native, Reply};

pub(super) const NATIVES: &[Native] = &[
    Native {
        name: "funcall",
        parameters: "function &rest arguments",
        doc: "Calls a function with arguments.",
        effect: Effect::Calls,
        code: Plain(|call| Ok(Reply::Call(call.argument(0), call.arguments[1..].to_vec()))),
    },
    Native {
        name: "%close-over",
        parameters: "function position value",
        doc: "Gives a local function the value that it captures at a position; it was made before that value.",
        effect: Effect::None,
        code: Plain(close_over),
    },
    Native {
        name: "apply",
        parameters: "function argument &rest more",
        doc: "Calls a function with arguments, the last of which is a list of further ones.",
        effect: Effect::Calls,
        code: Plain(apply),
    },
    Native {
        name: "execute-plan",
        parameters: "datum",
        doc: "Compiles a quoted plan and runs it here, in this task.",
        effect: Effect::Calls,
        code: Plain(|call| Ok(Reply::Ask(Asked::Code(call.argument(0))))),
    },
    Native {
        name: "random",
        parameters: "limit",
        doc: "A random number at or above 0 and below the limit, an integer for an integer; drawn from the run's seed.",
        effect: Effect::Acts,
        code: Plain(random),
    },
    Native {
        name: "print",
        parameters: "value",
        doc: "Writes a value and a newline, and returns the value.",
        effect: Effect::None,
        code: Plain(print),
    },
    Native {
        name: "log",
        parameters: "value",
        doc: "Writes a value to the trace and to standard error, and returns it.",
        effect: Effect::None,
        code: Plain(log),
    },
    Native {
        name: "measure",
        parameters: "symbol number",
        doc: "Measures this run: a number by its name, a column of an experiment; the last one of a name counts.",
        effect: Effect::None,
        code: Plain(measure),
    },
];

fn close_over(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let value = call.argument(2);
    if let (Value::Closure(function), Value::Int(position)) = (call.argument(0), call.argument(1))
        && let Ok(position) = usize::try_from(position)
        && let Some(captured) = call.machine.heap.closures[function].captured.get_mut(position)
    {
        *captured = value;
    }
    Ok(Reply::Value(Value::Nil))
}

fn apply(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let last = call.arguments.len() - 1;
    let mut arguments = call.arguments[1..last].to_vec();
    let count = arguments.len() + call.machine.heap.length(call.argument(last)).unwrap_or(0);
    if count > 200 {
        return Err(Raise::new("arity-error", format!("{count} arguments are too many for one call")));
    }
    arguments.extend(call.list(last)?);
    Ok(Reply::Call(call.argument(0), arguments))
}

fn random(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let share = call.machine.random.uniform();
    match call.argument(0) {
        Value::Int(limit) if limit > 0 => Ok(Reply::Value(Value::Int(((share * limit as f64) as i64).min(limit - 1)))),
        Value::Float(limit) if limit > 0.0 && limit.is_finite() => Ok(Reply::Value(Value::Float(share * limit))),
        Value::Int(_) | Value::Float(_) => {
            let (what, found) = (call.which(0), call.machine.described(call.argument(0)));
            Err(Raise::new("arithmetic-error", format!("{what} must be above 0 and finite, and it is {found}")))
        }
        _ => Err(call.wrong_type(0)),
    }
}

fn print(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let value = call.argument(0);
    let text = call.machine.show(call.around.program, value);
    call.burn_text(text.len());
    call.machine.put_out(Channel::Print, text);
    Ok(Reply::Value(value))
}

fn log(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let value = call.argument(0);
    let text = call.machine.show(call.around.program, value);
    call.burn_text(text.len());
    call.machine.trace_log(&text);
    call.machine.put_out(Channel::Log, text);
    Ok(Reply::Value(value))
}

fn measure(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let Value::Symbol(name) = call.argument(0) else { return Err(call.wrong_type(0)) };
    let (value, number) = (call.argument(1), call.number(1)?);
    if !number.is_finite() {
        let (what, found) = (call.which(1), call.machine.described(value));
        return Err(Raise::new("arithmetic-error", format!("{what} must be finite, and it is {found}")));
    }
    if !call.machine.measures.put(name, number) {
        let name = call.machine.symbols.name(name).to_string();
        return Err(Raise::new(
            "error",
            format!("a run has at most {MOST_MEASURES} measures, and `{name}` would be one more"),
        ));
    }
    call.machine.trace_measured(name, number);
    Ok(Reply::Value(value))
}
