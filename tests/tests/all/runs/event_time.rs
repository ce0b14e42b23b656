//! A robot that says when something happens to it next: the run comes to those instants and to no others.

use rpl_lang::compile::NoFiles;
use rpl_lang::symbol::Symbol;
use rpl_mission::libraries::base_natives;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{FluentSpec, NEVER_US, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::run::library::Library;
use rpl_runtime::run::system::{Outcome, Progress, System};
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::sync::Arc;

/// A letter box that is filled at known times; what it says follows time in between.
struct LetterBox {
    tables: RobotTables,
    /// When letters come, in microseconds.
    letters_us: Vec<u64>,
    follows_time: bool,
    steps: u32,
}

impl LetterBox {
    fn new(letters_s: &[u64], follows_time: bool) -> Self {
        let fluent = |name: &'static str, continuous| FluentSpec {
            name: name.into(),
            doc: "What it says.".into(),
            continuous,
            first: Some(0),
        };
        let tables =
            RobotTables { fluents: vec![fluent("letters*", false), fluent("age*", true)], ..RobotTables::default() };
        let letters_us = letters_s.iter().map(|second| second * 1_000_000).collect();
        Self { tables, letters_us, follows_time, steps: 0 }
    }
}

impl Outside for LetterBox {
    fn tables(&self) -> &RobotTables {
        &self.tables
    }

    fn start(&mut self, _: &Machine, _: u16, _: &[(Symbol, Value)], _: &mut Outbox) -> Result<(), Raise> {
        unreachable!("it has no behaviours")
    }

    fn stop(&mut self, _: u16, _: StopReason, _: &mut Outbox) {}

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        Some(self.letters_us.iter().copied().find(|&letter_us| letter_us > stepped_us).unwrap_or(NEVER_US))
    }

    fn steps_at(&self, stepped_us: u64, now_us: u64) -> bool {
        self.follows_time || self.next_event_us(stepped_us).is_some_and(|next_us| next_us <= now_us)
    }

    fn step(&mut self, now_us: u64, _: Phases<'_>, outbox: &mut Outbox) {
        self.steps += 1;
        let letters = self.letters_us.iter().filter(|&&letter_us| letter_us <= now_us).count();
        outbox.fluents.push((0, Reading::Int(letters as i64)));
        outbox.fluents.push((1, Reading::Int((now_us / 1_000_000) as i64)));
    }
}

/// The value of a plan beside the letter box, as it is shown, and how often the box made a step.
fn run(robot: LetterBox, plan: &str) -> (String, u32) {
    let library = Library::new(base_natives(), &[("prelude", rpl_stdlib::PRELUDE)], robot.tables())
        .unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    let loaded = library.load("plan.rpl", plan, &mut NoFiles).unwrap_or_else(|error| panic!("{}", error.render(false)));
    let mut system = System::new(Arc::new(library), loaded, robot, 0);
    while system.machine.now_us < 10_000_000_000 && system.advance() == Progress::Running {}
    match system.outcome() {
        Some(Outcome::Succeeded(value)) => (system.machine.write(&system.program, value), system.outside.steps),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_hour_costs_as_many_steps_as_things_happen() {
    let (value, steps) = run(LetterBox::new(&[100, 2_000, 3_600], false), "(wait-for (= letters* 3)) (now)");
    assert_eq!((value.as_str(), steps), ("3600.0", 4), "the first step is that of the start");
}

#[test]
fn timers_come_between_its_events_and_are_no_steps() {
    let plan = "(let ((at nil)) (n-times 3 (wait-time 40) (push (list (now) (value letters*)) at)) (reverse at))";
    let (value, steps) = run(LetterBox::new(&[50, 90], false), plan);
    assert_eq!((value.as_str(), steps), ("((40.0 0) (80.0 1) (120.0 2))", 3));
}

#[test]
fn what_follows_time_is_read_as_it_is_at_each_instant() {
    let (value, steps) = run(LetterBox::new(&[50], true), "(wait-time 7) (prog1 (value age*) (wait-time 1))");
    assert_eq!((value.as_str(), steps), ("7", 3));
}

#[test]
fn who_waits_for_what_never_happens_by_itself_is_not_deadlocked() {
    let plan = "(try-all (seq (wait-for (= letters* 9)) 'full) (seq (wait-time 5000) 'patient))";
    assert_eq!(run(LetterBox::new(&[1], false), plan).0, "patient");
}
