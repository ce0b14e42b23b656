//! The abstract robot of projected runs, behind the same behaviours, fluents and functions. It is made of a
//! controller, which has percepts and belief, in the world that the map shows, and so of nothing that the
//! robot does not know.

use super::behaviours::active_localization;
use super::behaviours::gripper::Gripping;
use super::behaviours::look_around;
use super::behaviours::move_by_odometry::{self, MovingByOdometry};
use super::behaviours::navigation::{self, Navigating};
use super::composition::Composition;
use super::controller::Controller;
use super::module::Module;
use super::words::{mode_name, no_map};
use crate::foresight::abstract_robot::{AbstractRobot, Knowledge};
use crate::foresight::activity::{Doing, Outcome, UnderWay};
use crate::foresight::drive_times::DriveTimes;
use crate::foresight::models::Models;
use crate::foresight::ways::{ForeseenWays, WayMap, Ways};
use crate::geometry::{Pose, Velocity};
use crate::localization::Estimate;
use crate::navigation::{MappedNavigation, MoveHindrance, Obstruction};
use crate::office::model::{MapModel, OfficeModel};
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{Ending, Foreseen, ForeseenRobot, NEVER_US, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::state::activation::{Phase, Phases};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::projected::Grain;
use rpl_runtime::state::value::Value;
use std::any::{Any, TypeId};
use std::collections::BTreeMap;

/// The place of the robot is drawn from this many maxima of its belief, each with at least such a part of it.
const MOST_HYPOTHESES: usize = 16;
const LEAST_MASS: f64 = 0.001;

/// Or from the likeliest states that hold this share of it, and at most from this many.
const LIKELY: f64 = 0.95;
const MOST_POSES: usize = 4096;

/// A robot that is not lost in a projection is as sure as one that nobody has touched.
const SURE: f64 = 0.9995;

/// One that is lost.
const LOST: f64 = 0.5;

/// The robot of projected runs.
#[derive(Clone)]
pub(super) struct ForeseenOffice<M: Module> {
    /// What functions of plans work on; its position follows the abstract robot.
    pub(super) controller: Controller<M>,
    pub(super) robot: AbstractRobot,
    pub(super) ways: ForeseenWays,
    pub(super) odom_in_map: Pose,
    /// Doors found closed before the projection begins.
    found_closed: Vec<usize>,
    /// What goes on when the projection begins.
    pub(super) begun: Vec<UnderWay>,
    unforeseen: Option<String>,
    /// What behaviours of other modules set when they succeed, by the places of fluents.
    sets: BTreeMap<u16, Vec<(usize, Reading)>>,
}

/// The robot that is foreseen from what a controller knows, with where it may be as a grain wants it.
///
/// # Errors
/// There is no map, or something goes on for which there is no model.
pub(super) fn foresee<M: Module>(
    controller: &Controller<M>,
    now_us: u64,
    phases: Phases<'_>,
    grain: Grain,
) -> Result<ForeseenOffice<M>, Raise> {
    let mut controller = known(controller);
    let begun = begun(&mut controller, phases)?;
    let models = learned(&mut controller);
    foreseen(controller, now_us, begun, models, grain)
}

/// The abstract robot at the start of a run, where what may come between is as likely as the models say: for the
/// projections of somebody who believes in them, or, once its run has begun, as a world of its own.
///
/// # Errors
/// There is no map.
pub(super) fn abstract_robot<M: Module>(controller: &Controller<M>, models: Models) -> Result<ForeseenRobot, Raise> {
    Ok(ForeseenRobot::of(at_start(controller, models)?))
}

/// The same, with what only the experimenter sees.
///
/// # Errors
/// There is no map.
pub(super) fn at_start<M: Module>(controller: &Controller<M>, models: Models) -> Result<ForeseenOffice<M>, Raise> {
    foreseen(known(controller), 0, Vec::new(), models, Grain::Abstract)
}

/// The controller in the world that the map shows.
fn known<M: Module>(controller: &Controller<M>) -> Controller<M> {
    let mut known = Controller { model: controller.model.known(), ..controller.clone() };
    known.modules.foresee();
    known
}

fn foreseen<M: Module>(
    mut controller: Controller<M>,
    now_us: u64,
    begun: Vec<UnderWay>,
    models: Models,
    grain: Grain,
) -> Result<ForeseenOffice<M>, Raise> {
    let model = controller.model.clone();
    let Some(map) = &model.map else { return Err(no_map("there is nothing to project drives on")) };
    let found_closed = closed_doors(&mut controller);
    let ways = ForeseenWays::default();
    let percept = controller.board.percept.as_ref();
    let holding = percept.and_then(|percept| percept.gripper.holding.clone());
    let battery = percept.map_or(1.0, |percept| percept.battery);
    let Estimate { pose_in_map, .. } = controller.estimate();
    let odom_in_map = pose_in_map.compose(controller.board.position.odometry_in_odom().inverse());
    let knowledge = knowledge(&controller, &model, map, models, grain);
    let robot = AbstractRobot::new(knowledge, ways.ways.clone(), holding, battery, now_us);
    let mut foreseen = ForeseenOffice {
        controller,
        robot,
        ways,
        odom_in_map,
        found_closed,
        begun,
        unforeseen: None,
        sets: BTreeMap::new(),
    };
    foreseen.tell_position();
    Ok(foreseen)
}

/// The part of the modules that is of a type.
pub(super) fn part<M: Module, T: 'static>(modules: &mut M) -> Option<&mut T> {
    modules.part(TypeId::of::<T>()).and_then(<dyn Any>::downcast_mut)
}

