//! Forged inputs of the command: worlds, maps, images, logs, traces, parameters and command lines that
//! somebody made wrong, and what must hold whatever they are.
//!
//! [`worlds`], [`images`], [`recordings`] and [`command_lines`] write a case from a seed, [`judge`]
//! runs it as a child process with little memory and time.

mod case;
pub mod command_lines;
pub mod images;
pub mod judge;
pub mod mangle;
pub mod recordings;
pub mod worlds;

pub use case::{Case, Content, Expected};

use crate::generated::Dice;

type Forger = fn(&mut Dice) -> Case;

/// The forgers, one after the other by the seed.
const FORGERS: [Forger; 10] = [
    worlds::mangled,
    images::map_file,
    recordings::log,
    images::pgm,
    worlds::full,
    images::png,
    recordings::trace,
    command_lines::typed,
    recordings::parameters,
    images::no_file,
];

impl Case {
    /// The case of a seed.
    pub fn new(seed: u64) -> Self {
        let forger = FORGERS[(seed % FORGERS.len() as u64) as usize];
        forger(&mut Dice::new(seed))
    }
}
