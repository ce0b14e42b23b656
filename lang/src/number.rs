//! Atoms that begin like a number: 64-bit integers, floats, floats with a unit.

use crate::suggest::suggest;

/// A number as read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NumberLiteral {
    /// Digits with an optional sign.
    Int(i64),
    /// Anything with a point, an exponent or a unit, in SI.
    Float(f64),
}

/// Why an atom that begins like a number is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NumberError {
    /// What was found.
    pub message: String,
    /// What to type instead.
    pub help: String,
}

/// How a unit becomes its SI unit.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scale {
    /// A power of ten, added to the decimal exponent before the number is rounded to binary: `15cm`
    /// is the float nearest to 0.15, as `0.15` is.
    Decimal(i32),
    /// A factor.
    Times(f64),
    /// A divisor, where the factor itself is not a float.
    Over(f64),
}

/// π/180 rounds better over whole degrees than 180/π; 30°, 45°, 60°, 90° and their multiples come
/// out as the nearest float of π/6, π/4, ….
const RADIANS_PER_DEGREE: f64 = std::f64::consts::PI / 180.0;

const UNITS: &[(&str, Scale)] = &[
    ("m", Scale::Decimal(0)),
    ("cm", Scale::Decimal(-2)),
    ("mm", Scale::Decimal(-3)),
    ("km", Scale::Decimal(3)),
    ("deg", Scale::Times(RADIANS_PER_DEGREE)),
    ("rad", Scale::Decimal(0)),
    ("s", Scale::Decimal(0)),
    ("ms", Scale::Decimal(-3)),
    ("min", Scale::Times(60.0)),
    ("h", Scale::Times(3600.0)),
    ("m/s", Scale::Decimal(0)),
    ("cm/s", Scale::Decimal(-2)),
    ("mm/s", Scale::Decimal(-3)),
    ("km/h", Scale::Over(3.6)),
    ("deg/s", Scale::Times(RADIANS_PER_DEGREE)),
    ("rad/s", Scale::Decimal(0)),
    ("kg", Scale::Decimal(0)),
    ("g", Scale::Decimal(-3)),
    ("%", Scale::Decimal(-2)),
];

/// The units a number may carry.
pub fn unit_names() -> impl Iterator<Item = &'static str> {
    UNITS.iter().map(|&(name, _)| name)
}

/// Whether an atom begins like a number, and so must be one: a digit, or a sign or point (or both)
/// followed by one. `1+` and `1-` are names of functions.
pub fn begins_like_number(atom: &str) -> bool {
    if matches!(atom, "1+" | "1-") {
        return false;
    }
    let unsigned = atom.strip_prefix(['+', '-']).unwrap_or(atom);
    let digits = unsigned.strip_prefix('.').unwrap_or(unsigned);
    digits.starts_with(|c: char| c.is_ascii_digit()) || non_finite(atom).is_some()
}

/// Reads an atom for which [`begins_like_number`] holds.
///
/// # Errors
/// An integer or float out of range, an unknown unit, or no number at all.
pub fn parse_number(atom: &str) -> Result<NumberLiteral, NumberError> {
    let atom = atom.to_lowercase();
    if let Some(value) = non_finite(&atom) {
        return Ok(NumberLiteral::Float(value));
    }
    let parts = split(&atom);
    match (parts.unit, parts.is_integer) {
        ("", true) => parse_integer(parts.digits),
        ("", false) => parse_float(parts.digits, Scale::Decimal(0)).map(NumberLiteral::Float),
        (unit, _) => match UNITS.iter().find(|&&(name, _)| name == unit) {
            Some(&(_, scale)) => parse_float(parts.digits, scale).map(NumberLiteral::Float),
            None => Err(unknown_unit(&atom, &parts)),
        },
    }
}

/// A float as text: the shortest form that reads back as the same float, with at least one
/// decimal; `+inf.0`, `-inf.0` and `+nan.0` for what is no number.
pub fn format_float(value: f64) -> String {
    if value.is_nan() {
        return "+nan.0".to_string();
    }
    if value.is_infinite() {
        return if value > 0.0 { "+inf.0" } else { "-inf.0" }.to_string();
    }
    let shortest = format!("{value:?}");
    match shortest.split_once('e') {
        Some((mantissa, exponent)) if !mantissa.contains('.') => format!("{mantissa}.0e{exponent}"),
        _ => shortest,
    }
}

