//! Values as text.

use crate::state::machine::Machine;
use crate::state::value::Value;
use rpl_lang::bars::{written_keyword, written_name};
use rpl_lang::code::Program;
use rpl_lang::number::format_float;
use rpl_lang::visible::{quote_string, visible};
use std::fmt::Write as _;

/// Text longer than this is cut, so that a circular list prints.
const MAX_CHARACTERS: usize = 1 << 20;

/// A value in the message of a failure is cut behind this many characters.
const LONGEST_IN_MESSAGE: usize = 200;

enum ToPrint {
    Value(Value),
    /// The rest of a list after its first element.
    Rest(Value),
    /// The elements of a vector from a position on.
    Elements(u32, usize),
    Text(&'static str),
}

/// A value as `print` shows it: strings without quotes, names without bars.
fn display(machine: &Machine, program: &Program, value: Value, text: &mut String) {
    match value {
        Value::Str(string) => text.push_str(&machine.heap.strings[string]),
        Value::Int(value) => text.push_str(itoa::Buffer::new().format(value)),
        Value::Symbol(symbol) => text.push_str(&visible(machine.symbols.name(symbol))),
        Value::Keyword(symbol) => text.extend([":", &visible(machine.symbols.name(symbol))]),
        Value::Failure(failure) => {
            let failure = &machine.heap.failures[failure];
            text.extend([machine.symbols.name(failure.class), ": ", &failure.message]);
        }
        other => readable(machine, program, other, text),
    }
}

/// A value as it could be read, where it can be.
fn readable(machine: &Machine, program: &Program, value: Value, text: &mut String) {
    if !matches!(value, Value::Cons(_) | Value::Vector(_)) {
        return atom(machine, program, value, text);
    }
    let before = text.len();
    let mut waiting = vec![ToPrint::Value(value)];
    while let Some(piece) = waiting.pop() {
        if text.len() - before > MAX_CHARACTERS {
            text.push('…');
            break;
        }
        match piece {
            ToPrint::Text(piece) => text.push_str(piece),
            ToPrint::Value(Value::Cons(pair)) => {
                let (car, cdr) = machine.heap.pair(pair);
                text.push('(');
                waiting.push(ToPrint::Rest(cdr));
                waiting.push(ToPrint::Value(car));
            }
            ToPrint::Value(Value::Vector(vector)) => {
                text.push_str("#(");
                waiting.push(ToPrint::Elements(vector, 0));
            }
            ToPrint::Elements(vector, at) => match machine.heap.vectors[vector].elements().get(at) {
                Some(&element) => {
                    text.push_str(if at > 0 { " " } else { "" });
                    waiting.push(ToPrint::Elements(vector, at + 1));
                    waiting.push(ToPrint::Value(element));
                }
                None => text.push(')'),
            },
            ToPrint::Value(value) => atom(machine, program, value, text),
            ToPrint::Rest(Value::Nil) => text.push(')'),
            ToPrint::Rest(Value::Cons(pair)) => {
                let (car, cdr) = machine.heap.pair(pair);
                text.push(' ');
                waiting.push(ToPrint::Rest(cdr));
                waiting.push(ToPrint::Value(car));
            }
            ToPrint::Rest(tail) => {
                text.push_str(" . ");
                waiting.push(ToPrint::Text(")"));
                waiting.push(ToPrint::Value(tail));
            }
        }
    }
}

fn atom(machine: &Machine, program: &Program, value: Value, text: &mut String) {
    let name = |symbol| visible(machine.symbols.name(symbol));
    let code_name = |code: u32| program.codes.get(code as usize).map_or("?".into(), |code| name(code.name));
    let written = match value {
        Value::Nil => write!(text, "nil"),
        Value::True => write!(text, "t"),
        Value::Int(value) => return text.push_str(itoa::Buffer::new().format(value)),
        Value::Float(value) => write!(text, "{}", format_float(value)),
        Value::Symbol(symbol) => write!(text, "{}", written_name(machine.symbols.name(symbol))),
        Value::Keyword(symbol) => write!(text, "{}", written_keyword(machine.symbols.name(symbol))),
        Value::Str(string) => write!(text, "{}", quote_string(&machine.heap.strings[string])),
        Value::Function(code) => write!(text, "#<function {}>", code_name(code)),
        Value::Closure(closure) => write!(text, "#<function {}>", code_name(machine.heap.closures[closure].code)),
        Value::Native(number) => write!(text, "#<native {number}>"),
        Value::Fluent(fluent) => match machine.fluents.get(fluent).and_then(|fluent| fluent.name) {
            Some(symbol) => write!(text, "#<fluent {}>", name(symbol)),
            None => write!(text, "#<fluent {fluent}>"),
        },
        Value::Task(task) => match machine.tasks.find(task) {
            Some(index) => write!(text, "#<task {}>", machine.path(index)),
            None => write!(text, "#<task gone>"),
        },
        Value::Valve(valve) => write!(text, "#<valve {}>", name(machine.valves[valve as usize].name)),
        Value::Failure(failure) => {
            let failure = &machine.heap.failures[failure];
            write!(text, "#<{} {}>", name(failure.class), quote_string(&failure.message))
        }
        Value::Table(table) => {
            write!(text, "#<hash-table of {}>", machine.heap.tables[table].len())
        }
        Value::Behaviour(number) => write!(text, "#<behaviour {number}>"),
        Value::Cons(_) | Value::Vector(_) | Value::Cell(_) | Value::Unbound => write!(text, "#<unbound>"),
    };
    debug_assert!(written.is_ok(), "writing into a string cannot fail");
}

impl Machine {
    /// A value as `print` shows it.
    pub fn show(&self, program: &Program, value: Value) -> String {
        let mut text = String::new();
        self.show_into(program, value, &mut text);
        text
    }

    /// The same behind a text.
    pub fn show_into(&self, program: &Program, value: Value, text: &mut String) {
        display(self, program, value, text);
    }

    /// A value in the message of a failure, cut where it is long.
    pub fn brief(&self, program: &Program, value: Value) -> String {
        let written = self.write(program, value);
        match written.char_indices().nth(LONGEST_IN_MESSAGE) {
            Some((end, _)) => format!("{}… ({} characters)", &written[..end], written.chars().count()),
            None => written,
        }
    }

    /// A value as it could be read.
    pub fn write(&self, program: &Program, value: Value) -> String {
        let mut text = String::new();
        readable(self, program, value, &mut text);
        text
    }
}
