//! Many numbers in little memory: their moments, and their quantiles.

use super::statistics::{Dispersion, Summary};
use std::collections::BTreeMap;

/// The most numbers that are kept as they are; of more, quantiles are known to a bin.
pub const KEPT: usize = 100_000;

/// Bits of a number that tell its bin: sign, exponent, and ten of the fraction, so that a bin is at most a thousandth
/// of what is in it wide.
const BIN_BITS: u32 = 22;

/// Count, mean and spread of numbers, one after the other (Welford, "Note on a method for calculating corrected sums of
/// squares and products", 1962).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    count: usize,
    mean: f64,
    /// Sum of the squares of the distances from the mean.
    squares: f64,
}

impl Moments {
    /// Takes in a number.
    pub fn add(&mut self, number: f64) {
        self.count += 1;
        let before = number - self.mean;
        self.mean += before / self.count as f64;
        self.squares += before * (number - self.mean);
    }

    fn deviation(&self) -> f64 {
        if self.count > 1 { (self.squares / (self.count - 1) as f64).sqrt() } else { 0.0 }
    }

    /// The mean, and half its 95 % interval; zero of nothing.
    pub fn mean_95(&self) -> (f64, f64) {
        (self.mean, super::statistics::mean_95(self.deviation(), self.count))
    }
}

/// Some numbers. Their quantiles do not depend on their order, nor do their moments but for rounding.
///
/// # Deviation
/// From [`KEPT`] numbers on, quantiles are the middle of a bin of relative width 2⁻¹⁰ (as in Masson, Rim and Lee,
/// "DDSketch", 2019), so that the memory does not grow with the number of runs.
#[derive(Clone, Debug)]
pub enum Numbers {
    /// All of them.
    All(Vec<f64>),
    /// How many there are in each bin.
    Binned {
        /// What they are on the whole.
        moments: Moments,
        /// Their sum.
        total: f64,
        /// The least and the greatest.
        range: (f64, f64),
        /// By the bin, from the least on.
        bins: BTreeMap<u64, usize>,
    },
}

impl Default for Numbers {
    fn default() -> Self {
        Self::All(Vec::new())
    }
}

impl Numbers {
    /// Takes in a number.
    pub fn add(&mut self, number: f64) {
        match self {
            Self::All(numbers) => {
                numbers.push(number);
                if numbers.len() > KEPT {
                    let mut numbers = std::mem::take(numbers);
                    numbers.sort_by(f64::total_cmp);
                    let range = (f64::INFINITY, f64::NEG_INFINITY);
                    let (moments, total, bins) = (Moments::default(), 0.0, BTreeMap::new());
                    *self = Self::Binned { moments, total, range, bins };
                    numbers.into_iter().for_each(|number| self.add(number));
                }
            }
            Self::Binned { moments, total, range, bins } => {
                moments.add(number);
                *total += number;
                *range = (range.0.min(number), range.1.max(number));
                *bins.entry(bin(number)).or_default() += 1;
            }
        }
    }

