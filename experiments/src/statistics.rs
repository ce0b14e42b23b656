//! Intervals and moments of a few numbers.

use serde::Serialize;

/// Mean, standard deviation, range and median of some numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Dispersion {
    /// Arithmetic mean.
    pub mean: f64,
    /// Standard deviation of the sample (n − 1); 0 for a single number.
    pub deviation: f64,
    /// Smallest.
    pub min: f64,
    /// The middle one, or the mean of the two in the middle.
    pub median: f64,
    /// Largest.
    pub max: f64,
}

impl Dispersion {
    /// Of some numbers; none if there are none.
    pub fn of(numbers: &[f64]) -> Option<Self> {
        if numbers.is_empty() {
            return None;
        }
        let count = numbers.len() as f64;
        let mean = numbers.iter().sum::<f64>() / count;
        let squares: f64 = numbers.iter().map(|number| (number - mean) * (number - mean)).sum();
        let deviation = if numbers.len() > 1 { (squares / (count - 1.0)).sqrt() } else { 0.0 };
        let mut ordered = numbers.to_vec();
        ordered.sort_by(f64::total_cmp);
        let (first, last) = (ordered[0], ordered[ordered.len() - 1]);
        let median = (ordered[(ordered.len() - 1) / 2] + ordered[ordered.len() / 2]) / 2.0;
        Some(Self { mean, deviation, min: first, median, max: last })
    }
}

/// The number that so large a share of some others does not exceed, given in order; none of nothing.
pub fn quantile(ordered: &[f64], share: f64) -> Option<f64> {
    let nearest = (ordered.len() as f64 * share).ceil() as usize;
    ordered.get(nearest.saturating_sub(1)).copied()
}

/// How many of some runs, and what that says of the true rate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Proportion {
    /// How many.
    pub count: usize,
    /// Of how many.
    pub of: usize,
    /// The one by the other; none of nothing.
    pub rate: Option<f64>,
    /// 95 % interval of the true rate (Wilson).
    pub interval_95: (f64, f64),
}

impl Proportion {
    /// `count` of `of`.
    pub fn new(count: usize, of: usize) -> Self {
        let rate = (of > 0).then(|| count as f64 / of as f64);
        Self { count, of, rate, interval_95: wilson_95(count, of) }
    }

    /// How many of how many in each of several groups, such as the openings of a drive, which succeed or fail together:
    /// the interval is that of as many independent ones as tell as much (Franco, Little, Louis, Slud, "Comparative Study
    /// of Confidence Intervals for Proportions in Complex Sample Surveys", 2019). Where all are alike, which tells
    /// nothing of how far they hang together, each group counts for one.
    pub fn in_groups(groups: &[(usize, usize)]) -> Self {
        let (count, of) = groups.iter().fold((0, 0), |sum, group| (sum.0 + group.0, sum.1 + group.1));
        let independent = independent(groups, count, of);
        let whole = Self::new(count, of);
        Self { interval_95: whole.rate.map_or(whole.interval_95, |rate| wilson_of_rate_95(rate, independent)), ..whole }
    }

    /// `19/20`
    pub fn fraction(&self) -> String {
        format!("{}/{}", self.count, self.of)
    }

    /// `76.4–99.1 %`
    pub fn interval(&self) -> String {
        let (low, high) = self.interval_95;
        format!("{:.1}–{:.1} %", 100.0 * low, 100.0 * high)
    }

    /// `19 of 20: 95.0 %, 95 % interval 76.4 to 99.1 % (Wilson)`
    pub fn sentence(&self) -> String {
        let Self { count, of, rate, interval_95: (low, high) } = self;
        let rate = rate.map_or(String::new(), |rate| format!("{:.1} %, ", 100.0 * rate));
        format!("{count} of {of}: {rate}95 % interval {:.1} to {:.1} % (Wilson)", 100.0 * low, 100.0 * high)
    }
}

