//! Failures: why something did not succeed, and where.

use crate::state::value::Value;
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
    /// When it was raised, in virtual time.
    pub time_us: u64,
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
    /// This many bytes are wanted at once: a native is called again when there is room for them.
    NoRoom(usize),
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

/// The classes every program has: name, the class above, slots of its own, documentation.
pub const CLASSES: &[(&str, &str, &[&str], &str)] = &[
    ("failure", "", &[], "The root: a handler of it takes every failure."),
    (
        "plan-failure",
        "failure",
        &[],
        "What `fail` raises unless it names another class, and the parent of most classes plans define.",
    ),
    ("error", "failure", &[], "A fault in the plan itself."),
    ("type-error", "error", &[], "A value is not of the type that is needed."),
    ("unbound-variable", "error", &[], "A variable or fluent was read before its definition ran."),
    ("arity-error", "error", &[], "A function was called with too few or too many arguments."),
    ("arithmetic-error", "error", &[], "A result does not fit an integer, or there is none, as of a division by zero."),
    ("index-error", "error", &[], "There is no element at that position."),
    ("control-error", "error", &[], "A block was left that is not active any more, or belongs to another task."),
    ("network-error", "error", &[], "A fluent network tried to wait, to assign or to act."),
    ("no-robot", "error", &[], "The plan needs a robot, and there is none."),
    ("runaway", "error", &[], "The tasks spent all steps of one instant."),
    ("stack-overflow", "error", &[], "Calls were nested too deep."),
    ("out-of-memory", "error", &[], "The plan's data outgrew the memory it is allowed."),
    ("timeout", "failure", &["seconds"], "The deadline of a `with-timeout` came first."),
    ("deadlock", "failure", &[], "Tasks wait for each other, or all wait and nothing can wake them."),
    ("valve-error", "failure", &["valve"], "A valve was used or released by a task that does not hold it."),
    ("composite-failure", "failure", &[], "Several alternatives failed; `failure-parts` gives their failures."),
    ("behaviour-failure", "failure", &["behaviour"], "A behaviour signalled failure, or could not be activated."),
    ("navigation-failure", "behaviour-failure", &["destination"], "The robot did not arrive."),
    ("unreachable", "navigation-failure", &[], "There is no way to the destination."),
    (
        "blocked",
        "navigation-failure",
        &["obstacle", "room", "x", "y"],
        "The way stayed blocked: `obstacle` is `door` or `thing`, or nil where nothing is seen; `room` is the door's, or the one the thing is in; `x` and `y` are where it is.",
    ),
    ("interrupted", "behaviour-failure", &[], "A behaviour lost its valve and gave up its goals."),
    (
        "immobile",
        "behaviour-failure",
        &[],
        "The robot was to drive and does not move: its emergency stop is pressed, a wheel is held, the battery is empty.",
    ),
    ("localization-failure", "behaviour-failure", &[], "The position was not found."),
    ("projection-failure", "failure", &[], "A plan could not be projected, and the message says why."),
    ("host-failure", "failure", &[], "Who moves the robot is gone: the run ends, and no handler keeps it."),
    (
        "module-failure",
        "behaviour-failure",
        &["module", "reason"],
        "A module in another process does not work any more: `module` is its name, `reason` what it did.",
    ),
    ("grasp-failure", "behaviour-failure", &[], "The gripper did not take the thing, or did not let go of it."),
];

/// The classes every program starts with.
pub fn base_classes(symbols: &mut Symbols) -> BTreeMap<Symbol, FailureClass> {
    CLASSES
        .iter()
        .map(|&(name, parent, slots, _)| {
            let parent = (!parent.is_empty()).then(|| symbols.intern(parent));
            let slots = slots.iter().map(|slot| symbols.intern(slot)).collect();
            (symbols.intern(name), FailureClass { parent, slots })
        })
        .collect()
}
