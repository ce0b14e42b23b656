//! The clock on the wall, for a run that goes on while something is typed.

use std::time::{Duration, Instant};

/// The longest wait, so that what the prompt shows stays true.
const LONGEST_WAIT: Duration = Duration::from_millis(250);

/// How fast a run goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Seconds of the run for each second on the wall.
    factor: f64,
    began: Instant,
    from_us: u64,
}

impl Clock {
    /// A clock that starts now, at this time of the run.
    pub fn new(factor: f64, now_us: u64) -> Self {
        Self { factor, began: Instant::now(), from_us: now_us }
    }

    /// The same speed from here on: a run that fell behind does not hurry afterwards.
    #[must_use]
    pub fn restarted(self, now_us: u64) -> Self {
        Self::new(self.factor, now_us)
    }

    /// The time of the run that has come.
    pub fn due_us(&self) -> u64 {
        self.from_us + (self.began.elapsed().as_secs_f64() * self.factor * 1e6) as u64
    }

    /// How long to wait for an instant of the run; none if nothing is to come.
    pub fn wait_for(&self, next_us: Option<u64>) -> Duration {
        let Some(next_us) = next_us else { return LONGEST_WAIT };
        let left_us = next_us.saturating_sub(self.due_us()) as f64;
        Duration::from_secs_f64((left_us / 1e6 / self.factor).min(LONGEST_WAIT.as_secs_f64()))
    }
}

/// A factor as it is typed: a number above 0, 1 if nothing is.
pub fn parse_factor(text: &str) -> Option<f64> {
    match text {
        "" => Some(1.0),
        text => text.parse().ok().filter(|factor: &f64| factor.is_finite() && *factor > 0.0),
    }
}
