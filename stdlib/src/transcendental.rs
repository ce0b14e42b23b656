//! Roots, powers, logarithms and angles. What has no real value is an `arithmetic-error`.

use crate::arguments::{NativeResult, count, pure, value};
use crate::numbers::{Number, arithmetic_error, division_by_zero, number, overflow};
use rpl_lang::number::format_float;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native};
use std::f64::consts::PI;

fn of_one(call: &Call<'_, '_>, function: fn(f64) -> f64) -> NativeResult {
    value(Value::Float(function(call.number(0)?)))
}

/// The function of an argument that must lie within bounds.
fn within(call: &Call<'_, '_>, what: &str, low: f64, high: f64, function: fn(f64) -> f64) -> NativeResult {
    let argument = call.number(0)?;
    if argument < low || argument > high {
        return Err(arithmetic_error(format!("{} has no {what}", format_float(argument))));
    }
    value(Value::Float(function(argument)))
}

fn logarithm_of(argument: f64) -> Result<f64, Raise> {
    if argument <= 0.0 {
        return Err(arithmetic_error(format!("{} has no logarithm: it is not positive", format_float(argument))));
    }
    Ok(libm::log(argument))
}

fn logarithm(call: &mut Call<'_, '_>) -> NativeResult {
    let argument = logarithm_of(call.number(0)?)?;
    if count(call) == 1 {
        return value(Value::Float(argument));
    }
    match logarithm_of(call.number(1)?)? {
        0.0 => Err(arithmetic_error("there are no logarithms to the base 1")),
        base => value(Value::Float(argument / base)),
    }
}

fn arc_tangent(call: &mut Call<'_, '_>) -> NativeResult {
    let y = call.number(0)?;
    value(Value::Float(if count(call) == 1 { libm::atan(y) } else { libm::atan2(y, call.number(1)?) }))
}

fn power(call: &mut Call<'_, '_>) -> NativeResult {
    let (base, exponent) = (number(call, 0)?, number(call, 1)?);
    if base.as_f64() == 0.0 && exponent.as_f64() < 0.0 {
        return Err(division_by_zero());
    }
    if let (Number::Int(base), Number::Int(exponent @ 0..)) = (base, exponent) {
        return value(Value::Int(integer_power(base, exponent).ok_or_else(|| overflow("the power"))?));
    }
    let (base, exponent) = (base.as_f64(), exponent.as_f64());
    let power = libm::pow(base, exponent);
    if power.is_nan() && !base.is_nan() && !exponent.is_nan() {
        let (base, exponent) = (format_float(base), format_float(exponent));
        return Err(arithmetic_error(format!("{base} to the power {exponent} is no real number")));
    }
    value(Value::Float(power))
}

/// Squaring; an exponent too large to fit has only the powers of -1, 0 and 1.
fn integer_power(base: i64, exponent: i64) -> Option<i64> {
    match (base, u32::try_from(exponent)) {
        (_, Ok(exponent)) => base.checked_pow(exponent),
        (0 | 1, Err(_)) => Some(base),
        (-1, Err(_)) => Some(if exponent % 2 == 0 { 1 } else { -1 }),
        (_, Err(_)) => None,
    }
}

fn distance(call: &mut Call<'_, '_>) -> NativeResult {
    value(Value::Float(libm::hypot(call.number(0)?, call.number(1)?)))
}

/// The angle on (-π, π].
fn normalized(angle: f64) -> f64 {
    let turned = angle % (2.0 * PI);
    if turned > PI {
        turned - 2.0 * PI
    } else if turned <= -PI {
        turned + 2.0 * PI
    } else {
        turned
    }
}

/// Roots, powers, logarithms, angles.
pub(super) const NATIVES: &[Native] = &[
    pure("sqrt", "number", "The square root, a float.", |call| {
        within(call, "real square root: it is negative", 0.0, f64::INFINITY, f64::sqrt)
    }),
    pure("expt", "base exponent", "The power; an integer for integers with an exponent that is not negative.", power),
    pure("exp", "number", "The power of e.", |call| of_one(call, libm::exp)),
    pure("ln", "number &optional base", "The natural logarithm, or that to the base.", logarithm),
    pure("sin", "angle", "The sine of an angle in radians.", |call| of_one(call, libm::sin)),
    pure("cos", "angle", "The cosine of an angle in radians.", |call| of_one(call, libm::cos)),
    pure("tan", "angle", "The tangent of an angle in radians.", |call| of_one(call, libm::tan)),
    pure("asin", "number", "The angle in radians that has this sine.", |call| {
        within(call, "arc sine: it is not between -1 and 1", -1.0, 1.0, libm::asin)
    }),
    pure("acos", "number", "The angle in radians that has this cosine.", |call| {
        within(call, "arc cosine: it is not between -1 and 1", -1.0, 1.0, libm::acos)
    }),
    pure(
        "atan",
        "y &optional x",
        "The angle in radians that has this tangent; with x the direction of the point (x, y).",
        arc_tangent,
    ),
    pure("hypot", "x y", "The distance of the point (x, y) from the origin.", distance),
    pure("deg->rad", "degrees", "An angle in degrees as radians.", |call| of_one(call, |degrees| degrees * PI / 180.0)),
    pure("rad->deg", "radians", "An angle in radians as degrees.", |call| of_one(call, |radians| radians * 180.0 / PI)),
    pure("normalize-angle", "radians", "The same direction as an angle above -π and not above π.", |call| {
        let radians = number(call, 0)?.as_f64();
        match radians.is_infinite() {
            true => Err(arithmetic_error("an infinite angle has no direction")),
            false => value(Value::Float(normalized(radians))),
        }
    }),
];