/// The doors found closed, as indices into the world's doors.
pub(super) fn closed_doors<M: Module>(controller: &mut Controller<M>) -> Vec<usize> {
    part::<M, Navigating>(&mut controller.modules).map_or_else(Vec::new, |navigating| navigating.closed_doors())
}

/// What of the behaviours is under way.
fn begun<M: Module>(controller: &mut Controller<M>, phases: Phases<'_>) -> Result<Vec<UnderWay>, Raise> {
    let composition = controller.composition.clone();
    let has_set_off = controller.board.drive_request != Velocity::default();
    let is_active = |&(number, _): &(usize, _)| phases.of(number as u16) == Phase::Active;
    let mut begun = Vec::new();
    for (number, spec) in composition.tables.behaviours.iter().enumerate().filter(is_active) {
        begun.push(match doing(&composition, number as u16) {
            Some(Doing::Driving) => {
                let navigating = part::<M, Navigating>(&mut controller.modules);
                let targets = navigating.map_or_else(Vec::new, |navigating| navigating.targets_in_map().to_vec());
                UnderWay::Driving { targets, patience_s: MappedNavigation::PATIENCE_S, has_set_off }
            }
            Some(Doing::Gripping) => {
                match part::<M, Gripping>(&mut controller.modules).and_then(|gripping| gripping.wanted()) {
                    Some(thing) => UnderWay::Grasping(thing.to_string()),
                    None => UnderWay::Releasing,
                }
            }
            Some(Doing::Looking) => UnderWay::Looking,
            Some(Doing::Moving) => {
                let odometry_in_odom = controller.board.position.odometry_in_odom();
                let moving = part::<M, MovingByOdometry>(&mut controller.modules);
                let Some(left) = moving.and_then(|moving| moving.left(odometry_in_odom)) else { continue };
                UnderWay::Moving(left)
            }
            Some(Doing::Searching) => UnderWay::Searching,
            Some(Doing::Acting(number)) => acting(&composition, number),
            None if spec.name == TRACKING => continue,
            None => return Err(Raise::new("projection-failure", without_model(&spec.name))),
        });
    }
    Ok(begun)
}

/// What keeps the position up to date goes on by itself.
const TRACKING: &str = "position-tracking";

