//! The robot, from the ground up: `geometry` and `sensors`; `description` (robots as data, read with
//! `file_text`); `occupancy` (maps as grids, distances and
//! rays); `world` (what stands where) and `buildings` (worlds drawn from a seed); `localization` (where the robot is) and `recording` (the same on
//! recorded drives); `active` (how it finds out); `planning` (ways and plans); `simulator` (the robot
//! and its world, step by step); `avoidance` (keeping off); `obstacles` (what its sensors have found);
//! `vision` (what its camera has found); `navigation` (driving by all of these). `office` binds them to the runtime.
//!
//! Every algorithm here is a pure function of its inputs and of seeded random streams: no clock,
//! no thread order, no file. Each module separates an immutable *model* (built once from a world,
//! shared, never saved) from a mutable *state* (cloned for a fork, serialized for a save).
//!
//! Units are SI, angles radians counter-clockwise, x forward and y left in the robot frame;
//! frames `map` (the world), `odom` (dead reckoning), `base` (the robot).

pub mod active;
pub mod avoidance;
pub mod buildings;
pub mod description;
pub mod file_text;
pub mod foresight;
pub mod geometry;
pub mod localization;
mod memo;
pub mod navigation;
pub mod obstacles;
pub mod occupancy;
pub mod office;
pub mod planning;
pub mod recording;
pub mod sensors;
pub mod simulator;
pub mod vision;
pub mod world;
