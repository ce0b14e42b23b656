//! Failure objects, made, and values described in their messages.

use crate::state::failure::{Failure, Raise};
use crate::state::machine::{Machine, NETWORK};
use crate::state::value::Value;
use rpl_lang::code::Program;
use rpl_lang::kind::{Kind, time_in_string};
use rpl_lang::number::format_float;
use rpl_lang::symbol::Symbol;
use rpl_lang::visible::{quoted, shortened, with_short_words};

impl Machine {
    /// A `type-error` about something that was found where something else was expected.
    pub fn wrong_type(&self, what: &str, expected: &str, found: Value) -> Raise {
        let message = match (found, self.heap.length(found)) {
            (Value::Cons(_), Err(Value::Cons(_))) => {
                format!("{what} must be {expected}, and it is a list that runs in a circle")
            }
            (Value::Cons(_), Err(end)) => format!(
                "{what} must be {expected}, and it is a list that ends in {} instead of nil",
                self.described(end)
            ),
            _ => format!("{what} must be {expected}, and it is {}", self.described(found)),
        };
        Raise::type_error(match found {
            Value::Fluent(fluent) if expected != Kind::Fluent.noun() => {
                format!("{message}; write `(value {})` for the fluent's value", self.fluent_name(fluent))
            }
            Value::Str(text) if expected == Kind::Seconds.noun() => match time_in_string(&self.heap.strings[text]) {
                Some(time) => format!("{message}; write `{time}`, without quotes"),
                None => message,
            },
            _ => message,
        })
    }

    /// A value in a message: its type, and what it is where that is short.
    pub fn described(&self, value: Value) -> String {
        match value {
            Value::Int(number) => format!("the integer {number}"),
            Value::Float(number) if number.is_nan() => "+nan.0, which is no number".to_string(),
            Value::Float(number) => format!("the float {}", format_float(number)),
            Value::Symbol(name) => format!("the symbol {}", shortened(self.symbols.name(name))),
            Value::Keyword(name) => format!("the keyword :{}", shortened(self.symbols.name(name))),
            Value::Str(text) => format!("the string {}", quoted(&self.heap.strings[text])),
            Value::Fluent(fluent) if self.fluents[fluent].name.is_some() => {
                format!("the fluent `{}`", self.fluent_name(fluent))
            }
            Value::Valve(valve) => format!("the valve `{}`", self.valve_name(valve)),
            other => other.type_name().to_string(),
        }
    }

    /// The error for what should be a record of a kind.
    ///
    /// # Errors
    /// Always, unless it is one.
    #[cold]
    pub fn check_record(&self, program: &Program, record: Value, kind: Value) -> Result<(), Raise> {
        if self.heap.is_record(&record, &kind) {
            return Ok(());
        }
        let (kind, found) = (self.write(program, kind), self.brief(program, record));
        Err(Raise::type_error(format!("this must be a `{kind}`, and it is {found}")))
    }

    /// The error for a slot that cannot be assigned: of no record of the kind, or beyond its end.
    #[cold]
    pub fn no_slot_to_set(&self, program: &Program, record: Value, kind: Value, position: usize) -> Raise {
        let is_record = self.check_record(program, record, kind);
        is_record.map_or_else(|raise| raise, |()| self.no_element_to_set(record, position))
    }

    /// The error for a change of what a fluent has or had as its value.
    #[cold]
    pub fn frozen(&self, value: Value) -> Raise {
        let (what, place) = match value {
            Value::Table(_) => ("hash table", "(gethash KEY (value FLUENT))"),
            Value::Vector(_) => ("vector", "(vref (value FLUENT) I)"),
            _ => ("list", "(nth I (value FLUENT))"),
        };
        Raise::type_error(format!(
            "this {what} is, or was, a part of a fluent's value, and such values never change: whoever waits for the \
             fluent would not be told; write `(setf {place} …)`, which assigns a changed copy"
        ))
    }

    /// The error for a place beyond the end of a list.
    #[cold]
    pub fn no_element_to_set(&self, list: Value, position: usize) -> Raise {
        let length = self.heap.spine(list).count();
        if self.heap.is_frozen(list) && position < length {
            return self.frozen(list);
        }
        Raise::new("index-error", format!("there is no element {position} to set: the length is {length}"))
    }

    /// The error for an element of a vector that is not there, or that cannot be named so.
    #[cold]
    pub fn no_element(&self, form: &str, vector: Value, position: Value) -> Raise {
        let Value::Vector(index) = vector else {
            return self.wrong_type(&format!("argument 1 of `{form}`"), Kind::Vector.noun(), vector);
        };
        let Value::Int(position) = position else {
            return self.wrong_type(&format!("argument 2 of `{form}`"), Kind::Integer.noun(), position);
        };
        let length = self.heap.vectors[index].elements().len();
        if self.heap.is_frozen(vector) && usize::try_from(position).is_ok_and(|position| position < length) {
            return self.frozen(vector);
        }
        let message = match length {
            0 => format!("there is no element {position}: the vector is empty"),
            length => format!("there is no element {position}: the vector has the positions 0 to {}", length - 1),
        };
        Raise::new("index-error", message)
    }

    /// Makes a failure object, of the current task.
    pub(crate) fn failure_from(&mut self, raise: Raise) -> Value {
        self.failure_of(self.current, raise)
    }

    /// Makes a failure object of a task.
    pub(crate) fn failure_of(&mut self, task: u32, raise: Raise) -> Value {
        match raise {
            Raise::Again(failure) => failure,
            Raise::NoRoom(_) => {
                let raise = self.out_of_memory();
                self.failure_of(task, raise)
            }
            Raise::New { class, message, slots } => {
                let class = self.symbols.intern(class);
                let slots = slots.into_iter().map(|(name, value)| (self.symbols.intern(name), value)).collect();
                self.new_failure(task, class, with_short_words(message), slots)
            }
        }
    }

    /// A failure of a network as that of a task that reads it or waits for it: what went wrong and where is the
    /// network's, the path and the calls are the task's. Another failure stays what it is.
    pub(crate) fn failure_of_reader(&mut self, task: u32, failure: Value) -> Value {
        let Value::Failure(index) = failure else { return failure };
        if self.heap.failures[index].path != NETWORK {
            return failure;
        }
        let (path, calls) = (self.path(task), self.plan_calls(task));
        let of_network = self.heap.failures[index].clone();
        self.heap.failure(Failure { path, calls, ..of_network })
    }

    /// Makes a failure of a class, of a task.
    pub(crate) fn new_failure(
        &mut self,
        task: u32,
        class: Symbol,
        message: String,
        slots: Vec<(Symbol, Value)>,
    ) -> Value {
        // The task may have ended just now, and what was around it with it.
        let (path, calls) = match self.tasks.get_alive(task) {
            Some(_) => (self.path(task), self.plan_calls(task)),
            None => (String::new(), Vec::new()),
        };
        let is_runaway = self.symbols.name(class) == "runaway";
        self.heap.failure(Failure {
            class,
            message,
            slots,
            time_us: self.now_us,
            span: None,
            path,
            calls,
            parts: Vec::new(),
            while_cleaning_up: Vec::new(),
            is_runaway,
        })
    }
}
