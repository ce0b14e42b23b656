//! Functions of the robot that plans can call.

use super::behaviours::navigation::{self, patience_argument};
use super::behaviours::position_tracking::{X, Y};
use super::controller::Controller;
use super::model::OfficeModel;
use super::plan_text;
use super::words::{mode_name, no_map};
use crate::geometry::{Point, Pose, distance_m};
use crate::world::{Place, TravelMode};
use rpl_lang::symbol::fold_name;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Effect, Native, NativeCode, NativeFunction, Reply};
use std::sync::Arc;

/// A destination counts as reached when the estimate is this near to it.
const AT_DESTINATION_M: f64 = 0.35;

/// A function that looks at something and changes nothing.
const fn look(name: &'static str, parameters: &'static str, doc: &'static str, code: NativeFunction) -> Native {
    Native { name, parameters, doc, effect: Effect::None, code: NativeCode::Plain(code) }
}

/// A function that acts on the robot or on its world.
pub(super) const fn act(
    name: &'static str,
    parameters: &'static str,
    doc: &'static str,
    code: NativeFunction,
) -> Native {
    Native { name, parameters, doc, effect: Effect::Acts, code: NativeCode::Plain(code) }
}

/// Functions of the robot.
pub fn natives() -> Vec<Native> {
    vec![
        look("place", "name", "The name of a place, checked: fails if the world has no such place.", place),
        look("place-pose", "name", "The pose of a place: x, y in metres, heading in radians.", place_pose),
        look(
            "at-destination?",
            "place",
            "Whether the robot believes itself to be at a place; wakes a condition.",
            at_destination,
        ),
        look("distance-to", "place", "Metres in a straight line from the estimated position to a place.", distance_to),
        look("region-of", "place", "The travel mode of the region around a place, or nil.", region_of),
        look(
            "generate-navigation-plan",
            "place &optional patience",
            "A plan, as data, that drives from the estimated position to a place, not through doors found closed if there is another way. The patience is that of `navigation`.",
            generate,
        ),
        look(
            "belief-maxima",
            "&optional count",
            "Local maxima of the belief: lists (x y heading mass), the heaviest first.",
            belief_maxima,
        ),
        look(
            "odometry-pose",
            "",
            "Where the robot is by its odometry: x, y in metres, heading in radians, from where it was switched on.",
            odometry_pose,
        ),
        look(
            "odometry-in-map",
            "pose",
            "Where a pose of the odometry lies in the map by what the robot believes now: x, y, heading.",
            odometry_in_map,
        ),
        act(
            "plan-remove-all-goals",
            "",
            "Deletes all target points of the navigation this task or one below it has started.",
            remove_all_goals,
        ),
        act(
            "doubt-position",
            "",
            "Discards the whole belief about the position in the next step: for when the estimate leads to a contradiction.",
            doubt_position,
        ),
        act("read-message", "", "The oldest message nobody has read, a list of symbols, or nil.", read_message),
        act("set-travel-mode", "mode", "Sets how the robot drives: hallway, office or doorway.", set_travel_mode),
    ]
}

fn model(call: &mut Call<'_, '_>) -> Result<Arc<OfficeModel>, Raise> {
    Ok(robot(call)?.model.clone())
}

fn robot<'a>(call: &'a mut Call<'_, '_>) -> Result<&'a mut Controller, Raise> {
    call.around.outside.as_any().downcast_mut().ok_or_else(Raise::no_robot)
}

fn named_place(call: &mut Call<'_, '_>) -> Result<(Arc<OfficeModel>, Place), Raise> {
    let name = call.name(0)?;
    let model = model(call)?;
    if model.map.is_none() {
        let message = format!(
            "the robot has no map and knows no place `{name}`; drive to a point with (go-to-point X Y), metres ahead \
             and to the left of the start, or run the plan without `--map none`"
        );
        return Err(Raise::new("unreachable", message));
    }
    let place = model.world.place(&name).cloned().map_err(|unknown| Raise::new("unreachable", unknown.to_string()))?;
    Ok((model, place))
}

fn place(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    named_place(call)?;
    Ok(Reply::Value(call.argument(0)))
}

fn place_pose(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let pose = named_place(call)?.1.pose_in_map;
    Ok(pose_list(call, pose))
}

/// The estimated position, read through the fluents so that a network that asks is woken.
fn estimated_point(call: &mut Call<'_, '_>) -> Result<Point, Raise> {
    let mut read = |number: usize| -> Result<f64, Raise> {
        match call.machine.robot_fluent(call.around.robot, number) {
            Some(fluent) => Ok(call.machine.read_fluent(fluent)?.as_f64().unwrap_or(f64::NAN)),
            None => Err(Raise::no_robot()),
        }
    };
    Ok(Point::new(read(X)?, read(Y)?))
}

