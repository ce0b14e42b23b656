//! An abstract world: events instead of physics, in which things go as chances say that no plan knows, and in which
//! people say what they say when it is time. What is projected by a robot in it follows from what that robot knows.
//! A mission takes milliseconds in it.

use super::controller::Controller;
use super::foreseen_robot::{ForeseenOffice, at_start};
use super::module::Module;
use crate::foresight::abstract_robot::{AbstractRobot, Experience};
use crate::foresight::models::{Chances, Models};
use crate::world::World;
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::{Foreseen, ForeseenRobot, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::projected::Grain;
use rpl_runtime::state::value::Value;
use std::any::{Any, TypeId};
use std::collections::VecDeque;

/// By what the robot in an abstract world foresees.
#[derive(Clone, Debug)]
pub enum Forecast {
    /// By what it has learned, here and before.
    Learned(Experience),
    /// As if nothing ever came between, and all took the time that it should take.
    Undisturbed,
    /// By the truth: what will happen, and what people will say. No robot can do that.
    Truth,
}

/// What an abstract world is like.
#[derive(Clone, Debug)]
pub struct AbstractSetting {
    /// What may come between.
    pub chances: Chances,
    /// Charge of the battery at the start, from 0 to 1.
    pub battery: f64,
    /// What people will say: when, in microseconds, and which words; the earliest first.
    pub messages: Vec<(u64, Vec<String>)>,
    /// By what the robot foresees.
    pub forecast: Forecast,
}

/// An abstract world with a robot.
#[derive(Clone)]
pub struct AbstractWorld<M: Module> {
    office: ForeseenOffice<M>,
    to_come: VecDeque<(u64, Vec<String>)>,
    forecast: Forecast,
}

impl<M: Module> AbstractWorld<M> {
    /// Of a controller at the start of its world; everything that is left to chance follows from the seed.
    ///
    /// # Errors
    /// There is no map.
    pub(super) fn new(controller: &Controller<M>, setting: AbstractSetting, seed: u64) -> Result<Self, Raise> {
        let AbstractSetting { chances, battery, messages, forecast } = setting;
        let mut office = at_start(controller, Models::exactly(&chances))?;
        office.robot.battery = battery;
        office.begin_run(seed);
        Ok(Self { office, to_come: messages.into(), forecast })
    }

    /// What there is on the map.
    pub fn world(&self) -> &World {
        &self.office.controller.model.world
    }

    /// The robot, as it really is.
    pub fn robot(&self) -> &AbstractRobot {
        &self.office.robot
    }
}

impl<M: Module> Outside for AbstractWorld<M> {
    fn tables(&self) -> &RobotTables {
        self.office.tables()
    }

    fn start(
        &mut self,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise> {
        self.office.start(machine, behaviour, arguments, outbox)
    }

    fn stop(&mut self, behaviour: u16, why: StopReason, outbox: &mut Outbox) {
        self.office.stop(behaviour, why, outbox);
    }

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        let said_us = self.to_come.front().map(|&(at_us, _)| at_us);
        self.office.next_event_us(stepped_us).into_iter().chain(said_us).min()
    }

    fn steps_at(&self, stepped_us: u64, now_us: u64) -> bool {
        self.office.steps_at(stepped_us, now_us)
    }

    fn step(&mut self, now_us: u64, phases: Phases<'_>, outbox: &mut Outbox) {
        while let Some((_, words)) = self.to_come.pop_front_if(|(at_us, _)| *at_us <= now_us) {
            self.office.controller.board.inbox.push(words);
        }
        self.office.step(now_us, phases, outbox);
    }

    fn foresee(&self, _: u64, _: Phases<'_>, grain: Grain) -> Result<ForeseenRobot, Raise> {
        if grain != Grain::Abstract {
            let why = "a robot in a world of events has no controller that could be simulated; leave out `:grain`";
            return Err(Raise::new("projection-failure", why));
        }
        let models = match &self.forecast {
            Forecast::Truth => return Ok(ForeseenRobot::of(self.clone())),
            Forecast::Undisturbed => Models::undisturbed(),
            Forecast::Learned(before) => {
                let mut experience = before.clone();
                experience.add(&self.office.robot.experience);
                let robot = &self.office.controller.model.settings.robot;
                Models::learned(robot, &experience.grasps, &experience.drives)
            }
        };
        Ok(ForeseenRobot::of(self.office.foreseen(models)))
    }

    fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        self.office.part(of)
    }
}

/// As it is foreseen by the truth: nothing is drawn anew.
impl<M: Module> Foreseen for AbstractWorld<M> {
    fn copied(&self) -> Box<dyn Foreseen> {
        Box::new(self.clone())
    }

    fn begin_run(&mut self, _: u64) {}

    fn unforeseen(&self) -> Option<&str> {
        self.office.unforeseen()
    }

    fn has_drawn(&self) -> bool {
        false
    }
}
