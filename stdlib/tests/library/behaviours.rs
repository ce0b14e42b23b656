//! `run-behaviour`, with a behaviour that digs for two steps.

use rpl_lang::compile::NoFiles;
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::{BehaviourSpec, Ending, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::run::library::Library;
use rpl_runtime::run::system::{Progress, System};
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::sync::{Arc, LazyLock};

/// A behaviour that succeeds after some steps, or strikes a rock.
#[derive(Debug, Default)]
struct Digger {
    steps_left: Option<u32>,
    rock: bool,
    stops: u32,
}

impl Outside for Digger {
    fn tables(&self) -> &RobotTables {
        static TABLES: LazyLock<RobotTables> = LazyLock::new(|| {
            let (name, doc, parameters) = ("digging".into(), "Digs.".into(), "&key steps rock".into());
            let digging = BehaviourSpec { name, doc, valve: None, parameters };
            RobotTables { behaviours: vec![digging], ..RobotTables::default() }
        });
        &TABLES
    }

    fn start(&mut self, machine: &Machine, _: u16, arguments: &[(Symbol, Value)], _: &mut Outbox) -> Result<(), Raise> {
        self.steps_left = Some(2);
        for &(name, value) in arguments {
            match (machine.symbols.name(name), value) {
                ("steps", Value::Int(steps)) => self.steps_left = Some(steps as u32),
                ("rock", value) => self.rock = value.is_true(),
                (other, _) => return Err(Raise::type_error(format!("no parameter {other}"))),
            }
        }
        Ok(())
    }

    fn stop(&mut self, _: u16, _: StopReason, _: &mut Outbox) {
        self.steps_left = None;
        self.stops += 1;
    }

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        Some(stepped_us + 1_000_000)
    }

    fn step(&mut self, _: u64, _: Phases<'_>, outbox: &mut Outbox) {
        let Some(left) = self.steps_left.as_mut() else { return };
        *left -= 1;
        if *left == 0 {
            self.steps_left = None;
            let rock = || Ending::failure("blocked", "a rock");
            outbox.endings.push((0, if self.rock { rock() } else { Ending::DONE }));
        }
    }
}

/// The printed value of a text, and the robot after it.
fn dig(text: &str) -> (String, Digger) {
    let mut natives = rpl_stdlib::natives();
    natives.extend(rpl_runtime::step::natives::natives());
    let library = Library::new(natives, &[("prelude.rpl", rpl_stdlib::PRELUDE)], Digger::default().tables());
    let library = Arc::new(library.unwrap_or_else(|rejected| panic!("{}", rejected.render(false))));
    let loaded = library.load("test", text, &mut NoFiles);
    let loaded = loaded.unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    let mut system = System::new(library, loaded, Digger::default(), 0);
    while system.advance() == Progress::Running {}
    let shown =
        system.with_machine(|machine, around| machine.show(around.program, *machine.tasks[machine.main].value()));
    (shown, system.outside)
}

#[test]
fn it_waits_for_success() {
    let (value, digger) = dig("(run-behaviour digging :steps 3) (now)");
    assert_eq!(value, "3.0");
    assert_eq!(digger.steps_left, None);
}

#[test]
fn it_fails_as_the_behaviour_does() {
    let (value, digger) = dig("(run-behaviour digging :rock t)");
    assert_eq!(value, "blocked: a rock");
    assert_eq!(digger.steps_left, None);
}

/// r[behaviour.run]
#[test]
fn cut_short_it_stops_the_behaviour() {
    let (value, digger) =
        dig("(ignore-failures (timeout) (with-timeout 2.5 (run-behaviour digging :steps 100))) (now)");
    assert_eq!(value, "2.5");
    assert_eq!((digger.steps_left, digger.stops), (None, 1), "it would still be digging");
}

#[test]
fn the_behaviour_may_be_computed_once() {
    let (value, _) = dig("(let ((n 0)) (run-behaviour (progn (incf n) digging)) (list n (now)))");
    assert_eq!(value, "(1 2.0)");
}
