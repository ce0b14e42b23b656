//! Who works, and how a day went for each.

use serde::{Deserialize, Serialize};

/// Who works: the form that the plan ends with.
pub const ROWS: [(&str, &str); 5] = [
    ("in turn", "(work-in-turn)"),
    ("reactive", "(work nil)"),
    ("one look ahead", "(work-with-one-look)"),
    ("foresight", "(work-with-foresight)"),
    ("truth", "(work-by-the-truth)"),
];

/// Rows by number.
pub const REACTIVE: usize = 1;
pub const ONE_LOOK: usize = 2;
pub const FORESIGHT: usize = 3;
pub const TRUTH: usize = 4;

/// How a day went.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RowDay {
    /// Orders that were kept.
    pub kept: u32,
    /// When the last work was done.
    pub ended_s: f64,
    /// Things that lie neither where they were nor where they were wanted.
    pub on_floor: u32,
    /// Things that were put down more than once.
    pub twice: u32,
    /// Valves that are still held.
    pub held: u32,
    /// Why the work came to no end, if it did not.
    pub failure: Option<String>,
}

/// A day, gone through by all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForesightDay {
    pub seed: u64,
    pub orders: u32,
    pub rows: Vec<RowDay>,
}
