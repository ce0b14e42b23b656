//! Calls of function values, plans as data, and output.

use crate::failure::Raise;
use crate::machine::{MAX_WAITING_OUTPUT, MAX_WAITING_OUTPUT_BYTES, Machine, Output};
use crate::memory::block;
use crate::native::{Call, Effect, Native, Reply};
use crate::value::Value;

pub(super) const NATIVES: &[Native] = &[
    Native {
        name: "funcall",
        parameters: "function &rest arguments",
        doc: "Calls a function with arguments.",
        effect: Effect::Calls,
        code: |call| Ok(Reply::Call(call.argument(0), call.arguments[1..].to_vec())),
    },
    Native {
        name: "apply",
        parameters: "function argument &rest more",
        doc: "Calls a function with arguments, the last of which is a list of further ones.",
        effect: Effect::Calls,
        code: apply,
    },
    Native {
        name: "execute-plan",
        parameters: "datum",
        doc: "Compiles a quoted plan and runs it here, in this task.",
        effect: Effect::Calls,
        code: |call| Ok(Reply::Execute(call.argument(0))),
    },
    Native {
        name: "random",
        parameters: "limit",
        doc: "A random number at or above 0 and below the limit, an integer for an integer; drawn from the run's seed.",
        effect: Effect::Acts,
        code: random,
    },
    Native {
        name: "print",
        parameters: "value",
        doc: "Writes a value and a newline, and returns the value.",
        effect: Effect::None,
        code: print,
    },
    Native {
        name: "log",
        parameters: "value",
        doc: "Writes a value to the trace and to standard error, and returns it.",
        effect: Effect::None,
        code: log,
    },
];

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
        other => Err(call.wrong_type(0, "a number above 0", other)),
    }
}

fn print(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let value = call.argument(0);
    let text = call.machine.show(call.around.program, value);
    call.burn_text(text.len());
    put_out(call.machine, Output::Print(text));
    Ok(Reply::Value(value))
}

fn put_out(machine: &mut Machine, output: Output) {
    let (Output::Print(text) | Output::Log(text)) = &output;
    if machine.output.is_empty() {
        machine.scratch.output_bytes = 0;
    }
    machine.heap.allocated += size_of::<Output>() + block(text.len());
    machine.scratch.output_bytes += text.len();
    machine.output.push(output);
    machine.scratch.switch |= machine.is_output_full();
}

impl Machine {
    /// Whether so much output waits to be taken that a task gives way for it.
    pub fn is_output_full(&self) -> bool {
        let bytes = if self.output.is_empty() { 0 } else { self.scratch.output_bytes };
        self.output.len() >= MAX_WAITING_OUTPUT || bytes >= MAX_WAITING_OUTPUT_BYTES
    }
}

fn log(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let value = call.argument(0);
    let text = call.machine.show(call.around.program, value);
    call.burn_text(text.len());
    call.machine.trace_log(&text);
    put_out(call.machine, Output::Log(text));
    Ok(Reply::Value(value))
}
