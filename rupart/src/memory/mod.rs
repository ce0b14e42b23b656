//! The case memory: cases by number, and the most similar one to a situation.
//!
//! A value: copying it copies no case, and a copy that goes on copies only what it changes.

mod case_memory;
mod chunk;
mod columns;
mod number;
mod retrieval;
#[cfg(test)]
mod tests;

pub use case_memory::{CaseMemory, RUNNERS_UP};
pub use number::CaseNumber;
pub use retrieval::{Match, Retrieval};
