//! Ways over the floor of a map, and plans that lead through its doors.
//!
//! Read in this order: `cost_grid` (what it costs to be somewhere; `narrow_cell` where the body fits into a part of a
//! cell), `narrow` (how such cells are found; `close_map` what is around them), `cost_to_go` (what it costs to go to a target from there), `way` (the ways
//! that follow), `open_edge` (where the map ends and no wall), `planner` (the robot's map); then `target` (where the robot
//! is to drive to), `areas` (the floor, cut along the edges of rooms), `passage` (doors and gaps), `topological` (target
//! points through doors and corridors), `between` (what keeps two points apart), `survey` (what of a world cannot be got
//! to).
//!
//! What is made of a map lies in the frame of that map, `map` or `odom`; points in it are `in_frame`.
//! Topological plans are of worlds, in `map`.

mod areas;
mod between;
mod close_map;
mod cost_grid;
mod cost_to_go;
mod gap;
mod narrow;
mod narrow_cell;
mod open_edge;
mod passage;
mod planner;
mod survey;
mod target;
#[cfg(test)]
mod tests;
mod topological;
mod way;

pub use close_map::Patch;
pub use cost_grid::{CostGrid, Inflation};
pub use cost_to_go::CostToGo;
pub use open_edge::OpenEdge;
pub use planner::PlannerModel;
pub use survey::Concern;
pub use target::Target;
pub use topological::{NavigationPlan, TopologicalModel, Unreachable, is_passed};
pub use way::path_length_m;