/// Events on the way, and what their count says of how often they happen.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PerKm {
    /// How many events.
    pub count: u32,
    /// The way, in kilometres.
    pub km: f64,
    /// Events in a kilometre.
    pub rate: f64,
    /// 95 % interval of the true rate (Garwood).
    pub interval_95: (f64, f64),
}

impl PerKm {
    /// `count` events on a way of `km` kilometres; none without a way.
    pub fn new(count: u32, km: f64) -> Option<Self> {
        let (low, high) = poisson_95(count);
        (km > 0.0).then(|| Self { count, km, rate: f64::from(count) / km, interval_95: (low / km, high / km) })
    }
}

/// What some numbers are on the whole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// How many numbers.
    pub count: usize,
    /// What they are like.
    #[serde(flatten)]
    pub spread: Dispersion,
    /// Half the 95 % interval of the mean.
    pub half_95: f64,
}

impl Summary {
    /// Of some numbers; none if there are none.
    pub fn of(numbers: &[f64]) -> Option<Self> {
        let spread = Dispersion::of(numbers)?;
        Some(Self { count: numbers.len(), spread, half_95: mean_95(spread.deviation, numbers.len()) })
    }

    /// `12.3 ± 0.4`: the mean and half its interval, both multiplied by `scale`; one number tells nothing of how others
    /// differ, and has none.
    pub fn told(&self, scale: f64, decimals: usize) -> String {
        let Self { count, spread: Dispersion { mean, .. }, half_95 } = *self;
        let mean = format!("{:.decimals$}", scale * mean);
        if count < 2 { mean } else { format!("{mean} ± {:.decimals$}", scale * half_95) }
    }
}

/// The 0.975 quantile of the normal distribution.
const Z_95: f64 = 1.959_963_984_540_054;

/// The interval that covers the true rate of success with 95 % (Wilson, "Probable inference, the
/// law of succession, and statistical inference", 1927). `(0, 1)` without runs.
fn wilson_95(successes: usize, runs: usize) -> (f64, f64) {
    if runs == 0 {
        return (0.0, 1.0);
    }
    wilson_of_rate_95(successes as f64 / runs as f64, runs as f64)
}

/// The same of a rate that was measured with `count` runs, not necessarily a whole number of them.
fn wilson_of_rate_95(rate: f64, count: f64) -> (f64, f64) {
    let z2 = Z_95 * Z_95;
    let centre = (rate + z2 / (2.0 * count)) / (1.0 + z2 / count);
    let half = Z_95 / (1.0 + z2 / count) * (rate * (1.0 - rate) / count + z2 / (4.0 * count * count)).sqrt();
    ((centre - half).max(0.0), (centre + half).min(1.0))
}

/// The 95 % interval of the difference of two shares of the same `pairs`, of which `gained` are in the second alone and
/// `lost` in the first alone: that of Wald with half a pair more of each kind (Agresti and Min, "Simple improved
/// confidence intervals for comparing matched proportions", 2005). `(-1, 1)` without pairs.
pub fn paired_difference_95(gained: usize, lost: usize, pairs: usize) -> (f64, f64) {
    if pairs == 0 {
        return (-1.0, 1.0);
    }
    let (gained, lost, pairs) = (gained as f64 + 0.5, lost as f64 + 0.5, pairs as f64 + 2.0);
    let difference = (gained - lost) / pairs;
    let half = Z_95 * ((gained + lost) / pairs - difference * difference).max(0.0).sqrt() / pairs.sqrt();
    ((difference - half).max(-1.0), (difference + half).min(1.0))
}

/// How many independent ones would tell as much of the rate as these groups: those there are, by the ratio of the
/// variance between groups to that of a binomial; at most those there are.
fn independent(groups: &[(usize, usize)], count: usize, of: usize) -> f64 {
    let groups: Vec<(f64, f64)> =
        groups.iter().filter(|group| group.1 > 0).map(|group| (group.0 as f64, group.1 as f64)).collect();
    let (number, of) = (groups.len() as f64, of as f64);
    let rate = count as f64 / of;
    let squares: f64 = groups.iter().map(|(count, of)| (count - rate * of) * (count - rate * of)).sum();
    if squares == 0.0 || number < 2.0 {
        return number;
    }
    let variance = squares * number / (number - 1.0) / (of * of);
    (rate * (1.0 - rate) / variance).clamp(1.0, of)
}

