//! Plan text to register code, and plan text laid out anew.
//!
//! Every phase returns a result *and* the errors beside it: text ([`source`]) → tokens ([`lexer`]) → data with places
//! ([`reader`], [`syntax`]) → expanded, resolved and compiled, one top-level form after the other ([`compile`]) →
//! register code ([`code`]). [`check`] finds faults in a text that can run. [`formatter`] and [`pretty`] lay out text
//! and data.
//!
//! It knows no task, no robot, no file and no clock, and runs nothing: macros are run by the crate above, through
//! [`compile::MacroHost`].
//!
//! Four floors, each of which imports only from those below it:
//!
//! - `check`, `formatter`: faults found; text laid out;
//! - `compile`: one row for each special form; it resolves and emits;
//! - `code`, `reader`: instructions; text to trees;
//! - `syntax`, `source`: trees with places.
//!
//! Read in this order: [`source`], [`symbol`], [`syntax`], [`diagnostic`], [`lexer`], [`bars`], [`reader`], [`code`],
//! [`compile`] with its special forms (`compile/forms`), [`check`], [`occurrences`], [`layout`], [`formatter`].

pub mod bars;
mod brackets;
pub mod continuation;
pub mod diagnostic;
pub mod formatter;
pub mod indentation;
mod infix;
pub mod kind;
pub mod layout;
pub mod lexer;
mod name_places;
mod nesting;
pub mod number;
pub mod pretty;
pub mod reader;
pub mod source;
mod stack;
pub mod suggest;
pub mod symbol;
pub mod syntax;
pub mod visible;

pub mod check;
pub mod code;
pub mod compile;
pub mod occurrences;