/// What [`format_float`] writes for what is no number.
pub fn non_finite(atom: &str) -> Option<f64> {
    match atom {
        "+inf.0" => Some(f64::INFINITY),
        "-inf.0" => Some(f64::NEG_INFINITY),
        "+nan.0" => Some(f64::NAN),
        _ => None,
    }
}

/// An atom cut into number and unit.
struct Parts<'a> {
    /// Sign, digits, point, exponent.
    digits: &'a str,
    is_integer: bool,
    unit: &'a str,
}

fn split(atom: &str) -> Parts<'_> {
    let bytes = atom.as_bytes();
    let digits_from = |from: usize| from + bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let sign = usize::from(atom.starts_with(['+', '-']));
    let mut end = digits_from(sign);
    let mut is_integer = true;
    if bytes.get(end) == Some(&b'.') {
        is_integer = false;
        end = digits_from(end + 1);
    }
    if bytes.get(end) == Some(&b'e') {
        let exponent = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if bytes.get(exponent).is_some_and(u8::is_ascii_digit) {
            is_integer = false;
            end = digits_from(exponent);
        }
    }
    Parts { digits: &atom[..end], is_integer, unit: &atom[end..] }
}

fn parse_integer(digits: &str) -> Result<NumberLiteral, NumberError> {
    digits.parse().map(NumberLiteral::Int).map_err(|_| NumberError {
        message: format!("the integer `{digits}` does not fit in 64 bits"),
        help: format!("integers go from {} to {}; write `{digits}.0` for a float", i64::MIN, i64::MAX),
    })
}

fn parse_float(digits: &str, scale: Scale) -> Result<f64, NumberError> {
    let value = match scale {
        Scale::Decimal(shift) => parse_decimal(digits, shift),
        Scale::Times(factor) => parse_decimal(digits, 0) * factor,
        Scale::Over(divisor) => parse_decimal(digits, 0) / divisor,
    };
    if value.is_finite() {
        return Ok(value);
    }
    Err(NumberError {
        message: format!("the number `{digits}` is too large for a float"),
        help: format!("floats go up to {:?}", f64::MAX),
    })
}

/// The float nearest to `digits` · 10^`shift`. An exponent too long for an integer is infinite or
/// zero anyway.
fn parse_decimal(digits: &str, shift: i32) -> f64 {
    let (mantissa, exponent) = digits.split_once('e').unwrap_or((digits, "0"));
    let clipped = if exponent.starts_with('-') { i32::MIN / 2 } else { i32::MAX / 2 };
    let exponent = exponent.parse::<i32>().unwrap_or(clipped).clamp(i32::MIN / 2, i32::MAX / 2) + shift;
    // `split` leaves only what `f64` reads, so the fallback is never taken.
    format!("{mantissa}e{exponent}").parse().unwrap_or(f64::NAN)
}

