//! Arithmetic and comparison. Integers have 64 bits and never wrap; an integer with a float gives a
//! float.

use crate::arguments::show;
use crate::arguments::{NativeResult, count, pure, truth, value};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::mixed::order;
use rpl_runtime::state::quotient::quotient;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};
use std::cmp::Ordering;

/// A number argument.
#[derive(Clone, Copy)]
pub(crate) enum Number {
    Int(i64),
    Float(f64),
}

impl Number {
    pub(crate) fn as_f64(self) -> f64 {
        match self {
            Number::Int(value) => value as f64,
            Number::Float(value) => value,
        }
    }

    pub(crate) fn value(self) -> Value {
        match self {
            Number::Int(value) => Value::Int(value),
            Number::Float(value) => Value::Float(value),
        }
    }
}

/// The argument at a position as a number.
pub(crate) fn number(call: &Call<'_, '_>, at: usize) -> Result<Number, Raise> {
    match call.argument(at) {
        Value::Int(value) => Ok(Number::Int(value)),
        Value::Float(value) => Ok(Number::Float(value)),
        _ => Err(call.wrong_type(at)),
    }
}

/// An `arithmetic-error`.
pub(crate) fn arithmetic_error(message: impl Into<String>) -> Raise {
    Raise::new("arithmetic-error", message)
}

/// The error for an integer result out of range.
pub(crate) fn overflow(what: &str) -> Raise {
    arithmetic_error(format!("{what} does not fit in a 64-bit integer; make one of the numbers a float"))
}

/// The error for a divisor of zero.
pub(crate) fn division_by_zero() -> Raise {
    arithmetic_error("division by zero")
}

fn combine(
    left: Number,
    right: Number,
    sign: char,
    integers: fn(i64, i64) -> Option<i64>,
    floats: fn(f64, f64) -> f64,
) -> Result<Number, Raise> {
    match (left, right) {
        (Number::Int(left), Number::Int(right)) => {
            integers(left, right).map(Number::Int).ok_or_else(|| overflow(&format!("{left} {sign} {right}")))
        }
        (left, right) => Ok(Number::Float(floats(left.as_f64(), right.as_f64()))),
    }
}

fn add(left: Number, right: Number) -> Result<Number, Raise> {
    combine(left, right, '+', i64::checked_add, |left, right| left + right)
}

fn subtract(left: Number, right: Number) -> Result<Number, Raise> {
    combine(left, right, '-', i64::checked_sub, |left, right| left - right)
}

fn multiply(left: Number, right: Number) -> Result<Number, Raise> {
    combine(left, right, '*', i64::checked_mul, |left, right| left * right)
}

/// An integer where the division is exact, else a float.
fn divide(left: Number, right: Number) -> Result<Number, Raise> {
    match quotient(left.value(), right.value())? {
        Some(Value::Int(value)) => Ok(Number::Int(value)),
        Some(Value::Float(value)) => Ok(Number::Float(value)),
        _ => unreachable!("two numbers have a quotient that is a number"),
    }
}

/// Folds all arguments from the left, beginning with a neutral number.
fn fold(call: &Call<'_, '_>, neutral: i64, step: fn(Number, Number) -> Result<Number, Raise>) -> NativeResult {
    let mut result = Number::Int(neutral);
    for at in 0..count(call) {
        result = step(result, number(call, at)?)?;
    }
    value(result.value())
}

/// Not what is left when it is taken off 0, which for 0.0 would be 0.0.
fn negate(number: Number) -> Result<Number, Raise> {
    Ok(match number {
        Number::Int(int) => Number::Int(int.checked_neg().ok_or_else(|| overflow(&format!("-{int}")))?),
        Number::Float(float) => Number::Float(-float),
    })
}

/// The first argument with all others taken off it; a single one turned round.
fn unfold(
    call: &Call<'_, '_>,
    of_one: fn(Number) -> Result<Number, Raise>,
    step: fn(Number, Number) -> Result<Number, Raise>,
) -> NativeResult {
    let first = number(call, 0)?;
    if count(call) == 1 {
        return value(of_one(first)?.value());
    }
    let mut result = first;
    for at in 1..count(call) {
        result = step(result, number(call, at)?)?;
    }
    value(result.value())
}

fn compare(left: Number, right: Number) -> Option<Ordering> {
    match (left, right) {
        (Number::Int(left), Number::Int(right)) => Some(left.cmp(&right)),
        (Number::Float(left), Number::Float(right)) => left.partial_cmp(&right),
        (Number::Int(left), Number::Float(right)) => order(left, right),
        (Number::Float(left), Number::Int(right)) => order(right, left).map(Ordering::reverse),
    }
}

/// Whether a relation holds between all neighbours. All arguments must be numbers, also those
/// behind the first pair that does not fit.
fn chain(call: &Call<'_, '_>, holds: fn(Option<Ordering>) -> bool) -> NativeResult {
    let mut all = true;
    let mut before = number(call, 0)?;
    for at in 1..count(call) {
        let next = number(call, at)?;
        all &= holds(compare(before, next));
        before = next;
    }
    truth(all)
}

fn all_different(call: &mut Call<'_, '_>) -> NativeResult {
    let mut numbers = Vec::new();
    for at in 0..count(call) {
        numbers.push(number(call, at)?);
    }
    let different = numbers
        .iter()
        .enumerate()
        .all(|(at, &left)| numbers[at + 1..].iter().all(|&right| compare(left, right) != Some(Ordering::Equal)));
    truth(different)
}

/// The argument that comes first in an order; the earlier one of equals.
fn extreme(call: &Call<'_, '_>, wanted: Ordering) -> NativeResult {
    let mut best = number(call, 0)?;
    for at in 1..count(call) {
        let next = number(call, at)?;
        if compare(next, best) == Some(wanted) || next.as_f64().is_nan() {
            best = next;
        }
    }
    value(best.value())
}

