//! Arithmetic beside the usual course: mixed operands, overflow, wrong types.

use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::mixed::order;
use crate::state::scratch::Cursor;
use crate::state::value::Value;
use crate::step::exec::Proceed;
use rpl_lang::code::Reg;
use rpl_lang::kind::Kind;

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
        self.wrong_type(&format!("an operand of {operation}"), Kind::Number.noun(), culprit)
    }

    /// Counts up what is no integer, or is the last there is; or what is counted up to no integer.
    #[cold]
    #[inline(never)]
    pub(super) fn count_other(&mut self, place: &mut Cursor, counter: Reg) -> Result<Proceed, Raise> {
        let register = &mut self.scratch.stack[place.frame.base as usize + usize::from(counter)];
        match *register {
            Value::Int(count) => *register = Value::Int(count.checked_add(1).ok_or_else(|| overflow("+"))?),
            Value::Float(count) => *register = Value::Float(count + 1.0),
            other => return Err(self.wrong_operands("`+`", other, other)),
        }
        Ok(Proceed::On)
    }

    /// The error for the argument of a function that is no number.
    #[cold]
    #[inline(never)]
    pub(crate) fn wrong_argument(&self, function: &str, left: Value, right: Value) -> Raise {
        let (at, culprit) = if left.as_f64().is_none() { (1, left) } else { (2, right) };
        self.wrong_type(&format!("argument {at} of `{function}`"), Kind::Number.noun(), culprit)
    }
}

/// A sum, difference or product: `$to := $left $operator $right`. For the loop, whose `fail!` and `next!` it needs.
///
/// All kinds of operands stand here: a call that comes back would have the loop keep its state in memory.
macro_rules! arithmetic {
    ($machine:ident, $to:expr, $left:expr, $right:expr, $name:literal, $checked:ident, $operator:tt) => {
        match (&$left, &$right) {
            (&Value::Int(x), &Value::Int(y)) => match x.$checked(y) {
                Some(value) => {
                    $to = Value::Int(value);
                    next!();
                }
                None => fail!(overflow($name)),
            },
            (&Value::Float(x), &Value::Float(y)) => {
                $to = Value::Float(x $operator y);
                next!();
            }
            (&Value::Int(x), &Value::Float(y)) => {
                $to = Value::Float(x as f64 $operator y);
                next!();
            }
            (&Value::Float(x), &Value::Int(y)) => {
                $to = Value::Float(x $operator y as f64);
                next!();
            }
            (&left, &right) => fail!($machine.wrong_operands(concat!("`", $name, "`"), left, right)),
        }
    };
}

/// How an integer stands to a float: -1, 0, 1, or NaN if in no way.
pub(super) fn sign(integer: i64, float: f64) -> f64 {
    order(integer, float).map_or(f64::NAN, |order| f64::from(order as i8))
}

/// Whether an order holds between two numbers.
macro_rules! compare {
    ($machine:ident, $left:expr, $right:expr, $name:literal, $operator:tt) => {
        match (&$left, &$right) {
            (&Value::Int(x), &Value::Int(y)) => x $operator y,
            (&Value::Float(x), &Value::Float(y)) => x $operator y,
            (&Value::Int(x), &Value::Float(y)) => $crate::step::exec::arithmetic::sign(x, y) $operator 0.0,
            (&Value::Float(x), &Value::Int(y)) => 0.0 $operator $crate::step::exec::arithmetic::sign(y, x),
            (&left, &right) => fail!($machine.wrong_operands($name, left, right)),
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
