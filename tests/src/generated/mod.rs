//! Random programs of all constructs, disturbed from outside, and what must hold of every run.
//!
//! [`grammar`] writes a program, [`robot`] stands in for a robot, [`drive`] runs and judges,
//! [`shrink`] makes a finding small. [`texts`] does to the reader and the compiler what these do to
//! the runtime. All of it is a function of a seed.

pub mod drive;
pub mod forged;
pub mod form;
pub mod grammar;
pub mod robot;
pub mod shrink;
pub mod texts;

use rand_core::Rng;

/// The stream everything is drawn from.
#[derive(Clone, Debug)]
pub struct Dice(rand_pcg::Pcg64Mcg);

impl Dice {
    /// The stream of a seed.
    pub fn new(seed: u64) -> Self {
        let mut stream = rand_pcg::Pcg64Mcg::new((u128::from(seed) << 64) | 0xdeca_fbad_5eed);
        stream.next_u64();
        Self(stream)
    }

    /// A number below `end`, which is not 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.0.next_u64() % end as u64) as usize
    }

    /// True once in a number of times.
    pub fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    /// One of them.
    pub fn pick<'a, T: ?Sized>(&mut self, from: &[&'a T]) -> &'a T {
        from[self.below(from.len())]
    }
}
