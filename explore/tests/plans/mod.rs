//! Plans without a robot, compiled, started and searched.

use rpl_explore::search::{Bounds, Searched, explore};
use rpl_lang::compile::NoFiles;
use rpl_lang::source::SourceId;
use rpl_runtime::robot::{NoRobot, RobotTables};
use rpl_runtime::run::canonical::Visible;
use rpl_runtime::run::library::{Library, Loaded};
use rpl_runtime::run::system::System;
use std::ops::ControlFlow::Continue;
use std::sync::{Arc, LazyLock};

/// Compiled once.
static LIBRARY: LazyLock<Arc<Library>> = LazyLock::new(|| {
    let natives = [rpl_runtime::step::natives::natives(), rpl_stdlib::natives()].concat();
    let library = Library::new(natives, &[("prelude", rpl_stdlib::PRELUDE)], RobotTables::EMPTY);
    Arc::new(library.unwrap_or_else(|why| panic!("{}", why.render(false))))
});

/// Steps of an instant: a program that goes round without waiting is soon a runaway.
const MAX_STEPS: u32 = 10_000;

/// All orders.
pub const BOUNDS: Bounds =
    Bounds { deviations: u32::MAX, states: 100_000, until_us: 3_600_000_000, deterministic: false };

/// A run that has not begun, and the number of its text.
pub fn started(text: &str, traced: bool) -> (System<NoRobot>, SourceId) {
    let (library, loaded) = loaded(text);
    let own = loaded.program.codes[loaded.main as usize].span.source;
    let start = if traced { System::traced } else { System::new };
    let mut system = start(library, loaded, NoRobot, 1);
    system.machine.limits.steps = MAX_STEPS;
    (system, own)
}

pub fn loaded(text: &str) -> (Arc<Library>, Loaded) {
    let library = LIBRARY.clone();
    let loaded = library.load("plan.rpl", text, &mut NoFiles).unwrap_or_else(|why| panic!("{}", why.render(false)));
    (library, loaded)
}

pub fn searched(text: &str, bounds: Bounds) -> Searched {
    let (library, loaded) = loaded(text);
    let visible = Visible::by(&loaded, &library);
    let (start, _) = started(text, false);
    explore(&start, visible, bounds, |_| Continue(()))
}
