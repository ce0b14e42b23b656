//! What never changes during a simulation.

use super::candidates::Candidates;
use super::crowd::Crowd;
use super::settings::SimulatorSettings;
use super::surface::{Surface, SurfaceForm, surfaces_of};
use super::walker::FARTHEST_WALL_M;
use crate::geometry::{Point, Vector};
use crate::sensors::{LASER_READINGS, SONARS, laser_direction_rad};
use crate::world::{Rect, SeenBy, Solid, SolidOrigin, World};
use std::sync::Arc;

/// A world made ready for simulation: built once, shared by all states that run in it. Building
/// `dept` takes some milliseconds.
#[derive(Debug)]
pub struct SimulatorModel {
    /// The world.
    pub world: Arc<World>,
    /// The robot.
    pub settings: SimulatorSettings,
    pub(super) solids: Vec<Solid>,
    pub(super) surfaces: Vec<Surface>,
    pub(super) candidates: Candidates,
    /// None in a world without a crowd.
    pub(super) crowd: Option<Crowd>,
    /// Unit vectors, in `base`, between the cones of sonar k and k + 1.
    pub(super) cone_edges: [Vector; SONARS],
    /// Unit vectors of the laser readings, in `base`.
    pub(super) laser_directions: Vec<Vector>,
}

impl SimulatorModel {
    /// Makes a world ready. The edge of the world is a wall, in case it has none.
    pub fn new(world: Arc<World>, settings: SimulatorSettings) -> Self {
        let solids = world.solids();
        let surfaces: Vec<Surface> = solids.iter().flat_map(surfaces_of).chain(world_edge(world.bounds())).collect();
        let candidates = Candidates::new(&surfaces, world.bounds(), reaches_m(&settings));
        let direction = |angle_rad: f64| {
            let (sin, cos) = libm::sincos(angle_rad);
            Vector::new(cos, sin)
        };
        Self {
            cone_edges: std::array::from_fn(|cone| {
                direction((cone as f64 + 0.5) * std::f64::consts::TAU / SONARS as f64)
            }),
            laser_directions: (0..LASER_READINGS)
                .map(|reading| direction(laser_direction_rad(LASER_READINGS, reading)))
                .collect(),
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
    /// Memory that the model of a world takes at most, without building it. Cost: the number of
    /// bodies.
    pub fn needed_bytes(world: &World, settings: &SimulatorSettings) -> f64 {
        let surfaces = world.solids().into_iter().flat_map(|solid| surfaces_of(&solid).collect::<Vec<_>>());
        let lists = Candidates::most_entries(surfaces, world.bounds(), reaches_m(settings)) * size_of::<u32>() as f64;
        lists * 2.0 + Crowd::needed_bytes(world)
    }
}

/// How far sensors see, from where something may be touched, and how far people mind walls.
fn reaches_m(settings: &SimulatorSettings) -> [f64; 3] {
    let laser_m = if settings.laser { settings.laser_max_range_m } else { 0.0 };
    let touch_m = settings.robot_radius_m + 2.0 * settings.max_translation_mps * settings.step_s();
    [settings.sonar_max_range_m.max(laser_m), touch_m, FARTHEST_WALL_M]
}

fn world_edge(bounds: Rect) -> impl Iterator<Item = Surface> {
    let Rect { min, max } = bounds;
    let corners = [min, Point::new(min.x, max.y), max, Point::new(max.x, min.y)];
    (0..4).map(move |side| Surface {
        form: SurfaceForm::Edge { a: corners[side], b: corners[(side + 1) % 4] },
        origin: SolidOrigin::Wall,
        seen_by: SeenBy { sonar: true, laser: true },
    })
}
