//! The robot of a run, if it has one, and what can be asked of it.

use crate::modules::SiteModules;
use crate::sight::{Account, PositionBelief, Sight};
use rpl_lang::symbol::Symbol;
use rpl_protocol::module::modules_alone::ModulesAlone;
use rpl_protocol::remote_host::RemoteHost;
use rpl_robot::active::{ActionField, Choice};
use rpl_robot::geometry::{Pose, Vector, Velocity};
use rpl_robot::localization::{Localization, Maximum};
use rpl_robot::office::{Localizing, Module, Navigating, OfficeModel, OfficeRobot, Oracle, SimulatedHost};
use rpl_robot::simulator::{Percept, SimulatorState};
use rpl_robot::world::World;
use rpl_runtime::robot::thinking::{Thought, Ticket};
use rpl_runtime::robot::{ForeseenRobot, NoRobot, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::run::save::SaveOutside;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::projected::Grain;
use rpl_runtime::state::value::Value;
use rpl_rupart::Rupart;
use rpl_rupart::memory::CaseMemory;
use std::any::{Any, TypeId};
use std::sync::Arc;

/// The robot of a run, if it has one.
#[derive(Clone)]
pub enum Robot<M: Module = SiteModules> {
    /// No world, no robot.
    Absent(NoRobot),
    /// A robot in its world, simulated.
    Office(Box<OfficeRobot<SimulatedHost, M>>),
    /// The same robot, moved by another process.
    Remote(Box<OfficeRobot<RemoteHost, M>>),
    /// No robot of ours: all that there is are modules in other processes.
    Modules(Box<ModulesAlone>),
}

impl<M: Module> Robot<M> {
    /// What can be seen of it.
    pub fn sight(&self) -> Option<Sight> {
        match self {
            Robot::Absent(_) | Robot::Modules(_) => None,
            Robot::Office(robot) => Some(sight(robot, Some(robot.true_pose_in_map()))),
            Robot::Remote(robot) => Some(sight(robot, None)),
        }
    }

    /// Probability that it is not lost.
    pub fn tracking(&self) -> Option<f64> {
        match self {
            Robot::Absent(_) | Robot::Modules(_) => None,
            Robot::Office(robot) => Some(robot.tracking()),
            Robot::Remote(robot) => Some(robot.tracking()),
        }
    }

    /// Where it really is; none if its host is another process, which does not tell.
    pub fn true_pose_in_map(&self) -> Option<Pose> {
        match self {
            Robot::Absent(_) | Robot::Remote(_) | Robot::Modules(_) => None,
            Robot::Office(robot) => Some(robot.true_pose_in_map()),
        }
    }

    /// Whether it does not know where it is.
    pub fn is_lost(&self) -> bool {
        match self {
            Robot::Absent(_) | Robot::Modules(_) => false,
            Robot::Office(robot) => is_lost(robot),
            Robot::Remote(robot) => is_lost(robot),
        }
    }

    /// The scenario beside it, if that has failed, and its failure.
    pub fn failed_scenario(&self) -> Option<(&System<Oracle>, Value)> {
        let Robot::Office(robot) = self else { return None };
        let scenario = robot.host.scenario.as_deref()?;
        match scenario.outcome()? {
            Outcome::Failed(failure) => Some((scenario, failure)),
            Outcome::Succeeded(_) | Outcome::Evaporated => None,
        }
    }

    /// The simulated world it is in; none if its host is another process. No plan sees it.
    pub fn simulated_world(&self) -> Option<(&World, &SimulatorState)> {
        match self {
            Robot::Absent(_) | Robot::Remote(_) | Robot::Modules(_) => None,
            Robot::Office(robot) => Some((&robot.host.model.world, &robot.host.state)),
        }
    }

    /// What it did so far.
    pub fn account(&self) -> Option<Account> {
        match self {
            Robot::Absent(_) | Robot::Modules(_) => None,
            Robot::Office(robot) => {
                let contacts = robot.contacts();
                Some(Account {
                    contacts: Some(contacts.caused),
                    contacts_unseen: Some(contacts.unseen),
                    contacts_by_people: Some(contacts.run_into),
                    distance_m: robot.distance_driven_m(),
                    host: None,
                })
            }
            Robot::Remote(robot) => {
                let record = robot.host.record;
                Some(Account {
                    contacts: None,
                    contacts_unseen: None,
                    contacts_by_people: None,
                    distance_m: record.distance_m,
                    host: Some(record),
                })
            }
        }
    }

    /// Bytes of its state that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        match (self, earlier) {
            (Robot::Office(robot), Robot::Office(earlier)) => robot.bytes_apart(earlier),
            (Robot::Remote(robot), Robot::Remote(earlier)) => robot.bytes_apart(earlier),
            (Robot::Absent(_) | Robot::Office(_) | Robot::Remote(_) | Robot::Modules(_), _) => 0,
        }
    }

    /// Where it may be.
    pub fn belief(&self) -> Option<PositionBelief> {
        match self {
            Robot::Absent(_) | Robot::Modules(_) => None,
            Robot::Office(robot) => belief(robot),
            Robot::Remote(robot) => belief(robot),
        }
    }

    /// The filter; none without a map.
    pub fn localization(&self) -> Option<&Localization> {
        match self {
            Robot::Absent(_) | Robot::Modules(_) => None,
            Robot::Office(robot) => robot.localization(),
            Robot::Remote(robot) => robot.localization(),
        }
    }

    /// The local maxima of its belief with at least this share, the heaviest first; none without a map. Costs some
    /// milliseconds.
    pub fn maxima(&self, least_share: f64) -> Vec<Maximum> {
        let (Some(localization), Some(model)) = (self.localization(), self.model()) else { return Vec::new() };
        let most = model.settings.active.max_maxima;
        model.map.as_ref().map_or(Vec::new(), |map| localization.maxima(&map.localization, most, least_share))
    }

    /// What active localization would choose now, and all that it considers; none while it is not under way. Costs some
    /// 50 ms.
    pub fn considered(&mut self) -> Option<(Choice, ActionField)> {
        let model = self.model()?.clone();
        let localization = self.localization()?.clone();
        let localizing = self.part(TypeId::of::<Localizing>())?.downcast_ref::<Localizing>()?;
        localizing.search()?.considered(&model.map.as_ref()?.localization, &localization)
    }

    /// States that together have this share of the belief, the likeliest first; none without a map. Costs some
    /// milliseconds.
    pub fn likely_states(&self, share: f64) -> Vec<Maximum> {
        let (Some(localization), Some(model)) = (self.localization(), self.model()) else { return Vec::new() };
        model.map.as_ref().map_or(Vec::new(), |map| localization.likely_states(&map.localization, share))
    }

    /// What its sensors found at the last step.
    pub fn percept(&self) -> Option<&Percept> {
        match self {
            Robot::Absent(_) | Robot::Modules(_) => None,
            Robot::Office(robot) => robot.percept(),
            Robot::Remote(robot) => robot.percept(),
        }
    }

    /// What is asked of its wheels.
    pub fn drive_request(&self) -> Option<Velocity> {
        match self {
            Robot::Absent(_) | Robot::Modules(_) => None,
            Robot::Office(robot) => Some(robot.controller.board.drive_request),
            Robot::Remote(robot) => Some(robot.controller.board.drive_request),
        }
    }

    /// What does not change of it.
    pub fn model(&self) -> Option<&Arc<OfficeModel>> {
        match self {
            Robot::Absent(_) | Robot::Modules(_) => None,
            Robot::Office(robot) => Some(robot.model()),
            Robot::Remote(robot) => Some(robot.model()),
        }
    }

    /// Its navigation: where it is to go, and what it has found on the way.
    pub fn navigation(&mut self) -> Option<&Navigating> {
        self.part(TypeId::of::<Navigating>())?.downcast_ref()
    }

    /// What it remembers of driving by cases; none without a robot that does.
    pub fn case_memory(&mut self) -> Option<&CaseMemory> {
        self.part(TypeId::of::<Rupart>())?.downcast_ref().map(Rupart::memory)
    }

    fn outside(&self) -> &dyn Outside {
        match self {
            Robot::Absent(robot) => robot,
            Robot::Office(robot) => robot.as_ref(),
            Robot::Remote(robot) => robot.as_ref(),
            Robot::Modules(modules) => modules.as_ref(),
        }
    }

    fn outside_mut(&mut self) -> &mut dyn Outside {
        match self {
            Robot::Absent(robot) => robot,
            Robot::Office(robot) => robot.as_mut(),
            Robot::Remote(robot) => robot.as_mut(),
            Robot::Modules(modules) => modules.as_mut(),
        }
    }
}

