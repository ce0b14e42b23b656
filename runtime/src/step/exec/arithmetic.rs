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
