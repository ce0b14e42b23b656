//! Behaviour-based control (Fox and Anderson-Sprecher, Behavior-based control in RUPART; after Blank, Kumar,
//! Meeden and Yanco 2003, "Pyro: A python-based versatile programming environment for teaching robotics").
//!
//! Read in this order: `state` (which there are, and what leads from one to another), `parameters` (what a
//! behaviour case sets), `surroundings` (what the behaviours look at), `wander` (what the state Wander blends),
//! `progress` (whether the robot gets nearer to its goal), `drive` (all of it, step by step).

mod drive;
mod parameters;
mod progress;
mod state;
mod surroundings;
mod wander;

pub use drive::{ARRIVAL_M, CaseDrive, DriveEvent, DriveGoal, DriveStep, PASSING_M};
pub use parameters::BehaviourParameters;
pub use progress::{BLOCKED_S, Progress};
pub use state::{State, TRANSITIONS, Trigger};
pub use surroundings::Surroundings;
pub use wander::{Advice, blend};
