//! Fluents and watches as data.

use crate::state::line::Line;
use crate::state::small_set::SmallSet;
use crate::state::value::Value;
use rpl_lang::code::Missed;
use rpl_lang::symbol::Symbol;
use serde::{Deserialize, Serialize};

/// Where a fluent's value comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Origin {
    /// A plan assigns it.
    Plan,
    /// The robot or the system assigns it; a plan cannot.
    System,
    /// Code computes it from other fluents.
    Network {
        /// The code.
        code: u32,
        /// The values it captured.
        captured: Box<[Value]>,
    },
    /// True in the propagation of a pulse of its input.
    Pulsed,
    /// True in the propagation of a change of its input.
    Changed,
    /// Counts the pulses of its input.
    Count,
}

/// A value that changes over time and can wake tasks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fluent {
    /// Grows from fluent to fluent: networks of one height are brought up to date and served in
    /// this order, whatever their slots.
    pub number: u64,
    /// The name of its global, for traces and errors.
    pub name: Option<Symbol>,
    /// Its value.
    pub value: Value,
    /// Where the value comes from.
    pub origin: Origin,
    /// The failure of a network that could not be evaluated.
    pub failure: Option<Value>,
    /// Networks that read it.
    pub dependents: SmallSet<u32>,
    /// Fluents a network read when it was last evaluated.
    pub inputs: Vec<u32>,
    /// Longest chain of inputs below it.
    pub height: u32,
    /// Tasks that wait for it, in the order in which they began to.
    pub waiters: Line,
    /// Watches of it, in the order in which they began: number and slot.
    pub watches: SmallSet<(u64, u32)>,
    /// It is pulsed in the propagation under way.
    pub is_pulsed: bool,
    /// It changed in the propagation under way.
    pub is_changed: bool,
}

impl Fluent {
    /// A fluent with a value.
    pub fn new(name: Option<Symbol>, value: Value, origin: Origin) -> Self {
        Self {
            number: 0,
            name,
            value,
            origin,
            failure: None,
            dependents: SmallSet::default(),
            inputs: Vec::new(),
            height: 0,
            waiters: Line::default(),
            watches: SmallSet::default(),
            is_pulsed: false,
            is_changed: false,
        }
    }

    /// What is read now: in the propagation of its pulse, a fluent that is nil reads as t.
    #[inline]
    pub fn reading(&self) -> &Value {
        if self.is_pulsed && matches!(self.value, Value::Nil) { &Value::True } else { &self.value }
    }

    /// Whether what is read now is true.
    pub fn is_true(&self) -> bool {
        self.is_pulsed || self.value.is_true()
    }

    /// Whether it is a plan's, no network reads it and nothing watches it: a new value concerns
    /// nobody but those who wait for it.
    #[inline]
    pub(crate) fn is_plain(&self) -> bool {
        matches!(self.origin, Origin::Plan) && self.dependents.is_empty() && self.watches.is_empty()
    }

    pub(crate) fn is_computed(&self) -> bool {
        !matches!(self.origin, Origin::Plan | Origin::System)
    }
}

/// A `whenever` that counts how often its fluent becomes true.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Watch {
    /// Grows from watch to watch.
    pub number: u64,
    /// The fluent.
    pub fluent: u32,
    /// The task.
    pub task: u32,
    /// Whether the fluent was true last.
    pub was_true: bool,
    /// Events not served yet.
    pub events: u32,
    /// What happens with events during the body.
    pub missed: Missed,
    /// Whether the fluent dies with the watch.
    pub owned: bool,
    /// Whether the task waits for the next event now.
    pub waits: bool,
}