/// What a behaviour does, if it is foreseen.
pub(super) fn doing<M: Module>(composition: &Composition<M>, behaviour: u16) -> Option<Doing> {
    match &*composition.tables.behaviours[usize::from(behaviour)].name {
        navigation::NAME => Some(Doing::Driving),
        "gripper" => Some(Doing::Gripping),
        look_around::NAME => Some(Doing::Looking),
        move_by_odometry::NAME => Some(Doing::Moving),
        active_localization::NAME => Some(Doing::Searching),
        _ => composition.models.contains_key(&behaviour).then_some(Doing::Acting(behaviour)),
    }
}

/// To do what the behaviour of another module does.
fn acting<M: Module>(composition: &Composition<M>, behaviour: u16) -> UnderWay {
    UnderWay::Acting(behaviour, composition.models[&behaviour].clone())
}

fn without_model(behaviour: &str) -> String {
    format!(
        "there is no model of what the behaviour `{behaviour}` does, so no plan that needs it is projected; a module in \
         another process says `takes` of it in its manifest"
    )
}

/// The models of what may come between, by what the robot has learned.
fn learned<M: Module>(controller: &mut Controller<M>) -> Models {
    let grasps = part::<M, Gripping>(&mut controller.modules).map(|gripping| gripping.record()).unwrap_or_default();
    let drives = part::<M, Navigating>(&mut controller.modules)
        .map(|navigating| navigating.record().clone())
        .unwrap_or_default();
    Models::learned(&controller.model.settings.robot, &grasps, &drives)
}

fn knowledge<M: Module>(
    controller: &Controller<M>,
    model: &OfficeModel,
    map: &MapModel,
    models: Models,
    grain: Grain,
) -> Knowledge {
    let robot = &*model.settings.robot;
    let chargers = model.world.places.iter().filter(|place| place.charges);
    Knowledge {
        drive_times: DriveTimes::of(robot),
        models,
        hypotheses: match grain {
            Grain::Abstract => hypotheses(controller, map),
            Grain::Simulated => likely_poses(controller, map),
        },
        gripper: robot.gripper,
        battery: robot.battery,
        chargers_in_map: chargers.map(|place| place.pose_in_map.point()).collect(),
        look_s: DriveTimes::look_s(robot),
    }
}

/// Where the robot may be, to a cell of its belief, with probabilities that sum to 1, the likeliest first.
fn likely_poses<M: Module>(controller: &Controller<M>, map: &MapModel) -> Vec<(Pose, f64)> {
    let Estimate { pose_in_map, .. } = controller.estimate();
    let Some(localization) = controller.board.position.localization() else { return vec![(pose_in_map, 1.0)] };
    let mut poses = localization.likely_poses(&map.localization, LIKELY);
    poses.truncate(MOST_POSES);
    let mass: f64 = poses.iter().map(|pose| pose.mass).sum();
    match mass > 0.0 {
        true => poses.iter().map(|pose| (pose.pose_in_map, pose.mass / mass)).collect(),
        false => vec![(pose_in_map, 1.0)],
    }
}

/// Where the robot may be, with probabilities that sum to 1: the estimate as long as it is sure.
fn hypotheses<M: Module>(controller: &Controller<M>, map: &MapModel) -> Vec<(Pose, f64)> {
    let Estimate { pose_in_map, certainty } = controller.estimate();
    let sure = vec![(pose_in_map, 1.0)];
    let Some(localization) = controller.board.position.localization() else { return sure };
    if certainty > 1.0 - LEAST_MASS {
        return sure;
    }
    let maxima = localization.maxima(&map.localization, MOST_HYPOTHESES, LEAST_MASS);
    let mass: f64 = maxima.iter().map(|maximum| maximum.mass).sum();
    if maxima.is_empty() || mass <= 0.0 {
        return sure;
    }
    maxima.iter().map(|maximum| (maximum.pose_in_map, maximum.mass / mass)).collect()
}

