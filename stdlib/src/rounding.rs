//! From floats to integers and back, and division with a remainder.

use crate::arguments::{NativeResult, count, drafted, pure, value};
use crate::numbers::{Number, arithmetic_error, division_by_zero, number, overflow};
use rpl_lang::number::{self, NumberLiteral, begins_like_number, format_float};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::quotient;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};

/// Which integer near a quotient is meant.
#[derive(Clone, Copy, PartialEq)]
enum Toward {
    /// The next one down.
    Floor,
    /// The next one up.
    Ceiling,
    /// The next one towards zero.
    Zero,
    /// The nearest one, the even one of two.
    Nearest,
}

/// A float without fraction as an integer.
fn to_integer(value: f64) -> Result<i64, Raise> {
    // 2^63 is a float, i64::MAX is none.
    const LIMIT: f64 = 9_223_372_036_854_775_808.0;
    if (-LIMIT..LIMIT).contains(&value) { Ok(value as i64) } else { Err(overflow(&format_float(value))) }
}

fn round_float(value: f64, toward: Toward) -> f64 {
    match toward {
        Toward::Floor => value.floor(),
        Toward::Ceiling => value.ceil(),
        Toward::Zero => value.trunc(),
        Toward::Nearest => value.round_ties_even(),
    }
}

fn divide_integers(left: i64, right: i64, toward: Toward) -> Option<i64> {
    let (quotient, rest) = (left.checked_div(right)?, left.checked_rem(right)?);
    // The quotient is cut towards zero; the exact one lies beyond it on this side.
    let beyond = if (rest < 0) == (right < 0) { 1 } else { -1 };
    let step = match toward {
        _ if rest == 0 => 0,
        Toward::Zero => 0,
        Toward::Floor => beyond.min(0),
        Toward::Ceiling => beyond.max(0),
        Toward::Nearest => {
            let (rest, other) = (rest.unsigned_abs(), right.unsigned_abs() - rest.unsigned_abs());
            if rest > other || (rest == other && quotient % 2 != 0) { beyond } else { 0 }
        }
    };
    Some(quotient + step)
}

/// A quotient that fits the remainder of [`remainder`]: `1.0` by `0.1`, a little more than a tenth,
/// goes 9 times.
fn divide_floats(left: f64, right: f64, toward: Toward) -> f64 {
    let rest = left % right;
    let whole = ((left - rest) / right).round_ties_even();
    let beyond = if (rest < 0.0) == (right < 0.0) { 1.0 } else { -1.0 };
    match toward {
        _ if rest == 0.0 => whole,
        Toward::Zero => whole,
        Toward::Floor => whole + f64::min(beyond, 0.0),
        Toward::Ceiling => whole + f64::max(beyond, 0.0),
        Toward::Nearest => (left / right).round_ties_even(),
    }
}

fn rounded(call: &Call<'_, '_>, toward: Toward) -> NativeResult {
    let left = number(call, 0)?;
    if count(call) == 1 {
        return value(match left {
            Number::Int(integer) => Value::Int(integer),
            Number::Float(float) => Value::Int(to_integer(round_float(float, toward))?),
        });
    }
    match (left, number(call, 1)?) {
        (Number::Int(_), Number::Int(0)) => Err(division_by_zero()),
        (Number::Int(left), Number::Int(right)) => {
            let quotient = divide_integers(left, right, toward).ok_or_else(|| overflow("the quotient"))?;
            value(Value::Int(quotient))
        }
        (_, right) if right.as_f64() == 0.0 => Err(division_by_zero()),
        (left, right) => value(Value::Int(to_integer(divide_floats(left.as_f64(), right.as_f64(), toward))?)),
    }
}

/// The remainder with the sign of the divisor (`floored`) or of the number. `mod` has an instruction where it is called
/// by name.
fn remainder(call: &Call<'_, '_>, floored: bool) -> NativeResult {
    let (left, right) = (call.argument(0), call.argument(1));
    let wrong_type = || call.wrong_type(usize::from(left.as_f64().is_some()));
    value(quotient::remainder(left, right, floored)?.ok_or_else(wrong_type)?)
}

fn float(call: &mut Call<'_, '_>) -> NativeResult {
    value(Value::Float(call.number(0)?))
}

/// Reads a number as the reader does, units included.
fn parse_number(call: &mut Call<'_, '_>) -> NativeResult {
    let text = call.text(0)?;
    let text = text.trim();
    if !begins_like_number(text) {
        return value(Value::Nil);
    }
    value(match number::parse_number(text) {
        Ok(NumberLiteral::Int(integer)) => Value::Int(integer),
        Ok(NumberLiteral::Float(float)) => Value::Float(float),
        Err(_) => Value::Nil,
    })
}

fn number_to_string(call: &mut Call<'_, '_>) -> NativeResult {
    number(call, 0)?;
    let mut shown = call.draft();
    call.machine.show_into(call.around.program, call.argument(0), &mut shown);
    drafted(call, shown)
}

fn integer_square_root(call: &mut Call<'_, '_>) -> NativeResult {
    let number = call.integer(0)?;
    match number.checked_isqrt() {
        Some(root) => value(Value::Int(root)),
        None => Err(arithmetic_error(format!("{number} has no square root: it is negative"))),
    }
}

/// From floats to integers and back.
pub(super) const NATIVES: &[Native] = &[
    pure(
        "floor",
        "number &optional divisor",
        "The greatest integer that is not above the number or quotient.",
        |call| rounded(call, Toward::Floor),
    ),
    pure(
        "ceiling",
        "number &optional divisor",
        "The least integer that is not below the number or quotient.",
        |call| rounded(call, Toward::Ceiling),
    ),
    pure("truncate", "number &optional divisor", "The integer part of the number or quotient.", |call| {
        rounded(call, Toward::Zero)
    }),
    pure(
        "round",
        "number &optional divisor",
        "The integer nearest to the number or quotient; the even one if two are as near.",
        |call| rounded(call, Toward::Nearest),
    ),
    pure("int", "number", "The integer part of the number.", |call| rounded(call, Toward::Zero)),
    pure("integer", "number", "The integer part of the number.", |call| rounded(call, Toward::Zero)),
    pure("float", "number", "The number as a float.", float),
    pure("mod", "number divisor", "The remainder of the floored division; it has the sign of the divisor.", |call| {
        remainder(call, true)
    }),
    pure("rem", "number divisor", "The remainder of the truncated division; it has the sign of the number.", |call| {
        remainder(call, false)
    }),
    pure("isqrt", "integer", "The integer part of the square root.", integer_square_root),
    pure(
        "parse-number",
        "string",
        "The number that the string spells, with its unit if it has one; nil if it spells none.",
        parse_number,
    ),
    pure("number->string", "number", "The number as it is printed.", number_to_string),
];
