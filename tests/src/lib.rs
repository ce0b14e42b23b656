//! What the end-to-end tests share: running a text to its end, with or without a robot.

pub mod attacker;
pub mod deliveries;
pub mod forger;
pub mod generated;
pub mod mission;
pub mod options;
pub mod repository;
pub mod valves;

use rpl_lang::compile::NoFiles;
use rpl_mission::libraries::library_without_robot;
use rpl_runtime::robot::{NoRobot, Outside};
use rpl_runtime::run::library::Library;
use rpl_runtime::run::system::{Outcome, Progress, System};
use rpl_runtime::state::output::{Channel, Output};
use rpl_runtime::state::trace::Event;
use std::sync::{Arc, OnceLock};

/// The library without a robot, compiled once.
pub fn library() -> &'static Arc<Library> {
    static LIBRARY: OnceLock<Arc<Library>> = OnceLock::new();
    LIBRARY.get_or_init(|| library_without_robot(Vec::new()).unwrap_or_else(|error| panic!("{error}")))
}

/// The seed of every run without a robot.
const SEED: u64 = 0;

/// A run of a text without a robot, at its start.
pub fn system(text: &str) -> System<NoRobot> {
    match System::without_robot(library(), "test.rpl", text, SEED) {
        Ok(system) => system,
        Err(rejected) => panic!("{}", rejected.render(false)),
    }
}

/// The same with its trace switched on, from the first event.
pub fn traced(text: &str) -> System<NoRobot> {
    match library().load("test.rpl", text, &mut NoFiles) {
        Ok(loaded) => System::traced(library().clone(), loaded, NoRobot, SEED),
        Err(rejected) => panic!("{}", rejected.render(false)),
    }
}

/// A session without a robot, at its start.
pub fn session() -> System<NoRobot> {
    System::session(library(), NoRobot, SEED).unwrap_or_else(|rejected| panic!("{}", rejected.render(false)))
}

/// What a text does, in lines: its output, then its value or failure.
pub fn run(text: &str) -> String {
    let mut system = match System::without_robot(library(), "test.rpl", text, SEED) {
        Ok(system) => system,
        Err(rejected) => return rejected.render(false),
    };
    loop {
        let progress = system.advance();
        if let Err(broken) = system.machine.check_invariants() {
            panic!("after an instant of\n{text}\n{broken}");
        }
        if progress == Progress::Ended {
            return transcript(&mut system);
        }
    }
}

/// Runs a text and compares what it does, in lines, with what it should do.
///
/// # Panics
/// If they differ, with the text.
#[track_caller]
pub fn check(text: &str, expected: &str) {
    assert_eq!(run(text), expected, "{text}");
}

/// The output of an ended run, then its value or failure.
pub fn transcript(system: &mut System<NoRobot>) -> String {
    let output = std::mem::take(&mut system.machine.output);
    let mut lines: Vec<String> = output.into_iter().map(output_text).collect();
    lines.push(outcome_text(system));
    lines.join("\n")
}

/// What was printed or logged, as it is compared.
pub fn output_text(output: Output) -> String {
    match output.channel {
        Channel::Print => output.text,
        Channel::Log => format!("log: {}", output.text),
    }
}

/// The value or failure of a run, in one line.
pub fn outcome_text<O: Outside>(system: &System<O>) -> String {
    let (machine, program) = (&system.machine, &system.program);
    match system.outcome() {
        Some(Outcome::Succeeded(value)) => format!("=> {}", machine.write(program, value)),
        Some(Outcome::Failed(failure)) => format!("failed: {}", machine.show(program, failure)),
        Some(Outcome::Evaporated) => "evaporated".to_string(),
        None => "still running".to_string(),
    }
}

/// A detail of an event, empty if it has none of the name.
pub fn detail<'e>(event: &'e Event, name: &str) -> &'e str {
    event.details.iter().find(|(known, _)| known == name).map_or("", |(_, value)| value)
}