fn sight<H, M: Module>(robot: &OfficeRobot<H, M>, robot_in_map: Option<Pose>) -> Sight {
    let percept = robot.percept();
    Sight {
        robot_in_map,
        estimate_in_map: robot.estimated_pose_in_map(),
        certainty: robot.estimate().certainty,
        velocity: percept.map(|percept| Velocity {
            translation_mps: percept.translation_mps,
            rotation_radps: percept.rotation_radps,
        }),
        battery: percept.map(|percept| percept.battery),
    }
}

fn is_lost<H, M: Module>(robot: &OfficeRobot<H, M>) -> bool {
    robot.tracking() <= robot.model().settings.active.certainty
}

fn belief<H, M: Module>(robot: &OfficeRobot<H, M>) -> Option<PositionBelief> {
    let grid = &robot.model().map.as_ref()?.localization.grid;
    Some(PositionBelief {
        resolution_m: grid.cell_m,
        // The grid names the middle of its first cell, a drawing wants its corner.
        origin_in_map: grid.origin_in_map - Vector::new(grid.cell_m, grid.cell_m) / 2.0,
        columns: grid.columns,
        cells: robot.belief_xy()?,
    })
}

impl<M: Module> Outside for Robot<M> {
    fn tables(&self) -> &RobotTables {
        self.outside().tables()
    }

