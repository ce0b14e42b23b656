//! The robot, from the ground up. Read in this order; a module imports only from those above it:
//!
//! - `geometry`;
//! - `file_text`: texts that people write, and the faults in them;
//! - `sensors`: measuring distances; `occupancy`: maps as grids, distances and rays;
//! - `description`: robots as data;
//! - `world`: what stands where;
//! - `localization`: where the robot is, by ranges and landmarks;
//! - `recording`: the same on recorded drives; `active`: drives that find it out;
//! - `planning`: ways and plans; `buildings`: worlds drawn from a seed;
//! - `avoidance`: keeping off;
//! - `vision`: findings of a camera: colours, blobs, sheets on the floor and on walls;
//! - `simulator`: the robot and its world, step by step; `obstacles`: findings of its range sensors;
//! - `navigation`: drives to targets by all of these;
//! - `foresight`: what will probably become of drives and grasps;
//! - `office`: behaviours, fluents and functions of plans; it alone imports the runtime.
//!
//! Every algorithm here is a pure function of its inputs and of seeded random streams: no clock, no thread order, no
//! file. Each module separates an immutable *model* (built once from a world, shared, never saved) from a mutable
//! *state* (cloned for a fork, serialized for a save).
//!
//! Units are SI, angles radians counter-clockwise, x forward and y left in the robot frame; frames `map` (the world),
//! `odom` (dead reckoning), `base` (the robot).

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
