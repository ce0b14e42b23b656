//! Virtual time, in microseconds.

use crate::state::value::Value;

/// The last instant of the clock, after some 253 years. Up to 2³³ seconds floats are less than a
/// microsecond apart, so that every instant is exact in seconds: in plans, traces and records.
pub const LAST_INSTANT_US: u64 = 8_000_000_000_000_000;

/// Seconds as microseconds, to the nearest, those before the start as 0; none behind the end of the
/// clock and for what is no number.
pub fn microseconds(seconds: f64) -> Option<u64> {
    let time_us = libm::round(seconds * 1e6);
    (time_us <= LAST_INSTANT_US as f64).then_some(time_us.max(0.0) as u64)
}

/// Seconds that a plan gives; none for what is no number.
pub(crate) fn seconds(value: Value) -> Option<f64> {
    value.as_f64().filter(|seconds| !seconds.is_nan())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_rounded_and_never_cut() {
        assert_eq!(microseconds(1.25), Some(1_250_000));
        assert_eq!(microseconds(4e-7), Some(0));
        assert_eq!(microseconds(-3.0), Some(0));
        assert_eq!(microseconds(f64::NEG_INFINITY), Some(0));
        assert_eq!(microseconds(8e9), Some(LAST_INSTANT_US));
        for never in [8.1e9, 1e300, f64::INFINITY, f64::NAN] {
            assert_eq!(microseconds(never), None, "{never}");
        }
    }

    #[test]
    fn every_instant_is_exact_in_seconds() {
        for time_us in [LAST_INSTANT_US, LAST_INSTANT_US - 1, LAST_INSTANT_US / 3, 1] {
            assert_eq!(microseconds(time_us as f64 / 1e6), Some(time_us));
        }
    }
}
