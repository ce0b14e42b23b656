//! Modules in other processes where there is no robot of ours: all that plans see comes from them. They hear of time
//! by ticks at a fixed period, and each turn is one of [`ProcessModules`], as on a robot.

use super::foreseen_modules::ForeseenModules;
use super::message::Greeting;
use super::process_modules::ProcessModules;
use rpl_lang::symbol::Symbol;
use rpl_robot::office::{Composition, Module, Report, Telling};
use rpl_runtime::robot::{ForeseenRobot, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::run::save::{SaveOutside, append};
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::projected::Grain;
use rpl_runtime::state::value::Value;
use std::any::{Any, TypeId};
use std::sync::Arc;

/// Microseconds between two ticks: as often as the robots of the papers make a step.
pub const PERIOD_US: u64 = 50_000;

/// Modules in other processes, with no robot beside them.
#[derive(Clone)]
pub struct ModulesAlone {
    composition: Arc<Composition<ProcessModules>>,
    modules: ProcessModules,
    /// When they heard the last tick.
    ticked_us: u64,
}

impl ModulesAlone {
    /// The modules at the start of a run, which have been greeted.
    pub fn new(composition: Arc<Composition<ProcessModules>>, seed: u64) -> Self {
        let modules = ProcessModules::greeted(&composition.settings, Greeting { period_us: PERIOD_US, seed });
        Self { composition, modules, ticked_us: 0 }
    }

    fn names(&self) -> Vec<String> {
        self.composition.reserved_names()
    }
}

impl Outside for ModulesAlone {
    fn tables(&self) -> &RobotTables {
        &self.composition.tables
    }

    fn start(
        &mut self,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise> {
        let tell = &mut Telling::of_all(outbox);
        self.modules.start_one(usize::from(behaviour), (machine, arguments), self.ticked_us, tell)
    }

    fn stop(&mut self, behaviour: u16, why: StopReason, _: &mut Outbox) {
        self.modules.stop_one(usize::from(behaviour), why);
    }

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        Some(stepped_us + PERIOD_US)
    }

    fn renew(&mut self, outbox: &mut Outbox) -> bool {
        outbox.events.push(Report::Resumed.into());
        Module::renew(&mut self.modules, &mut Telling::of_all(outbox))
    }

    fn step(&mut self, now_us: u64, _: Phases<'_>, outbox: &mut Outbox) {
        self.ticked_us = now_us;
        self.modules.turn(now_us, None, &mut Telling::of_all(outbox));
    }

    fn foresee(&self, now_us: u64, phases: Phases<'_>, _: Grain) -> Result<ForeseenRobot, Raise> {
        let (composition, modules) = (self.composition.clone(), self.modules.clone());
        Ok(ForeseenRobot::of(ForeseenModules::new(composition, modules, now_us, phases)?))
    }

    fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        Module::part(&mut self.modules, of)
    }
}

impl SaveOutside for ModulesAlone {
    fn save(&self, bytes: Vec<u8>) -> Vec<u8> {
        append(bytes, &(self.names(), self.ticked_us, &self.modules))
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let read = postcard::from_bytes::<(Vec<String>, u64, ProcessModules)>(bytes);
        let (names, ticked_us, mut modules) = read.map_err(|error| format!("its state is damaged: {error}"))?;
        if names != self.names() {
            return Err("the run was saved with other modules".into());
        }
        Module::resume(&mut modules, &self.modules)?;
        (self.ticked_us, self.modules) = (ticked_us, modules);
        Ok(())
    }
}
