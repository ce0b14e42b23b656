//! The race of several plans with one: all are run on the same streams, and those that are not better drop out, so
//! that the runs go to the plans between which the choice lies.

use crate::run::paired::{Paired, Verdict};
use crate::run::projection_record::Projection;
use crate::state::figures::Comparison;
use crate::state::projected::{Question, Stake};

/// The plans of a question, by number. The first is the one that the others are compared with.
pub(crate) struct Race {
    stake: Option<Stake>,
    /// Those that still run.
    runners: Vec<usize>,
    others: Vec<Other>,
}

/// What is known of one of the others.
#[derive(Clone, Copy)]
struct Other {
    verdict: Verdict,
    /// Nothing was left to chance in it and in the first one.
    is_certain: bool,
}

impl Race {
    /// All plans run.
    pub fn new(plans: usize, question: &Question) -> Self {
        let others = vec![Other { verdict: Verdict::Open, is_certain: false }; plans.saturating_sub(1)];
        Self { stake: question.stake, runners: (0..plans).collect(), others }
    }

    /// The plans that run on, the first one before all others.
    pub fn runners(&self) -> &[usize] {
        &self.runners
    }

    /// Looks at how those that run do, each with as many runs as the others: who is not better drops out. Whether
    /// the race is over; without a stake it is when the last runs are made.
    pub fn look(&mut self, projections: &[Projection], is_last: bool) -> bool {
        let Some(stake) = self.stake else { return is_last };
        // What is rare may decide, and runs that have not met it are all the same.
        let paired = |plan: usize, than: usize| {
            let gains = projections[plan].gains_over(&projections[than], stake.worth);
            if is_last { Paired::of(&gains) } else { Paired::with_unseen(&gains) }
        };
        for &plan in &self.runners[1..] {
            let verdict = paired(plan, 0).verdict(stake.margin, stake.standard_errors);
            let is_certain = projections[0].is_certain() && projections[plan].is_certain();
            self.others[plan - 1] = Other { verdict, is_certain };
        }
        let mut ahead: Vec<usize> = self.runners[1..]
            .iter()
            .copied()
            .filter(|plan| self.others[plan - 1].verdict != Verdict::NotBetter)
            .collect();
        let leader = ahead.iter().copied().max_by(|&a, &b| {
            let mean = |plan: usize| paired(plan, 0).mean;
            // Of those that do alike, the first.
            mean(a).total_cmp(&mean(b)).then(b.cmp(&a))
        });
        if let Some(leader) = leader {
            let is_behind =
                |plan: usize| paired(plan, leader).verdict(0.0, stake.standard_errors) == Verdict::NotBetter;
            ahead.retain(|&plan| plan == leader || !is_behind(plan));
        }
        let is_decided = ahead.iter().all(|plan| self.others[plan - 1].verdict == Verdict::Better) && ahead.len() < 2;
        self.runners.truncate(1);
        self.runners.append(&mut ahead);
        is_last || is_decided
    }

    /// How each of the others did, by the runs it made.
    pub fn comparisons(&self, projections: &[Projection]) -> Vec<Comparison> {
        let Some(stake) = self.stake else { return Vec::new() };
        let others = self.others.iter().zip(&projections[1..]);
        others
            .map(|(other, projection)| {
                let Paired { mean, error, .. } = Paired::of(&projection.gains_over(&projections[0], stake.worth));
                Comparison {
                    difference: mean,
                    error,
                    is_better: other.verdict == Verdict::Better,
                    is_certain: other.is_certain,
                    runs: projection.runs.len() as u32,
                }
            })
            .collect()
    }
}
