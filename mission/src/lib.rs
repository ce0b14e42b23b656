//! Missions: a plan, the robot in its world, what happens there, and a seed, put together in any
//! program. The `rpl` command is one such program; tests, benches and programs that embed plans are
//! others.
//!
//! A [`site::Site`] is all that is the same in every run: what plans can call, the models of a world,
//! and a scenario. It is built once and shared. A run is a value of it, a plan and a seed; the program
//! goes on with it in its own loop, and looks at it whenever it likes.
//!
//! ```
//! use rpl_lang::compile::NoFiles;
//! use rpl_mission::run::{Reached, run_to};
//! use rpl_mission::site::{Setup, Site};
//! use rpl_robot::world::World;
//! use std::ops::ControlFlow::Continue;
//!
//! let site = Site::new(Setup { world: World::builtin("test-room"), ..Setup::default() })?;
//! let plan = site.compile("plan.rpl", "(go-to 'table-side)", &mut NoFiles)?;
//! let mut run = site.start(plan, 1);
//! let reached = run_to(&mut run, 120_000_000, |_| Continue(()));
//! assert!(matches!(reached, Reached::End(_)));
//!
//! let sight = run.outside.sight().ok_or("there is a robot")?;
//! let robot_in_map = sight.robot_in_map.ok_or("its host knows where it is")?;
//! assert!(robot_in_map.distance_m(sight.estimate_in_map) < 0.3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Plans can call functions of the program around them: a [`rpl_runtime::step::native::Native`] in the
//! [`site::Setup`], whose code may capture what it needs. The example `embedding` reports over a
//! channel what the robot holds.
//!
//! This crate knows no file, terminal or clock, and starts no thread: texts are handed in, and what a
//! run prints and traces is handed out. Whatever is wrong is a value ([`error::SiteError`]) that says
//! what was found, where, and what would be right.
//!
//! Read in this order: `site`, `libraries`, `modules`, `scenario`, `robot` and `sight`, `run`, `reference`, `examples`,
//! `cost`, `error`.

pub mod cost;
pub mod error;
pub mod examples;
mod foreign_modules;
pub mod libraries;
pub mod modules;
pub mod reference;
pub mod robot;
pub mod run;
mod scenario;
pub mod sight;
pub mod site;
