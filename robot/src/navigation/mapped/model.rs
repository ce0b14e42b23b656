//! What driving on a map needs to know of the world and the robot.

use super::costs_to_go::CostsToGo;
use crate::avoidance::DriveLimits;
use crate::geometry::Point;
use crate::obstacles::Doorway;
use crate::planning::{Inflation, PlannerModel};
use crate::world::World;
use std::sync::Arc;

/// What navigation needs to know of the world and the robot. Immutable; share it.
#[derive(Clone, Debug)]
pub struct NavigationModel {
    /// The map.
    pub planner: Arc<PlannerModel>,
    /// What it costs to go to targets on it.
    pub costs_to_go: CostsToGo,
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
        let planner = PlannerModel::of_world(world, Self::CELL_M, Inflation::of_robot(limits.robot_radius_m));
        Self { planner: Arc::new(planner), costs_to_go: CostsToGo::default(), doorways: Doorway::all(world), limits }
    }

    /// Whether a door, by its index, opens from there.
    pub(super) fn is_at_door(&self, door: usize, here: Point) -> bool {
        self.doorways.iter().any(|doorway| doorway.door == door && doorway.is_at_hand(here))
    }

    /// The same map, and what was found out about it, for another robot of that size.
    #[must_use]
    pub fn with_limits(&self, limits: DriveLimits) -> Self {
        Self { limits, ..self.clone() }
    }
}
