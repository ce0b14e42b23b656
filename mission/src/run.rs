//! Going on with a run from instant to instant, and what its trace leaves out.

use rpl_runtime::robot::Outside;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::trace::EventKind;
use rpl_runtime::state::value::Value;
use std::ops::ControlFlow;

/// How far a run has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reached {
    /// Its end.
    End(Outcome),
    /// The time that was given: the next instant lies behind it.
    Time,
    /// Where it was to stop.
    Stop,
}

/// Goes on from instant to instant up to a time of the plan, in microseconds. At the end of each
/// instant, when all tasks are blocked, whoever runs it looks at the run and says whether it goes on;
/// nothing keeps them from taking out what was printed or traced. A run that has ended is looked at
/// once more.
pub fn run_to<O: Outside>(
    system: &mut System<O>,
    until_us: u64,
    mut look: impl FnMut(&mut System<O>) -> ControlFlow<()>,
) -> Reached {
    loop {
        system.settle();
        let choice = look(system);
        if let Some(outcome) = system.outcome() {
            return Reached::End(outcome);
        }
        if choice.is_break() {
            return Reached::Stop;
        }
        if system.next_instant_us().is_some_and(|next_us| next_us > until_us) {
            return Reached::Time;
        }
        system.next_instant();
    }
}

/// The value of a fluent of the robot, or of a global one of the plan, if there is one of the name.
pub fn fluent_value<O: Outside>(system: &System<O>, name: &str) -> Option<Value> {
    fluent_named(system, name).map(|fluent| system.machine.fluents[fluent].value)
}

/// Keeps the fluents that change in every step out of the trace, also the changes it has already.
pub fn silence_continuous_fluents<O: Outside>(system: &mut System<O>) {
    let names: Vec<String> = system.outside.tables().continuous_fluents().map(str::to_string).collect();
    let fluents: Vec<u32> = names.iter().filter_map(|name| fluent_named(system, name)).collect();
    system.machine.trace.quiet.extend(fluents);
    // The first step of the robot was traced before anybody could say which fluents are quiet.
    system.machine.trace.events.retain(|event| {
        event.kind != EventKind::Fluent
            || !event.details.iter().any(|(name, value)| name == "fluent" && names.contains(value))
    });
}

fn fluent_named<O: Outside>(system: &System<O>, name: &str) -> Option<u32> {
    let symbol = system.machine.symbols.find(name)?;
    let global = *system.program.names.get(&symbol)?;
    match system.machine.globals.get(global as usize)? {
        Value::Fluent(fluent) => Some(*fluent),
        _ => None,
    }
}