/// Half the 95 % interval of a mean of `count` numbers with this deviation (Student, "The probable error of a mean",
/// 1908).
pub fn mean_95(deviation: f64, count: usize) -> f64 {
    if count < 2 { 0.0 } else { student_95(count - 1) * deviation / (count as f64).sqrt() }
}

/// The 0.975 quantile of Student's distribution with `freedom` degrees of freedom, at least one: exactly for one and
/// two, beyond by its expansion around the normal one (Abramowitz and Stegun 1964, 26.7.5), which is 0.1 % too small
/// for three and less so for more.
fn student_95(freedom: usize) -> f64 {
    let z2 = Z_95 * Z_95;
    match freedom {
        0 | 1 => 12.706_204_736_174_7,
        2 => 4.302_652_729_749_46,
        _ => {
            let terms = [
                (z2 + 1.0) / 4.0,
                ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0,
                (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0,
                ((((79.0 * z2 + 776.0) * z2 + 1_482.0) * z2 - 1_920.0) * z2 - 945.0) / 92_160.0,
            ];
            Z_95 * (1.0 + terms.iter().rev().fold(0.0, |sum, term| (sum + term) / freedom as f64))
        }
    }
}

/// The interval that covers the mean of a Poisson distribution with 95 %, given one count: the means
/// under which a count as high, or as low, has 2.5 % (Garwood 1936).
fn poisson_95(count: u32) -> (f64, f64) {
    // P(at most n events | mean), by its sum.
    let at_most = |events: u32, mean: f64| -> f64 {
        let mut term = (-mean).exp();
        let mut sum = term;
        for k in 1..=events {
            term *= mean / f64::from(k);
            sum += term;
        }
        sum
    };
    let solve = |is_below: &dyn Fn(f64) -> bool| -> f64 {
        let (mut low, mut high) = (0.0, 2.0 * f64::from(count) + 20.0);
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            if is_below(middle) { low = middle } else { high = middle }
        }
        low
    };
    let low = if count == 0 { 0.0 } else { solve(&|mean| 1.0 - at_most(count - 1, mean) < 0.025) };
    (low, solve(&|mean| at_most(count, mean) > 0.025))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_solves_wilsons_equation() {
        // Its ends are the rates p whose score statistic |rate − p| / √(p(1−p)/n) is the quantile.
        for (successes, runs) in [(1, 10), (5, 10), (97, 100), (250, 1000)] {
            let rate = successes as f64 / runs as f64;
            let (low, high) = wilson_95(successes, runs);
            for end in [low, high] {
                let score = (rate - end).abs() / (end * (1.0 - end) / runs as f64).sqrt();
                assert!((score - Z_95).abs() < 1e-9, "{successes}/{runs}: {score}");
            }
        }
    }

    #[test]
    fn the_interval_is_symmetric_and_stays_within_0_and_1() {
        for runs in [1, 7, 100] {
            for successes in 0..=runs {
                let (low, high) = wilson_95(successes, runs);
                let (other_low, other_high) = wilson_95(runs - successes, runs);
                assert!(0.0 <= low && low < high && high <= 1.0);
                assert!((low - (1.0 - other_high)).abs() < 1e-12 && (high - (1.0 - other_low)).abs() < 1e-12);
            }
        }
        assert_eq!(wilson_95(0, 0), (0.0, 1.0));
        assert_eq!(wilson_95(0, 50).0, 0.0);
        assert_eq!(wilson_95(50, 50).1, 1.0);
    }

    #[test]
    fn what_hangs_together_counts_for_less() {
        let alone: Vec<(usize, usize)> = (0..100).map(|run| (usize::from(run % 4 != 0), 1)).collect();
        let (low, high) = Proportion::in_groups(&alone).interval_95;
        let (wilson_low, wilson_high) = wilson_95(75, 100);
        assert!((low - wilson_low).abs() < 1e-3 && (high - wilson_high).abs() < 1e-3, "groups of one are runs");
        let together: Vec<(usize, usize)> = (0..100).map(|run| (if run % 4 == 0 { 0 } else { 10 }, 10)).collect();
        let (low, high) = Proportion::in_groups(&together).interval_95;
        assert!((low - wilson_low).abs() < 1e-3 && (high - wilson_high).abs() < 1e-3, "ten alike tell as much as one");
        assert_eq!(Proportion::in_groups(&[(10, 10); 20]).interval_95, wilson_95(20, 20));
        assert_eq!(Proportion::in_groups(&[]).interval_95, (0.0, 1.0));
        assert_eq!(Proportion::in_groups(&[(0, 0), (3, 5)]).rate, Some(0.6));
    }

    #[test]
    fn a_share_of_nothing_has_no_rate() {
        assert_eq!(Proportion::new(0, 0).rate, None);
        assert_eq!(Proportion::new(19, 20).sentence(), "19 of 20: 95.0 %, 95 % interval 76.4 to 99.1 % (Wilson)");
        assert_eq!(PerKm::new(3, 0.0), None);
        assert_eq!(PerKm::new(3, 2.0).map(|alarms| alarms.rate), Some(1.5));
    }

    #[test]
    fn few_numbers_have_students_interval() {
        // Table 26.10 of Abramowitz and Stegun.
        for (freedom, quantile) in
            [(1, 12.706), (2, 4.303), (3, 3.182), (5, 2.571), (9, 2.262), (30, 2.042), (120, 1.980)]
        {
            assert!((student_95(freedom) / quantile - 1.0).abs() < 1.5e-3, "{freedom}: {}", student_95(freedom));
        }
        assert!((student_95(1_000_000) - Z_95).abs() < 1e-5);
        let summary = Summary::of(&[1.0, 2.0, 3.0]).expect("there are numbers");
        assert!((summary.half_95 - 4.303 / 3.0_f64.sqrt()).abs() < 1e-3, "{summary:?}");
        assert_eq!(summary.told(10.0, 1), "20.0 ± 24.8");
        assert_eq!(Summary::of(&[2.0]).map(|one| one.told(1.0, 2)).as_deref(), Some("2.00"));
    }

    #[test]
    fn counts_without_and_with_events_have_their_intervals() {
        // Without events the upper end is −ln 0.025; the ends for ten are in Garwood's table.
        let (low, high) = poisson_95(0);
        assert!(low == 0.0 && (high + 0.025f64.ln()).abs() < 1e-9);
        let (low, high) = poisson_95(10);
        assert!((low - 4.795).abs() < 1e-3 && (high - 18.390).abs() < 1e-3, "{low} {high}");
    }

    #[test]
    fn a_quantile_is_the_first_that_so_many_do_not_exceed() {
        let ordered: Vec<f64> = (1..=20).map(f64::from).collect();
        let at = |share: f64| quantile(&ordered, share);
        assert_eq!([at(0.0), at(0.05), at(0.5), at(0.95), at(1.0)], [1.0, 1.0, 10.0, 19.0, 20.0].map(Some));
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn the_spread_of_equal_numbers_is_nothing() {
        let spread = Dispersion::of(&[2.5; 4]).expect("there are numbers");
        assert_eq!(spread, Dispersion { mean: 2.5, deviation: 0.0, min: 2.5, median: 2.5, max: 2.5 });
        let spread = Dispersion::of(&[1.0, 3.0]).expect("there are numbers");
        assert_eq!((spread.mean, spread.deviation), (2.0, 2.0_f64.sqrt()));
        assert_eq!(Dispersion::of(&[7.0, 1.0, 2.0]).map(|spread| spread.median), Some(2.0));
        assert_eq!(Dispersion::of(&[]), None);
    }
}
