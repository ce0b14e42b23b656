//! Runs that failed: how many of each class, and the first of them by name, so that a million failures need no more
//! memory than a thousand.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Failures that are told one by one.
pub const TOLD: usize = 1_000;

/// Failures that are named in the tables.
const NAMED: usize = 20;

/// A run that failed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FailedRun {
    /// Its seed.
    pub seed: u64,
    /// What went wrong, the class of the failure first.
    pub fault: String,
}

impl FailedRun {
    fn class(&self) -> &str {
        self.fault.split(':').next().unwrap_or_default()
    }
}

/// Runs that failed.
#[derive(Clone, Debug, Default)]
pub struct FailedRuns {
    first: Vec<FailedRun>,
    by_class: BTreeMap<String, usize>,
}

/// Failures of one class.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FailedClass {
    /// The class.
    pub class: String,
    /// How many runs failed so.
    pub runs: usize,
}

impl FailedRuns {
    /// Takes in the next one.
    pub fn add(&mut self, run: FailedRun) {
        match self.by_class.get_mut(run.class()) {
            Some(count) => *count += 1,
            None => _ = self.by_class.insert(run.class().to_string(), 1),
        }
        if self.first.len() < TOLD {
            self.first.push(run);
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.by_class.values().sum()
    }

    /// The first [`TOLD`].
    pub fn told(&self) -> &[FailedRun] {
        &self.first
    }

    /// How many failed in which way, the most frequent class first.
    pub fn classes(&self) -> Vec<FailedClass> {
        let mut classes: Vec<FailedClass> =
            self.by_class.iter().map(|(class, &runs)| FailedClass { class: class.clone(), runs }).collect();
        classes.sort_by_key(|failed| std::cmp::Reverse(failed.runs));
        classes
    }

    /// The first of them as a table names them, by `name`; and how many more there are, by class if those are not
    /// named. None if there is none.
    pub fn sentence(&self, name: impl Fn(&FailedRun) -> &str) -> Option<String> {
        let named: Vec<String> =
            self.first.iter().take(NAMED).map(|run| format!("{} ({})", run.seed, name(run))).collect();
        let more = self.count().saturating_sub(NAMED);
        let more = if more > 0 {
            let classes: Vec<String> =
                self.classes().iter().map(|failed| format!("{} {}", failed.runs, failed.class)).collect();
            format!(", and {more} more; of all: {}", classes.join(", "))
        } else {
            String::new()
        };
        (!named.is_empty()).then(|| named.join(", ") + &more)
    }

    /// The same, each named by its class.
    pub fn seeds_and_classes(&self) -> Option<String> {
        self.sentence(FailedRun::class)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn failed(seeds: impl Iterator<Item = u64>, fault: &str) -> FailedRuns {
        let mut runs = FailedRuns::default();
        seeds.for_each(|seed| runs.add(FailedRun { seed, fault: fault.into() }));
        runs
    }

    #[test]
    fn a_million_failures_are_counted_and_a_thousand_are_told() {
        let mut runs = failed(0..1_000_000, "timeout: after 20 s");
        runs.add(FailedRun { seed: 7, fault: "blocked".into() });
        assert_eq!((runs.count(), runs.told().len()), (1_000_001, TOLD));
        let class = |class: &str, runs| FailedClass { class: class.into(), runs };
        assert_eq!(runs.classes(), [class("timeout", 1_000_000), class("blocked", 1)]);
    }

    #[test]
    fn seeds_that_are_not_named_are_counted_by_class() {
        let told = failed(1..=25, "timeout: after 20 s").seeds_and_classes().expect("all failed");
        assert!(told.starts_with("1 (timeout), "), "{told}");
        assert!(told.ends_with("20 (timeout), and 5 more; of all: 25 timeout"), "{told}");
        assert_eq!(failed(1..=1, "timeout: after 20 s").seeds_and_classes().as_deref(), Some("1 (timeout)"));
        assert_eq!(failed(0..0, "").seeds_and_classes(), None);
    }
}
