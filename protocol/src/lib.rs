//! What is said to processes outside the deterministic core, and what they answer: modules written in other languages,
//! and hosts that move a robot.
//!
//! Everything here is a value or a function of values. Who carries the words stands behind the trait [`line::Line`];
//! pipes, sockets, threads and clocks are in the crate `link`.
//!
//! Read `line` first, then `value` and `module`; `host`, `remote_host`, `guard` and `course`; `token`, `thinking` and `json_fault`.

pub mod course;
pub mod guard;
pub mod host;
mod json_fault;
pub mod line;
pub mod module;
pub mod remote_host;
#[cfg(feature = "schema")]
pub mod schema;
pub mod thinking;
pub mod token;
pub mod value;
