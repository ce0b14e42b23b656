//! Costs, ways and plans beside other means of finding them.

mod costs;
mod narrow;
mod octile;
mod paths;
mod plans;
mod reasons;

use super::*;
use crate::geometry::{Point, Pose, distance_m};
use crate::occupancy::{Cell, OccupancyGrid};
use crate::world::{Place, TravelMode, World};
use rpl_random::Stream;
use std::sync::Arc;

/// Of a body without extent, at the price of length alone.
const POINT: Inflation = Inflation { body_radius_m: 0.0, comfortable_distance_m: 0.0, closeness_weight: 0.0 };

fn grid(columns: usize, rows: usize, occupied: &[u8]) -> OccupancyGrid {
    let mut map = OccupancyGrid::filled(Point::new(-1.0, 2.0), 0.1, columns, rows, Cell::Free);
    for (cell, _) in occupied.iter().take(columns * rows).enumerate().filter(|&(_, &value)| value == 0) {
        map.cells[cell] = Cell::Occupied;
    }
    map
}

/// A world as its map shows it.
struct Building {
    world: Arc<World>,
    planner: PlannerModel,
    topology: TopologicalModel,
}

impl Building {
    fn new(world: World) -> Self {
        let world = Arc::new(world);
        let planner = PlannerModel::of_world(&world, 0.1, Inflation::of_robot(0.265));
        let topology = TopologicalModel::new(&world, &planner);
        Self { world, planner, topology }
    }

    fn builtin(name: &str) -> Self {
        Self::new(World::builtin(name).expect("a built-in world"))
    }

    fn plan(&self, start: Pose, place: &Place) -> Result<NavigationPlan, Unreachable> {
        self.topology.plan(&self.planner, start, place, &[])
    }
}
