//! Intervals and moments of a few numbers.

/// Mean, standard deviation and range of some numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Arithmetic mean.
    pub mean: f64,
    /// Standard deviation of the sample (n − 1); 0 for a single number.
    pub deviation: f64,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
}

impl Spread {
    /// Of some numbers; none if there are none.
    pub fn of(numbers: &[f64]) -> Option<Self> {
        if numbers.is_empty() {
            return None;
        }
        let count = numbers.len() as f64;
        let mean = numbers.iter().sum::<f64>() / count;
        let squares: f64 = numbers.iter().map(|number| (number - mean) * (number - mean)).sum();
        let deviation = if numbers.len() > 1 { (squares / (count - 1.0)).sqrt() } else { 0.0 };
        let min = numbers.iter().copied().fold(f64::INFINITY, f64::min);
        let max = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Some(Self { mean, deviation, min, max })
    }
}

/// The 0.975 quantile of the normal distribution.
const Z_95: f64 = 1.959_963_984_540_054;

/// The interval that covers the true rate of success with 95 % (Wilson, "Probable inference, the
/// law of succession, and statistical inference", 1927). `(0, 1)` without runs.
pub fn wilson_95(successes: usize, runs: usize) -> (f64, f64) {
    if runs == 0 {
        return (0.0, 1.0);
    }
    let count = runs as f64;
    let rate = successes as f64 / count;
    let z2 = Z_95 * Z_95;
    let centre = (rate + z2 / (2.0 * count)) / (1.0 + z2 / count);
    let half = Z_95 / (1.0 + z2 / count) * (rate * (1.0 - rate) / count + z2 / (4.0 * count * count)).sqrt();
    ((centre - half).max(0.0), (centre + half).min(1.0))
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
    fn the_spread_of_equal_numbers_is_nothing() {
        let spread = Spread::of(&[2.5; 4]).expect("there are numbers");
        assert_eq!(spread, Spread { mean: 2.5, deviation: 0.0, min: 2.5, max: 2.5 });
        let spread = Spread::of(&[1.0, 3.0]).expect("there are numbers");
        assert_eq!((spread.mean, spread.deviation), (2.0, 2.0_f64.sqrt()));
        assert_eq!(Spread::of(&[]), None);
    }
}
