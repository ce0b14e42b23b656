//! State-set progression: how far the robot has got with an instruction (Gutierrez-Osuna and Luo, "State-Set
//! Progression", after Nourbakhsh, Powers and Birchfield's DERVISH).
//!
//! For each instruction there is a chain of nodes (Figs. 4 and 5): the start, the openings that are counted,
//! of which only the last one's kind is known, and what lies beyond. Each percept moves the certainties
//! along it.

mod chain;
mod counter;
mod inference;
mod literal;
mod matrix;
mod progression;

pub use inference::{Inference, Method};
pub use matrix::Matrix;
pub use progression::{Candidate, Standing, StateSet, USUAL_DISTANCE_M};
