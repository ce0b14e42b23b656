//! Times as plans give them: seconds, which become microseconds of virtual time.

use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::time::{LAST_INSTANT_US, microseconds, seconds};
use crate::state::value::Value;
use rpl_lang::kind::Kind;
use rpl_lang::number::format_float;

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

    /// The instant a number of seconds from now; what lies before now is now.
    ///
    /// # Errors
    /// A `type-error` if it is no number, an `arithmetic-error` if the clock does not go so far.
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
