//! Register code: what a plan is compiled to. The list of [`Op`]s is its specification.
//!
//! A frame has up to 256 registers. A call's arguments are its callee's first registers, so the
//! callee's window starts at the caller's first argument and the result is found there. A closure's
//! captured values follow the parameters. Variables that are both captured and assigned live in
//! heap cells; their register holds the cell.
//!
//! Code never changes, and all forks of a run share it. Every instruction knows its place in the text.

mod body;
mod constant;
mod construct;
mod op;
mod parameters;
mod program;

pub(crate) use body::are_plain;
pub use body::{Code, CodeKind, Local, PLAIN_REGISTERS, SlotAccess};
pub use constant::{Atom, Constant, Part};
pub use construct::{Argument, Child, Construct, Failures, Quorum, Successes, Values};
pub use op::{Missed, NO_REG, Op, Reg};
pub use parameters::{ARRANGES, Parameters};
pub use program::{FailureClass, Global, GlobalKind, Program};
