//! The robot of a run, if it has one, and what can be asked of it.

use crate::sight::{Account, PositionBelief, Sight};
use rpl_lang::symbol::Symbol;
use rpl_robot::geometry::Vector;
use rpl_robot::office::{Module, OfficeModules, OfficeRobot, Oracle, SimulatedHost};
use rpl_runtime::robot::{NoRobot, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::any::{Any, TypeId};

/// The robot of a run, if it has one.
#[derive(Clone)]
pub enum Robot<M: Module = OfficeModules> {
    /// No world, no robot.
    Absent(NoRobot),
    /// A robot in its world, simulated.
    Office(Box<OfficeRobot<SimulatedHost, M>>),
}

impl<M: Module> Robot<M> {
    /// What can be seen of it.
    pub fn sight(&self) -> Option<Sight> {
        match self {
            Robot::Absent(_) => None,
            Robot::Office(robot) => Some(Sight {
                robot_in_map: robot.true_pose_in_map(),
                estimate_in_map: robot.estimated_pose_in_map(),
                certainty: robot.estimate().certainty,
            }),
        }
    }

    /// Whether it does not know where it is.
    pub fn is_lost(&self) -> bool {
        match self {
            Robot::Absent(_) => false,
            Robot::Office(robot) => robot.estimate().certainty <= robot.model().settings.active.certainty,
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

    /// What it did so far.
    pub fn account(&self) -> Option<Account> {
        match self {
            Robot::Absent(_) => None,
            Robot::Office(robot) => {
                let contacts = robot.contacts();
                Some(Account {
                    contacts: contacts.caused,
                    contacts_unseen: contacts.unseen,
                    contacts_by_people: contacts.run_into,
                    distance_m: robot.distance_driven_m(),
                })
            }
        }
    }

    /// Bytes of its state that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        match (self, earlier) {
            (Robot::Office(robot), Robot::Office(earlier)) => robot.bytes_apart(earlier),
            (Robot::Absent(_), _) | (Robot::Office(_), Robot::Absent(_)) => 0,
        }
    }

    /// Where it may be.
    pub fn belief(&self) -> Option<PositionBelief> {
        match self {
            Robot::Absent(_) => None,
            Robot::Office(robot) => {
                let grid = &robot.model().map.as_ref()?.localization.grid;
                Some(PositionBelief {
                    resolution_m: grid.cell_m,
                    // The grid names the middle of its first cell, a drawing wants its corner.
                    origin_in_map: grid.origin_in_map - Vector::new(grid.cell_m, grid.cell_m) / 2.0,
                    columns: grid.columns,
                    cells: robot.belief_xy()?,
                })
            }
        }
    }

    fn outside(&self) -> &dyn Outside {
        match self {
            Robot::Absent(robot) => robot,
            Robot::Office(robot) => robot.as_ref(),
        }
    }

    fn outside_mut(&mut self) -> &mut dyn Outside {
        match self {
            Robot::Absent(robot) => robot,
            Robot::Office(robot) => robot.as_mut(),
        }
    }
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

    fn period_us(&self) -> Option<u64> {
        self.outside().period_us()
    }

    fn step(&mut self, phases: Phases<'_>, outbox: &mut Outbox) {
        self.outside_mut().step(phases, outbox);
    }

    fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        self.outside_mut().part(of)
    }
}
