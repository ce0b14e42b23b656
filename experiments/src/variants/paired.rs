//! Variants beside the first one, seed by seed: what a variant changes is told better by runs that share their chance.

use crate::kind::Tally;
use crate::quantity::{Quantity, as_name};
use crate::row_result::RowTally;
use crate::statistics::{Summary, paired_difference_95};
use crate::trial::MissionTrial;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::Serialize;
use std::collections::BTreeMap;

/// What is kept of the runs of a variant: figures on the whole, and, where variants are compared, those of each seed.
#[derive(Default)]
pub struct VariantTally {
    /// On the whole.
    pub row: RowTally,
    /// Run by run; none where there is nothing to compare with.
    runs: Option<SeedRuns>,
}

impl VariantTally {
    /// Of no runs yet, of one of several variants or of the only one.
    pub fn new(is_compared: bool) -> Self {
        Self { runs: is_compared.then(SeedRuns::default), ..Self::default() }
    }
}

/// Runs by their seeds. It takes 8 bytes for each number that was measured.
#[derive(Default)]
struct SeedRuns {
    quantities: Vec<Quantity>,
    runs: BTreeMap<u64, SeedRun>,
}

/// What was measured with a seed.
struct SeedRun {
    /// Whether it succeeded, if it counts.
    succeeded: Option<bool>,
    /// In the order of the quantities, as far as there were any when it ended; what was not measured is not a number.
    measures: Box<[f64]>,
}

impl SeedRun {
    fn measure(&self, at: usize) -> Option<f64> {
        self.measures.get(at).copied().filter(|number| !number.is_nan())
    }
}

impl Tally<MissionTrial> for VariantTally {
    fn add(&mut self, trial: MissionTrial) {
        if let Some(SeedRuns { quantities, runs }) = &mut self.runs {
            for (quantity, _) in &trial.measures {
                if !quantities.contains(quantity) {
                    quantities.push(quantity.clone());
                }
            }
            let succeeded = trial.is_measured().then(|| trial.succeeded());
            let measures = quantities.iter().map(|quantity| trial.measure(quantity).unwrap_or(f64::NAN)).collect();
            runs.insert(trial.seed, SeedRun { succeeded, measures });
        }
        self.row.add(trial);
    }
}

/// How a variant differs from the first one.
#[derive(Clone, Debug, Serialize)]
pub struct PairedDifferences {
    /// The variant.
    pub name: String,
    /// The first one.
    pub against: String,
    /// By how much the share of runs that succeed is larger.
    pub succeeded: PairedShares,
    /// By how much quantities are larger.
    pub measures: Vec<PairedMeasure>,
}

/// By how much the share of runs that succeed is larger.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PairedShares {
    /// Seeds with which both count.
    pub pairs: usize,
    /// With how many this one succeeds alone.
    pub gained: usize,
    /// With how many the first one succeeds alone.
    pub lost: usize,
    /// The difference of the shares, if there are pairs.
    pub difference: Option<f64>,
    /// Its 95 % interval.
    pub interval_95: (f64, f64),
}

/// By how much a quantity is larger, in runs with the same seed that both have it.
#[derive(Clone, Debug, Serialize)]
pub struct PairedMeasure {
    /// What was measured.
    #[serde(rename = "name", serialize_with = "as_name")]
    pub quantity: Quantity,
    /// The differences.
    #[serde(flatten)]
    pub difference: Summary,
}

impl PairedShares {
    fn of(pairs: impl Iterator<Item = (bool, bool)>) -> Self {
        let (mut all, mut gained, mut lost) = (0, 0, 0);
        for (first, other) in pairs {
            all += 1;
            gained += usize::from(other && !first);
            lost += usize::from(first && !other);
        }
        let difference = (all > 0).then(|| (gained as f64 - lost as f64) / all as f64);
        Self { pairs: all, gained, lost, difference, interval_95: paired_difference_95(gained, lost, all) }
    }
}

impl PairedDifferences {
    /// Of all variants but the first, from the first. Cost: the numbers that were measured.
    pub fn of(names: &[String], tallies: &[VariantTally]) -> Vec<Self> {
        let mut runs = names.iter().zip(tallies).filter_map(|(name, tally)| Some((name, tally.runs.as_ref()?)));
        let Some((against, first)) = runs.next() else { return Vec::new() };
        runs.map(|(name, other)| Self::between(name, other, against, first)).collect()
    }

