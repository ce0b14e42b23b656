//! The robot: geometry, maps and worlds, simulator, localization, active localization, navigation,
//! and recorded drives.
//!
//! Every algorithm here is a pure function of its inputs and of seeded random streams: no clock,
//! no thread order, no file. Each module separates an immutable *model* (built once from a world,
//! shared, never saved) from a mutable *state* (cloned for a fork, serialized for a save).
//!
//! Units are SI, angles radians counter-clockwise, x forward and y left in the robot frame;
//! frames `map` (the world), `odom` (dead reckoning), `base` (the robot).

pub mod active;
pub mod geometry;
pub mod localization;
pub mod navigation;
pub mod occupancy;
pub mod office;
pub mod recording;
pub mod simulator;
pub mod world;
