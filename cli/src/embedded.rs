//! What programs use that have the command in them, such as the package for Python: the command itself, and plans,
//! worlds and robots by the names that it takes.

use crate::commands::check;
use anyhow::{Result, bail};
use rpl_drive::show::failure_report::Reporter;
use rpl_drive::show::figures;
use rpl_mission::robot::Robot;
use rpl_mission::sight::{PositionBelief, Sight};
use rpl_mission::site::{Setup, Site};
use rpl_protocol::module::process_modules::ModuleSource;
use rpl_robot::description::RobotDescription;
use rpl_robot::office::OfficeSettings;
use rpl_robot::world::World;
use rpl_runtime::run::library::Loaded;
use rpl_runtime::run::system::System;
use rpl_runtime::state::value::Value;
use rpl_shell::files::{plans, robot_files, world_files};
use rpl_shell::sites;
use serde_json::json;
use std::ffi::OsString;
use std::sync::Arc;

/// Which build this is: parts of experiments that others have made fit only if they are of the same.
pub use crate::version::BUILD;
/// Modules within this process.
pub use rpl_shell::files::module_files::{Speaker, within as module_within};
/// A plan's text: a file, a built-in example, or a text that is at hand.
pub use rpl_shell::files::plans::{Folder, PlanText};

/// Does what the command does with these words, of which the first is its own name. Answers its exit status. It takes
/// the signals of the process, and writes to its standard output.
pub fn command(words: Vec<OsString>) -> u8 {
    crate::status_of(words).code()
}

/// A plan by its name: a file from the working folder, else a built-in example.
///
/// # Errors
/// It cannot be read.
pub fn plan(name: &str) -> Result<PlanText> {
    plans::plan(name)
}

/// A scenario by its name: the same, among the built-in scenarios too.
///
/// # Errors
/// It cannot be read.
pub fn scenario(name: &str) -> Result<PlanText> {
    plans::scenario(name)
}

/// A robot by its name, or from a file; the papers' robot if nobody names one.
///
/// # Errors
/// No robot has the name, or the file has faults.
pub fn robot(name: Option<&str>) -> Result<Arc<RobotDescription>> {
    robot_files::named(name)
}

/// The names of all worlds that need no file.
pub fn world_names() -> impl Iterator<Item = &'static str> {
    world_files::names().map(|(name, _)| name)
}

/// A world by its name, or from a file, for a robot that is to start in it; an arena is drawn from the seed.
///
/// # Errors
/// No world has the name, the file has faults, or the robot has no room at the start.
pub fn world(name: &str, robot: &RobotDescription, seed: u64) -> Result<World> {
    world_files::named(name, robot, seed)
}

/// Where a plan runs, with modules beside those of the robot, and the plan compiled for it.
///
/// # Errors
/// The plan or the scenario has faults, the world cannot be used, there are modules and no robot, or they do not fit it.
pub fn site(
    plan: &PlanText,
    world: Option<World>,
    robot: Arc<RobotDescription>,
    scenario: Option<PlanText>,
    modules: Vec<ModuleSource>,
) -> Result<(Site, Loaded)> {
    if let (None, Some(module)) = (&world, modules.first()) {
        bail!("the module `{}` needs a robot; name a world, such as `dept`", module.manifest.name);
    }
    let setup = Setup { world, settings: OfficeSettings::of(robot), ..Setup::default() };
    let site = sites::build(setup, scenario, modules)?;
    let loaded = sites::load(&site, plan, false)?;
    Ok((site, loaded))
}

/// What `rpl check --json` finds in a plan: a list of findings.
///
/// # Errors
/// The library of plans does not compile.
pub fn findings(plan: &PlanText) -> Result<serde_json::Value> {
    check::found_in(plan)
}

/// A failure of a plan with its causes, with the keys that `rpl run --json` gives it; null if the value is none.
pub fn failure(system: &System<Robot>, value: Value) -> serde_json::Value {
    let reporter = Reporter { machine: &system.machine, program: &system.program, colour: false };
    json!(reporter.record(value))
}

/// A drawing as SVG: the true path (solid) and the estimated one (dashed), and where the robot may be.
pub fn figure(world: &World, robot_radius_m: f64, track: &[Sight], belief: Option<&PositionBelief>) -> String {
    figures::mission(world, robot_radius_m, track, belief)
}

/// A drawing of a world as SVG, with a robot of this radius at the start.
pub fn world_figure(world: &World, robot_radius_m: f64) -> String {
    figures::world(world, robot_radius_m)
}