    fn between(name: &str, other: &SeedRuns, against: &str, first: &SeedRuns) -> Self {
        let pairs: Vec<(&SeedRun, &SeedRun)> =
            first.runs.iter().filter_map(|(seed, run)| Some((run, other.runs.get(seed)?))).collect();
        let both = |&(first, other): &(&SeedRun, &SeedRun)| Some((first.succeeded?, other.succeeded?));
        let measure = |(at, quantity): (usize, &Quantity)| {
            let there = other.quantities.iter().position(|known| known == quantity)?;
            let differences: Vec<f64> =
                pairs.iter().filter_map(|(first, other)| Some(other.measure(there)? - first.measure(at)?)).collect();
            Some(PairedMeasure { quantity: quantity.clone(), difference: Summary::of(&differences)? })
        };
        Self {
            name: name.to_string(),
            against: against.to_string(),
            succeeded: PairedShares::of(pairs.iter().filter_map(both)),
            measures: first.quantities.iter().enumerate().filter_map(measure).collect(),
        }
    }

    /// The differences as a table.
    pub fn blocks(&self) -> Vec<Block> {
        let mut table = Table::new(&["", "pairs", "difference", "95 % interval"]);
        let PairedShares { pairs, difference, interval_95: (low, high), .. } = self.succeeded;
        let percent = |share: f64| format!("{:+.1} %", 100.0 * share);
        table.row([
            "succeeded".to_string(),
            pairs.to_string(),
            difference.map_or(NOTHING.to_string(), percent),
            format!("{:+.1} to {:+.1} %", 100.0 * low, 100.0 * high),
        ]);
        for PairedMeasure { quantity, difference: Summary { count, spread, half_95 } } in &self.measures {
            let (mean, low, high) = (spread.mean, spread.mean - half_95, spread.mean + half_95);
            // One pair tells nothing of how others differ.
            let interval = if *count > 1 { format!("{low:+.2} to {high:+.2}") } else { NOTHING.to_string() };
            table.row([quantity.name().to_string(), count.to_string(), format!("{mean:+.2}"), interval]);
        }
        let head = format!("{} beside {}, seed by seed: by how much it is more", self.name, self.against);
        vec![Block::Lines(String::new()), Block::Lines(head), Block::Table(table)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::ErrorTrack;

    fn trial(seed: u64, time_s: f64, is_over: bool, rooms: Option<f64>) -> MissionTrial {
        let own = rooms.map(|rooms| (Quantity::Own("rooms".to_string()), Some(rooms)));
        MissionTrial {
            seed,
            fault: (!is_over).then(|| "blocked".to_string()),
            unmeasured: None,
            value: None,
            measures: [(Quantity::Time, Some(time_s))].into_iter().chain(own).collect(),
            error: ErrorTrack::default(),
            samples: vec![],
        }
    }

    #[test]
    fn runs_are_paired_by_their_seeds_and_not_by_their_order() {
        let (mut first, mut other) = (VariantTally::new(true), VariantTally::new(true));
        [(1, 100.0), (2, 500.0), (3, 900.0)]
            .into_iter()
            .for_each(|(seed, time_s)| first.add(trial(seed, time_s, true, None)));
        [(3, 890.0), (2, 490.0), (7, 0.0)]
            .into_iter()
            .for_each(|(seed, time_s)| other.add(trial(seed, time_s, seed != 2, Some(4.0))));
        let names = ["first", "other"].map(str::to_string);
        let found = PairedDifferences::of(&names, &[first, other]);
        let [PairedDifferences { succeeded, measures, .. }] = &found[..] else { panic!("one pair of variants") };
        assert_eq!((succeeded.pairs, succeeded.gained, succeeded.lost), (2, 0, 1));
        // What both have alone is compared; chance that both share leaves no spread.
        let [PairedMeasure { quantity: Quantity::Time, difference }] = &measures[..] else { panic!("{measures:?}") };
        assert_eq!((difference.count, difference.spread.mean, difference.spread.deviation), (2, -10.0, 0.0));
    }
}
