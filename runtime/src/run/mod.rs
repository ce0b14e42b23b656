//! Runs as values: started, stepped from instant to instant, forked, saved, gone back in, looked at.

mod base;
pub mod beside;
pub mod canonical;
pub mod choices;
mod compiled_library;
mod datum;
pub mod difference;
pub mod disturbance;
mod execute_plan;
mod instants;
mod invariants;
pub mod library;
mod macro_host;
mod paired;
pub mod projection;
mod projection_record;
mod race;
pub mod resumption;
pub mod save;
pub mod session;
pub mod stepping;
pub mod system;
pub mod timeline;
mod units;
mod validate;
pub mod variables;
