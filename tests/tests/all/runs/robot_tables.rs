//! The seam to a robot: tables made at run time, and readings of every kind.

use rpl_lang::compile::NoFiles;
use rpl_lang::symbol::Symbol;
use rpl_mission::libraries::base_natives;
use rpl_runtime::robot::reading::{MAX_NESTING, Reading, ReadingList, TooNested};
use rpl_runtime::robot::{FluentSpec, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::run::library::Library;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::sync::Arc;

/// Says something in every step.
struct Talker {
    tables: RobotTables,
    says: Reading,
}

impl Talker {
    /// With a fluent of this name.
    fn new(fluent: &str, says: Reading) -> Self {
        let fluent =
            FluentSpec { name: fluent.to_string().into(), doc: "What it says.".into(), continuous: true, first: None };
        Self { tables: RobotTables { fluents: vec![fluent], ..RobotTables::default() }, says }
    }
}

impl Outside for Talker {
    fn tables(&self) -> &RobotTables {
        &self.tables
    }

    fn start(&mut self, _: &Machine, _: u16, _: &[(Symbol, Value)], _: &mut Outbox) -> Result<(), Raise> {
        unreachable!("it has no behaviours")
    }

    fn stop(&mut self, _: u16, _: StopReason, _: &mut Outbox) {}

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        Some(stepped_us + 50_000)
    }

    fn step(&mut self, _: u64, _: Phases<'_>, outbox: &mut Outbox) {
        outbox.fluents.push((0, self.says.clone()));
    }
}

fn start(robot: Talker, plan: &str) -> System<Talker> {
    let library = Library::new(base_natives(), &[("prelude", rpl_stdlib::PRELUDE)], robot.tables())
        .unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    let loaded = library.load("plan.rpl", plan, &mut NoFiles).unwrap_or_else(|error| panic!("{}", error.render(false)));
    System::new(Arc::new(library), loaded, robot, 0)
}

fn outcome(system: &System<Talker>) -> String {
    match system.outcome() {
        Some(Outcome::Succeeded(value)) => format!("=> {}", system.machine.write(&system.program, value)),
        Some(Outcome::Failed(failure)) => format!("failed: {}", system.machine.show(&system.program, failure)),
        Some(Outcome::Evaporated) | None => panic!("it has no outcome"),
    }
}

fn told(says: Reading) -> String {
    let mut system = start(Talker::new("heard*", says), "(value heard*)");
    system.run_until(1_000_000);
    outcome(&system)
}

fn list(items: impl IntoIterator<Item = Reading>) -> Reading {
    Reading::List(ReadingList::new(items.into_iter().collect()).expect("it is flat enough"))
}

#[test]
fn readings_of_every_kind_are_values() {
    let symbol = |name: &str| Reading::Symbol(name.to_string());
    assert_eq!(told(Reading::Truth(true)), "=> t");
    assert_eq!(told(Reading::Text("two \"words\"".to_string())), "=> \"two \\\"words\\\"\"");
    assert_eq!(told(list([])), "=> nil");
    let seen = list([symbol("cup"), Reading::Float(1.5), list([Reading::Int(3), Reading::Text("red".to_string())])]);
    assert_eq!(told(list([seen, Reading::Truth(false)])), "=> ((cup 1.5 (3 \"red\")) nil)");
}

#[test]
fn lists_are_nested_to_a_bound() {
    let mut nested = list([]);
    for _ in 1..MAX_NESTING {
        nested = list([nested]);
    }
    assert!(told(nested.clone()).ends_with(&")".repeat(MAX_NESTING - 1)));
    let refused = ReadingList::new(vec![nested]);
    assert_eq!(refused, Err(TooNested));
    assert!(TooNested.to_string().contains(&format!("at most {MAX_NESTING} deep")));
}

/// A list of `count` numbers, made anew each time.
fn numbers(count: i64) -> Reading {
    list((0..count).map(Reading::Int))
}

#[test]
fn a_robot_that_talks_while_all_tasks_wait_does_not_fill_the_memory() {
    let mut system = start(Talker::new("heard*", numbers(20_000)), "(wait-time 60)");
    system.machine.limits.bytes = 32 << 20;
    let mut most = 0;
    while system.outcome().is_none() {
        system.advance();
        most = most.max(system.machine.used_bytes());
    }
    assert_eq!(outcome(&system), "=> nil");
    assert!(most < 32 << 20, "{most} bytes");
}

#[test]
fn a_reading_that_does_not_fit_fails_the_task_that_wants_memory_next() {
    let mut system = start(Talker::new("heard*", numbers(10)), "(wait-time 1) (length (list 1 2 3))");
    system.machine.limits.bytes = 16 << 20;
    system.outside.says = numbers(1_000_000);
    system.run_until(10_000_000);
    let outcome = outcome(&system);
    assert!(outcome.contains("16 MiB"), "{outcome}");
}
