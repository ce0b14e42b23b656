//! What plans can call: native functions without effects on tasks, and the prelude, the derived
//! constructs and list functions written in RPL itself.
//!
//! A native gives its value at once: it never waits, never calls back into a plan and never walks
//! a circular list without end. Whatever takes a function as an argument stands in the prelude.
//! Tasks, fluents, time, valves and behaviours belong to the runtime.
//!
//! Revision is a plan of this library (`prelude/revision.rpl`, `prelude/rules.rpl`). Rules are functions from a
//! projection and a plan, as data, to a plan. `with-foresight` is a policy. It compares what the rules make of a plan
//! with the plan that runs, each as a projected `swap-plan`, and swaps in the better one.
//!
//! Read `arguments` and `support` first, then the natives by topic, from `predicates` and `numbers` on; then the
//! prelude: `constructs.rpl`, `functions.rpl`, `queues.rpl`, `foresight.rpl`, `revision.rpl`, `rules.rpl`.

mod arguments;
mod elements;
mod format;
mod lists;
mod merging;
mod numbers;
mod places;
mod predicates;
mod rounding;
mod sets;
mod sorting;
mod strings;
mod support;
mod symbols;
mod tables;
mod transcendental;
mod vectors;

use rpl_runtime::step::native::Native;

/// The library in RPL: macros first, then functions. It uses only natives and special forms.
pub const PRELUDE: &str = concat!(
    include_str!("prelude/constructs.rpl"),
    "\n",
    include_str!("prelude/functions.rpl"),
    "\n",
    include_str!("prelude/queues.rpl"),
    "\n",
    include_str!("prelude/foresight.rpl"),
    "\n",
    include_str!("prelude/revision.rpl"),
    "\n",
    include_str!("prelude/rules.rpl"),
);

/// All native functions of the library, in a fixed order.
pub fn natives() -> Vec<Native> {
    [
        numbers::NATIVES,
        rounding::NATIVES,
        transcendental::NATIVES,
        predicates::NATIVES,
        lists::NATIVES,
        elements::NATIVES,
        sets::NATIVES,
        sorting::NATIVES,
        merging::NATIVES,
        places::NATIVES,
        strings::NATIVES,
        symbols::NATIVES,
        tables::NATIVES,
        vectors::NATIVES,
        format::NATIVES,
        support::NATIVES,
    ]
    .concat()
}
