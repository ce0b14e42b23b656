//! Plan text to compiled code: tokens, syntax, expansion, resolution, register code.
//!
//! Pure: no task, no robot, no file. Every phase returns a result *and* the errors beside it.
//! Read in this order: [`source`], [`symbol`], [`syntax`], [`diagnostic`], [`lexer`], [`reader`].

pub mod continuation;
pub mod diagnostic;
pub mod formatter;
pub mod indentation;
pub mod kind;
pub mod lexer;
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
