//! What never changes during a simulation.

use super::candidates::Candidates;
use super::crowd::Crowd;
use super::eye::{Eye, SIGHT_M};
use super::fan::Fan;
use super::settings::SimulatorSettings;
use super::surface::{Surface, SurfaceForm, surfaces_of};
use super::walker::FARTHEST_WALL_M;
use crate::description::RobotDescription;
use crate::geometry::Point;
use crate::sensors::{RangeSensors, SonarMount};
use crate::world::{Rect, SeenBy, Solid, SolidOrigin, World};
use std::sync::Arc;

/// A world made ready for simulation: built once, shared by all states that run in it. Building
/// `dept` takes some milliseconds.
#[derive(Debug)]
pub struct SimulatorModel {
    /// The world.
    pub world: Arc<World>,
    /// The robot, and how people behave.
    pub settings: SimulatorSettings,
    pub(super) solids: Vec<Solid>,
    pub(super) surfaces: Vec<Surface>,
    pub(super) candidates: Candidates,
    /// None in a world without a crowd.
    pub(super) crowd: Option<Crowd>,
    /// How the robot's range sensors look.
    pub sensors: RangeSensors,
    /// How far the rim of the robot is from each sonar, along its axis.
    pub(super) sonar_rims_m: Vec<f64>,
    /// The readings of the laser.
    pub(super) laser_fan: Option<Fan>,
    /// None if the robot has no camera.
    pub(super) eye: Option<Eye>,
}

impl SimulatorModel {
    /// Makes a world ready. Nobody gets beyond its edge, and nothing is seen there: so the map has it.
    pub fn new(world: Arc<World>, settings: SimulatorSettings) -> Self {
        let solids = world.solids();
        let mut surfaces: Vec<Surface> = solids.iter().flat_map(|solid| surfaces_of(solid, world.bounds())).collect();
        let seen = surfaces.len();
        surfaces.extend(world_edge(world.bounds()));
        let candidates = Candidates::new(&surfaces, seen, world.bounds(), reaches_m(&settings.robot));
        let sensors = settings.robot.range_sensors();
        let rim_m = |mount: &SonarMount| to_rim_m(mount, settings.robot.radius_m);
        Self {
            sonar_rims_m: sensors.sonars.iter().flat_map(|sonars| sonars.mounts.iter().map(rim_m)).collect(),
            laser_fan: sensors.laser.map(Fan::new),
            eye: settings.robot.camera.map(Eye::new),
            sensors,
            crowd: Crowd::new(&world),
            world,
            settings,
            solids,
            surfaces,
            candidates,
        }
    }
}

impl SimulatorModel {
    /// The robot.
    pub fn robot(&self) -> &RobotDescription {
        &self.settings.robot
    }

    /// Memory that the model of a world takes at most, without building it. Cost: the number of
    /// bodies.
    pub fn needed_bytes(world: &World, robot: &RobotDescription) -> f64 {
        let surfaces = world.solids().into_iter().flat_map(|solid| surfaces_of(&solid, world.bounds()));
        let lists = Candidates::most_entries(surfaces, world.bounds(), reaches_m(robot)) * size_of::<u32>() as f64;
        lists * 2.0 + Crowd::needed_bytes(world)
    }
}

/// How far sensors see, from where something may be touched, and how far people mind walls.
fn reaches_m(robot: &RobotDescription) -> [f64; 3] {
    let off_m = |mount: &SonarMount| mount.at_in_base.coords.norm();
    let sonar_m = robot
        .sonar
        .as_ref()
        .map_or(0.0, |sonar| sonar.range_m + sonar.layout.mounts().iter().map(off_m).fold(0.0, f64::max));
    let laser_m = robot.laser.map_or(0.0, |laser| laser.scanner.range_m);
    let camera_m = robot.camera.map_or(0.0, |_| SIGHT_M);
    let touch_m = robot.radius_m + 2.0 * robot.motors.max_translation_mps * robot.step_s();
    [sonar_m.max(laser_m).max(camera_m), touch_m, FARTHEST_WALL_M]
}

/// How far it is from a sonar to the rim of the body that it sits on: nothing can be nearer.
fn to_rim_m(mount: &SonarMount, radius_m: f64) -> f64 {
    let at = mount.at_in_base.coords;
    let along_m = mount.ahead_m();
    (along_m * along_m - at.norm_squared() + radius_m * radius_m).max(0.0).sqrt() - along_m
}

/// It stops whoever comes to it.
fn world_edge(bounds: Rect) -> impl Iterator<Item = Surface> {
    let Rect { min, max } = bounds;
    let corners = [min, Point::new(min.x, max.y), max, Point::new(max.x, min.y)];
    (0..4).map(move |side| Surface {
        form: SurfaceForm::Edge { a: corners[side], b: corners[(side + 1) % 4] },
        origin: SolidOrigin::Wall,
        seen_by: SeenBy { sonar: false, laser: false },
    })
}