    /// What they are on the whole; none if there are none.
    pub fn summary(&self) -> Option<Summary> {
        match self {
            Self::All(numbers) => Summary::of(&sorted(numbers)),
            Self::Binned { moments, range: (min, max), .. } => {
                let last = moments.count - 1;
                let median = (self.ranked(last / 2)? + self.ranked(last.div_ceil(2))?) / 2.0;
                let spread =
                    Dispersion { mean: moments.mean, deviation: moments.deviation(), min: *min, median, max: *max };
                Some(Summary { count: moments.count, spread, half_95: moments.mean_95().1 })
            }
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        match self {
            Self::All(numbers) => numbers.len(),
            Self::Binned { moments, .. } => moments.count,
        }
    }

    /// Their sum.
    pub fn total(&self) -> f64 {
        match self {
            Self::All(numbers) => sorted(numbers).iter().sum(),
            Self::Binned { total, .. } => *total,
        }
    }

    /// The number that `tenths` of ten do not exceed; none if there are none.
    pub fn of_ten(&self, tenths: usize) -> Option<f64> {
        self.ranked(self.count() * tenths / 10)
    }

    /// The different numbers, from the least on; none if there are more than this, or they are only known by bins.
    pub fn different(&self, most: usize) -> Option<Vec<f64>> {
        let Self::All(numbers) = self else { return None };
        let mut different = sorted(numbers);
        different.dedup();
        (different.len() <= most).then_some(different)
    }

    /// How many do not exceed a number.
    pub fn up_to(&self, most: f64) -> usize {
        match self {
            Self::All(numbers) => numbers.iter().filter(|&&number| number <= most).count(),
            Self::Binned { bins, .. } => bins.range(..=bin(most)).map(|(_, count)| count).sum(),
        }
    }

    /// The number of a rank, from 0 on.
    fn ranked(&self, rank: usize) -> Option<f64> {
        match self {
            Self::All(numbers) => sorted(numbers).get(rank).copied(),
            Self::Binned { bins, range: (min, max), .. } => {
                let mut below = 0;
                let found = bins.iter().find(|(_, count)| {
                    below += **count;
                    below > rank
                });
                found.map(|(bin, _)| middle(*bin).clamp(*min, *max))
            }
        }
    }
}

fn sorted(numbers: &[f64]) -> Vec<f64> {
    let mut numbers = numbers.to_vec();
    numbers.sort_by(f64::total_cmp);
    numbers
}

/// The bits of a number in the order of the numbers.
fn ordered(number: f64) -> u64 {
    let bits = number.to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

fn bin(number: f64) -> u64 {
    ordered(number) >> (64 - BIN_BITS)
}

fn middle(bin: u64) -> f64 {
    let first = bin << (64 - BIN_BITS);
    // A zero is not blurred: it is what is counted most often.
    if first == 1 << 63 {
        return 0.0;
    }
    let ordered = first | 1 << (63 - BIN_BITS);
    f64::from_bits(if ordered >> 63 == 1 { ordered & !(1 << 63) } else { !ordered })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_random::Stream;

    #[test]
    fn many_numbers_say_what_all_of_them_would() {
        let mut stream = Stream::new(7, "numbers");
        let all: Vec<f64> = (0..KEPT + 50_000).map(|_| (stream.uniform_in(-3.0, 4.0)).powi(3)).collect();
        let (mut forwards, mut backwards) = (Numbers::default(), Numbers::default());
        all.iter().for_each(|&number| forwards.add(number));
        all.iter().rev().for_each(|&number| backwards.add(number));
        assert!(matches!(forwards, Numbers::Binned { .. }));
        let (exact, found) = (Summary::of(&all).expect("numbers"), forwards.summary().expect("numbers"));
        assert_eq!(
            (found.count, found.spread.min, found.spread.max),
            (exact.count, exact.spread.min, exact.spread.max)
        );
        assert!((found.spread.mean - exact.spread.mean).abs() < 1e-9);
        assert!((found.spread.deviation - exact.spread.deviation).abs() < 1e-9);
        assert!((found.spread.median - exact.spread.median).abs() <= 1e-3 * exact.spread.median.abs());
        let ordered = sorted(&all);
        let ninth = ordered[all.len() * 9 / 10];
        assert!((forwards.of_ten(9).expect("numbers") - ninth).abs() <= 1e-3 * ninth.abs());
        let below = all.iter().filter(|&&number| number <= 1.0).count();
        assert!(forwards.up_to(1.0).abs_diff(below) < all.len() / 1000);
        assert_eq!(forwards.of_ten(5), backwards.of_ten(5));
    }

    #[test]
    fn what_is_always_the_same_stays_that() {
        for number in [0.0, -0.0, 1.0, -17.25, 1e300, f64::MIN_POSITIVE] {
            let mut numbers = Numbers::default();
            (0..KEPT + 2).for_each(|_| numbers.add(number));
            let summary = numbers.summary().expect("numbers");
            assert_eq!((summary.spread.median, summary.spread.deviation), (number, 0.0));
            assert_eq!(numbers.of_ten(9), Some(number));
        }
    }
}
