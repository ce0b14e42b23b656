//! Driving: to targets, with a map or without one, about at random, along a path, on the spot.
//!
//! Read in this order: `input` (what a step gets to know), `turning`, `driver` (from target to target,
//! whoever knows the ways), `mapped` and `mapless` (who knows them: by the map and what is seen besides,
//! or by what has been seen alone; `profile` how near and fast), `cache`; `local_drive` (following and wandering by what is seen just
//! now), `look_around` and `relative_move` (turns and straight stretches by the odometry). Nothing here knows the plan language or the simulator.

mod cache;
mod driver;
mod input;
mod local_drive;
mod look_around;
mod mapless;
mod mapped;
mod profile;
mod relative_move;
mod turning;

#[cfg(test)]
mod tests;

pub use driver::{NavigationEvent, NavigationOutput};
pub use input::NavigationInput;
pub use local_drive::{DriveOutput, DriveStatus, DriveTask, LocalDrive};
pub use look_around::LookAround;
pub use mapless::MaplessNavigation;
pub use mapped::{CostsToGo, MappedNavigation, NavigationModel, Obstruction};
pub use relative_move::{MoveGoal, MoveHindrance, MoveStatus, RelativeMove};
pub use turning::turn_to;
