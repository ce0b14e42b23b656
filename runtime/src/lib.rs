//! Values, heap, tasks, fluents, valves, failures, timers, scheduler, trace.
//!
//! The whole run is one value, [`system::System`], that [`system::System::advance`] steps from
//! instant to instant. Nothing here knows a clock, a thread, a file or a robot: time is virtual,
//! and the robot stands behind [`behaviour::Outside`].
//!
//! Read in this order: [`value`], [`heap`], [`task`], [`machine`], `exec`, `construct`, `unwind`,
//! [`fluent`], [`valve`], [`behaviour`], [`system`].

pub mod active_time;
pub mod behaviour;
pub mod beside;
mod circle;
mod construct;
mod datum;
pub mod difference;
pub mod disturbance;
mod exec;
pub mod failure;
pub mod fluent;
mod gc;
pub mod heap;
mod invariants;
pub mod library;
pub mod machine;
mod macro_host;
pub mod memory;
pub mod native;
pub mod natives;
pub mod print;
pub mod registers;
pub mod save;
pub mod scheduler;
pub mod session;
pub mod slab;
pub mod small_set;
pub mod stall;
pub mod stepping;
pub mod system;
pub mod task;
pub mod time;
pub mod timeline;
pub mod trace;
mod tree;
mod units;
mod unwind;
mod validate;
pub mod value;
pub mod valve;
pub mod valve_line;
pub mod waiting;