fn unknown_unit(atom: &str, parts: &Parts<'_>) -> NumberError {
    let known: Vec<_> = unit_names().collect();
    let known = known.join(" ");
    let Parts { digits, unit, .. } = parts;
    let looks_like_unit = unit.chars().all(|c| c.is_alphabetic() || c == '/');
    let message = if looks_like_unit {
        format!("`{atom}` begins like a number, and `{unit}` is no unit")
    } else {
        format!("`{atom}` begins like a number and is none")
    };
    let help = match (parts.is_integer, unit.strip_prefix('/'), suggest(unit, unit_names())) {
        (true, Some(divisor), _) if divisor.parse::<u64>().is_ok() => {
            format!("for a ratio write `(/ {digits} {divisor})`")
        }
        (_, _, Some(near)) if looks_like_unit => format!("did you mean `{digits}{near}`? The known units are {known}"),
        _ => format!("a name may not begin with a number; the known units are {known}"),
    };
    NumberError { message, help }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn float(atom: &str) -> f64 {
        match parse_number(atom) {
            Ok(NumberLiteral::Float(value)) => value,
            other => panic!("{atom}: {other:?}"),
        }
    }

    #[test]
    fn a_unit_reads_as_the_si_number_written_out() {
        for (atom, si) in [
            ("15cm", 0.15),
            ("2.5m", 2.5),
            ("1mm", 0.001),
            ("1.5km", 1500.0),
            ("250ms", 0.25),
            ("2s", 2.0),
            ("3min", 180.0),
            ("8h", 28800.0),
            ("0.3m/s", 0.3),
            ("30CM/S", 0.3),
            ("3.6km/h", 1.0),
            ("750g", 0.75),
            ("2kg", 2.0),
            ("80%", 0.8),
            ("1e3mm", 1.0),
            ("-7cm", -0.07),
            ("0.5rad", 0.5),
            ("0.5rad/s", 0.5),
        ] {
            assert_eq!(float(atom), si, "{atom}");
        }
    }

    #[test]
    fn degrees_hit_the_constants_of_the_circle() {
        for (atom, radians) in [
            ("90deg", PI / 2.0),
            ("180deg", PI),
            ("-45deg", -PI / 4.0),
            ("30deg", PI / 6.0),
            ("60deg", PI / 3.0),
            ("270deg", 3.0 * PI / 2.0),
            ("360deg/s", 2.0 * PI),
        ] {
            assert_eq!(float(atom), radians, "{atom}");
        }
    }

    #[test]
    fn plain_numbers() {
        for (atom, value) in
            [("1.5", 1.5), (".5", 0.5), ("1e3", 1000.0), ("-2.", -2.0), ("+.25", 0.25), ("1E-3", 0.001)]
        {
            assert_eq!(float(atom), value, "{atom}");
        }
        assert_eq!(parse_number("-9223372036854775808"), Ok(NumberLiteral::Int(i64::MIN)));
        assert_eq!(parse_number("+7"), Ok(NumberLiteral::Int(7)));
    }

    #[test]
    fn names_of_functions_are_no_numbers() {
        for atom in ["1+", "1-", "+", "-", "...", "-x", "+.x", "a1", "inf"] {
            assert!(!begins_like_number(atom), "{atom}");
        }
        for atom in ["1", "-1", ".5", "-.5", "3d", "1+2"] {
            assert!(begins_like_number(atom), "{atom}");
        }
    }

    #[test]
    fn what_is_no_number_says_why() {
        for (atom, message, help) in [
            ("3d", "`d` is no unit", "the known units are m cm mm km deg rad s ms min h"),
            ("3metre", "`metre` is no unit", "the known units are"),
            ("90degs", "`degs` is no unit", "did you mean `90deg`?"),
            ("1/2", "begins like a number and is none", "write `(/ 1 2)`"),
            ("1.2.3", "begins like a number and is none", "a name may not begin with a number"),
            ("9223372036854775808", "does not fit in 64 bits", "9223372036854775808.0"),
            ("1e999", "too large for a float", "1.79"),
            ("1e99999999999", "too large for a float", "1.79"),
        ] {
            let Err(error) = parse_number(atom) else { panic!("{atom} reads") };
            assert!(error.message.contains(message), "{atom}: {}", error.message);
            assert!(error.help.contains(help), "{atom}: {}", error.help);
        }
    }

    proptest! {
        #[test]
        fn a_printed_float_reads_back_bit_by_bit(bits: u64) {
            let value = f64::from_bits(bits);
            let text = format_float(value);
            prop_assert!(text.contains('.'));
            prop_assert!(begins_like_number(&text));
            let back = float(&text);
            prop_assert!(back.to_bits() == bits || (value.is_nan() && back.is_nan()), "{}", text);
        }

        #[test]
        fn centimetres_are_the_nearest_float(hundredths in -1_000_000i64..1_000_000) {
            prop_assert_eq!(float(&format!("{hundredths}cm")), hundredths as f64 / 100.0);
        }
    }
}
