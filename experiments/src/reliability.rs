//! What a certainty is worth: of all moments at which the robot says 0.8, it should be right in 80 %.

use rpl_robot::localization::Calibration;
use rpl_shell::terminal::table::Table;
use serde::Serialize;

/// Bins of the reliability diagram, all with the same number of moments.
const BINS: usize = 10;

/// Certainties from here on are left out of the bins: there are so many that they would fill them.
pub const SURE: f64 = 0.99;

/// A moment at which a robot says where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged {
    /// What it belongs to, such as a run: moments of one group depend on each other.
    pub group: usize,
    /// How certain it is.
    pub certainty: f64,
    /// Whether it is right.
    pub is_right: bool,
}

/// Moments of one group that are counted together, because the robot says about the same at all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Counted {
    /// What they belong to.
    pub group: usize,
    /// How certain it is, on average.
    pub certainty: f64,
    /// At how many it is right.
    pub right: usize,
    /// How many there are; at least one.
    pub moments: usize,
}

impl From<Judged> for Counted {
    fn from(Judged { group, certainty, is_right }: Judged) -> Self {
        Self { group, certainty, right: usize::from(is_right), moments: 1 }
    }
}

/// Some moments of about the same certainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// How many.
    pub samples: usize,
    /// Smallest and largest certainty.
    pub range: (f64, f64),
    /// Mean certainty.
    pub said: f64,
    /// Share of moments at which the estimate was right.
    pub was: f64,
    /// 95 % interval of that share, over groups.
    #[serde(rename = "interval_95")]
    pub interval: (f64, f64),
}

impl Bin {
    /// Of moments from the least certain on; there is one at least.
    fn of(counts: &[Counted]) -> Self {
        let samples = moments(counts);
        let sum = |of: fn(&Counted) -> f64| counts.iter().map(of).sum::<f64>() / samples as f64;
        let said = sum(|counted| counted.certainty * counted.moments as f64);
        let was = sum(|counted| counted.right as f64);
        let half = 1.96 * deviation_of_share(counts, was);
        let end = |counted: Option<&Counted>| counted.map_or(0.0, |counted| counted.certainty);
        Self {
            samples,
            range: (end(counts.first()), end(counts.last())),
            said,
            was,
            interval: ((was - half).max(0.0), (was + half).min(1.0)),
        }
    }

    /// How far the certainty is from the truth.
    pub fn error(&self) -> f64 {
        self.said - self.was
    }
}

/// The bins of moments that are not sure, from the least certain on.
pub fn bins<C: Into<Counted>>(counts: impl IntoIterator<Item = C>) -> Vec<Bin> {
    let mut unsure: Vec<Counted> = counts.into_iter().map(C::into).filter(|counted| counted.certainty < SURE).collect();
    unsure.sort_by(|a, b| a.certainty.total_cmp(&b.certainty));
    let size = moments(&unsure).div_ceil(BINS).max(1);
    in_chunks(&unsure, size).into_iter().map(Bin::of).collect()
}

fn moments(counts: &[Counted]) -> usize {
    counts.iter().map(|counted| counted.moments).sum()
}

/// Neighbours together, cut where the count of all moments up to there comes to the next multiple of a size.
fn in_chunks(counts: &[Counted], size: usize) -> Vec<&[Counted]> {
    let (mut chunks, mut first, mut count, mut next) = (Vec::new(), 0, 0, size);
    for (at, counted) in counts.iter().enumerate() {
        count += counted.moments;
        if count >= next {
            chunks.push(&counts[first..=at]);
            (first, next) = (at + 1, (count / size + 1) * size);
        }
    }
    if first < counts.len() {
        chunks.push(&counts[first..]);
    }
    chunks
}

