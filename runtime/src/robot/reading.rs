//! Readings: what a robot says to plans.

use crate::state::block::block;
use crate::state::heap::PAIR;
use std::fmt;

/// Lists of readings are nested at most so deep: copying, comparing and dropping one takes the
/// thread's stack as often.
pub const MAX_NESTING: usize = 64;

/// A value the robot gives to a fluent, or to a slot of a failure.
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// `nil` or `t`.
    Truth(bool),
    /// An integer.
    Int(i64),
    /// A float.
    Float(f64),
    /// A symbol.
    Symbol(String),
    /// A string.
    Text(String),
    /// A list; empty it is `nil`.
    List(ReadingList),
}

/// Readings one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadingList {
    items: Vec<Reading>,
    /// Lists in it, one inside the other, itself counted; at most [`MAX_NESTING`].
    nesting: usize,
}

/// A list has more lists inside one another than a robot may give.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooNested;

impl fmt::Display for TooNested {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "lists of a robot are nested at most {MAX_NESTING} deep, and this one is nested deeper")
    }
}

impl std::error::Error for TooNested {}

impl ReadingList {
    /// A list of readings.
    ///
    /// # Errors
    /// It would be nested deeper than [`MAX_NESTING`].
    pub fn new(items: Vec<Reading>) -> Result<Self, TooNested> {
        let nesting = 1 + items.iter().map(Reading::nesting).max().unwrap_or(0);
        if nesting > MAX_NESTING { Err(TooNested) } else { Ok(Self { items, nesting }) }
    }

    /// Its readings, in order.
    pub fn items(&self) -> &[Reading] {
        &self.items
    }
}

impl Reading {
    /// Lists in it, one inside the other.
    fn nesting(&self) -> usize {
        match self {
            Reading::Truth(_) | Reading::Int(_) | Reading::Float(_) | Reading::Symbol(_) | Reading::Text(_) => 0,
            Reading::List(list) => list.nesting,
        }
    }

    /// Bytes that the value takes of a plan's memory.
    pub(crate) fn bytes(&self) -> usize {
        match self {
            Reading::Truth(_) | Reading::Int(_) | Reading::Float(_) | Reading::Symbol(_) => 0,
            Reading::Text(text) => block(text.len()),
            Reading::List(list) => list.items.iter().map(|item| PAIR + item.bytes()).sum(),
        }
    }
}
