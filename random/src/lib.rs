//! Seeded random streams: one for each consumer, found by name, so that a new consumer never
//! changes what an old one draws, and no two draw the same numbers.
//!
//! This is the only place where a stream is made of a seed.

use rand_core::Rng;
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

/// A named stream of random numbers. Cloning it forks it: both copies go on alike.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stream(Pcg64Mcg);

impl Stream {
    /// The stream of this name under this seed.
    pub fn new(seed: u64, name: &str) -> Self {
        // FNV-1a over name and seed: fixed for all time, unlike the standard library's hashes.
        let hash = |basis: u64| {
            name.bytes()
                .chain(seed.to_le_bytes())
                .fold(basis, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
        };
        let state = (u128::from(hash(0xcbf2_9ce4_8422_2325)) << 64) | u128::from(hash(0x9ae1_6a3b_2f90_404f));
        let mut generator = Pcg64Mcg::new(state);
        generator.next_u64();
        Self(generator)
    }

    /// Uniform in [0, 1), 53 bits.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in [low, high).
    pub fn uniform_in(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Uniform in 0..count; `count` must not be 0.
    pub fn index(&mut self, count: usize) -> usize {
        // The product keeps the high bits, whose bias is below 2⁻⁵³ for any real count.
        ((self.uniform() * count as f64) as usize).min(count - 1)
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.uniform() < probability
    }

    /// A seed for streams of somebody else.
    pub fn seed(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Normal with mean 0 and standard deviation 1 (Box and Muller; two draws each, so that the
    /// stream holds no half-used pair).
    pub fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.uniform()));
        radius * libm::cos(std::f64::consts::TAU * self.uniform())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_seeds_give_different_streams() {
        let first = |seed, name| Stream::new(seed, name).uniform();
        assert_eq!(first(1, "sonar"), first(1, "sonar"));
        assert_ne!(first(1, "sonar"), first(2, "sonar"));
        assert_ne!(first(1, "sonar"), first(1, "odometry"));
    }

    #[test]
    fn normal_has_unit_variance() {
        let mut stream = Stream::new(7, "test");
        let count = 20_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..count {
            let value = stream.normal();
            sum += value;
            squares += value * value;
        }
        assert!((sum / count as f64).abs() < 0.03);
        assert!((squares / count as f64 - 1.0).abs() < 0.05);
    }
}
