//! The controller: what runs on the robot itself. Of the world it has percepts, and commands go out; the
//! truth is the host's.

use super::behaviours::body::WHEELS;
use super::behaviours::module::{Moment, Start};
use super::behaviours::{Modules, tables};
use super::board::Board;
use super::model::OfficeModel;
use crate::geometry::Velocity;
use crate::localization::Estimate;
use crate::simulator::{Commands, Percept};
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::{Outbox, StopReason};
use rpl_runtime::state::activation::{Phase, Phases};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::sync::Arc;

/// What runs on the robot.
#[derive(Clone)]
pub struct Controller {
    /// What does not change.
    pub model: Arc<OfficeModel>,
    /// What the modules share.
    pub board: Board,
    /// The modules.
    pub modules: Modules,
}

impl Controller {
    pub(super) fn new(model: Arc<OfficeModel>, seed: u64) -> Self {
        Self { board: Board::new(&model), modules: Modules::new(&model, seed), model }
    }

    /// Where the robot believes itself to be, and how certain it is. Without a map: where its odometry
    /// says it is, in `odom`.
    pub fn estimate(&self) -> Estimate {
        self.board.position.estimate(self.model.map.as_ref())
    }

    /// What the robot is to do in the next step.
    pub(super) fn take_commands(&mut self, phases: Phases<'_>) -> Commands {
        let Velocity { translation_mps, rotation_radps } = self.board.drive_request;
        let mut commands = Commands { translation_mps, rotation_radps, ..Commands::default() };
        for (number, module) in self.modules.numbered() {
            module.command(self.board.mode, phase_of(phases, number), &mut commands);
        }
        commands
    }

    /// One step of all modules; afterwards they tell how things stand.
    pub(super) fn step(&mut self, phases: Phases<'_>, percept: Percept, outbox: &mut Outbox) {
        let Self { model, board, modules } = self;
        board.drive_request = Velocity::default();
        board.inbox.extend(percept.messages.iter().cloned());
        let mut now =
            Moment { model, percept: &percept, mode: board.mode, unread: board.inbox.len(), phase: Phase::Inactive };
        for (number, module) in modules.numbered() {
            now.phase = phase_of(phases, number);
            let work = module.step(&now, &mut board.position, &mut outbox.events);
            board.drive_request = work.velocity.unwrap_or(board.drive_request);
            outbox.endings.extend(number.zip(work.ending));
        }
        for (number, module) in modules.numbered() {
            let is_over = outbox.endings.iter().any(|(ended, _)| Some(*ended) == number);
            now.phase = if is_over { Phase::Done } else { phase_of(phases, number) };
            module.publish(&now, &board.position, outbox);
        }
        // Without a map what was told is where the odometry was before this step.
        board.position.end_step(percept.odometry_in_odom);
        board.percept = Some(percept);
    }

    /// Starts a behaviour.
    pub(super) fn start(
        &mut self,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise> {
        let time_us = self.board.percept.as_ref().map_or(0, |percept| percept.time_us);
        let start = Start { model: &self.model, machine, arguments, time_us };
        match self.modules.of(behaviour) {
            Some(module) => module.start(&start, &mut self.board.position, outbox),
            None => unreachable!("the tables have no behaviour {behaviour}"),
        }
    }

    /// Stops a behaviour. If it drives, the robot stands.
    pub(super) fn stop(&mut self, behaviour: u16, how: StopReason, outbox: &mut Outbox) {
        if tables().behaviours[usize::from(behaviour)].valve == Some(WHEELS) {
            self.board.drive_request = Velocity::default();
        }
        if let Some(module) = self.modules.of(behaviour) {
            module.stop(how, outbox);
        }
    }
}

/// Where a module's behaviour stands; one without a behaviour stands nowhere.
fn phase_of(phases: Phases<'_>, number: Option<u16>) -> Phase {
    number.map_or(Phase::Inactive, |number| phases.of(number))
}
