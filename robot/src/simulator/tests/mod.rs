mod camera;
mod edge;
mod hands;
mod motion;
mod people;
mod sensing;
mod whole;

use super::*;
use crate::description::{RobotDescription, Sonar};
use crate::geometry::{Point, Pose};
use crate::world::{Object, Rect, SeenBy, Shape, World};
use rpl_random::Stream;
use std::sync::Arc;

fn model(world: &str, settings: SimulatorSettings) -> SimulatorModel {
    SimulatorModel::new(Arc::new(World::builtin(world).expect("built in")), settings)
}

/// A small empty hall of 10 x 6 m, the robot in its middle looking east, with more text after it.
fn hall(settings: SimulatorSettings, more: &str) -> SimulatorModel {
    const WALLS: &str =
        "[[wall]]\nline = [[0.0, 0.0], [10.0, 0.0], [10.0, 6.0], [0.0, 6.0], [0.0, 0.0]]\nthickness = 0.0";
    open_lot(settings, &format!("{more}\n{WALLS}"))
}

/// The same without walls.
fn open_lot(settings: SimulatorSettings, more: &str) -> SimulatorModel {
    let text = format!("name = \"hall\"\nsize = [10.0, 6.0]\nstart = [5.0, 3.0, 0]\n{more}");
    SimulatorModel::new(Arc::new(World::parse(&text, "hall.toml").expect("no faults")), settings)
}

fn builtin(robot: &str) -> RobotDescription {
    RobotDescription::clone(&RobotDescription::builtin(robot).expect("built in"))
}

/// A robot that makes no errors.
fn exact(robot: &str) -> SimulatorSettings {
    SimulatorSettings::of(builtin(robot).without_errors())
}

/// A robot that makes no errors but those of its sonars that are given here.
fn with_sonars(change: impl FnOnce(&mut Sonar)) -> SimulatorSettings {
    let mut robot = builtin("b21").without_errors();
    change(robot.sonar.as_mut().expect("it has a ring"));
    SimulatorSettings::of(robot)
}

fn drive(translation_mps: f64, rotation_radps: f64) -> Commands {
    Commands { translation_mps, rotation_radps, sonars_on: true, ..Commands::default() }
}

fn steps(model: &SimulatorModel, state: &mut SimulatorState, commands: &Commands, count: usize) -> Percept {
    let mut percept = model.step(state, commands);
    for _ in 1..count {
        percept = model.step(state, commands);
    }
    percept
}

fn ring(model: &SimulatorModel, state: &mut SimulatorState) -> Vec<f32> {
    model.step(state, &drive(0.0, 0.0)).sonar_m.expect("sonars are on")
}

fn crate_at(name: &str, x: f64, y: f64, sonar: bool, laser: bool) -> Object {
    let rect = Rect { min: Point::new(x - 0.2, y - 0.2), max: Point::new(x + 0.2, y + 0.2) };
    Object { name: name.to_owned(), shape: Shape::Rect(rect), mapped: false, seen_by: SeenBy { sonar, laser } }
}

/// A pose where the robot touches nothing.
fn free_pose(model: &SimulatorModel, state: &SimulatorState, stream: &mut Stream) -> Pose {
    let size_m = model.world.size_m;
    loop {
        let pose =
            Pose::new(stream.uniform_in(0.0, size_m.x), stream.uniform_in(0.0, size_m.y), stream.uniform_in(-3.2, 3.2));
        if model.in_the_way(state, pose.point(), model.robot().radius_m).is_none() {
            return pose;
        }
    }
}

/// A random choice of open doors.
fn shuffle_doors(state: &mut SimulatorState, stream: &mut Stream) {
    for open in &mut state.doors_open {
        *open = stream.chance(0.5);
    }
}