/// Standard deviation of a share, with groups as clusters: the root of the sum over groups of squared
/// sums of residuals, by the number of moments.
fn deviation_of_share(counts: &[Counted], share: f64) -> f64 {
    let residual = |counted: &Counted| (counted.group, counted.right as f64 - share * counted.moments as f64);
    let mut by_group: Vec<(usize, f64)> = counts.iter().map(residual).collect();
    by_group.sort_by_key(|&(group, _)| group);
    let squares: f64 = by_group
        .chunk_by(|a, b| a.0 == b.0)
        .map(|group| group.iter().map(|&(_, residual)| residual).sum::<f64>().powi(2))
        .sum();
    squares.sqrt() / moments(counts) as f64
}

/// The largest difference between what was said and what was right, over the bins.
pub fn largest_error(bins: &[Bin]) -> f64 {
    bins.iter().map(|bin| bin.error().abs()).fold(0.0, f64::max)
}

/// The bins as a table.
pub fn table(bins: &[Bin]) -> Table {
    let mut table = Table::new(&["samples", "certainty", "mean", "right", "error", "95 % interval"]);
    for bin in bins {
        table.row([
            bin.samples.to_string(),
            format!("{:.3}–{:.3}", bin.range.0, bin.range.1),
            format!("{:.3}", bin.said),
            format!("{:.3}", bin.was),
            format!("{:+.3}", bin.error()),
            format!("{:.3}–{:.3}", bin.interval.0, bin.interval.1),
        ]);
    }
    table
}

/// Moments that are counted together when a calibration is fitted.
const GROUP: usize = 100;

/// Two knots of a fitted calibration are at least so far apart, in nats of log odds.
const KNOTS_APART: f64 = 0.25;

/// Moments around one share of the belief.
#[derive(Clone, Copy)]
struct Pool {
    /// Sum of the shares.
    shares: f64,
    /// How many estimates were right.
    right: f64,
    /// How many there are.
    moments: f64,
}

impl Pool {
    fn and(self, other: Self) -> Self {
        Self {
            shares: self.shares + other.shares,
            right: self.right + other.right,
            moments: self.moments + other.moments,
        }
    }

    fn rate(self) -> f64 {
        (self.right + 0.5) / (self.moments + 1.0)
    }
}

/// The knots of the monotone calibration that fits these moments best, which were judged with `used`:
/// pools of adjacent moments that would violate the order are merged (pool adjacent violators).
pub fn fitted<C: Into<Counted>>(counts: impl IntoIterator<Item = C>, used: &Calibration) -> Vec<[f64; 2]> {
    let share = |counted: Counted| Counted { certainty: used.share(counted.certainty), ..counted };
    let mut shares: Vec<Counted> = counts.into_iter().map(C::into).map(share).collect();
    shares.sort_by(|a, b| a.certainty.total_cmp(&b.certainty));
    let pools = in_chunks(&shares, GROUP).into_iter().map(|group| Pool {
        shares: group.iter().map(|counted| counted.certainty * counted.moments as f64).sum(),
        right: group.iter().map(|counted| counted.right as f64).sum(),
        moments: moments(group) as f64,
    });
    let in_order = pooled(pools, |last, next| last.rate() < next.rate());
    let log_odds = |pool: Pool| (pool.rate() / (1.0 - pool.rate())).ln();
    let apart = pooled(in_order.into_iter(), |last, next| log_odds(next) - log_odds(last) >= KNOTS_APART);
    apart.into_iter().map(|pool| [pool.shares / pool.moments, pool.rate()]).collect()
}

/// Merges neighbours until all of them pass.
fn pooled(pools: impl Iterator<Item = Pool>, passes: impl Fn(Pool, Pool) -> bool) -> Vec<Pool> {
    let mut kept: Vec<Pool> = Vec::new();
    for mut next in pools {
        while let Some(last) = kept.pop_if(|last| !passes(*last, next)) {
            next = last.and(next);
        }
        kept.push(next);
    }
    kept
}

