//! Navigation: it drives to the points of a plan, on a map or without one.

use super::body::WHEELS;
use super::places::named_place;
use crate::foresight::abstract_robot::AbstractRobot;
use crate::foresight::drive_times::{DriveTimes, WayFeatures};
use crate::foresight::models::{DriveRecord, TimedDrive};
use crate::foresight::ways::ForeseenWays;
use crate::geometry::{Point, Pose, Velocity, distance_m};
use crate::navigation::{
    MaplessNavigation, MappedNavigation, NavigationEvent, NavigationModel, NavigationOutput, Obstruction,
};
use crate::office::functions::{act, board, look, model};
use crate::office::model::OfficeModel;
use crate::office::module::{Module, ModuleSpec, Moment, PlanText, Start, Telling, fluent, fluent_number};
use crate::office::plan_text;
use crate::office::position::Position;
use crate::office::words::no_map;
use crate::planning::Target;
use crate::simulator::Commands;
use crate::world::{Door, TravelMode, World};
use rpl_lang::symbol::{Symbol, fold_name};
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{BehaviourSpec, Ending, FluentSpec, StopReason};
use rpl_runtime::state::activation::Phase;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Reply};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Its name.
pub(in crate::office) const NAME: &str = "navigation";

/// The robot's own plan library.
pub const PLANS: &str = include_str!("../plans.rpl");

/// Rules that revise plans of the robot, and the plans that they make use of.
pub const RULES: &str = include_str!("../rules.rpl");

/// What it tells plans.
pub(in crate::office) const FLUENTS: &[FluentSpec] = &[
    fluent("navigation-active?*", "True while a navigation plan is executed."),
    fluent("nr-of-nav-goals*", "Target points not yet reached."),
];

const NAVIGATION_ACTIVE: usize = fluent_number(FLUENTS, "navigation-active?*");
const NR_OF_NAV_GOALS: usize = fluent_number(FLUENTS, "nr-of-nav-goals*");

/// The state of navigation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Navigating {
    /// On a map; idle without one.
    mapped: MappedNavigation,
    /// Without a map; idle with one.
    mapless: MaplessNavigation,
    needs_sonars: bool,
    /// The drive on the map that goes on, if nobody has interrupted it.
    driving: Option<DriveBegun>,
    /// What it has learned of its drives.
    record: DriveRecord,
}

/// A drive that goes on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct DriveBegun {
    begun_us: u64,
    /// What was driven so far.
    way: WayFeatures,
    mode: TravelMode,
    /// Doorways that were entered.
    doorways: u32,
}

/// What turns slower than this does not turn, but keeps its way.
const TURNING_RADPS: f64 = 0.2;

impl Navigating {
    /// Doors found closed not long ago, as indices into the world's doors.
    pub fn closed_doors(&self) -> Vec<usize> {
        self.mapped.closed_doors()
    }

    /// What it has learned of its drives.
    pub(in crate::office) fn record(&self) -> &DriveRecord {
        &self.record
    }

    /// Targets on the map that are not reached yet.
    pub fn targets_in_map(&self) -> &[Target] {
        self.mapped.remaining_targets()
    }

    /// Targets that are not reached yet, the next first: in `map` with a map, in `odom` without one.
    pub fn remaining_targets(&self) -> impl Iterator<Item = Point> {
        let targets = self.mapped.remaining_targets().iter().chain(self.mapless.remaining_targets());
        targets.map(|target| target.point_in_frame)
    }

    /// What stands there and is not in the map, as far as it knows, in the map.
    pub(in crate::office) fn standing_in_map(
        &self,
        model: &NavigationModel,
        estimated_in_map: Pose,
        odometry_in_odom: Pose,
    ) -> Vec<Point> {
        self.mapped.standing_in_map(model, estimated_in_map, odometry_in_odom)
    }

    /// Time passes in which there is nothing to do and nothing to see.
    pub(in crate::office) fn let_pass(&mut self, seconds: f64) {
        self.mapped.let_pass(seconds);
    }

    /// Obstacles that it remembers, in `odom`.
    pub fn obstacles_in_odom(&self) -> impl Iterator<Item = Point> {
        let remembered = self.mapped.remembered().iter().chain(self.mapless.remembered());
        remembered.map(|remembered| remembered.point_in_odom)
    }

    /// Takes down what this step adds to the drive.
    fn note_step(&mut self, now: &Moment<'_>) {
        let (Some(drive), step_s) = (&mut self.driving, now.model.limits.step_s) else { return };
        let Velocity { translation_mps, rotation_radps } = now.input().velocity;
        drive.way.add(now.mode, translation_mps.abs() * step_s);
        if rotation_radps.abs() > TURNING_RADPS {
            drive.way.turned_rad += rotation_radps.abs() * step_s;
        }
        drive.doorways += u32::from(now.mode == TravelMode::Doorway && drive.mode != now.mode);
        drive.mode = now.mode;
    }

