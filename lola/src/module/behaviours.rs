//! Its behaviours: what they are started with, and how they stop.

use super::behaviour_places::{
    DIRECTION_FOLLOW, FEATURE_DETECTION, GOAL_SEEK, MARKER_DETECTION, REGISTRATION, WALL_FOLLOW,
};
use super::drive::Drive;
use super::hallway::Hallway;
use super::hallway_drive::{HallwayDrive, Until};
use super::seeing::Seeing;
use super::state::Lola;
use crate::routines::DoorwayDetection;
use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::navigation::{DriveTask, LocalDrive, MaplessNavigation};
use rpl_robot::office::{OfficeModel, Start, StopReason};
use rpl_robot::planning::Target;
use rpl_runtime::robot::BehaviourSpec;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use std::borrow::Cow;

/// Held up for longer than this, a behaviour gives up unless it has another `:patience`.
const PATIENCE_S: f64 = 30.0;

/// A door out of a room is sought on the way to a point this far off, which lies outside of it.
const OUTSIDE_M: f64 = 12.0;

const WHEELS: Option<Cow<'static, str>> = Some(Cow::Borrowed("wheels"));

/// The table.
pub(super) fn behaviours() -> Vec<BehaviourSpec> {
    let behaviour = |name, valve, parameters, doc| BehaviourSpec {
        name: Cow::Borrowed(name),
        doc: Cow::Borrowed(doc),
        valve,
        parameters: Cow::Borrowed(parameters),
    };
    vec![
        behaviour(
            "direction-follow",
            WHEELS,
            ":to :lane :patience",
            "Drives along the registered hallway, in its middle or `:lane` metres left of it, to its end, or to where `:to` metres from its beginning are reached, ahead or behind. Registers again after the robot was turned by hand, and goes back first to where it was called away. Fails with registration-failure in no hallway, with blocked if for the time of `:patience`, without it 30 s, it does not get on.",
        ),
        behaviour(
            "wall-follow",
            WHEELS,
            ":side",
            "Keeps a wall on the `:side`, left or right. Never ends by itself but with blocked.",
        ),
        behaviour(
            "goal-seek",
            WHEELS,
            ":to :detour :through-door :patience",
            "Drives to `:to`, a list (x y) or (x y heading) in the frame of the odometry, by what it sees on the way; with `:detour` by no way that is so many metres longer than the straight one: it waits for who stands there. With `:through-door t` it succeeds as soon as the robot has come through a door, and needs no goal. Fails with unreachable, or with blocked if for the time of `:patience`, without it 30 s, it gets no nearer.",
        ),
        behaviour(
            "registration",
            WHEELS,
            ":heading :patience",
            "Begins with a hallway that runs about the way of `:heading`, an angle in the frame of the odometry, without it the way the robot looks: drives along it until its axis is known by its walls, and back to where it began. Fails with registration-failure where there are no such walls.",
        ),
        behaviour(
            "feature-detection",
            None,
            "",
            "Perceives what is beside the hallway that direction-follow drives along, each opening once. Never ends by itself.",
        ),
        behaviour(
            "marker-detection",
            None,
            ":colour :size :around",
            "Looks with the camera for markers on the floor, of `:colour` and of `:size`, the length of a side: on both sides of the hallway, or with `:around t` all around. What it has found counts for feature-detection. Never ends by itself.",
        ),
    ]
}

impl Lola {
    /// Starts a behaviour.
    pub(super) fn begin(&mut self, behaviour: usize, start: &Start<'_>, here: Pose) -> Result<(), Raise> {
        if start.model.sensors.sonars.is_none() {
            let robot = &start.model.settings.robot.name;
            let message = format!("the robot `{robot}` has no sonars, by which hallways are followed; try b21");
            return Err(Raise::new("registration-failure", message));
        }
        match behaviour {
            DIRECTION_FOLLOW => self.begin_direction_follow(start, here)?,
            WALL_FOLLOW => self.drive = Drive::Wall { drive: Box::new(wall_follow(start)?), stuck_s: 0.0 },
            GOAL_SEEK => self.begin_goal_seek(start, here)?,
            REGISTRATION => {
                let heading_rad = number(start, "heading", "an angle, such as `:heading 90deg`")?;
                self.hallway = Some(Hallway::start(heading_rad.unwrap_or(here.heading_rad), here));
                self.drive = Drive::Hallway(Box::new(HallwayDrive::register(patience_s(start)?)));
            }
            MARKER_DETECTION => self.markers = Some(Seeing::start(start, self.markers.take())?),
            _ => {}
        }
        self.has_news = true;
        Ok(())
    }

