//! Arithmetic beside the usual course: mixed operands, overflow, wrong types.

use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::value::Value;
use rpl_lang::kind::Kind;

#[inline(never)]
pub(crate) fn as_floats(left: &Value, right: &Value) -> Option<(f64, f64)> {
    Some((left.as_f64()?, right.as_f64()?))
}

#[cold]
#[inline(never)]
pub(crate) fn overflow(operation: &str) -> Raise {
    Raise::new("arithmetic-error", format!("integer overflow in {operation}: the result does not fit 64 bits"))
}

impl Machine {
    #[cold]
    #[inline(never)]
    pub(crate) fn wrong_operands(&self, operation: &str, left: Value, right: Value) -> Raise {
        let culprit = if left.as_f64().is_none() { left } else { right };
        self.wrong_type(&format!("an operand of `{operation}`"), Kind::Number.noun(), culprit)
    }

    /// The error for the argument of a function that is no number.
    #[cold]
    #[inline(never)]
    pub(crate) fn wrong_argument(&self, function: &str, left: Value, right: Value) -> Raise {
        let (at, culprit) = if left.as_f64().is_none() { (1, left) } else { (2, right) };
        self.wrong_type(&format!("argument {at} of `{function}`"), Kind::Number.noun(), culprit)
    }
}

/// A sum, difference or product: `$to := $left $operator $right`. For the loop, whose `fail!` it needs.
macro_rules! arithmetic {
    ($machine:ident, $to:expr, $left:expr, $right:expr, $name:literal, $checked:ident, $operator:tt) => {
        match (&$left, &$right) {
            (&Value::Int(x), &Value::Int(y)) => match x.$checked(y) {
                Some(value) => $to = Value::Int(value),
                None => fail!(overflow($name)),
            },
            (&Value::Float(x), &Value::Float(y)) => $to = Value::Float(x $operator y),
            (left, right) => match as_floats(left, right) {
                Some((x, y)) => $to = Value::Float(x $operator y),
                None => {
                    let (left, right) = (*left, *right);
                    fail!($machine.wrong_operands($name, left, right))
                }
            },
        }
    };
}

/// Whether an order holds between two numbers.
macro_rules! compare {
    ($machine:ident, $left:expr, $right:expr, $name:literal, $operator:tt) => {
        match (&$left, &$right) {
            (&Value::Int(x), &Value::Int(y)) => x $operator y,
            (left, right) => match as_floats(left, right) {
                Some((x, y)) => x $operator y,
                None => {
                    let (left, right) = (*left, *right);
                    fail!($machine.wrong_operands($name, left, right))
                }
            },
        }
    };
}

/// Whether an order holds between a number and an integer of an instruction.
macro_rules! compare_int {
    ($machine:ident, $left:expr, $value:expr, $name:literal, $operator:tt) => {
        match &$left {
            &Value::Int(x) => x $operator i64::from($value),
            &Value::Float(x) => x $operator f64::from($value),
            &other => fail!($machine.wrong_operands($name, other, other)),
        }
    };
}

pub(super) use {arithmetic, compare, compare_int};
