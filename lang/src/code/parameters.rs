//! The parameters of a function.

use crate::symbol::Symbol;
use serde::{Deserialize, Serialize};

/// The count of no call: what is called has its arguments arranged.
pub const ARRANGES: u16 = u16::MAX;

/// The parameters of a function.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Must be given.
    pub required: u8,
    /// May be given, in order.
    pub optional: u8,
    /// Whether further arguments are collected in a list.
    pub rest: bool,
    /// May be given by name.
    pub keys: Vec<Symbol>,
}

impl Parameters {
    /// Whether a call passes exactly the required parameters and nothing needs to be arranged.
    pub fn is_simple(&self) -> bool {
        self.optional == 0 && !self.rest && self.keys.is_empty()
    }

    /// The number of arguments of a call that needs nothing arranged; [`ARRANGES`] if there is none.
    pub fn exact_count(&self) -> u16 {
        if self.is_simple() { u16::from(self.required) } else { ARRANGES }
    }

    /// How many registers the parameters take.
    pub fn registers(&self) -> usize {
        usize::from(self.required) + usize::from(self.optional) + usize::from(self.rest) + self.keys.len()
    }

    /// Whether a call with this many arguments can be right.
    pub fn accepts(&self, count: usize) -> bool {
        let positional = usize::from(self.required) + usize::from(self.optional);
        count >= usize::from(self.required) && (count <= positional || self.rest || !self.keys.is_empty())
    }

    /// "2 arguments", "at least 1 argument", as errors say it.
    pub fn describe(&self) -> String {
        let required = usize::from(self.required);
        let plural = |count: usize| if count == 1 { "1 argument".to_string() } else { format!("{count} arguments") };
        if self.rest || !self.keys.is_empty() {
            format!("at least {}", plural(required))
        } else if self.optional > 0 {
            format!("{required} to {}", plural(required + usize::from(self.optional)))
        } else {
            plural(required)
        }
    }
}
