//! Division, for the instructions and for the library.

use super::failure::Raise;
use super::value::Value;

fn error(message: &str) -> Raise {
    Raise::new("arithmetic-error", message)
}

/// A quotient: an integer where the division of integers is exact, else a float; none where an operand is no
/// number.
///
/// # Errors
/// An `arithmetic-error` for a divisor of zero, and where an integer does not fit 64 bits.
#[inline(never)]
pub fn quotient(left: Value, right: Value) -> Result<Option<Value>, Raise> {
    let (Some(dividend), Some(divisor)) = (left.as_f64(), right.as_f64()) else { return Ok(None) };
    if divisor == 0.0 {
        return Err(error("division by zero"));
    }
    Ok(Some(match (left, right) {
        (Value::Int(i64::MIN), Value::Int(-1)) => {
            return Err(error("the quotient does not fit in a 64-bit integer; make one of the numbers a float"));
        }
        (Value::Int(left), Value::Int(right)) if left % right == 0 => Value::Int(left / right),
        _ => Value::Float(dividend / divisor),
    }))
}

/// The remainder with the sign of the divisor (`floored`) or of the number; none where an operand is no number.
///
/// # Errors
/// An `arithmetic-error` for a divisor of zero.
#[inline(never)]
pub fn remainder(left: Value, right: Value, floored: bool) -> Result<Option<Value>, Raise> {
    let (Some(dividend), Some(divisor)) = (left.as_f64(), right.as_f64()) else { return Ok(None) };
    if divisor == 0.0 {
        return Err(error("division by zero"));
    }
    Ok(Some(match (left, right) {
        (Value::Int(left), Value::Int(right)) => {
            let rest = left.wrapping_rem(right);
            let wrong_sign = rest != 0 && (rest < 0) != (right < 0);
            Value::Int(if floored && wrong_sign { rest + right } else { rest })
        }
        _ => {
            let rest = dividend % divisor;
            let wrong_sign = rest != 0.0 && (rest < 0.0) != (divisor < 0.0);
            Value::Float(if floored && wrong_sign { rest + divisor } else { rest })
        }
    }))
}
