//! The robot: its controller and a host, as the runtime steps them.

use super::abstract_world::{AbstractSetting, AbstractWorld};
use super::behaviours::{OfficeModules, office_modules};
use super::composition::Composition;
use super::controller::Controller;
use super::foreseen_robot::{abstract_robot, foresee};
use super::host::{Host, HostLost, SimulatedHost};
use super::model::OfficeModel;
use super::module::Module;
use super::report::Report;
use super::simulated_robot::SimulatedOffice;
use crate::foresight::models::Models;
use crate::geometry::Pose;
use crate::localization::{Estimate, Localization, Spread};
use crate::simulator::{Contacts, OracleError, Percept};
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::thinking::{Insight, Thought, Ticket};
use rpl_runtime::robot::{ForeseenRobot, Outbox, Outside, RobotEvent, RobotTables, StopReason};
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::projected::Grain;
use rpl_runtime::state::value::Value;
use std::any::{Any, TypeId};
use std::sync::Arc;

/// A robot in its world: what the runtime steps.
#[derive(Clone)]
pub struct OfficeRobot<H = SimulatedHost, M: Module = OfficeModules> {
    /// What runs on it.
    pub controller: Controller<M>,
    /// Who moves it and senses for it.
    pub host: H,
    /// Why the host is gone, once it is: nothing starts any more.
    pub(super) lost: Option<HostLost>,
}

impl<H> OfficeRobot<H> {
    /// The office robot at the start of its world.
    pub fn new(model: Arc<OfficeModel>, host: H, seed: u64) -> Self {
        Self::with_modules(office_modules().clone(), model, host, seed)
    }
}

impl<H, M: Module> OfficeRobot<H, M> {
    /// A robot of these modules at the start of its world.
    pub fn with_modules(composition: Arc<Composition<M>>, model: Arc<OfficeModel>, host: H, seed: u64) -> Self {
        Self { controller: Controller::new(model, composition, seed), host, lost: None }
    }

    /// What does not change.
    pub fn model(&self) -> &Arc<OfficeModel> {
        &self.controller.model
    }

    /// Tells it where it is. Without a map it cannot be told.
    pub fn tell_position(&mut self, pose_in_map: Pose, spread: Spread) {
        let Controller { model, board, .. } = &mut self.controller;
        if let Some(map) = &model.map {
            board.position.tell(map, pose_in_map, spread);
        }
    }

    /// It may be anywhere in its map.
    pub fn forget_position(&mut self) {
        let Controller { model, board, .. } = &mut self.controller;
        if let Some(map) = &model.map {
            board.position.forget(map);
        }
    }

    /// Where it believes itself to be, and how certain it is. Without a map: where its odometry says it is,
    /// in `odom`.
    pub fn estimate(&self) -> Estimate {
        self.controller.estimate()
    }

    /// Probability that its position is not lost.
    pub fn tracking(&self) -> f64 {
        self.controller.board.position.tracking(self.model().map.as_ref())
    }

    /// Where it believes itself to be, also without a map: then by its odometry from the start of the world.
    pub fn estimated_pose_in_map(&self) -> Pose {
        let Estimate { pose_in_map, .. } = self.estimate();
        let model = self.model();
        if model.map.is_some() { pose_in_map } else { model.world.start_in_map.compose(pose_in_map) }
    }

    /// The filter; none without a map.
    pub fn localization(&self) -> Option<&Localization> {
        self.controller.board.position.localization()
    }

    /// Probability of each cell of (x, y), `[row][column]` on the filter's grid; none without a map.
    pub fn belief_xy(&self) -> Option<Vec<f64>> {
        let map = self.model().map.as_ref()?;
        Some(self.localization()?.belief_xy(&map.localization))
    }

    /// Bytes of belief and plans of the way that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        let belief = match (self.localization(), earlier.localization()) {
            (Some(now), Some(earlier)) => now.bytes_apart(earlier),
            (Some(_) | None, _) => 0,
        };
        belief + self.controller.modules.bytes_apart(&earlier.controller.modules)
    }

    /// The abstract robot at the start of a run, with models of what may come between: made of the map and of where
    /// this one believes itself to be.
    ///
    /// # Errors
    /// There is no map.
    pub fn abstract_robot(&self, models: Models) -> Result<ForeseenRobot, Raise> {
        abstract_robot(&self.controller, models)
    }

    /// An abstract world with this robot, at the start of a run.
    ///
    /// # Errors
    /// There is no map.
    pub fn abstract_world(&self, setting: AbstractSetting, seed: u64) -> Result<AbstractWorld<M>, Raise> {
        AbstractWorld::new(&self.controller, setting, seed)
    }

    /// The percept of the last step.
    pub fn percept(&self) -> Option<&Percept> {
        self.controller.board.percept.as_ref()
    }
}

