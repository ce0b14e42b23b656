//! Modules in other processes: behaviours, fluents and valves that a program of somebody else brings,
//! in whatever language. A manifest says what they are, messages what becomes of them.

mod foreseen_modules;
pub mod manifest;
pub mod message;
pub mod modules_alone;
pub mod process_module;
pub mod process_modules;
mod queries;