    fn note_arrival(&mut self, now: &Moment<'_>) {
        let Some(drive) = self.driving.take() else { return };
        let took_s = now.percept.time_us.saturating_sub(drive.begun_us) as f64 / 1e6;
        let expected_s = DriveTimes::of(&now.model.settings.robot).time_s(&drive.way);
        self.record.note(TimedDrive { expected_s, took_s }, drive.doorways);
    }

    fn remove_all_targets(&mut self) {
        self.driving = None;
        self.mapped.remove_all_targets();
        self.mapless.remove_all_targets();
    }

    fn publish_goals(&self, phase: Phase, tell: &mut Telling<'_>) {
        let active = matches!(phase, Phase::Active | Phase::Interrupted);
        let goals = if active { self.remaining_targets().count() } else { 0 };
        tell.fluent(NAVIGATION_ACTIVE, Reading::Truth(active));
        tell.fluent(NR_OF_NAV_GOALS, Reading::Int(goals as i64));
    }

    fn drive(&mut self, now: &Moment<'_>, position: &Position) -> NavigationOutput {
        let (model, input) = (now.model, now.input());
        match &model.map {
            Some(map) => {
                let estimated_in_map = position.estimate(Some(map)).pose_in_map;
                self.mapped.step(&map.navigation, estimated_in_map, &input, now.mode)
            }
            None => self.mapless.step(&model.limits, &input, model.limits.speed_limit_mps(now.mode)),
        }
    }

    fn unreachable(&self, model: &OfficeModel, position: &Position) -> Ending {
        let message = match (&model.map, self.mapped.remaining_targets().first()) {
            (Some(map), Some(target)) => {
                let here = position.estimate(Some(map)).pose_in_map.point();
                let between = map.topology.what_is_between(&map.navigation.planner, here, target.point_in_frame);
                format!("the map shows no way to the target: {between}")
            }
            (Some(_), None) => "the map shows no way to the target".to_string(),
            (None, _) => "what has been seen leaves no way to the target".to_string(),
        };
        Ending::failure("unreachable", message)
    }

    fn blocked(&self, now: &Moment<'_>, position: &Position) -> Ending {
        let estimated_in_map = position.estimate(now.model.map.as_ref()).pose_in_map;
        let obstruction =
            now.model.map.as_ref().and_then(|map| {
                self.mapped.obstruction(&map.navigation, estimated_in_map, now.percept.odometry_in_odom)
            });
        blocked(&now.model.world, obstruction, estimated_in_map.point())
    }
}

impl Module for Navigating {
    type Settings = ();

    fn specs((): &()) -> Vec<ModuleSpec> {
        vec![ModuleSpec {
            name: NAME.into(),
            behaviours: vec![BehaviourSpec {
                name: Cow::Borrowed(NAME),
                doc: Cow::Borrowed(
                    "Drives to the points of `:targets`, lists (x y) or, for the last, (x y heading). Succeeds close to the last one; fails with unreachable, or with blocked if for the time of `:patience`, without it two minutes, the robot gets no nearer.",
                ),
                valve: Some(WHEELS),
                parameters: Cow::Borrowed(":targets :patience"),
            }],
            fluents: FLUENTS.to_vec(),
            functions: vec![
                look(
                    "generate-navigation-plan",
                    "place &optional patience",
                    "A plan, as data, that drives from the estimated position to a place, not through doors found closed if there is another way. The patience is that of `navigation`.",
                    generate,
                ),
                act(
                    "plan-remove-all-goals",
                    "",
                    "Deletes all target points of the navigation this task or one below it has started.",
                    remove_all_goals,
                ),
                act(
                    "forget-obstacles",
                    "&optional x y radius",
                    "Forgets what was seen and felt to stand somewhere besides the map, and which doors were found closed: all of it, or what is within a radius of a point. What stands there is seen anew.",
                    forget_obstacles,
                ),
            ],
            plans: vec![
                PlanText { name: "robot".into(), text: PLANS.into() },
                PlanText { name: "rules".into(), text: RULES.into() },
            ],
            ..ModuleSpec::default()
        }]
    }

    fn new((): &(), model: &OfficeModel, _: u64) -> Self {
        let mapless = MaplessNavigation::new(model.sensors.sharpest());
        Self {
            mapped: MappedNavigation::default(),
            mapless,
            needs_sonars: true,
            driving: None,
            record: DriveRecord::default(),
        }
    }

