//! What a retrieval finds, and why.

use super::number::CaseNumber;
use crate::case::Kind;
use crate::situation::Feature;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::fmt;

/// The most similar case, and those that come next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Retrieval {
    /// The most similar.
    pub best: Match,
    /// The others, the most similar first.
    pub runners_up: Vec<Match>,
}

/// A case, and how far from the situation it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Match {
    /// Of the case.
    pub number: CaseNumber,
    /// Of the case.
    pub kind: Kind,
    /// The sum of the contributions.
    pub distance: f64,
    /// What each feature adds, weighted, in the order of [`Feature::ALL`].
    pub contributions: [f64; Feature::COUNT],
}

impl fmt::Display for Match {
    /// The case, its distance, and what adds to it, the most first.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "case {} ({}), distance {:.3}", self.number, self.kind.name(), self.distance)?;
        let mut parts: Vec<(Feature, f64)> = Feature::ALL.into_iter().zip(self.contributions).collect();
        parts.retain(|(_, contribution)| *contribution > 0.0);
        parts.sort_by(|one, other| other.1.total_cmp(&one.1));
        for (index, (feature, contribution)) in parts.into_iter().enumerate() {
            write!(out, "{}{} {contribution:.3}", if index == 0 { ": " } else { ", " }, feature.name())?;
        }
        Ok(())
    }
}

/// The best cases that were offered so far.
pub(super) struct Best {
    /// By distance and then by number; at most `count`.
    found: Vec<(f64, CaseNumber)>,
    count: usize,
}

impl Best {
    /// Keeps the best `count`, at least 1.
    pub(super) fn new(count: usize) -> Self {
        Self { found: Vec::with_capacity(count + 1), count }
    }

    /// A case that is farther off is not among them.
    pub(super) fn worst(&self) -> f64 {
        if self.found.len() < self.count { f64::INFINITY } else { self.found[self.count - 1].0 }
    }

    pub(super) fn offer(&mut self, distance: f64, number: CaseNumber) {
        let is_before = |one: &(f64, CaseNumber)| one.0.total_cmp(&distance).then(one.1.cmp(&number)) == Ordering::Less;
        let place = self.found.partition_point(is_before);
        if place < self.count {
            self.found.insert(place, (distance, number));
            self.found.truncate(self.count);
        }
    }

    /// The cases that were found.
    pub(super) fn numbers(&self) -> impl Iterator<Item = CaseNumber> {
        self.found.iter().map(|(_, number)| *number)
    }

    /// What was found, with the kind and the contributions of each case.
    pub(super) fn retrieval(
        self,
        explained: impl Fn(CaseNumber) -> Option<(Kind, [f64; Feature::COUNT])>,
    ) -> Option<Retrieval> {
        let mut matches = self.found.into_iter().filter_map(|(distance, number)| {
            let (kind, contributions) = explained(number)?;
            Some(Match { number, kind, distance, contributions })
        });
        Some(Retrieval { best: matches.next()?, runners_up: matches.collect() })
    }
}
