//! The mean of the last readings of each sonar.

use serde::{Deserialize, Serialize};

/// Readings of a sonar that are averaged (Fox and Anderson-Sprecher, RUPART Architecture).
pub const READINGS_AVERAGED: usize = 5;

/// The last readings of each sonar. Readings, not steps: in doorways the sonars fire in every fourth step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RecentSonars {
    /// For each sonar its last readings, the oldest first; at most [`READINGS_AVERAGED`].
    readings_m: Vec<Vec<f64>>,
}

impl RecentSonars {
    /// Takes what the sonars measured: one entry for each, none for those that did not fire. Another number
    /// of sonars than before begins anew.
    pub fn hear(&mut self, readings_m: &[Option<f64>]) {
        if readings_m.len() != self.readings_m.len() {
            self.readings_m = vec![Vec::new(); readings_m.len()];
        }
        for (recent_m, reading_m) in self.readings_m.iter_mut().zip(readings_m) {
            let Some(reading_m) = *reading_m else { continue };
            if recent_m.len() == READINGS_AVERAGED {
                recent_m.remove(0);
            }
            recent_m.push(reading_m);
        }
    }

    /// What each sonar measured last; none before all of them have fired.
    pub fn last_m(&self) -> Option<Vec<f64>> {
        self.of_each(|recent_m| recent_m.last().copied())
    }

    /// The mean of the last readings of each sonar; none before all of them have fired.
    pub fn mean_m(&self) -> Option<Vec<f64>> {
        self.of_each(|recent_m| {
            let sum_m: f64 = recent_m.iter().sum();
            (!recent_m.is_empty()).then(|| sum_m / recent_m.len() as f64)
        })
    }

    fn of_each(&self, of: impl Fn(&[f64]) -> Option<f64>) -> Option<Vec<f64>> {
        let all: Option<Vec<f64>> = self.readings_m.iter().map(|recent_m| of(recent_m)).collect();
        all.filter(|all| !all.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_without_a_reading_do_not_count() {
        let mut recent = RecentSonars::default();
        assert_eq!(recent.mean_m(), None);
        recent.hear(&[Some(1.0), None]);
        assert_eq!(recent.last_m(), None, "the second has not fired yet");
        for reading_m in 1..=6 {
            recent.hear(&[None, Some(f64::from(reading_m))]);
            recent.hear(&[None, None]);
        }
        assert_eq!(recent.last_m(), Some(vec![1.0, 6.0]));
        assert_eq!(recent.mean_m(), Some(vec![1.0, 4.0]), "of 2 to 6");
        recent.hear(&[Some(2.0)]);
        assert_eq!(recent.mean_m(), Some(vec![2.0]), "another ring of sonars");
    }
}
