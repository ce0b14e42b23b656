//! The simulated robot of projected runs: its own controller drives it and looks around, in a world made of what it
//! knows; what its gripper does, a search for its position and its battery are those of the abstract robot.

use super::behaviours::look_around::{self, LookingAround};
use super::behaviours::move_by_odometry::{self, MovingByOdometry};
use super::behaviours::navigation::{self, Navigating};
use super::controller::Controller;
use super::foreseen_robot::{ForeseenOffice, closed_doors, part};
use super::module::{Module, Moment, Start, Telling};
use crate::foresight::abstract_robot::AbstractRobot;
use crate::foresight::activity::{Doing, UnderWay};
use crate::foresight::drive_times::DriveTimes;
use crate::foresight::simulated_world::{Motion, SimulatedWorld};
use crate::foresight::ways::{ForeseenWays, Way};
use crate::geometry::{Point, Transform, Velocity, distance_m};
use crate::localization::Estimate;
use crate::simulator::Percept;
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{Foreseen, NEVER_US, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::state::activation::{Phase, Phases};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use std::any::{Any, TypeId};

/// A robot that stops within this of a place plans its next way from there.
const FROM_PLACE_M: f64 = 0.5;

/// What stands this near to the middle of a door found closed is its leaf.
const LEAF_M: f64 = 0.6;

/// Where the behaviours that drive, and their fluents, stand in the tables of the robot.
#[derive(Clone, Copy)]
struct Numbers {
    navigation: Option<usize>,
    looking: Option<usize>,
    moving: Option<usize>,
    navigation_fluents: usize,
}

impl Numbers {
    fn of(tables: &RobotTables) -> Self {
        let behaviour = |name| tables.behaviours.iter().position(|spec| spec.name == name);
        let fluents = tables.fluents.iter().position(|spec| spec.name == navigation::FLUENTS[0].name);
        Self {
            navigation: behaviour(navigation::NAME),
            looking: behaviour(look_around::NAME),
            moving: behaviour(move_by_odometry::NAME),
            navigation_fluents: fluents.unwrap_or_default(),
        }
    }
}

/// The robot of simulated runs.
#[derive(Clone)]
pub(super) struct SimulatedOffice<M: Module> {
    /// What it has in common with the abstract one; its position follows this one.
    office: ForeseenOffice<M>,
    numbers: Numbers,
    world: SimulatedWorld,
    /// How it moved, and what it remembered to stand where in `odom`, when the projection began.
    motion: Motion,
    standing_in_odom: Vec<Point>,
    /// Which of the behaviours that drive are at work.
    navigates: bool,
    looks: bool,
    moves: bool,
    /// When its world makes the next step; while it stands with nothing to do, none is made.
    next_step_us: u64,
}

impl<M: Module> SimulatedOffice<M> {
    /// Of what a controller knows, and of what is left of it in the abstract robot.
    pub fn new(controller: &Controller<M>, mut office: ForeseenOffice<M>, now_us: u64) -> Self {
        let is_driving = |begun: &UnderWay| matches!(begun, UnderWay::Driving { .. });
        let navigates = office.begun.iter().any(is_driving);
        let looks = office.begun.contains(&UnderWay::Looking);
        let is_moving = |begun: &UnderWay| matches!(begun, UnderWay::Moving(_));
        let moves = office.begun.iter().any(is_moving);
        // These go on by themselves.
        office.begun.retain(|begun| !is_driving(begun) && !is_moving(begun) && *begun != UnderWay::Looking);
        office.ways.from_place_m = FROM_PLACE_M;
        let motion = motion(controller);
        let standing_in_odom = standing_in_odom(controller, &mut office, motion);
        let simulator = office.controller.model.simulator.clone();
        let world = SimulatedWorld::new(simulator, 0, now_us, office.robot.robot_in_map, motion, &[]);
        let numbers = Numbers::of(office.tables());
        Self { office, numbers, world, motion, standing_in_odom, navigates, looks, moves, next_step_us: now_us }
    }

    fn step_us(&self) -> u64 {
        self.office.controller.model.settings.robot.step_us
    }

    /// Whether it stands, and nothing would move it.
    fn is_at_rest(&self) -> bool {
        let is_still = self.world.motion().velocity == Velocity::default();
        let is_active = self.navigates || self.looks || self.moves;
        is_still && !is_active && self.office.controller.board.drive_request == Velocity::default()
    }

    /// Its world goes on from now, if it stood still.
    fn wake(&mut self, now_us: u64) {
        if !self.is_at_rest() {
            return;
        }
        let step_us = self.step_us();
        let rested_us = (now_us + step_us).saturating_sub(self.next_step_us);
        if let Some(navigating) = part::<M, Navigating>(&mut self.office.controller.modules) {
            navigating.let_pass(rested_us as f64 / 1e6);
        }
        self.next_step_us = now_us + step_us;
    }

    /// One of the behaviours that drive begins.
    fn begin(
        &mut self,
        doing: Doing,
        machine: &Machine,
        arguments: &[(Symbol, Value)],
        outbox: &mut Outbox,
    ) -> Result<(), Raise> {
        self.wake(machine.now_us);
        let numbers = self.numbers;
        let Controller { model, board, modules, .. } = &mut self.office.controller;
        let start = Start { model, machine, arguments, time_us: machine.now_us };
        match doing {
            Doing::Driving => {
                let tell = &mut Telling::at(outbox, numbers.navigation.unwrap_or_default(), numbers.navigation_fluents);
                let Some(navigating) = part::<M, Navigating>(modules) else { return Ok(()) };
                navigating.start(0, &start, &mut board.position, tell)?;
                self.navigates = true;
                self.begin_drive();
            }
            Doing::Looking => {
                let tell = &mut Telling::at(outbox, numbers.looking.unwrap_or_default(), 0);
                let Some(looking) = part::<M, LookingAround>(modules) else { return Ok(()) };
                looking.start(0, &start, &mut board.position, tell)?;
                self.looks = true;
            }
            Doing::Moving => {
                let tell = &mut Telling::at(outbox, numbers.moving.unwrap_or_default(), 0);
                let Some(moving) = part::<M, MovingByOdometry>(modules) else { return Ok(()) };
                moving.start(0, &start, &mut board.position, tell)?;
                self.moves = true;
            }
            Doing::Gripping | Doing::Searching | Doing::Acting(_) => {}
        }
        Ok(())
    }

    /// What may come between on the drive that navigation has begun is drawn.
    fn begin_drive(&mut self) {
        let Controller { model, modules, .. } = &mut self.office.controller;
        let Some(navigating) = part::<M, Navigating>(modules) else { return };
        let way = Way::straight(&model.world, self.office.robot.robot_in_map, navigating.targets_in_map());
        let expected_s = DriveTimes::of(&model.settings.robot).time_s(&way.features());
        self.world.begin_drive(&mut self.office.robot, &way, expected_s);
    }

    /// One step of its world and of what drives it.
    fn step_world(&mut self, outbox: &mut Outbox) {
        let wanted = self.office.controller.board.drive_request;
        let percept = self.world.step(&mut self.office.robot, wanted, self.next_step_us, self.moves);
        let pose_in_map = self.world.robot_in_map();
        let is_driven = self.world.motion().velocity != Velocity::default();
        self.office.robot.carry_to(pose_in_map, is_driven);
        let estimate = Estimate { pose_in_map, certainty: self.office.certainty() };
        self.office.controller.board.position.foresee(estimate, percept.odometry_in_odom);
        self.office.controller.board.drive_request = self.decide(&percept, outbox);
    }

    /// What the behaviours that drive want of the wheels.
    fn decide(&mut self, percept: &Percept, outbox: &mut Outbox) -> Velocity {
        let (numbers, endings) = (self.numbers, outbox.endings.len());
        let Controller { model, board, modules, .. } = &mut self.office.controller;
        let now = Moment { model, percept, mode: board.mode, unread: board.inbox.len(), phases: &[Phase::Active] };
        let mut wanted = None;
        if self.navigates
            && let Some(navigating) = part::<M, Navigating>(modules)
        {
            let tell = &mut Telling::at(outbox, numbers.navigation.unwrap_or_default(), numbers.navigation_fluents);
            wanted = navigating.step(&now, &mut board.position, tell);
            self.navigates = outbox.endings.len() == endings;
        }
        let endings = outbox.endings.len();
        if self.looks
            && let Some(looking) = part::<M, LookingAround>(modules)
        {
            let tell = &mut Telling::at(outbox, numbers.looking.unwrap_or_default(), 0);
            wanted = looking.step(&now, &mut board.position, tell).or(wanted);
            self.looks = outbox.endings.len() == endings;
        }
        let endings = outbox.endings.len();
        if self.moves
            && let Some(moving) = part::<M, MovingByOdometry>(modules)
        {
            let tell = &mut Telling::at(outbox, numbers.moving.unwrap_or_default(), 0);
            wanted = moving.step(&now, &mut board.position, tell).or(wanted);
            self.moves = outbox.endings.len() == endings;
        }
        wanted.unwrap_or_default()
    }

    fn publish(&mut self, outbox: &mut Outbox) {
        let targets = match part::<M, Navigating>(&mut self.office.controller.modules) {
            Some(navigating) if self.navigates => navigating.targets_in_map().len(),
            Some(_) | None => 0,
        };
        self.office.publish((self.navigates, targets), outbox);
        let speed = self.tables().fluents.iter().position(|fluent| fluent.name == "speed*");
        let speed_mps = self.world.motion().velocity.translation_mps;
        outbox.fluents.extend(speed.map(|number| (number, Reading::Float(speed_mps))));
    }
}

/// How a controller's robot moves.
fn motion<M: Module>(controller: &Controller<M>) -> Motion {
    let percept = controller.board.percept.as_ref();
    let velocity = percept.map_or_else(Velocity::default, |percept| Velocity {
        translation_mps: percept.translation_mps,
        rotation_radps: percept.rotation_radps,
    });
    Motion { odometry_in_odom: controller.board.position.odometry_in_odom(), velocity }
}

/// What a controller remembers to stand somewhere, but for the leaves of doors found closed.
fn standing_in_odom<M: Module>(
    controller: &Controller<M>,
    office: &mut ForeseenOffice<M>,
    motion: Motion,
) -> Vec<Point> {
    let (Estimate { pose_in_map, .. }, model) = (controller.estimate(), office.controller.model.clone());
    let closed = closed_doors(&mut office.controller);
    let (Some(map), Some(navigating)) = (&model.map, part::<M, Navigating>(&mut office.controller.modules)) else {
        return Vec::new();
    };
    let mut standing = navigating.standing_in_map(&map.navigation, pose_in_map, motion.odometry_in_odom);
    standing.retain(|&point| closed.iter().all(|&door| distance_m(model.world.doors[door].at, point) > LEAF_M));
    let map_in_odom = Transform::new(motion.odometry_in_odom.compose(pose_in_map.inverse()));
    standing.into_iter().map(|point| map_in_odom.apply(point)).collect()
}

impl<M: Module> Foreseen for SimulatedOffice<M> {
    fn copied(&self) -> Box<dyn Foreseen> {
        Box::new(self.clone())
    }

    fn begin_run(&mut self, seed: u64) {
        self.office.begin_run(seed);
        let robot_in_map = self.office.robot.robot_in_map;
        let odom_in_map = robot_in_map.compose(self.motion.odometry_in_odom.inverse());
        let to_map = Transform::new(odom_in_map);
        let standing: Vec<Point> = self.standing_in_odom.iter().map(|&point| to_map.apply(point)).collect();
        let simulator = self.office.controller.model.simulator.clone();
        let now_us = self.office.robot.now_us();
        self.world = SimulatedWorld::new(simulator, seed, now_us, robot_in_map, self.motion, &standing);
        self.office.odom_in_map = odom_in_map;
        self.office.tell_position();
        if self.navigates {
            self.begin_drive();
        }
        self.next_step_us = now_us + self.step_us();
    }

    fn unforeseen(&self) -> Option<&str> {
        self.office.unforeseen()
    }

    fn has_drawn(&self) -> bool {
        self.office.has_drawn()
    }
}

impl<M: Module> Outside for SimulatedOffice<M> {
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
        match self.office.doing(behaviour) {
            Some(doing @ (Doing::Driving | Doing::Looking | Doing::Moving)) => {
                self.begin(doing, machine, arguments, outbox)
            }
            Some(Doing::Gripping | Doing::Searching | Doing::Acting(_)) | None => {
                self.office.start(machine, behaviour, arguments, outbox)
            }
        }
    }

    /// As for any robot, who stops it lets it stand.
    fn stop(&mut self, behaviour: u16, why: StopReason, outbox: &mut Outbox) {
        let numbers = self.numbers;
        let stopped = self.office.doing(behaviour);
        let Controller { board, modules, .. } = &mut self.office.controller;
        match stopped {
            Some(Doing::Driving) => {
                let tell = &mut Telling::at(outbox, usize::from(behaviour), numbers.navigation_fluents);
                if let Some(navigating) = part::<M, Navigating>(modules) {
                    navigating.stop(0, why, tell);
                }
                (self.navigates, board.drive_request) = (false, Velocity::default());
            }
            Some(Doing::Looking) => {
                if let Some(looking) = part::<M, LookingAround>(modules) {
                    looking.stop(0, why, &mut Telling::at(outbox, usize::from(behaviour), 0));
                }
                (self.looks, board.drive_request) = (false, Velocity::default());
            }
            Some(Doing::Moving) => {
                if let Some(moving) = part::<M, MovingByOdometry>(modules) {
                    moving.stop(0, why, &mut Telling::at(outbox, usize::from(behaviour), 0));
                }
                (self.moves, board.drive_request) = (false, Velocity::default());
            }
            Some(Doing::Gripping | Doing::Searching | Doing::Acting(_)) | None => {
                self.office.stop(behaviour, why, outbox)
            }
        }
    }

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        let events_us = self.office.next_event_us(stepped_us).unwrap_or(NEVER_US);
        Some(if self.is_at_rest() { events_us } else { events_us.min(self.next_step_us) })
    }

    /// Position and battery follow time.
    fn steps_at(&self, _: u64, _: u64) -> bool {
        true
    }

    fn step(&mut self, now_us: u64, _: Phases<'_>, outbox: &mut Outbox) {
        let ended = self.office.robot.advance_to(now_us);
        self.office.tell_endings(ended, outbox);
        while self.next_step_us <= now_us && !self.is_at_rest() {
            self.step_world(outbox);
            self.next_step_us += self.step_us();
        }
        self.office.tell_position();
        self.publish(outbox);
    }

    fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        if of == TypeId::of::<ForeseenWays>() {
            self.office.ways.closed_doors = closed_doors(&mut self.office.controller);
            Some(&mut self.office.ways)
        } else if of == TypeId::of::<AbstractRobot>() {
            Some(&mut self.office.robot)
        } else {
            self.office.controller.part(of)
        }
    }
}
