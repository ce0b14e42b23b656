//! Where the robot is by what its sensors measure just now: one scan against the whole map.

use super::functions::{board, model};
use super::model::{MapModel, OfficeModel};
use super::words::{no_belief, no_map};
use crate::geometry::Pose;
use crate::localization::once::{LikelyPose, MOST_POSES, RangeBeam};
use crate::sensors::{RangeSensor, SonarScan};
use crate::simulator::Percept;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Reply};

/// What `locate` does.
pub(super) const LOCATE: &str = "All places of the map that explain what the sensors measure just now: lists (x y heading probability), the likeliest first; the robot must stand still. What the probabilities lack to 1 is that it is elsewhere. The belief is not changed; `set-position` takes one of them.";

/// What `set-position` does.
pub(super) const SET_POSITION: &str = "Takes a pose (x y heading), as `locate` gives it, for the robot's position: the whole belief is laid around it in the next step. Elements after the third are ignored.";

/// The readings of the sensor that the robot localizes with; none while it is off.
fn beams(model: &OfficeModel, map: &MapModel, percept: &Percept) -> Option<Vec<RangeBeam>> {
    let sensor = map.localization.parameters.sensors.first()?;
    let beam = |(bearing_rad, &range_m): (f64, &f32)| RangeBeam { bearing_rad, range_m: f64::from(range_m) };
    match sensor.source {
        RangeSensor::Laser => {
            let (laser, ranges_m) = model.sensors.laser.as_ref().zip(percept.laser_m.as_deref())?;
            let bearings = (0..ranges_m.len()).map(|reading| laser.direction_rad(reading));
            Some(bearings.zip(ranges_m).map(beam).collect())
        }
        RangeSensor::Sonar => {
            let (sonars, ranges_m) = model.sensors.sonars.as_ref().zip(percept.sonar_m.as_deref())?;
            let from_middle_m = SonarScan { sonars, ranges_m }.ranges_from_middle_m();
            let bearings = sonars.mounts.iter().map(|mount| mount.heading_rad);
            Some(bearings.zip(from_middle_m.iter()).map(beam).collect())
        }
    }
}

pub(super) fn locate(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let count = if call.arguments.is_empty() { 10 } else { call.integer(0)?.clamp(1, MOST_POSES as i64) as usize };
    let model = model(call)?;
    let Some(map) = &model.map else { return Err(no_map("there is nothing to compare a scan with")) };
    let percept = board(call)?.percept.clone();
    let beams = percept.and_then(|percept| beams(&model, map, &percept));
    let located = beams.zip(map.locator(&model.world)).map(|(beams, locator)| locator.locate(&beams));
    let poses = located.map_or(Vec::new(), |located| located.poses);
    let lists: Vec<Value> = (poses.iter().take(count))
        .map(|LikelyPose { pose_in_map: Pose { x_m, y_m, heading_rad }, probability }| {
            call.machine.heap.list(&[*x_m, *y_m, *heading_rad, *probability].map(Value::Float))
        })
        .collect();
    Ok(Reply::Value(call.machine.heap.list(&lists)))
}

pub(super) fn set_position(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let expected = || Raise::type_error("`set-position` takes a pose `(x y heading)`, as `(locate)` gives it");
    let elements = call.machine.heap.elements(call.argument(0)).map_err(|_| expected())?;
    let numbers: Option<Vec<f64>> = elements.into_iter().map(Value::as_f64).collect();
    let Some(&[x_m, y_m, heading_rad, ..]) = numbers.as_deref() else { return Err(expected()) };
    let model = model(call)?;
    if !model.settings.has_belief() {
        return Err(no_belief(&model, "there is no belief to be laid around a pose"));
    }
    let pose = Pose::new(x_m, y_m, heading_rad);
    let on_map = |map: &MapModel| map.localization.grid.cell_at(pose.point()).is_some();
    if !model.map.as_ref().is_some_and(on_map) {
        return Err(Raise::type_error(format!("the pose ({x_m} {y_m} {heading_rad}) is not on the map")));
    }
    board(call)?.position.set(pose);
    Ok(Reply::Value(Value::Nil))
}
