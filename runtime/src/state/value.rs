//! Values: 16 bytes, copied; what is larger lives in the heap and is named by a handle.

use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};

/// Names one run of a task; a dead task's slot can be used again under a new generation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct TaskRef {
    /// Slot in the task table.
    pub index: u32,
    /// Counts the uses of the slot.
    pub generation: u32,
}

/// Assigns a value in the parts it was written in: reading the whole of a value whose parts have just been written stalls
/// the processor, and reading parts of what was written whole does not. The casts, which change nothing, keep the compiler
/// from making one copy of it.
macro_rules! assign {
    ($to:expr, $from:expr) => {
        match $from {
            Value::Int(value) => $to = Value::Int(value as u64 as i64),
            Value::Cons(pair) => $to = Value::Cons(pair as i32 as u32),
            Value::Float(value) => $to = Value::Float(f64::from_bits(value.to_bits())),
            Value::Cell(cell) => $to = Value::Cell(cell as i32 as u32),
            Value::Closure(closure) => $to = Value::Closure(closure as i32 as u32),
            other => $to = other,
        }
    };
}

pub(crate) use assign;

/// A value. `PartialEq` is bitwise sameness of handles, not `equal`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Value {
    /// False and the empty list.
    #[default]
    Nil,
    /// `t`
    True,
    /// A 64-bit integer.
    Int(i64),
    /// A float.
    Float(f64),
    /// A symbol other than `nil` and `t`.
    Symbol(Symbol),
    /// A keyword.
    Keyword(Symbol),
    /// A pair.
    Cons(u32),
    /// A string.
    Str(u32),
    /// A variable that is captured and assigned; never seen by a plan.
    Cell(u32),
    /// A function without captured values: its code.
    Function(u32),
    /// A function with captured values.
    Closure(u32),
    /// A native function.
    Native(u16),
    /// A fluent.
    Fluent(u32),
    /// A task.
    Task(TaskRef),
    /// A valve.
    Valve(u32),
    /// A failure.
    Failure(u32),
    /// A hash table.
    Table(u32),
    /// A vector.
    Vector(u32),
    /// A behaviour of the robot.
    Behaviour(u16),
    /// No value yet; never seen by a plan.
    Unbound,
}

impl Value {
    /// `nil` or `t`, if it is one of them. Looks at the tag alone: to read the whole of a value that has
    /// just been written in parts stalls the processor.
    #[inline]
    pub fn as_truth(&self) -> Option<Self> {
        match self {
            Value::Nil => Some(Value::Nil),
            Value::True => Some(Value::True),
            _ => None,
        }
    }

    /// Whether it may refer to something.
    #[inline]
    pub fn refers(&self) -> bool {
        !matches!(
            self,
            Value::Nil | Value::True | Value::Int(_) | Value::Float(_) | Value::Symbol(_) | Value::Keyword(_)
        )
    }

    /// A copy made of the parts it was written in, as in `assign!`.
    #[inline(always)]
    pub fn copied(&self) -> Self {
        let copy;
        assign!(copy, *self);
        copy
    }

    /// Becomes another value, as by `assign!`.
    #[inline(always)]
    pub fn set(&mut self, from: &Self) {
        assign!(*self, *from);
    }

    /// Whether it is the very same as another: `==`, where what is mostly compared is seen by the compiler.
    #[inline(always)]
    pub(crate) fn is_eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Value::Symbol(own), Value::Symbol(other)) => own == other,
            (Value::Symbol(_), _) | (_, Value::Symbol(_)) => false,
            (own, other) => own == other,
        }
    }

    /// Whether it counts as true: everything but `nil`.
    #[inline]
    pub fn is_true(self) -> bool {
        !matches!(self, Value::Nil)
    }

    /// `t` or `nil`, written as a whole, so that it can soon be read as a whole.
    #[inline]
    pub fn truth(condition: bool) -> Value {
        static TRUTHS: [Value; 2] = [Value::Nil, Value::True];
        TRUTHS[usize::from(condition)]
    }

    /// The number as a float, if it is one.
    pub fn as_f64(self) -> Option<f64> {
        match self {
            Value::Int(value) => Some(value as f64),
            Value::Float(value) => Some(value),
            _ => None,
        }
    }

    /// The name of its type, as errors say it.
    pub fn type_name(self) -> &'static str {
        match self {
            Value::Nil => "nil",
            Value::True => "t",
            Value::Int(_) => "an integer",
            Value::Float(_) => "a float",
            Value::Symbol(_) => "a symbol",
            Value::Keyword(_) => "a keyword",
            Value::Cons(_) => "a list",
            Value::Str(_) => "a string",
            Value::Function(_) | Value::Closure(_) | Value::Native(_) => "a function",
            Value::Fluent(_) => "a fluent",
            Value::Task(_) => "a task",
            Value::Valve(_) => "a valve",
            Value::Failure(_) => "a failure",
            Value::Table(_) => "a hash table",
            Value::Vector(_) => "a vector",
            Value::Behaviour(_) => "a behaviour",
            Value::Cell(_) | Value::Unbound => "nothing",
        }
    }
}
