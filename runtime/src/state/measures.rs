//! Measures: numbers that a plan says of its run, for tables over many runs.

use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};

/// Measures of a run are columns of a table; more than these are none that anybody reads.
pub const MOST_MEASURES: usize = 100;

/// Numbers by their names, in the order in which they were first measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measures(Vec<(Symbol, f64)>);

impl Measures {
    /// Takes a number in the place of an earlier one of that name. Answers whether there was room.
    pub(crate) fn put(&mut self, name: Symbol, number: f64) -> bool {
        if let Some((_, known)) = self.0.iter_mut().find(|(known, _)| *known == name) {
            *known = number;
            return true;
        }
        let has_room = self.0.len() < MOST_MEASURES;
        if has_room {
            self.0.push((name, number));
        }
        has_room
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = (Symbol, f64)> {
        self.0.iter().copied()
    }
}
