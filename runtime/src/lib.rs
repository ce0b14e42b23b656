//! Values, heap, tasks, fluents, valves, failures, timers, scheduler, trace.

pub mod behaviour;
pub mod run;
pub mod state;
pub mod step;
