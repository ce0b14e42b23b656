//! What a share of the belief is worth as a probability.

use serde::{Deserialize, Serialize};

/// How often an estimate is right, by the share of the belief around it: monotone, and linear between
/// knots.
///
/// # Deviation
/// The papers take the share itself. But the readings of one scan, and of scans from neighbouring
/// places, share their errors, so the belief is too flat after few scans and too sure after many;
/// and at first one scan in a row of thousands says little against a pose, though a robot that was
/// just carried away is wrong at once. So the shares are brought to how often such estimates were
/// right (isotonic calibration; Zadrozny and Elkan, "Transforming classifier scores into accurate
/// multiclass probability estimates", 2002).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// Share of the belief and certainty, both growing from (0, 0) to (1, at most 1).
    knots: Vec<[f64; 2]>,
}

impl Calibration {
    /// Through these knots, which must grow in both; (0, 0) is put before them, and (1, the last
    /// certainty) behind. Without knots a share is its own certainty.
    pub fn new(knots: &[[f64; 2]]) -> Self {
        let mut all = vec![[0.0, 0.0]];
        all.extend(knots.iter().filter(|knot| knot[0] > 0.0 && knot[0] < 1.0));
        all.push([1.0, knots.last().map_or(1.0, |last| last[1])]);
        Self { knots: all }
    }

    /// How often an estimate with this share is right.
    pub fn certainty(&self, share: f64) -> f64 {
        interpolated(&self.knots, share, [0, 1])
    }

    /// The smallest share that has this certainty; 1 if none has.
    pub fn share(&self, certainty: f64) -> f64 {
        interpolated(&self.knots, certainty, [1, 0])
    }
}

/// The value over the axis `to` where the axis `from` has `at`.
fn interpolated(knots: &[[f64; 2]], at: f64, [from, to]: [usize; 2]) -> f64 {
    let above = knots.iter().position(|knot| knot[from] >= at).unwrap_or(knots.len().saturating_sub(1));
    // A saved run may hold no knots at all; it is refused later, for not being that of this robot.
    let (Some(high), Some(low)) = (knots.get(above), knots.get(above.saturating_sub(1))) else { return at };
    let width = high[from] - low[from];
    if width <= 0.0 {
        return high[to];
    }
    low[to] + (high[to] - low[to]) * ((at - low[from]) / width).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn certainty_passes_through_the_knots_and_grows_between_them() {
        let calibration = Calibration::new(&[[0.2, 0.4], [0.9, 0.7], [0.999, 0.99]]);
        for [share, certainty] in [[0.0, 0.0], [0.1, 0.2], [0.2, 0.4], [0.55, 0.55], [0.999, 0.99], [1.0, 0.99]] {
            assert!((calibration.certainty(share) - certainty).abs() < 1e-12, "{share}");
        }
        let steps: Vec<f64> = (0..=1000).map(|step| calibration.certainty(f64::from(step) / 1000.0)).collect();
        assert!(steps.is_sorted());
    }

    #[test]
    fn without_knots_a_share_is_its_own_certainty() {
        let calibration = Calibration::new(&[]);
        assert!([0.0, 0.3, 1.0].iter().all(|&share| calibration.certainty(share) == share));
    }

    #[test]
    fn a_certainty_leads_back_to_its_share() {
        let calibration = Calibration::new(&[[0.2, 0.4], [0.9, 0.7], [0.999, 0.99]]);
        for share in [0.0, 0.05, 0.3, 0.9, 0.95, 0.999] {
            assert!((calibration.share(calibration.certainty(share)) - share).abs() < 1e-9, "{share}");
        }
        assert_eq!(calibration.share(0.995), 1.0);
    }
}
