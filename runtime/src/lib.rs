//! Values, heap, tasks, fluents, valves, failures, timers, scheduler, trace.
//!
//! The whole run is one value, [`run::system::System`], that [`run::system::System::advance`] steps from instant to
//! instant. Nothing here knows a clock, a thread, a file or a robot: time is virtual, and the robot stands behind
//! [`robot::Outside`].
//!
//! Four floors, each of which imports only from those below it:
//!
//! - [`run`]: the whole: start, instants, sessions, stepping, going back, saving;
//! - [`step`]: the changes of the records; `exec` is the loop;
//! - [`robot`]: the seam to a robot: tables, readings, events;
//! - [`state`]: records, each with the operations that keep it whole.
//!
//! Read in this order: [`state::value`], [`state::task`], [`state::machine`], `step::exec`, `step::construct`,
//! [`step::tasks`], `step::fluents`, `step::valve`, [`robot`], [`run::system`].

pub mod robot;
pub mod run;
pub mod state;
pub mod step;
