//! Navigation: it drives to the points of a plan, on a map or without one.

use super::body::WHEELS;
use super::module::{Module, ModuleSpec, Moment, Start, Work, fluent};
use super::position::Position;
use super::{behaviour_number, fluent_number};
use crate::geometry::{Point, Pose, Velocity};
use crate::navigation::{MaplessNavigation, MappedNavigation, NavigationEvent, NavigationOutput, Obstruction};
use crate::office::model::OfficeModel;
use crate::planning::Target;
use crate::sensors::RangeSensor;
use crate::simulator::Commands;
use crate::world::{Door, TravelMode, World};
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{BehaviourSpec, Ending, Outbox, RobotEvent, StopReason};
use rpl_runtime::state::activation::Phase;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Its number.
pub const NUMBER: u16 = behaviour_number("navigation");

const NAVIGATION_ACTIVE: usize = fluent_number("navigation-active?*");
const NR_OF_NAV_GOALS: usize = fluent_number("nr-of-nav-goals*");

/// The state of navigation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Navigating {
    /// On a map; idle without one.
    mapped: MappedNavigation,
    /// Without a map; idle with one.
    mapless: MaplessNavigation,
    needs_sonars: bool,
}

impl Navigating {
    pub(super) const SPEC: ModuleSpec = ModuleSpec {
        behaviour: Some(BehaviourSpec {
            name: Cow::Borrowed("navigation"),
            doc: Cow::Borrowed(
                "Drives to the points of `:targets`, lists (x y) or, for the last, (x y heading). Succeeds close to the last one; fails with unreachable, or with blocked if for the time of `:patience`, without it two minutes, the robot gets no nearer.",
            ),
            valve: Some(WHEELS),
            parameters: Cow::Borrowed(":targets :patience"),
        }),
        fluents: &[
            fluent("navigation-active?*", "True while a navigation plan is executed."),
            fluent("nr-of-nav-goals*", "Target points not yet reached."),
        ],
        valves: &[],
    };

    pub(super) fn new(model: &OfficeModel, _: u64) -> Self {
        let sensor = if model.settings.simulator.laser { RangeSensor::Laser } else { RangeSensor::Sonar };
        Self { mapped: MappedNavigation::default(), mapless: MaplessNavigation::new(sensor), needs_sonars: true }
    }

    /// Doors found closed not long ago.
    pub(in crate::office) fn closed_doors(&self) -> Vec<usize> {
        self.mapped.closed_doors()
    }

    /// Bytes of plans of the way that an earlier state does not share.
    pub(in crate::office) fn bytes_apart(&self, earlier: &Self) -> usize {
        self.mapped.bytes_apart(&earlier.mapped) + self.mapless.bytes_apart(&earlier.mapless)
    }

    fn remove_all_targets(&mut self) {
        self.mapped.remove_all_targets();
        self.mapless.remove_all_targets();
    }

    /// Targets not yet reached.
    fn remaining_targets(&self) -> usize {
        self.mapped.remaining_targets().len() + self.mapless.remaining_targets().len()
    }

    fn publish_goals(&self, phase: Phase, outbox: &mut Outbox) {
        let active = matches!(phase, Phase::Active | Phase::Interrupted);
        let goals = if active { self.remaining_targets() } else { 0 };
        outbox.fluents.push((NAVIGATION_ACTIVE, Reading::Truth(active)));
        outbox.fluents.push((NR_OF_NAV_GOALS, Reading::Int(goals as i64)));
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
    fn start(&mut self, start: &Start<'_>, _: &mut Position, outbox: &mut Outbox) -> Result<(), Raise> {
        let (targets, patience_s) = arguments(start.machine, start.arguments)?;
        match start.model.map {
            Some(_) => self.mapped.start(targets, patience_s.unwrap_or(MappedNavigation::PATIENCE_S)),
            None => self.mapless.start(targets, patience_s.unwrap_or(MaplessNavigation::PATIENCE_S)),
        }
        self.publish_goals(Phase::Active, outbox);
        Ok(())
    }

    fn stop(&mut self, how: StopReason, outbox: &mut Outbox) {
        self.remove_all_targets();
        let phase = match how {
            StopReason::Deactivated => Phase::Inactive,
            StopReason::Interrupted => Phase::Interrupted,
        };
        self.publish_goals(phase, outbox);
    }

    /// Sonars may only rest in doorways while it drives and does not need them.
    fn command(&mut self, _: TravelMode, phase: Phase, commands: &mut Commands) {
        commands.sonars_on |= self.needs_sonars || phase != Phase::Active;
    }

    /// It remembers what is in the way also while it does not drive.
    fn step(&mut self, now: &Moment<'_>, position: &mut Position, _: &mut Vec<RobotEvent>) -> Work {
        let output = self.drive(now, position);
        self.needs_sonars = output.needs_sonars;
        if now.phase != Phase::Active {
            return Work::default();
        }
        let ending = match output.event {
            Some(NavigationEvent::Arrived) => Ending::Success,
            Some(NavigationEvent::Unreachable) => self.unreachable(now.model, position),
            Some(NavigationEvent::Blocked) => self.blocked(now, position),
            Some(NavigationEvent::TargetReached) | None => {
                return Work { velocity: Some(output.velocity), ending: None };
            }
        };
        self.remove_all_targets();
        Work { velocity: Some(Velocity::default()), ending: Some(ending) }
    }

    fn publish(&mut self, now: &Moment<'_>, _: &Position, outbox: &mut Outbox) {
        self.publish_goals(now.phase, outbox);
    }
}

/// The failure that tells what blocks the way, and where; `here` is the robot's own place.
fn blocked(world: &World, obstruction: Option<Obstruction>, here: Point) -> Ending {
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
fn arguments(machine: &Machine, arguments: &[(Symbol, Value)]) -> Result<(Vec<Target>, Option<f64>), Raise> {
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
pub(crate) fn patience_argument(value: Value) -> Result<Option<f64>, Raise> {
    let wrong = || Raise::type_error("a patience is a time in seconds, at least 0, such as `:patience 2min`, or nil");
    match value {
        Value::Nil => Ok(None),
        value => value.as_f64().filter(|patience_s| *patience_s >= 0.0).map(Some).ok_or_else(wrong),
    }
}