impl<M: Module> ForeseenOffice<M> {
    fn map<'m>(model: &'m OfficeModel) -> Option<WayMap<'m>> {
        model.map.as_ref().map(|map| map.ways(&model.world))
    }

    /// The robot as who is in an abstract world foresees it, by models of what may come between.
    pub(super) fn foreseen(&self, models: Models) -> Self {
        let ways = Ways::default();
        let robot = self.robot.believed(models, ways.clone());
        let found_closed = self.robot.closed_doors();
        let ways = ForeseenWays { ways, ..ForeseenWays::default() };
        Self { robot, ways, found_closed, begun: self.robot.under_way(), ..self.clone() }
    }

    /// The position is what functions of plans find it to be: where the abstract robot believes itself.
    pub(super) fn tell_position(&mut self) {
        self.robot.is_lost |= self.controller.board.position.take_doubt();
        let (certainty, pose_in_map) = (self.certainty(), self.robot.robot_in_map);
        let odometry_in_odom = self.odom_in_map.inverse().compose(pose_in_map);
        self.controller.board.position.foresee(Estimate { pose_in_map, certainty }, odometry_in_odom);
        self.ways.closed_doors = self.robot.closed_doors();
    }

    /// As certain as it tells plans to be.
    pub(super) fn certainty(&self) -> f64 {
        if self.robot.is_lost { LOST } else { SURE }
    }

    fn ending(&self, outcome: Outcome) -> Ending {
        let world = &self.controller.model.world;
        match outcome {
            Outcome::Done => Ending::DONE,
            Outcome::Unreachable => Ending::failure("unreachable", "the map shows no way to the target"),
            Outcome::Empty => navigation::blocked(world, None, self.robot.robot_in_map.point()),
            Outcome::DoorClosed(door) => {
                navigation::blocked(world, Some(Obstruction::Door(door)), self.robot.robot_in_map.point())
            }
            Outcome::Hindered(goal) => {
                move_by_odometry::blocked(MoveHindrance::Obstacle, goal, self.robot.robot_in_map)
            }
            Outcome::NotHeld(thing) => Ending::failure("grasp-failure", format!("the gripper does not hold `{thing}`")),
            Outcome::NotOpened => Ending::failure("grasp-failure", "the gripper did not open"),
            Outcome::NotFound => Ending::failure("localization-failure", "the position is still not known"),
            Outcome::Failed(class) => Ending::failure(&class, "its module says that it fails at times"),
        }
    }

    /// Tells plans how things stand, and of navigation whether it is active, and how many targets are left.
    pub(super) fn publish(&self, (is_navigating, targets): (bool, usize), outbox: &mut Outbox) {
        let board = &self.controller.board;
        let pose = self.robot.robot_in_map;
        let region = self.controller.model.world.mode_at(pose.point());
        let mode = |mode| Reading::Symbol(mode_name(mode).to_string());
        let values = [
            ("x*", Reading::Float(pose.x_m)),
            ("y*", Reading::Float(pose.y_m)),
            ("o*", Reading::Float(pose.heading_rad)),
            ("pos-certainty*", Reading::Float(self.certainty())),
            ("position-lost*", Reading::Truth(self.robot.is_lost)),
            ("travel-mode*", mode(board.mode)),
            ("region*", region.map_or(Reading::Truth(false), mode)),
            ("holding*", self.robot.holding.clone().map_or(Reading::Truth(false), Reading::Symbol)),
            ("battery*", Reading::Float(libm::round(self.robot.battery * 1000.0) / 1000.0)),
            ("messages*", Reading::Int(board.inbox.len() as i64)),
            ("navigation-active?*", Reading::Truth(is_navigating)),
            ("nr-of-nav-goals*", Reading::Int(targets as i64)),
        ];
        let fluents = &self.tables().fluents;
        for (name, reading) in values {
            if let Some(number) = fluents.iter().position(|fluent| fluent.name == name) {
                outbox.fluents.push((number, reading));
            }
        }
    }

    pub(super) fn tell_endings(&self, ended: Vec<(Doing, Outcome)>, outbox: &mut Outbox) {
        for (doing, outcome) in ended {
            let mut numbers = 0..self.tables().behaviours.len() as u16;
            if let Some(number) = numbers.find(|&number| self.doing(number) == Some(doing)) {
                if outcome == Outcome::Done {
                    outbox.fluents.extend(self.sets.get(&number).into_iter().flatten().cloned());
                }
                outbox.endings.push((number, self.ending(outcome)));
            }
        }
    }

    /// What a behaviour does, if it is foreseen.
    pub(super) fn doing(&self, behaviour: u16) -> Option<Doing> {
        doing(&self.controller.composition, behaviour)
    }

    fn begin(&mut self, asked: &UnderWay) {
        let model = self.controller.model.clone();
        if let Some(map) = Self::map(&model) {
            self.robot.begin(map, asked);
        }
    }
}

