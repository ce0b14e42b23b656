//! Places: what plans can ask of the places of the world. It has no behaviour.

use super::position_tracking::{X, Y};
use crate::foresight::drive_times::DriveTimes;
use crate::foresight::ways::{ForeseenWays, Way};
use crate::geometry::{Point, distance_m};
use crate::office::functions::{board, look, model, pose_list};
use crate::office::model::OfficeModel;
use crate::office::module::{Module, ModuleSpec};
use crate::office::words::mode_name;
use crate::world::Place;
use rpl_lang::symbol::fold_name;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Reply};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A destination counts as reached when the estimate is this near to it.
const AT_DESTINATION_M: f64 = 0.35;

/// Places do not change.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Places;

impl Module for Places {
    type Settings = ();

    fn specs((): &()) -> Vec<ModuleSpec> {
        vec![ModuleSpec {
            name: "places".into(),
            functions: vec![
                look("place", "place", "The name of a place, checked: fails if the world has no such place.", place),
                look("place-pose", "place", "The pose of a place: x, y in metres, heading in radians.", place_pose),
                look(
                    "at-destination?",
                    "place",
                    "Whether the robot believes itself to be at a place; wakes a condition.",
                    at_destination,
                ),
                look(
                    "distance-to",
                    "place",
                    "Metres in a straight line from the estimated position to a place.",
                    distance_to,
                ),
                look(
                    "charging-places",
                    "",
                    "The names of the places where the battery is charged, a list.",
                    charging_places,
                ),
                look(
                    "drive-time",
                    "place &optional place",
                    "Seconds that a drive to a place probably takes, undisturbed, by the map: from another place, or from the estimated position. Nil if the map leaves no way.",
                    drive_time,
                ),
                look("region-of", "place", "The travel mode of the region around a place, or nil.", region_of),
            ],
            ..ModuleSpec::default()
        }]
    }

    fn new((): &(), _: &OfficeModel, _: u64) -> Self {
        Self
    }
}

/// The place an argument names, in a world of which the robot has a map.
pub(super) fn named_place(call: &mut Call<'_, '_>) -> Result<(Arc<OfficeModel>, Place), Raise> {
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
    let mut read = |name: &str| -> Result<f64, Raise> {
        let number = call.around.outside.tables().fluents.iter().position(|fluent| fluent.name == name);
        match number.and_then(|number| call.machine.robot_fluent(call.around.robot, number)) {
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

fn charging_places(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let model = model(call)?;
    let charging = model.world.places.iter().filter(|place| place.charges);
    let names: Vec<Value> =
        charging.map(|place| Value::Symbol(call.machine.symbols.intern(&fold_name(&place.name)))).collect();
    Ok(Reply::Value(call.machine.heap.list(&names)))
}

fn drive_time(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (model, to) = named_place(call)?;
    let from_in_map = match call.arguments.get(1) {
        None | Some(Value::Nil) => board(call)?.position.estimate(model.map.as_ref()).pose_in_map,
        Some(_) => {
            let name = call.name(1)?;
            let place = model.world.place(&name);
            place.map_err(|unknown| Raise::new("unreachable", unknown.to_string()))?.pose_in_map
        }
    };
    let ways = call.part::<ForeseenWays>().map(|foreseen| foreseen.ways.clone()).unwrap_or_default();
    let way = model.map.as_ref().map(|map| map.ways(&model.world)).and_then(|map| {
        let plan = ways.plan(map, from_in_map, &to, &[]).ok()?;
        Way::over(&ways, map, from_in_map, &plan.targets)
    });
    let time_s = way.map(|way| DriveTimes::of(&model.settings.robot).time_s(&way.features()));
    Ok(Reply::Value(time_s.map_or(Value::Nil, Value::Float)))
}

fn region_of(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let (model, place) = named_place(call)?;
    Ok(Reply::Value(match model.world.mode_at(place.pose_in_map.point()) {
        Some(mode) => Value::Symbol(call.machine.symbols.intern(mode_name(mode))),
        None => Value::Nil,
    }))
}