fn absolute(call: &mut Call<'_, '_>) -> NativeResult {
    value(match number(call, 0)? {
        Number::Int(number) => Value::Int(number.checked_abs().ok_or_else(|| overflow("the absolute value"))?),
        Number::Float(number) => Value::Float(number.abs()),
    })
}

fn signum(call: &mut Call<'_, '_>) -> NativeResult {
    value(match number(call, 0)? {
        Number::Int(number) => Value::Int(number.signum()),
        Number::Float(number) if number == 0.0 || number.is_nan() => Value::Float(number),
        Number::Float(number) => Value::Float(number.signum()),
    })
}

fn clamp(call: &mut Call<'_, '_>) -> NativeResult {
    let (wish, low, high) = (number(call, 0)?, number(call, 1)?, number(call, 2)?);
    if compare(low, high) == Some(Ordering::Greater) {
        let (low, high) = (show(call, low.value()), show(call, high.value()));
        return Err(arithmetic_error(format!("the range from {low} to {high} is empty")));
    }
    value(match (compare(wish, low), compare(wish, high)) {
        (Some(Ordering::Less), _) => low.value(),
        (_, Some(Ordering::Greater)) => high.value(),
        _ => wish.value(),
    })
}

fn parity(call: &Call<'_, '_>, odd: bool) -> NativeResult {
    truth((call.integer(0)? % 2 != 0) == odd)
}

fn sign_is(call: &Call<'_, '_>, wanted: Ordering) -> NativeResult {
    truth(compare(number(call, 0)?, Number::Int(0)) == Some(wanted))
}

fn gcd_of(left: u64, right: u64) -> u64 {
    let (mut left, mut right) = (left, right);
    while right != 0 {
        (left, right) = (right, left % right);
    }
    left
}

fn gcd(call: &mut Call<'_, '_>) -> NativeResult {
    let mut result = 0;
    for at in 0..count(call) {
        result = gcd_of(result, call.integer(at)?.unsigned_abs());
    }
    value(Value::Int(i64::try_from(result).map_err(|_| overflow("the greatest common divisor"))?))
}

fn lcm(call: &mut Call<'_, '_>) -> NativeResult {
    let mut result = 1u64;
    for at in 0..count(call) {
        let next = call.integer(at)?.unsigned_abs();
        result = match gcd_of(result, next) {
            0 => 0,
            divisor => (result / divisor).checked_mul(next).ok_or_else(|| overflow("the least common multiple"))?,
        };
    }
    value(Value::Int(i64::try_from(result).map_err(|_| overflow("the least common multiple"))?))
}

/// Arithmetic and comparison.
pub(super) const NATIVES: &[Native] = &[
    pure("+", "&rest numbers", "The sum; 0 of nothing.", |call| fold(call, 0, add)),
    pure("-", "number &rest numbers", "The first number less all others; a single number negated.", |call| {
        unfold(call, negate, subtract)
    }),
    pure("*", "&rest numbers", "The product; 1 of nothing.", |call| fold(call, 1, multiply)),
    pure(
        "/",
        "number &rest numbers",
        "The first number divided by all others, an integer if that is exact; the reciprocal of a single number.",
        |call| unfold(call, |number| divide(Number::Int(1), number), divide),
    ),
    pure("1+", "number", "The number plus one.", |call| value(add(number(call, 0)?, Number::Int(1))?.value())),
    pure("1-", "number", "The number less one.", |call| value(subtract(number(call, 0)?, Number::Int(1))?.value())),
    pure(
        "=",
        "number &rest numbers",
        "Whether all numbers are the same; an integer can be the same as a float.",
        |call| chain(call, |order| order == Some(Ordering::Equal)),
    ),
    pure("/=", "number &rest numbers", "Whether no two of the numbers are the same.", all_different),
    pure("<", "number &rest numbers", "Whether each number is less than the next.", |call| {
        chain(call, |order| order == Some(Ordering::Less))
    }),
    pure(">", "number &rest numbers", "Whether each number is greater than the next.", |call| {
        chain(call, |order| order == Some(Ordering::Greater))
    }),
    pure("<=", "number &rest numbers", "Whether no number is greater than the next.", |call| {
        chain(call, |order| matches!(order, Some(Ordering::Less | Ordering::Equal)))
    }),
    pure(">=", "number &rest numbers", "Whether no number is less than the next.", |call| {
        chain(call, |order| matches!(order, Some(Ordering::Greater | Ordering::Equal)))
    }),
    pure("abs", "number", "The number without its sign.", absolute),
    pure("signum", "number", "-1, 0 or 1 with the number's sign, a float for a float.", signum),
    pure("min", "number &rest numbers", "The least of the numbers.", |call| extreme(call, Ordering::Less)),
    pure("max", "number &rest numbers", "The greatest of the numbers.", |call| extreme(call, Ordering::Greater)),
    pure(
        "clamp",
        "number low high",
        "The number, or the end of the range from low to high that it lies beyond.",
        clamp,
    ),
    pure("evenp", "integer", "Whether the integer is even.", |call| parity(call, false)),
    pure("oddp", "integer", "Whether the integer is odd.", |call| parity(call, true)),
    pure("zerop", "number", "Whether the number is zero.", |call| sign_is(call, Ordering::Equal)),
    pure("plusp", "number", "Whether the number is greater than zero.", |call| sign_is(call, Ordering::Greater)),
    pure("minusp", "number", "Whether the number is less than zero.", |call| sign_is(call, Ordering::Less)),
    pure("gcd", "&rest integers", "The greatest common divisor.", gcd),
    pure("lcm", "&rest integers", "The least common multiple.", lcm),
];
