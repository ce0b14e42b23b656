//! Constants of the text.

use crate::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A constant that has no parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Atom {
    /// An integer that does not fit [`Op::Int`](super::Op::Int).
    Int(i64),
    /// A float.
    Float(f64),
    /// A string.
    Str(Arc<str>),
    /// A symbol; `nil` and `t` are not symbols at run time.
    Symbol(Symbol),
    /// A keyword.
    Keyword(Symbol),
    /// `nil`
    Nil,
    /// `t`
    True,
    /// A native function.
    Native(u16),
    /// An object of the running system, by the index its compiler call gave.
    Object(u32),
}

/// A part of a list or vector. The parts stand in the order in which a stack builds the whole, so that
/// copying, comparing, writing or dropping it costs no Rust stack, however deep it nests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Part {
    /// An element.
    Atom(Atom),
    /// The list of the `length` elements before it.
    List {
        /// How many, the tail not included.
        length: u32,
        /// Whether one more, the last, is the tail after the dot.
        dotted: bool,
    },
    /// The vector of the `length` elements before it.
    Vector {
        /// How many.
        length: u32,
    },
}

/// A constant of the text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Constant {
    /// What has no parts.
    Atom(Atom),
    /// A list or vector; the last part makes it of those before.
    Compound(Vec<Part>),
}

impl From<Atom> for Constant {
    fn from(atom: Atom) -> Self {
        Constant::Atom(atom)
    }
}
