//! The paired comparison of two plans: both were run on the same streams, so that most of what chance does
//! to them is the same and cancels out.

/// What a single event may change in the worth of a run: all of it, or as much as one errand is worth where a fluent
/// counts them.
const MOST: f64 = 1.0;

/// How much better one of two plans was than the other, run by run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Paired {
    /// Mean of the differences.
    pub mean: f64,
    /// Its standard error; 0 for one difference, and where all are the same.
    pub error: f64,
}

/// What a comparison says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Better by more than the margin.
    Better,
    /// Not better by the margin.
    NotBetter,
    /// More runs are needed to say.
    Open,
}

impl Paired {
    /// Of the differences; there is at least one.
    pub fn of(differences: &[f64]) -> Self {
        let count = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / count;
        let squares: f64 = differences.iter().map(|difference| (difference - mean) * (difference - mean)).sum();
        let error = if count > 1.0 { libm::sqrt(squares / (count - 1.0) / count) } else { 0.0 };
        Self { mean, error }
    }

    /// The same where something may yet happen that no run has met: as if it had happened once for either plan, and
    /// had decided the run. So [`crate::run::projection_record`] counts shares of success, too.
    pub fn with_unseen(differences: &[f64]) -> Self {
        Self::of(&[differences, &[MOST, -MOST]].concat())
    }

    /// Whether it is better by a margin that lies `standard_errors` standard errors away from the mean difference.
    pub fn verdict(self, margin: f64, standard_errors: f64) -> Verdict {
        let reach = standard_errors * self.error;
        if self.mean - reach > margin {
            Verdict::Better
        } else if self.mean + reach <= margin {
            Verdict::NotBetter
        } else {
            Verdict::Open
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_that_of_the_textbook() {
        let Paired { mean, error } = Paired::of(&[1.0, 2.0, 3.0, 4.0]);
        // The variance of 1, 2, 3, 4 is 5/3, and that of their mean a fourth of it.
        assert!((mean - 2.5).abs() < 1e-12 && (error * error - 5.0 / 12.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_always_the_same_is_decided_and_what_strays_is_not() {
        assert_eq!(Paired::of(&[0.3; 8]).verdict(0.1, 2.0), Verdict::Better);
        assert_eq!(Paired::of(&[0.0; 8]).verdict(0.0, 2.0), Verdict::NotBetter, "equal plans are not changed");
        assert_eq!(Paired::with_unseen(&[0.0; 8]).verdict(0.1, 2.0), Verdict::Open, "one run in ten may go otherwise");
        assert_eq!(Paired::with_unseen(&[0.0; 64]).verdict(0.1, 2.0), Verdict::NotBetter);
        assert_eq!(Paired::of(&[-0.4, 0.6, 0.5, -0.3]).verdict(0.0, 2.0), Verdict::Open);
    }
}