/// What only an experimenter knows and does.
impl<M: Module> OfficeRobot<SimulatedHost, M> {
    /// The same robot at the beginning of a run, put down elsewhere and told so.
    ///
    /// # Errors
    /// Something stands there.
    pub fn starting_at(mut self, start_in_map: Pose) -> Result<Self, OracleError> {
        self.host.model.clone().teleport(&mut self.host.state, start_in_map)?;
        self.tell_position(start_in_map, Spread::default());
        Ok(self)
    }

    /// Where the robot really is.
    pub fn true_pose_in_map(&self) -> Pose {
        self.host.state.true_pose()
    }

    /// Contacts so far.
    pub fn contacts(&self) -> Contacts {
        self.host.state.contacts()
    }

    /// Metres driven so far.
    pub fn distance_driven_m(&self) -> f64 {
        self.host.state.distance_driven_m()
    }
}

/// Nobody thinks about the questions of a host any more, and they are to be asked again.
fn ask_again(host: &mut impl Host) -> Vec<(Ticket, Option<Insight>)> {
    host.forget_questions().into_iter().map(|ticket| (ticket, None)).collect()
}

impl<H: Host + 'static, M: Module> Outside for OfficeRobot<H, M> {
    fn tables(&self) -> &RobotTables {
        &self.controller.composition.tables
    }

    fn start(
        &mut self,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise> {
        match &self.lost {
            None => self.controller.start(machine, behaviour, arguments, outbox),
            Some(HostLost(why)) => Err(Raise::robot_lost(why)),
        }
    }

    fn stop(&mut self, behaviour: u16, how: StopReason, outbox: &mut Outbox) {
        self.controller.stop(behaviour, how, outbox);
    }

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        self.lost.is_none().then(|| stepped_us + self.model().settings.robot.step_us)
    }

    fn charge_permille(&self) -> Option<u16> {
        let percept = self.controller.board.percept.as_ref();
        percept.map(|percept| libm::round(percept.battery * 1000.0) as u16)
    }

    /// Where the world has gone on, all that the robot was doing in it is interrupted, and its position is
    /// doubted: somebody may have moved it.
    fn renew(&mut self, outbox: &mut Outbox) -> bool {
        let is_module_outside = self.controller.renew(outbox);
        let is_host_outside = self.lost.is_none() && self.host.renew();
        if is_host_outside {
            let Controller { model, board, .. } = &mut self.controller;
            if model.map.is_some() {
                board.position.doubt();
            }
            outbox.interrupted = (0..self.tables().behaviours.len() as u16).collect();
            outbox.answers = ask_again(&mut self.host);
        }
        let is_outside = is_module_outside || is_host_outside;
        if is_outside {
            outbox.events.push(Report::Resumed.into());
        }
        is_outside
    }

    fn step(&mut self, _: u64, phases: Phases<'_>, outbox: &mut Outbox) {
        let commands = self.controller.take_commands(phases);
        let mut reports = Vec::new();
        let stepped = self.host.step(&commands, &mut reports);
        if let Err(HostLost(why)) = &stepped {
            reports.push(Report::HostLost { why: why.clone() });
        }
        outbox.events.extend(reports.into_iter().map(RobotEvent::from));
        match stepped {
            Ok(percept) => self.controller.step(phases, percept, outbox),
            Err(lost) => {
                outbox.lost = Some(lost.0.clone());
                self.lost = Some(lost);
            }
        }
    }

    /// Of the controller alone: the host, which knows the truth, is not asked.
    fn foresee(&self, now_us: u64, phases: Phases<'_>, grain: Grain) -> Result<ForeseenRobot, Raise> {
        let office = foresee(&self.controller, now_us, phases, grain)?;
        Ok(match grain {
            Grain::Abstract => ForeseenRobot::of(office),
            Grain::Simulated => ForeseenRobot::of(SimulatedOffice::new(&self.controller, office, now_us)),
        })
    }

    /// Without a host nothing goes on while the run computes.
    fn think(&mut self, ticket: Ticket, thought: Arc<dyn Thought>) -> Result<Option<Arc<dyn Thought>>, Raise> {
        if self.lost.is_none() { self.host.think(ticket, thought) } else { Ok(Some(thought)) }
    }

    fn answers(&mut self, is_awaited: &dyn Fn(Ticket) -> bool, outbox: &mut Outbox) {
        outbox.answers = if self.lost.is_none() { self.host.answers(is_awaited) } else { ask_again(&mut self.host) };
    }

    /// Functions of plans reach the controller, whatever the host, and never the host.
    fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        self.controller.part(of)
    }
}
