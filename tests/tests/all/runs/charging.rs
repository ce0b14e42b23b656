//! While a battery is charged a run that waits is not stalled.

use rpl_lang::compile::NoFiles;
use rpl_lang::symbol::Symbol;
use rpl_mission::libraries::base_natives;
use rpl_runtime::robot::{Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::run::library::Library;
use rpl_runtime::run::system::System;
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::sync::Arc;

/// Stands at a charger, until it is full after some seconds.
struct Charging {
    tables: RobotTables,
    full_after_s: u16,
    now_s: u16,
}

impl Outside for Charging {
    fn tables(&self) -> &RobotTables {
        &self.tables
    }

    fn start(&mut self, _: &Machine, _: u16, _: &[(Symbol, Value)], _: &mut Outbox) -> Result<(), Raise> {
        Ok(())
    }

    fn stop(&mut self, _: u16, _: StopReason, _: &mut Outbox) {}

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        Some(stepped_us + 1_000_000)
    }

    fn step(&mut self, now_us: u64, _: Phases<'_>, _: &mut Outbox) {
        self.now_s = (now_us / 1_000_000) as u16;
    }

    fn charge_permille(&self) -> Option<u16> {
        Some(self.now_s.min(self.full_after_s))
    }
}

/// When a run that waits for ever is said to be stalled, in seconds.
fn stalled_at_s(full_after_s: u16) -> u64 {
    let robot = Charging { tables: RobotTables::default(), full_after_s, now_s: 0 };
    let library = Library::new(base_natives(), &[("prelude", rpl_stdlib::PRELUDE)], robot.tables())
        .unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    let plan = "(def-fluent never nil) (wait-for never)";
    let loaded = library.load("plan.rpl", plan, &mut NoFiles).unwrap_or_else(|error| panic!("{}", error.render(false)));
    let mut system = System::new(Arc::new(library), loaded, robot, 0);
    while system.machine.now_us < 2_000_000_000 {
        system.advance();
        if system.machine.output.iter().any(|line| line.text.contains("stalled")) {
            return system.machine.now_us / 1_000_000;
        }
    }
    panic!("it is never said")
}

/// r[deadlock.stalled]
#[test]
fn what_waits_for_a_battery_that_is_charged_is_not_stalled() {
    assert_eq!(stalled_at_s(0), 120);
    let charged_s = stalled_at_s(300);
    assert!((420..=540).contains(&charged_s), "{charged_s}");
}
