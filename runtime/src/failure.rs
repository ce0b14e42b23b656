//! Failures: why something did not succeed, and where.

use crate::value::Value;
use rpl_lang::code::FailureClass;
use rpl_lang::source::Span;
use rpl_lang::symbol::{Symbol, Symbols};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A failure, as plans handle it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// Its class.
    pub class: Symbol,
    /// One sentence.
    pub message: String,
    /// Values of the class's slots that were given.
    pub slots: Vec<(Symbol, Value)>,
    /// Where it was raised.
    pub span: Option<Span>,
    /// The path of the task that raised it.
    pub path: String,
    /// The plan calls around the place, innermost first, with the place of each call.
    pub calls: Vec<(Symbol, Option<Span>)>,
    /// The failures of a `composite-failure`.
    pub parts: Vec<Value>,
    /// Failures of clean-ups that ran because of this one.
    pub while_cleaning_up: Vec<Value>,
    /// It is a task that ran out of a limit or was deadlocked, or is composed of one.
    pub is_runaway: bool,
}

/// A failure on its way out of native code: class by name, message, slots.
#[derive(Clone, Debug, PartialEq)]
pub enum Raise {
    /// A new failure.
    New {
        /// Name of its class.
        class: &'static str,
        /// One sentence.
        message: String,
        /// Slots by name.
        slots: Vec<(&'static str, Value)>,
    },
    /// A failure that exists.
    Again(Value),
}

impl Raise {
    /// A new failure without slots.
    pub fn new(class: &'static str, message: impl Into<String>) -> Self {
        Raise::New { class, message: message.into(), slots: Vec::new() }
    }

    /// A `type-error`.
    pub fn type_error(message: impl Into<String>) -> Self {
        Raise::new("type-error", message)
    }
}

/// The classes every program has: name and the class above.
pub const CLASSES: &[(&str, &str, &[&str])] = &[
    ("failure", "", &[]),
    ("plan-failure", "failure", &[]),
    ("error", "failure", &[]),
    ("type-error", "error", &[]),
    ("unbound-variable", "error", &[]),
    ("arity-error", "error", &[]),
    ("arithmetic-error", "error", &[]),
    ("index-error", "error", &[]),
    ("control-error", "error", &[]),
    ("network-error", "error", &[]),
    ("runaway", "error", &[]),
    ("stack-overflow", "error", &[]),
    ("out-of-memory", "error", &[]),
    ("timeout", "failure", &["seconds"]),
    ("deadlock", "failure", &[]),
    ("valve-error", "failure", &["valve"]),
    ("composite-failure", "failure", &[]),
    ("behaviour-failure", "failure", &["behaviour"]),
    ("navigation-failure", "behaviour-failure", &["destination"]),
    ("unreachable", "navigation-failure", &[]),
    ("blocked", "navigation-failure", &[]),
    ("interrupted", "behaviour-failure", &[]),
    ("localization-failure", "behaviour-failure", &[]),
    ("grasp-failure", "behaviour-failure", &[]),
];

/// The classes every program starts with.
pub fn base_classes(symbols: &mut Symbols) -> BTreeMap<Symbol, FailureClass> {
    CLASSES
        .iter()
        .map(|&(name, parent, slots)| {
            let parent = (!parent.is_empty()).then(|| symbols.intern(parent));
            let slots = slots.iter().map(|slot| symbols.intern(slot)).collect();
            (symbols.intern(name), FailureClass { parent, slots })
        })
        .collect()
}