    fn start(&mut self, _: usize, start: &Start<'_>, _: &mut Position, tell: &mut Telling<'_>) -> Result<(), Raise> {
        let (targets, patience_s) = arguments(start.machine, start.arguments)?;
        self.driving = start.model.map.is_some().then_some(DriveBegun {
            begun_us: start.time_us,
            way: WayFeatures::default(),
            mode: TravelMode::Hallway,
            doorways: 0,
        });
        match start.model.map {
            Some(_) => self.mapped.start(targets, patience_s.unwrap_or(MappedNavigation::PATIENCE_S)),
            None => self.mapless.start(targets, patience_s.unwrap_or(MaplessNavigation::PATIENCE_S)),
        }
        self.publish_goals(Phase::Active, tell);
        Ok(())
    }

    fn stop(&mut self, _: usize, why: StopReason, tell: &mut Telling<'_>) {
        let phase = match why {
            StopReason::Deactivated => {
                self.remove_all_targets();
                Phase::Inactive
            }
            StopReason::Interrupted => {
                self.mapped.interrupt();
                self.mapless.remove_all_targets();
                self.driving = None;
                Phase::Interrupted
            }
        };
        self.publish_goals(phase, tell);
    }

    /// Sonars may only rest in doorways while it drives and does not need them.
    fn command(&mut self, _: TravelMode, phases: &[Phase], commands: &mut Commands) {
        commands.sonars_on |= self.needs_sonars || phases != [Phase::Active];
    }

    /// It remembers what is in the way also while it does not drive.
    fn step(&mut self, now: &Moment<'_>, position: &mut Position, tell: &mut Telling<'_>) -> Option<Velocity> {
        let output = self.drive(now, position);
        self.needs_sonars = output.needs_sonars;
        position.note_held_up(now.phases == [Phase::Active] && self.mapped.is_held_up());
        if now.phases != [Phase::Active] {
            return None;
        }
        self.note_step(now);
        let ending = match output.event {
            Some(NavigationEvent::Arrived) => {
                self.note_arrival(now);
                Ending::DONE
            }
            Some(NavigationEvent::Unreachable) => self.unreachable(now.model, position),
            Some(NavigationEvent::Blocked) => {
                let ending = self.blocked(now, position);
                self.record.doors_closed += u32::from(is_at_door(&ending));
                ending
            }
            Some(NavigationEvent::TargetReached) | None => return Some(output.velocity),
        };
        self.remove_all_targets();
        tell.end(0, ending);
        Some(Velocity::default())
    }

    fn publish(&mut self, now: &Moment<'_>, _: &Position, tell: &mut Telling<'_>) {
        self.publish_goals(now.phases[0], tell);
    }

    fn bytes_apart(&self, earlier: &Self) -> usize {
        self.mapped.bytes_apart(&earlier.mapped) + self.mapless.bytes_apart(&earlier.mapless)
    }
}

/// Whether a door was in the way.
fn is_at_door(ending: &Ending) -> bool {
    let door = Reading::Symbol("door".to_string());
    matches!(ending, Ending::Failure { slots, .. } if slots.iter().any(|(name, value)| name == "obstacle" && *value == door))
}

/// The failure that tells what blocks the way, and where; `here` is the robot's own place.
pub(in crate::office) fn blocked(world: &World, obstruction: Option<Obstruction>, here: Point) -> Ending {
    let (what, obstacle, room, at) = match obstruction {
        Some(Obstruction::Door(door)) => {
            let Door { room, at, .. } = &world.doors[door];
            let what = format!("the door of `{room}` at {:.1} {:.1} is closed, or something stands in it", at.x, at.y);
            (what, Some("door"), Some(room.as_str()), *at)
        }
        Some(Obstruction::Thing(at)) => {
            let room = world.room_at(at).map(|room| &*room.name);
            let inside = room.map_or(String::new(), |room| format!(" in `{room}`"));
            let what = format!("a thing or a person that is not in the map stands at {:.1} {:.1}{inside}", at.x, at.y);
            (what, Some("thing"), room, at)
        }
        None => {
            (format!("nothing is seen in it; the robot came as far as {:.1} {:.1}", here.x, here.y), None, None, here)
        }
    };
    let symbol = |name: Option<&str>| name.map_or(Reading::Truth(false), |name| Reading::Symbol(name.to_string()));
    Ending::Failure {
        class: "blocked".to_string(),
        message: format!("the way to the target stays blocked: {what}"),
        slots: vec![
            ("obstacle".to_string(), symbol(obstacle)),
            ("room".to_string(), symbol(room)),
            ("x".to_string(), Reading::Float(at.x)),
            ("y".to_string(), Reading::Float(at.y)),
        ],
    }
}

