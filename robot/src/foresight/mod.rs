//! Foresight: what will probably become of drives, grasps and the battery, by what the robot knows. An
//! abstract robot does in a few events what the simulator does in thousands of steps; it is told what is
//! believed, and nothing here can look at the truth.
//!
//! There are two grains. In the abstract one a drive is a duration and an outcome. In the simulated one the
//! robot's own controller drives, in a simulated world that is made of the map and of what is believed, without a
//! filter, and all else is as in the abstract one.
//!
//! Read `ways` (where a drive leads), `drive_times` (how long it takes), `models` (what may come between),
//! `activity` (what is asked of a robot), `drive`, `streams` and `abstract_robot` (the robot that lives by them), `simulated_world` (the
//! world in which it drives for itself).
//!
//! Behaviours of modules in other processes are drawn from the declarations in their manifests (`act_model`).

pub mod abstract_robot;
pub mod act_model;
pub mod activity;
mod drive;
pub mod drive_times;
pub mod models;
pub mod simulated_world;
mod streams;
pub mod ways;
