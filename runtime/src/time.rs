//! Times as plans give them: seconds, which become microseconds of virtual time.

use crate::failure::Raise;
use crate::machine::Machine;
use crate::value::Value;
use rpl_lang::kind::Kind;
use rpl_lang::number::format_float;

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

impl Machine {
    /// The instant at a time since the start. `what` names the value in errors.
    ///
    /// # Errors
    /// A `type-error` if it is no number, an `arithmetic-error` if the clock does not go so far.
    pub(crate) fn instant_at(&self, value: Value, what: impl Fn() -> String) -> Result<u64, Raise> {
        match seconds(value).map(microseconds) {
            Some(Some(time_us)) => Ok(time_us),
            _ => Err(self.wrong_time(value, &what())),
        }
    }

    /// The instant so many seconds from now; what lies before now is now.
    ///
    /// # Errors
    /// As for [`Machine::instant_at`].
    pub fn instant_after(&self, value: Value, what: impl Fn() -> String) -> Result<u64, Raise> {
        let time_us = self.instant_at(value, &what)?;
        let instant_us = self.now_us.checked_add(time_us).filter(|&instant_us| instant_us <= LAST_INSTANT_US);
        instant_us.ok_or_else(|| self.wrong_time(value, &what()))
    }

    #[cold]
    fn wrong_time(&self, value: Value, what: &str) -> Raise {
        match seconds(value) {
            Some(seconds) => beyond_clock(what, seconds),
            None => self.wrong_type(what, Kind::Seconds.noun(), value),
        }
    }
}

fn beyond_clock(what: &str, seconds: f64) -> Raise {
    let message = format!(
        "{what} is {}, and the clock ends at {} s, after 253 years; to wait without an end, wait for a fluent that \
         stays nil",
        format_float(seconds),
        LAST_INSTANT_US / 1_000_000
    );
    Raise::new("arithmetic-error", message)
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
