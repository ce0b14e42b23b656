//! Native functions on what the runtime itself keeps: fluents, tasks, time, valves, behaviours,
//! failures, calls, revision and output.

mod behaviours;
mod calls;
mod failures;
mod fluents;
mod foresight;
mod revision;
mod tasks;
mod valves;
mod within;

use crate::step::native::Native;

/// All of them, in a fixed order.
pub fn natives() -> Vec<Native> {
    [
        fluents::NATIVES,
        within::NATIVES,
        tasks::NATIVES,
        valves::NATIVES,
        behaviours::NATIVES,
        failures::NATIVES,
        calls::NATIVES,
        revision::NATIVES,
        foresight::NATIVES,
    ]
    .concat()
}
