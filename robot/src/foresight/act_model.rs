//! What a module declares of its behaviours, so that plans with them can be projected: how long they take, and how
//! they may fail.

use rpl_random::Stream;

/// How one behaviour usually goes.
#[derive(Clone, Debug, PartialEq)]
pub struct ActModel {
    /// How long it takes, in seconds: at least, most likely and at most, as a triangular distribution.
    pub takes_s: [f64; 3],
    /// Classes of failures in which it may end, each with its probability; together at most 1.
    pub failures: Vec<(String, f64)>,
}

impl ActModel {
    /// Whether it always goes alike.
    pub fn is_certain(&self) -> bool {
        let [least_s, _, most_s] = self.takes_s;
        least_s == most_s && self.failures.iter().all(|&(_, probability)| probability == 0.0 || probability == 1.0)
    }

    /// How long it takes once, and the class of its failure, if it fails. Two numbers are drawn, whatever comes of
    /// them.
    pub fn drawn(&self, stream: &mut Stream) -> (f64, Option<&str>) {
        let (time, mut left) = (stream.uniform(), stream.uniform());
        let failure = self.failures.iter().find(|(_, probability)| {
            left -= probability;
            left < 0.0
        });
        (self.takes_s(time), failure.map(|(class, _)| class.as_str()))
    }

    /// The time below which a share of all lie: the distribution function, inverted.
    fn takes_s(&self, share: f64) -> f64 {
        let [least_s, likely_s, most_s] = self.takes_s;
        let whole_s = most_s - least_s;
        let rising_s = likely_s - least_s;
        if share * whole_s < rising_s {
            least_s + libm::sqrt(share * whole_s * rising_s)
        } else {
            most_s - libm::sqrt((1.0 - share) * whole_s * (most_s - likely_s))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn acts_take_as_long_and_fail_as_often_as_is_declared() {
        let failures = vec![("lamp-failure".to_string(), 0.1), ("blocked".to_string(), 0.2)];
        let model = ActModel { takes_s: [2.0, 3.0, 7.0], failures };
        let mut stream = Stream::new(1, "acts");
        let drawn: Vec<(f64, Option<&str>)> = (0..20_000).map(|_| model.drawn(&mut stream)).collect();
        assert!(drawn.iter().all(|(takes_s, _)| (2.0..=7.0).contains(takes_s)));
        let mean_s = drawn.iter().map(|(takes_s, _)| takes_s).sum::<f64>() / 20_000.0;
        assert!((mean_s - 4.0).abs() < 0.05, "the mean of three corners, not {mean_s}");
        let share = |class| drawn.iter().filter(|(_, failure)| *failure == class).count() as f64 / 20_000.0;
        assert!((share(Some("lamp-failure")) - 0.1).abs() < 0.01 && (share(Some("blocked")) - 0.2).abs() < 0.01);
        let always = ActModel { takes_s: [4.0; 3], failures: Vec::new() };
        assert!(always.is_certain() && always.drawn(&mut stream) == (4.0, None));
    }
}
