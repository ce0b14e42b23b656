//! What a marker looks like to a camera: pixels that are known to show one, in many places with their own
//! light. From them are the histograms of [`marker_colours`](rpl_robot::vision::marker_colours).

use rpl_random::Stream;
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Point, Pose};
use rpl_robot::sensors::{CameraView, Pixel, Rgb};
use rpl_robot::simulator::{CameraCommand, Commands, SimulatorModel, SimulatorSettings};
use rpl_robot::vision::Histogram;
use rpl_robot::world::{MarkerColour, World};
use std::sync::Arc;

/// Side of the marker that is looked at.
const SIZE_M: f64 = 0.3;

/// Where it lies, in a hall without anything else.
const AT: Point = Point::new(10.0, 10.0);

/// Pixels nearer than this to the edge of the marker show the floor as well.
const INNER: f64 = 0.7;

/// How far off the robot stands, at the least and at the most.
const OFF_M: [f64; 2] = [1.6, 3.0];

/// What is seen of markers of a colour in a number of places, each with its light, from a seed on. Cost: a third of a
/// millisecond for each.
pub fn calibrate(robot: &Arc<RobotDescription>, colour: MarkerColour, seed: u64, places: u64) -> Histogram {
    let model = hall(robot, colour);
    Histogram::of((0..places).flat_map(|place| labelled(&model, seed.wrapping_add(place))))
}

fn hall(robot: &Arc<RobotDescription>, colour: MarkerColour) -> SimulatorModel {
    let text = format!(
        "name = \"hall\"\nsize = [20.0, 20.0]\nstart = [5.0, 5.0, 0]\n[[marker]]\nat = [{}, {}]\ncolour = \"{}\"\nsize = {SIZE_M}",
        AT.x,
        AT.y,
        colour.name()
    );
    match World::parse(&text, "hall.toml") {
        Ok(world) => SimulatorModel::new(Arc::new(world), SimulatorSettings::of(robot.clone())),
        Err(faults) => unreachable!("the hall is as this file says: {faults}"),
    }
}

/// The pixels that show the marker from a place drawn from a seed.
fn labelled(model: &SimulatorModel, seed: u64) -> Vec<Rgb> {
    let Some(camera) = model.robot().camera else { return Vec::new() };
    let mut stream = Stream::new(seed, "calibration");
    let (bearing_rad, off_m) = (stream.uniform_in(-3.1, 3.1), stream.uniform_in(OFF_M[0], OFF_M[1]));
    let (sin, cos) = libm::sincos(bearing_rad);
    let half_rad = camera.view.field_of_view_rad / 2.0;
    let heading_rad = bearing_rad + stream.uniform_in(-half_rad, half_rad);
    let robot_in_map = Pose::new(AT.x - off_m * cos, AT.y - off_m * sin, heading_rad);
    let mut state = model.start(seed);
    if let Err(taken) = model.teleport(&mut state, robot_in_map) {
        unreachable!("the hall is empty: {taken}");
    }
    let looking = Commands { camera: Some(CameraCommand::default()), ..Commands::default() };
    let image = std::iter::from_fn(|| Some(model.step(&mut state, &looking)))
        .take((camera.period_us / model.robot().step_us) as usize + 1)
        .find_map(|percept| percept.camera?.image);
    let Some(image) = image else { return Vec::new() };
    let pixels = (0..camera.view.rows).flat_map(|row| (0..camera.view.columns).map(move |column| (column, row)));
    pixels
        .filter(|&(column, row)| shows_marker(&camera.view, state.robot_in_map, column, row))
        .map(|(column, row)| image.at(column, row))
        .collect()
}

fn shows_marker(view: &CameraView, robot_in_map: Pose, column: usize, row: usize) -> bool {
    let middle = Pixel { column: column as f64 + 0.5, row: row as f64 + 0.5 };
    let on_floor = view.floor_point(middle).map(|point| robot_in_map.transform(point));
    on_floor.is_some_and(|point| (point - AT).amax() <= INNER * SIZE_M / 2.0)
}