/// Fitted knots, as the text of a list.
pub fn knots_text(knots: &[[f64; 2]]) -> String {
    let knots: Vec<String> = knots.iter().map(|[share, rate]| format!("[{share:.5}, {rate:.4}]")).collect();
    let lines: Vec<String> = knots.chunks(4).map(|knots| format!("    {},", knots.join(", "))).collect();
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged((certainty, is_right): (f64, bool)) -> Judged {
        Judged { group: 0, certainty, is_right }
    }

    #[test]
    fn bins_have_equal_mass_and_a_robot_that_is_right_as_often_as_it_says_has_no_error() {
        // Of the moments with certainty c every (1/c)-th is wrong: 0.5 and 0.75, 400 each.
        let of = |certainty: f64, every: usize| (0..400).map(move |n| (certainty, n % every != 0));
        let bins = bins(of(0.5, 2).chain(of(0.75, 4)).chain((0..50).map(|_| (0.999, true))).map(judged));
        assert_eq!(bins.len(), BINS);
        assert!(bins.iter().all(|bin| bin.samples == 80));
        assert!(bins.iter().all(|bin| bin.error().abs() < 1e-6), "{bins:?}");
    }

    #[test]
    fn a_robot_that_is_always_wrong_errs_by_what_it_says() {
        let bins = bins((0..100).map(|n| judged((f64::from(n) / 200.0, false))));
        assert!(bins.iter().all(|bin| bin.error() == bin.said && bin.was == 0.0));
        let largest = largest_error(&bins);
        assert!((0.47..0.48).contains(&largest), "{largest}");
    }

    #[test]
    fn moments_of_one_group_tell_as_much_as_one() {
        // Ten groups, right in nine: the deviation is that of ten moments, however many each group has.
        let moments = (0..1000).map(|n| Judged { group: n / 100, certainty: 0.9, is_right: n >= 100 });
        let moments: Vec<Counted> = moments.map(Counted::from).collect();
        assert!((deviation_of_share(&moments, 0.9) - (0.9f64 * 0.1 / 10.0).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn moments_that_are_counted_together_tell_the_same_as_one_by_one() {
        let of =
            |group: usize, certainty: f64, right: usize, moments: usize| Counted { group, certainty, right, moments };
        let counts = [of(0, 0.2, 30, 100), of(1, 0.2, 10, 100), of(0, 0.6, 50, 100), of(1, 0.6, 70, 100)];
        let singly = || {
            counts.into_iter().flat_map(|Counted { group, certainty, right, moments }| {
                (0..moments).map(move |n| Judged { group, certainty, is_right: n < right })
            })
        };
        let (together, alone) = (Bin::of(&counts), Bin::of(&singly().map(Counted::from).collect::<Vec<_>>()));
        assert_eq!((together.samples, together.range, together.was), (alone.samples, alone.range, alone.was));
        assert!((together.said - alone.said).abs() < 1e-12 && (together.interval.0 - alone.interval.0).abs() < 1e-12);
        let used = Calibration::new(&[[0.2, 0.3], [0.5, 0.7], [0.95, 0.96]]);
        let (together, alone) = (fitted(counts, &used), fitted(singly(), &used));
        assert_eq!(together.len(), alone.len(), "{together:?} {alone:?}");
        for (one, other) in together.iter().zip(&alone) {
            assert!((one[0] - other[0]).abs() < 1e-9 && (one[1] - other[1]).abs() < 1e-9, "{together:?} {alone:?}");
        }
    }

    #[test]
    fn the_fit_finds_how_often_a_share_is_right_whatever_was_in_use() {
        // Shares of 0.2, 0.5 and 0.9 are right every fourth, every second and nine times in ten.
        let used = Calibration::new(&[[0.2, 0.3], [0.5, 0.7], [0.95, 0.96]]);
        let of = |share: f64, right_of_20: usize| {
            let certainty = used.certainty(share);
            (0..2000).map(move |n| (certainty, n % 20 < right_of_20))
        };
        let knots = fitted(of(0.2, 5).chain(of(0.5, 10)).chain(of(0.9, 18)).map(judged), &used);
        assert_eq!(knots.len(), 3, "{knots:?}");
        for (knot, expected) in knots.iter().zip([[0.2, 0.25], [0.5, 0.5], [0.9, 0.9]]) {
            assert!((knot[0] - expected[0]).abs() < 1e-9 && (knot[1] - expected[1]).abs() < 1e-3, "{knots:?}");
        }
    }
}