    /// Stops a behaviour: what is known of the hallway is kept.
    pub(super) fn end(&mut self, behaviour: usize, _: StopReason) {
        if ![FEATURE_DETECTION, MARKER_DETECTION].contains(&behaviour) {
            self.drive = Drive::Idle;
        }
        self.has_news = true;
    }

    fn begin_direction_follow(&mut self, start: &Start<'_>, here: Pose) -> Result<(), Raise> {
        let Some(hallway) = &self.hallway else {
            return Err(Raise::new(
                "registration-failure",
                "the robot is in no hallway that it knows; `registration` comes before `direction-follow`",
            ));
        };
        let until = match number(start, "to", "metres along the hallway, such as `:to 3m`")? {
            Some(along_m) => Until::Along { along_m },
            None => Until::End,
        };
        let lane_m = number(start, "lane", "metres left of the middle, such as `:lane 30cm`")?.unwrap_or(0.0);
        let drive = HallwayDrive::follow(hallway, here, until, lane_m, patience_s(start)?);
        self.drive = Drive::Hallway(Box::new(drive));
        Ok(())
    }

    fn begin_goal_seek(&mut self, start: &Start<'_>, here: Pose) -> Result<(), Raise> {
        let through_door = start.argument("through-door").is_some_and(Value::is_true);
        let target = match start.argument("to") {
            Some(Value::Nil) | None if through_door => Target::through(outside(start.model, here)),
            Some(goal) => target(start, goal)?,
            None => return Err(no_goal()),
        };
        let mut navigation = MaplessNavigation::new(start.model.sensors.sharpest());
        match number(start, "detour", "metres, such as `:detour 4m`")? {
            Some(detour_m) => {
                let longest_way_m = distance_m(here.point(), target.point_in_frame) + detour_m;
                navigation.start_nearby(target, patience_s(start)?, longest_way_m);
            }
            None => navigation.start(vec![target], patience_s(start)?),
        }
        let doorways = through_door.then(DoorwayDetection::default);
        self.drive = Drive::Goal { navigation: Box::new(navigation), doorways };
        Ok(())
    }
}

/// A point outside of the room, whichever way.
fn outside(_: &OfficeModel, here: Pose) -> Point {
    here.transform(Point::new(OUTSIDE_M, 0.0))
}

fn no_goal() -> Raise {
    Raise::type_error(
        "`goal-seek` takes `:to`, a point `(x y)` or `(x y heading)` of the odometry, or `:through-door t`",
    )
}

fn target(start: &Start<'_>, goal: Value) -> Result<Target, Raise> {
    let elements = start.machine.heap.elements(goal).map_err(|_| no_goal())?;
    let numbers: Option<Vec<f64>> = elements.into_iter().map(Value::as_f64).collect();
    match numbers.as_deref() {
        Some(&[x_m, y_m]) => Ok(Target::through(Point::new(x_m, y_m))),
        Some(&[x_m, y_m, heading_rad]) => Ok(Target::at(Pose::new(x_m, y_m, heading_rad))),
        _ => Err(no_goal()),
    }
}

fn wall_follow(start: &Start<'_>) -> Result<LocalDrive, Raise> {
    let name = match start.argument("side") {
        Some(Value::Symbol(side)) => start.machine.symbols.name(side),
        _ => "",
    };
    let side = match name {
        "left" => 1,
        "right" => -1,
        _ => return Err(Raise::type_error("`wall-follow` takes `:side 'left` or `:side 'right`")),
    };
    Ok(LocalDrive::new(DriveTask::WallFollow { side }))
}

/// A number given for a parameter; nil is none.
fn number(start: &Start<'_>, parameter: &str, expected: &str) -> Result<Option<f64>, Raise> {
    match start.argument(parameter) {
        None | Some(Value::Nil) => Ok(None),
        Some(value) => value
            .as_f64()
            .filter(|number| number.is_finite())
            .map(Some)
            .ok_or_else(|| Raise::type_error(format!("`:{parameter}` takes {expected}"))),
    }
}

fn patience_s(start: &Start<'_>) -> Result<f64, Raise> {
    Ok(number(start, "patience", "a time, such as `:patience 20s`")?.unwrap_or(PATIENCE_S).max(0.0))
}
