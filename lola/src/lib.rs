//! Finding a room by instructions, without a map (Gutierrez-Osuna and Luo 1996, "LOLA: Probabilistic Navigation for
//! Topological Maps", AI Magazine 17(1)).
//!
//! Nothing here knows where the robot is on any map: there is the odometry, and what the sonars and a camera tell of a
//! hallway's sides.
//!
//! Read in this order: `feature` (what there is beside a hallway, and what is perceived of it) and `instruction`;
//! `registration` (which way the hallway runs), `beside` and `features` (what the sonars hear at its sides), `markers`
//! (what the camera sees); `state_set` (how far the robot has got with an instruction) and `judgement` (whether the
//! instruction is wrong); `topological` (the same with a complete map); `routines` (driving); then `module`, which
//! binds all to plans and alone knows the runtime, and `arena` (offices to try it in).

pub mod arena;
pub mod beside;
#[cfg(test)]
mod drive;
pub mod feature;
pub mod features;
pub mod instruction;
pub mod judgement;
pub mod markers;
mod module;
pub mod registration;
pub mod routines;
pub mod state_set;
pub mod topological;

pub use module::{Hallway, Lola, LolaSettings, PLANS};