fn distance_to_place_m(call: &mut Call<'_, '_>) -> Result<f64, Raise> {
    let here = estimated_point(call)?;
    let place = named_place(call)?.1;
    Ok(distance_m(here, place.pose_in_map.point()))
}

fn at_destination(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    Ok(Reply::Value(Value::truth(distance_to_place_m(call)? <= AT_DESTINATION_M)))
}

fn distance_to(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    Ok(Reply::Value(Value::Float(distance_to_place_m(call)?)))
}

fn region_of(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (model, place) = named_place(call)?;
    Ok(Reply::Value(match model.world.mode_at(place.pose_in_map.point()) {
        Some(mode) => Value::Symbol(call.machine.symbols.intern(mode_name(mode))),
        None => Value::Nil,
    }))
}

fn generate(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (model, place) = named_place(call)?;
    let patience_s = if call.arguments.len() > 1 { patience_argument(call.argument(1))? } else { None };
    let robot = robot(call)?;
    let start_in_map: Pose = robot.estimate().pose_in_map;
    let closed_doors = robot.modules.navigation.closed_doors();
    let Some(map) = &model.map else { return Err(no_map("there is nothing to plan on")) };
    let plan = plan_text::navigation_plan(map, call.machine, start_in_map, &place, &closed_doors, patience_s);
    plan.map(Reply::Value).map_err(|unreachable| {
        let destination = Value::Symbol(call.machine.symbols.intern(&fold_name(&place.name)));
        Raise::New {
            class: "unreachable",
            message: format!("no way to `{}`: {}", place.name, unreachable.reason),
            slots: vec![("destination", destination)],
        }
    })
}

fn pose_list(call: &mut Call<'_, '_>, pose: Pose) -> Reply {
    let values = [pose.x_m, pose.y_m, pose.heading_rad].map(Value::Float);
    Reply::Value(call.machine.heap.list(&values))
}

fn odometry_pose(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let odometry_in_odom = robot(call)?.board.position.odometry_in_odom();
    Ok(pose_list(call, odometry_in_odom))
}

fn odometry_in_map(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let expected =
        || Raise::type_error("`odometry-in-map` takes a pose `(x y heading)`, as `(odometry-pose)` gives it");
    let elements = call.machine.heap.elements(call.argument(0)).map_err(|_| expected())?;
    let numbers: Option<Vec<f64>> = elements.into_iter().map(Value::as_f64).collect();
    let Some(&[x_m, y_m, heading_rad]) = numbers.as_deref() else { return Err(expected()) };
    let robot = robot(call)?;
    let odom_in_map = robot.estimate().pose_in_map.compose(robot.board.position.odometry_in_odom().inverse());
    Ok(pose_list(call, odom_in_map.compose(Pose::new(x_m, y_m, heading_rad))))
}

fn belief_maxima(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let count = if call.arguments.is_empty() { 10 } else { call.integer(0)?.clamp(1, 100) as usize };
    let robot = robot(call)?;
    let model = robot.model.clone();
    let maxima: Vec<(Pose, f64)> = match (&model.map, robot.board.position.localization()) {
        (Some(map), Some(localization)) => {
            let maxima = localization.maxima(&map.localization, count, 0.001);
            maxima.iter().map(|maximum| (maximum.pose_in_map, maximum.mass)).collect()
        }
        _ => vec![(robot.estimate().pose_in_map, 1.0)],
    };
    let lists: Vec<Value> = maxima
        .iter()
        .map(|(pose, mass)| call.machine.heap.list(&[pose.x_m, pose.y_m, pose.heading_rad, *mass].map(Value::Float)))
        .collect();
    Ok(Reply::Value(call.machine.heap.list(&lists)))
}

fn remove_all_goals(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    call.machine.remove_goals(call.around, navigation::NUMBER);
    Ok(Reply::Value(Value::Nil))
}

fn doubt_position(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let robot = robot(call)?;
    if robot.model.map.is_none() {
        return Err(no_map("there is no belief to give up"));
    }
    robot.board.position.doubt();
    Ok(Reply::Value(Value::Nil))
}

fn read_message(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let inbox = &mut robot(call)?.board.inbox;
    if inbox.is_empty() {
        return Ok(Reply::Value(Value::Nil));
    }
    let words = inbox.remove(0);
    let symbols: Vec<Value> = words.iter().map(|word| Value::Symbol(call.machine.symbols.intern(word))).collect();
    Ok(Reply::Value(call.machine.heap.list(&symbols)))
}

fn set_travel_mode(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let name = call.name(0)?;
    let mode = [TravelMode::Hallway, TravelMode::Office, TravelMode::Doorway]
        .into_iter()
        .find(|&mode| mode_name(mode) == name)
        .ok_or_else(|| {
            Raise::type_error(format!("`{name}` is no travel mode; there are hallway, office and doorway"))
        })?;
    robot(call)?.board.mode = mode;
    Ok(Reply::Value(Value::Nil))
}
