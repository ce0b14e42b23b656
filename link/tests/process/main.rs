//! Modules in processes, from the greeting to the end: `sh` plays the module.

mod ending;
mod faults;
mod module;
mod right;
