//! The controller: what runs on the robot itself. Of the world it has percepts, and commands go out; the
//! truth is the host's.

use super::behaviours::OfficeModules;
use super::behaviours::body::WHEELS;
use super::board::Board;
use super::composition::Composition;
use super::immobility::IMMOBILE_S;
use super::model::OfficeModel;
use super::module::{Module, Moment, Start, Telling};
use super::report::Report;
use crate::geometry::Velocity;
use crate::localization::Estimate;
use crate::simulator::{Commands, Percept};
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::{Ending, Outbox, StopReason};
use rpl_runtime::state::activation::{Phase, Phases};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::any::{Any, TypeId};
use std::sync::Arc;

/// What runs on the robot.
#[derive(Clone)]
pub struct Controller<M: Module = OfficeModules> {
    /// What does not change.
    pub model: Arc<OfficeModel>,
    /// What the modules offer.
    pub composition: Arc<Composition<M>>,
    /// What the modules share.
    pub board: Board,
    /// The modules.
    pub modules: M,
}

impl<M: Module> Controller<M> {
    pub(super) fn new(model: Arc<OfficeModel>, composition: Arc<Composition<M>>, seed: u64) -> Self {
        let modules = M::new(&composition.settings, &model, seed);
        Self { board: Board::new(&model), modules, composition, model }
    }

    /// Where the robot believes itself to be, and how certain it is. Without a map: where its odometry
    /// says it is, in `odom`.
    pub fn estimate(&self) -> Estimate {
        self.board.position.estimate(self.model.map.as_ref())
    }

    fn phases(&self, phases: Phases<'_>) -> Vec<Phase> {
        (0..self.composition.tables.behaviours.len()).map(|behaviour| phases.of(behaviour as u16)).collect()
    }

    /// What the robot is to do in the next step.
    pub(super) fn take_commands(&mut self, phases: Phases<'_>) -> Commands {
        let Velocity { translation_mps, rotation_radps } = self.board.drive_request;
        let mut commands = Commands { translation_mps, rotation_radps, ..Commands::default() };
        let phases = self.phases(phases);
        self.modules.command(self.board.mode, &phases, &mut commands);
        commands
    }

    /// One step of all modules; afterwards they tell how things stand.
    pub(super) fn step(&mut self, phases: Phases<'_>, percept: Percept, outbox: &mut Outbox) {
        let mut phases = self.phases(phases);
        let Self { model, board, modules, .. } = self;
        board.inbox.extend(percept.messages.iter().cloned());
        let (mode, unread) = (board.mode, board.inbox.len());
        let now = Moment { model, percept: &percept, mode, unread, phases: &phases };
        let mut wanted = modules.step(&now, &mut board.position, &mut Telling::of_all(outbox));
        if board.immobility.watch(board.drive_request, &percept) {
            wanted = None;
            outbox.events.push(Report::Immobile { battery: percept.battery }.into());
            for behaviour in drivers(&self.composition, &phases, outbox) {
                modules.stop(behaviour, StopReason::Deactivated, &mut Telling::of_all(outbox));
                outbox.endings.push((behaviour as u16, immobile(percept.battery)));
            }
        }
        board.drive_request = wanted.unwrap_or_default();
        for (behaviour, _) in &outbox.endings {
            phases[usize::from(*behaviour)] = Phase::Done;
        }
        let now = Moment { model, percept: &percept, mode, unread, phases: &phases };
        modules.publish(&now, &board.position, &mut Telling::of_all(outbox));
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
        let Self { model, board, modules, .. } = self;
        let time_us = board.percept.as_ref().map_or(0, |percept| percept.time_us);
        let start = Start { model, machine, arguments, time_us };
        let tell = &mut Telling::of_all(outbox);
        modules.start(usize::from(behaviour), &start, &mut board.position, tell)?;
        if board.position.take_given_up() {
            modules.publish_position(model, &board.position, tell);
        }
        Ok(())
    }

    /// Stops a behaviour. If it drives, the robot stands.
    pub(super) fn stop(&mut self, behaviour: u16, why: StopReason, outbox: &mut Outbox) {
        let behaviour = usize::from(behaviour);
        if self.composition.tables.behaviours[behaviour].valve == Some(WHEELS) {
            self.board.drive_request = Velocity::default();
        }
        self.modules.stop(behaviour, why, &mut Telling::of_all(outbox));
    }

    /// What speaks for modules outside was started anew. Whether there is such a thing.
    pub(super) fn renew(&mut self, outbox: &mut Outbox) -> bool {
        self.modules.renew(&mut Telling::of_all(outbox))
    }

    /// What functions of plans work on: the model, what the modules share, or a module.
    pub(super) fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        if of == TypeId::of::<Arc<OfficeModel>>() {
            Some(&mut self.model)
        } else if of == TypeId::of::<Board>() {
            Some(&mut self.board)
        } else {
            self.modules.part(of)
        }
    }
}

/// The behaviours that drive and have not ended.
fn drivers<M: Module>(composition: &Composition<M>, phases: &[Phase], outbox: &Outbox) -> Vec<usize> {
    let has_ended = |behaviour: usize| outbox.endings.iter().any(|&(ended, _)| usize::from(ended) == behaviour);
    let drives = |&behaviour: &usize| {
        let needs_wheels = composition.tables.behaviours[behaviour].valve == Some(WHEELS);
        needs_wheels && phases[behaviour] == Phase::Active && !has_ended(behaviour)
    };
    (0..phases.len()).filter(drives).collect()
}

/// The failure of what drives a robot that does not move.
fn immobile(battery: f64) -> Ending {
    let why = match battery > 0.0 {
        true => "is its emergency stop pressed, or does something hold a wheel?",
        false => "its battery is empty",
    };
    Ending::failure("immobile", format!("for {IMMOBILE_S} s the robot was to drive and has not moved: {why}"))
}
