//! The case memory of RUPART without its robot (Fox and Anderson-Sprecher 2006): how good its routes are and how
//! much work, and whether the kind of case comes back that is needed.

pub mod behaviours;
mod control_figures;
pub mod days;
pub mod kinds;
mod pictures;
mod route_rows;
pub mod routes;

use super::request::ExperimentRequest;
use anyhow::Result;
use rpl_robot::description::RobotDescription;
use rpl_robot::world::World;
use rpl_rupart::places::Places;
use rpl_shell::files::{robot_files, world_files};
use std::sync::Arc;

/// Where, unless another world is named.
const WORLD: &str = "olin-rice";

/// Who drives there.
const ROBOT: &str = "pioneer-2dx";

/// The building, its places, and the robot that is to pass between them.
pub struct Building {
    world: World,
    robot: Arc<RobotDescription>,
    places: Places,
}

impl Building {
    fn of(request: &ExperimentRequest) -> Result<Self> {
        Self::or(request, WORLD)
    }

    /// That of the request, or else this one.
    fn or(request: &ExperimentRequest, usual: &str) -> Result<Self> {
        let robot = robot_files::named(Some(ROBOT))?;
        let world = world_files::for_all_seeds(request.world.as_deref().unwrap_or(usual), &robot)?;
        let places = Places::new(&world, robot.radius_m)?;
        Ok(Self { world, robot, places })
    }
}
