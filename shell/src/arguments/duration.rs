//! Times on the command line: `90s`, `5min`, `120`.

use rpl_lang::number::{NumberLiteral, parse_number};
use rpl_runtime::state::time::{LAST_INSTANT_US, microseconds};

/// Units of time among the units of the language.
const UNITS: &[&str] = &["ms", "s", "min", "h"];

/// A time in microseconds; a number without a unit counts seconds.
///
/// # Errors
/// What would be right.
pub fn parse_duration_us(text: &str) -> Result<u64, String> {
    const EXPECTED: &str = "a time such as 90s, 5min, 2h or 250ms is expected";
    let text = text.trim();
    let unit = text.trim_start_matches(|c: char| c.is_ascii_digit() || matches!(c, '.' | '+'));
    if text.len() == unit.len() || !(unit.is_empty() || UNITS.contains(&unit)) {
        return Err(EXPECTED.to_string());
    }
    let seconds = match parse_number(text) {
        Ok(NumberLiteral::Int(value)) => value as f64,
        Ok(NumberLiteral::Float(value)) => value,
        Err(_) => return Err(EXPECTED.to_string()),
    };
    microseconds(seconds).ok_or_else(|| format!("the clock ends at {} s, after 253 years", LAST_INSTANT_US / 1_000_000))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_carry_units_of_time_only() {
        assert_eq!(parse_duration_us("90s"), Ok(90_000_000));
        assert_eq!(parse_duration_us("5min"), Ok(300_000_000));
        assert_eq!(parse_duration_us("120"), Ok(120_000_000));
        assert_eq!(parse_duration_us("1.5"), Ok(1_500_000));
        assert_eq!(parse_duration_us("250ms"), Ok(250_000));
        for wrong in ["", "s", "-5s", "5m", "5 apples", "1e400", "soon", "10000000000s", "99999999999999999999.0"] {
            assert!(parse_duration_us(wrong).is_err(), "{wrong}");
        }
    }
}
