//! Foresight: what will probably become of drives, grasps and the battery, by what the robot knows. An
//! abstract robot does in a few events what the simulator does in thousands of steps; it is told what is
//! believed, and nothing here can look at the truth.
//!
//! Read `ways` (where a drive leads), `drive_times` (how long it takes), `models` (what may come between),
//! `abstract_robot` (the robot that lives by them).

pub mod abstract_robot;
pub mod drive_times;
pub mod models;
pub mod ways;
