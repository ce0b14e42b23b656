//! Robots that the command line names: built-in ones, and robot files.

use super::inputs;
use anyhow::{Result, anyhow, bail};
use rpl_lang::suggest::suggest;
use rpl_lang::visible::visible;
use rpl_robot::description::RobotDescription;
use std::path::Path;
use std::sync::Arc;

/// A robot by its name, or from a file; the papers' robot if nobody names one.
///
/// # Errors
/// No robot has the name, or the file has faults.
pub fn named(name: Option<&str>) -> Result<Arc<RobotDescription>> {
    let Some(name) = name else { return Ok(RobotDescription::papers()) };
    if let Some(robot) = RobotDescription::builtin(name) {
        return Ok(robot);
    }
    if !is_file(name) {
        bail!(unknown(name));
    }
    let robot = RobotDescription::parse(&text(name)?, name);
    robot.map(Arc::new).map_err(|error| anyhow!("the robot `{}` has faults\n{error}", visible(name)))
}

/// The text of a robot file, or of a built-in robot.
///
/// # Errors
/// No robot has the name, or the file cannot be read.
pub fn text(name: &str) -> Result<String> {
    if let Some(text) = RobotDescription::builtin_text(name) {
        return Ok(text.to_string());
    }
    if !is_file(name) {
        bail!(unknown(name));
    }
    inputs::short_text(Path::new(name)).map_err(|reason| anyhow!("cannot read the robot `{}`: {reason}", visible(name)))
}

fn is_file(name: &str) -> bool {
    let path = Path::new(name);
    path.extension().is_some_and(|extension| extension == "toml") || path.metadata().is_ok_and(|known| !known.is_dir())
}

fn unknown(name: &str) -> String {
    let meant = suggest(name, RobotDescription::builtin_names());
    let name = visible(name);
    match meant {
        Some(meant) => format!("no robot is called `{name}`; did you mean `{meant}`?"),
        None => {
            let names: Vec<&str> = RobotDescription::builtin_names().collect();
            format!("no robot is called `{name}`; there are {}, and files that end in .toml", names.join(", "))
        }
    }
}
