//! Finding a room by instructions, without a map (Gutierrez-Osuna and Luo 1996, "LOLA: Probabilistic
//! Navigation for Topological Maps", AI Magazine 17(1)).
//!
//! Nothing here knows where the robot is on any map: there is the odometry, and what the sonars and a
//! camera tell of a hallway's sides.
//!
//! Read in this order: `feature` (what there is beside a hallway, and what is perceived of it) and
//! `instruction`; then `module`, which binds all to plans.

pub mod feature;
pub mod instruction;
mod module;

pub use module::Lola;
