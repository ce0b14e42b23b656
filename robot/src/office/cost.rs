//! What a world takes in memory and time, before anything is built from it.

use super::model::{OfficeModel, OfficeSettings, SENSOR_MAP_CELL_M};
use crate::localization::LocalizationModel;
use crate::navigation::NavigationModel;
use crate::simulator::SimulatorModel;
use crate::world::World;

/// Bytes that a cell of the sensors' map takes at most: the map, what is connected, distances and
/// their squares.
const SENSOR_MAP_BYTES: f64 = 20.0;

/// Bytes that a cell of the planner's map takes at most.
const PLANNER_BYTES: f64 = 40.0;

/// Time for the maps of a square metre and for what the coarse belief expects to measure there, on one core. What the
/// fine belief expects is computed where it comes to lie.
const MAPPING_S_PER_M2: f64 = 32e-6;

/// Time to fill a byte of the simulator's lists and of its people's ways.
const FILLING_S_PER_BYTE: f64 = 4e-9;

/// What a world takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Memory, at its peak: while a robot is lost, and once it has been everywhere.
    pub bytes: f64,
    /// Time before the first step, roughly.
    pub seconds: f64,
}

impl OfficeModel {
    /// What the models of a world and the robot's state will take. Cost: the number of bodies.
    pub fn cost(world: &World, settings: &OfficeSettings) -> Cost {
        let area_m2 = world.size_m.x * world.size_m.y;
        let simulator_bytes = SimulatorModel::needed_bytes(world, &settings.robot);
        let filling_s = FILLING_S_PER_BYTE * simulator_bytes;
        if !settings.map_known {
            return Cost { bytes: simulator_bytes, seconds: filling_s };
        }
        let cells = |cell_m: f64| area_m2 / (cell_m * cell_m);
        let belief_bytes = LocalizationModel::needed_bytes(world.size_m, &settings.localization) as f64;
        let maps_bytes = cells(SENSOR_MAP_CELL_M) * SENSOR_MAP_BYTES + cells(NavigationModel::CELL_M) * PLANNER_BYTES;
        let mapping_s = MAPPING_S_PER_M2 * area_m2;
        Cost { bytes: simulator_bytes + belief_bytes + maps_bytes, seconds: mapping_s + filling_s }
    }
}
