//! `--shard I/K`: the I-th of K stretches of the runs.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// More shards than this are more than any batch system takes.
const MOST: u32 = 10_000_000;

/// The I-th of K stretches of the runs, which differ by at most one in length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 1 on.
    pub number: u32,
    /// How many there are.
    pub of: u32,
}

impl Shard {
    /// The only one.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// The numbers of its runs, of `runs` runs.
    pub fn runs(self, runs: u32) -> Range<u64> {
        let begins = |shard: u32| u64::from(shard) * u64::from(runs) / u64::from(self.of);
        begins(self.number - 1)..begins(self.number)
    }

    /// The one, of `of` shards, that has a run of `runs`.
    pub fn with(run: u64, runs: u32, of: u32) -> Self {
        // The last shard that begins at this run or before: ⌊n · runs / of⌋ ≤ run.
        let before = ((run + 1) * u64::from(of) - 1) / u64::from(runs.max(1));
        Self { number: u32::try_from(before).unwrap_or(of).min(of - 1) + 1, of }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        let shard = numbers.map(|(number, of)| Self { number, of });
        let is_one = |shard: &Self| (1..=shard.of).contains(&shard.number) && shard.of <= MOST;
        shard.filter(is_one).ok_or_else(|| {
            "a number and how many there are is expected, such as 3/8: the third of eight; the first is 1/8".to_string()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_is_in_one_shard() {
        for (runs, of) in [(20, 3), (3, 20), (1, 1), (10_000_000, 4_999)] {
            let shards: Vec<Range<u64>> = (1..=of).map(|number| Shard { number, of }.runs(runs)).collect();
            assert_eq!((shards[0].start, shards[shards.len() - 1].end), (0, u64::from(runs)));
            assert!(shards.windows(2).all(|pair| pair[0].end == pair[1].start), "{runs}/{of}");
            for shard in (1..=of).step_by(7).map(|number| Shard { number, of }) {
                let Range { start, end } = shard.runs(runs);
                assert!(
                    [start, end.saturating_sub(1)]
                        .iter()
                        .all(|&run| start == end || Shard::with(run, runs, of) == shard)
                );
            }
        }
    }

    #[test]
    fn shards_are_counted_from_1() {
        assert_eq!("3/8".parse(), Ok(Shard { number: 3, of: 8 }));
        for wrong in ["0/8", "9/8", "3", "3/0", "-1/8", "3/8/2", "", "1/99999999999"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
