//! Runs.

pub mod beside;
pub mod datum;
pub mod difference;
pub mod disturbance;
pub mod execute_plan;
pub mod instants;
pub mod invariants;
pub mod library;
pub mod macro_host;
pub mod save;
pub mod session;
pub mod stepping;
pub mod system;
pub mod timeline;
pub mod units;
pub mod validate;
pub mod variables;
