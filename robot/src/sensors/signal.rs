//! Signals of sensors and actuators that this crate does not know.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a sensor perceives, or an actuator is told, of which this crate knows nothing but the name: it
/// goes between a module and a host that agree on it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Signal {
    /// Yes or no.
    Truth(bool),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// Signals, one after the other.
    List(Vec<Signal>),
}

/// Signals by the names of their sensors or actuators.
pub type Signals = BTreeMap<String, Signal>;

impl Signal {
    /// The number, if it is one.
    pub fn number(&self) -> Option<f64> {
        match self {
            Signal::Number(number) => Some(*number),
            Signal::Truth(_) | Signal::Text(_) | Signal::List(_) => None,
        }
    }
}
