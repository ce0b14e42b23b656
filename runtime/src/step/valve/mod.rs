//! Valves.

pub mod boost;
pub mod hooks;
pub mod links;
pub mod request;
pub mod serving;