    fn start(
        &mut self,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise> {
        self.outside_mut().start(machine, behaviour, arguments, outbox)
    }

    fn stop(&mut self, behaviour: u16, how: StopReason, outbox: &mut Outbox) {
        self.outside_mut().stop(behaviour, how, outbox);
    }

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        self.outside().next_event_us(stepped_us)
    }

    fn charge_permille(&self) -> Option<u16> {
        self.outside().charge_permille()
    }

    fn renew(&mut self, outbox: &mut Outbox) -> bool {
        self.outside_mut().renew(outbox)
    }

    fn steps_at(&self, stepped_us: u64, now_us: u64) -> bool {
        self.outside().steps_at(stepped_us, now_us)
    }

    fn step(&mut self, now_us: u64, phases: Phases<'_>, outbox: &mut Outbox) {
        self.outside_mut().step(now_us, phases, outbox);
    }

    fn foresee(&self, now_us: u64, phases: Phases<'_>, grain: Grain) -> Result<ForeseenRobot, Raise> {
        self.outside().foresee(now_us, phases, grain)
    }

    fn think(&mut self, ticket: Ticket, thought: Arc<dyn Thought>) -> Result<Option<Arc<dyn Thought>>, Raise> {
        self.outside_mut().think(ticket, thought)
    }

    fn answers(&mut self, is_awaited: &dyn Fn(Ticket) -> bool, outbox: &mut Outbox) {
        self.outside_mut().answers(is_awaited, outbox);
    }

    fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        self.outside_mut().part(of)
    }
}

/// A saved robot ends with who moves it.
const NOBODY: u8 = 0;
const SIMULATED: u8 = 1;
const REMOTE: u8 = 2;
const MODULES: u8 = 3;

impl<M: Module> SaveOutside for Robot<M> {
    fn save(&self, bytes: Vec<u8>) -> Vec<u8> {
        let (who, mut state) = match self {
            Robot::Absent(robot) => (NOBODY, robot.save(bytes)),
            Robot::Office(robot) => (SIMULATED, robot.save(bytes)),
            Robot::Remote(robot) => (REMOTE, robot.save(bytes)),
            Robot::Modules(modules) => (MODULES, modules.save(bytes)),
        };
        state.push(who);
        state
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), String> {
        let Some((&who, state)) = bytes.split_last() else { return Err("its state is damaged: it is empty".into()) };
        match (who, self) {
            (NOBODY, Robot::Absent(robot)) => robot.load(state),
            (SIMULATED, Robot::Office(robot)) => robot.load(state),
            (REMOTE, Robot::Remote(robot)) => robot.load(state),
            (MODULES, Robot::Modules(modules)) => modules.load(state),
            (NOBODY, Robot::Modules(_)) => Err("the run was saved without modules, and there are some".into()),
            (MODULES, _) => Err("the run was saved with modules and no robot, and this one is not like that".into()),
            (NOBODY, _) => Err("the run was saved without a robot, and there is one".into()),
            (SIMULATED | REMOTE, Robot::Modules(_)) => {
                Err("the run was saved with a robot, and there are only modules".into())
            }
            (_, Robot::Absent(_)) => Err("the run was saved with a robot, and there is none".into()),
            (SIMULATED, _) => {
                Err("the run was saved in the simulator, and its robot is moved by another process".into())
            }
            (REMOTE, _) => Err("the run was saved with a robot that another process moves, and it is simulated".into()),
            _ => Err("its state is damaged: nobody moves it".into()),
        }
    }
}