impl<M: Module> Foreseen for ForeseenOffice<M> {
    fn copied(&self) -> Box<dyn Foreseen> {
        Box::new(self.clone())
    }

    fn begin_run(&mut self, seed: u64) {
        self.robot.begin_run(seed);
        for &door in &self.found_closed {
            self.robot.know_closed(door);
        }
        for begun in self.begun.clone() {
            self.begin(&begun);
        }
        self.tell_position();
    }

    fn unforeseen(&self) -> Option<&str> {
        self.unforeseen.as_deref()
    }

    fn has_drawn(&self) -> bool {
        self.robot.has_drawn()
    }
}

impl<M: Module> Outside for ForeseenOffice<M> {
    fn tables(&self) -> &RobotTables {
        &self.controller.composition.tables
    }

    fn start(
        &mut self,
        machine: &Machine,
        behaviour: u16,
        arguments: &[(Symbol, Value)],
        _: &mut Outbox,
    ) -> Result<(), Raise> {
        let Some(doing) = self.doing(behaviour) else {
            let why = without_model(&self.tables().behaviours[usize::from(behaviour)].name);
            self.unforeseen.get_or_insert_with(|| why.clone());
            return Err(Raise::new("projection-failure", why));
        };
        let asked = match doing {
            Doing::Driving => {
                let (targets, patience_s) = navigation::arguments(machine, arguments)?;
                let patience_s = patience_s.unwrap_or(MappedNavigation::PATIENCE_S);
                UnderWay::Driving { targets, patience_s, has_set_off: false }
            }
            Doing::Gripping => match Gripping::asked(machine, arguments)? {
                Some(thing) => UnderWay::Grasping(thing.to_string()),
                None => UnderWay::Releasing,
            },
            Doing::Looking => UnderWay::Looking,
            Doing::Moving => UnderWay::Moving(move_by_odometry::arguments(machine, arguments)?.0),
            Doing::Searching => UnderWay::Searching,
            Doing::Acting(number) => {
                let composition = &self.controller.composition;
                let sets = composition.models[&number].effects(&composition.tables, machine, arguments);
                self.sets.insert(number, sets);
                acting(composition, number)
            }
        };
        self.begin(&asked);
        Ok(())
    }

    fn stop(&mut self, behaviour: u16, _: StopReason, _: &mut Outbox) {
        if let Some(doing) = self.doing(behaviour) {
            self.robot.stop(doing);
        }
    }

    fn next_event_us(&self, _: u64) -> Option<u64> {
        Some(self.robot.next_event_us().unwrap_or(NEVER_US))
    }

    /// Position and battery follow time.
    fn steps_at(&self, _: u64, _: u64) -> bool {
        true
    }

    fn step(&mut self, now_us: u64, _: Phases<'_>, outbox: &mut Outbox) {
        let ended = self.robot.advance_to(now_us);
        self.tell_position();
        self.publish((self.robot.drives(), self.robot.remaining_targets()), outbox);
        self.tell_endings(ended, outbox);
    }

    fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        if of == TypeId::of::<ForeseenWays>() {
            Some(&mut self.ways)
        } else if of == TypeId::of::<AbstractRobot>() {
            Some(&mut self.robot)
        } else {
            self.controller.part(of)
        }
    }
}