/// `:targets`, a list of (x y) or (x y heading), and `:patience` in seconds.
pub(in crate::office) fn arguments(
    machine: &Machine,
    arguments: &[(Symbol, Value)],
) -> Result<(Vec<Target>, Option<f64>), Raise> {
    let (mut targets, mut patience_s) = (Vec::new(), None);
    for &(key, value) in arguments {
        match machine.symbols.name(key) {
            "targets" => targets = targets_argument(machine, value)?,
            "patience" => patience_s = patience_argument(value)?,
            _ => return Err(no_targets()),
        }
    }
    if targets.is_empty() { Err(no_targets()) } else { Ok((targets, patience_s)) }
}

fn no_targets() -> Raise {
    Raise::type_error("`navigation` takes `:targets`, a list of points `(x y)` or `(x y heading)`, and `:patience`")
}

fn targets_argument(machine: &Machine, points: Value) -> Result<Vec<Target>, Raise> {
    let target = |point: Value| {
        let numbers: Option<Vec<f64>> =
            machine.heap.elements(point).map_err(|_| no_targets())?.into_iter().map(Value::as_f64).collect();
        match numbers.as_deref() {
            Some(&[x_m, y_m]) => Ok(Target::through(Point::new(x_m, y_m))),
            Some(&[x_m, y_m, heading_rad]) => Ok(Target::at(Pose::new(x_m, y_m, heading_rad))),
            _ => Err(no_targets()),
        }
    };
    machine.heap.elements(points).map_err(|_| no_targets())?.into_iter().map(target).collect()
}

/// How long the robot is to wait where it gets no nearer: seconds, at least 0; nil is the usual.
pub(super) fn patience_argument(value: Value) -> Result<Option<f64>, Raise> {
    let wrong = || Raise::type_error("a patience is a time in seconds, at least 0, such as `:patience 2min`, or nil");
    match value {
        Value::Nil => Ok(None),
        value => value.as_f64().filter(|patience_s| *patience_s >= 0.0).map(Some).ok_or_else(wrong),
    }
}

fn generate(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (model, place) = named_place(call)?;
    let patience_s = if call.arguments.len() > 1 { patience_argument(call.argument(1))? } else { None };
    let start_in_map = board(call)?.position.estimate(model.map.as_ref()).pose_in_map;
    let Some(map) = &model.map else { return Err(no_map("there is nothing to plan on")) };
    // A projected robot knows doors closed that this one will find, and goes the same ways often.
    let plan = match call.part::<ForeseenWays>() {
        Ok(foreseen) => foreseen.plan(map.ways(&model.world), start_in_map, &place),
        Err(_) => {
            let closed_doors = call.part::<Navigating>()?.closed_doors();
            map.topology.plan(&map.navigation.planner, start_in_map, &place, &closed_doors)
        }
    };
    plan.map(|plan| Reply::Value(plan_text::navigation_plan(&plan, call.machine, patience_s))).map_err(|unreachable| {
        let destination = Value::Symbol(call.machine.symbols.intern(&fold_name(&place.name)));
        Raise::New {
            class: "unreachable",
            message: format!("no way to `{}`: {}", place.name, unreachable.reason),
            slots: vec![("destination", destination)],
        }
    })
}

fn forget_obstacles(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let around = match call.arguments.len() {
        0 => None,
        3 => Some((Point::new(call.number(0)?, call.number(1)?), call.number(2)?)),
        _ => {
            return Err(Raise::type_error(
                "`forget-obstacles` takes nothing, or a point and a radius: `(forget-obstacles X Y 1m)`",
            ));
        }
    };
    let is_meant = |point| around.is_none_or(|(at, radius_m)| distance_m(at, point) <= radius_m);
    let model = model(call)?;
    let position = &board(call)?.position;
    let (estimated_in_map, odometry_in_odom) =
        (position.estimate(model.map.as_ref()).pose_in_map, position.odometry_in_odom());
    if let Ok(foreseen) = call.part::<AbstractRobot>() {
        foreseen.forget_doors(|door| is_meant(model.world.doors[door].at));
    }
    let navigating = call.part::<Navigating>()?;
    match &model.map {
        Some(map) => navigating.mapped.forget_where(&map.navigation, estimated_in_map, odometry_in_odom, is_meant),
        None => navigating.mapless.forget(around),
    }
    Ok(Reply::Value(Value::Nil))
}

fn remove_all_goals(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let behaviours = &call.around.outside.tables().behaviours;
    let number = behaviours.iter().position(|behaviour| behaviour.name == NAME).ok_or_else(Raise::no_robot)?;
    call.machine.remove_goals(call.around, number as u16);
    Ok(Reply::Value(Value::Nil))
}
