//! Keeping off what stands around the robot, whatever it is and wherever the robot wants to go.
//!
//! Read in this order: `limits` (what the robot can do), `clearance` (how far an arc is free),
//! `braking` (what is wanted, as far as it is safe), `dynamic_window` (the best of the safe velocities), `collision_avoidance` (the same over time, and
//! the way out where there is none). All of it is in `base`; it knows no map.

mod braking;
mod clearance;
mod collision_avoidance;
mod dynamic_window;
mod limits;

pub use braking::braked_velocity;
pub use clearance::open_distance_m;
pub use collision_avoidance::{AvoidanceChoice, AvoidanceStatus, CollisionAvoidance};
pub use dynamic_window::{CANDIDATES, WINDOW_S, WindowInput, best_velocity};
pub use limits::DriveLimits;
