//! What driving on a map needs to know of the world and the robot.

use crate::avoidance::DriveLimits;
use crate::obstacles::Doorway;
use crate::planning::{Inflation, PlannerModel};
use crate::world::World;

/// What navigation needs to know of the world and the robot. Immutable; share it.
#[derive(Clone, Debug)]
pub struct NavigationModel {
    /// The map.
    pub planner: PlannerModel,
    /// The doors that the map shows open.
    pub doorways: Vec<Doorway>,
    /// The robot.
    pub limits: DriveLimits,
}

impl NavigationModel {
    /// Edge of a cell of the planner's map.
    pub const CELL_M: f64 = 0.1;

    /// The map of a world at 10 cm, and its doors.
    pub fn new(world: &World, limits: DriveLimits) -> Self {
        let planner = PlannerModel::new(&world.map(Self::CELL_M), Inflation::of_robot(limits.robot_radius_m));
        Self { planner, doorways: Doorway::all(world), limits }
    }
}
