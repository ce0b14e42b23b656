//! Path planning, collision avoidance, topological plans.
//!
//! Read in this order: `distance` (how far the obstacles are), `planner` (what each cell costs),
//! `value_field` (the value of every cell for a target, and paths), `obstacle_memory` (what the
//! sensors saw lately), `sonar_views` (where the sound passed), `alignment` (where that fits the
//! map), `doorways` (which doors were found closed), `clearance` (how far an arc is free),
//! `dynamic_window` (safe speeds), `areas` (the floor, cut along the edges of rooms), `topological`
//! (target points through doors and corridors), `between` (what keeps two points apart), `survey`
//! (what of a world cannot be got to), `progress` (whether the robot gets on), `navigation` (the
//! state machine that drives them), `drive` (following and wandering without a map), `look_around`
//! (turning on the spot); `laser_scan` (what a scan shows of surfaces),
//! `learned_map`, `manner` and `mapless` (driving without a map by what the sensors have seen).
//! Nothing here knows the plan language or the simulator.

pub mod alignment;
mod areas;
mod between;
pub mod clearance;
pub mod distance;
pub mod doorways;
pub mod drive;
pub mod dynamic_window;
mod laser_scan;
pub mod learned_map;
mod look_around;
mod manner;
pub mod mapless;
#[allow(clippy::module_inception)]
pub mod navigation;
pub mod obstacle_memory;
pub mod planner;
mod progress;
mod sonar_views;
mod survey;
pub mod topological;
pub mod value_field;

#[cfg(test)]
mod tests;

pub use doorways::{DoorMemory, Doorway};
pub use drive::{Drive, DriveOutput, DriveStatus, DriveTask};
pub use dynamic_window::{DriveLimits, DynamicWindow, Speeds, WindowChoice, WindowStatus};
pub use learned_map::{Grain, LearnedMap};
pub use look_around::LookAround;
pub use mapless::MaplessNavigation;
pub use navigation::{Navigation, NavigationEvent, NavigationInput, NavigationModel, NavigationOutput, Obstruction};
pub use obstacle_memory::ObstacleMemory;
pub use planner::{PlannerModel, PlannerParameters};
pub use survey::Concern;
pub use topological::{NavigationPlan, Target, TopologicalModel, Unreachable};
pub use value_field::{ValueField, path_length_m};
