//! Worlds that the command line names: built-in ones, world files, and recorded maps.

use super::inputs;
use super::maps::{MAP_FILE, MapFile, ros_map};
use crate::terminal::console;
use anyhow::{Context, Result, anyhow, bail};
use rpl_lang::suggest::suggest;
use rpl_robot::description::RobotDescription;
use rpl_robot::occupancy::OccupancyGrid;
use rpl_robot::world::World;
use std::path::Path;

/// A world by its name, or from a file, for a robot that is to start in it.
///
/// # Errors
/// No world has the name, the file has faults, or the robot has no room at the start.
pub fn named(name: &str, robot: &RobotDescription) -> Result<World> {
    let world = read(name, robot)?;
    let Err(taken) = world.room_at_start(robot.radius_m) else { return Ok(world) };
    match file_name(name) {
        Some(file) => bail!("the world `{name}` has faults\n{}", taken.in_file(&file, &text(name)?)),
        None => bail!("the world `{name}` has faults\n{taken}"),
    }
}

fn read(name: &str, robot: &RobotDescription) -> Result<World> {
    if let Some(world) = World::builtin(name) {
        return Ok(world);
    }
    let path = Path::new(name);
    if is_map(path) {
        let title = path.file_stem().map_or(name.into(), |stem| stem.to_string_lossy());
        let map = read_map(path)?;
        return World::from_map(&title, map, robot.radius_m).with_context(|| format!("the map `{name}` is no world"));
    }
    let is_there = path.metadata().is_ok_and(|known| !known.is_dir());
    if path.extension().is_some_and(|extension| extension == "toml") || is_there {
        let text = text(name)?;
        let beside = path.parent().unwrap_or(Path::new("."));
        let load_map = |map: &str| read_map(&beside.join(map)).map_err(|error| format!("{error:#}"));
        return World::parse_with_map(&text, name, load_map)
            .map_err(|error| anyhow!("the world `{name}` has faults\n{error}"));
    }
    match suggest(name, World::builtin_names()) {
        Some(meant) => bail!("no world is called `{name}`; did you mean `{meant}`?"),
        None => {
            let names: Vec<&str> = World::builtin_names().collect();
            bail!(
                "no world is called `{name}`; there are {}, files that end in .toml, and ROS maps (a map.yaml or its folder)",
                names.join(", ")
            )
        }
    }
}

/// What a world file is called in messages about it; none for a recorded map, which has no text.
pub fn file_name(name: &str) -> Option<String> {
    if World::builtin_text(name).is_some() {
        return Some(format!("{name}.toml"));
    }
    let path = Path::new(name);
    (!is_map(path)).then(|| name.to_string())
}

fn is_map(path: &Path) -> bool {
    let is_yaml = path.extension().is_some_and(|extension| extension == "yaml" || extension == "yml");
    is_yaml || path.join(MAP_FILE).is_file()
}

/// The text of a world file, or of a built-in world.
///
/// # Errors
/// It cannot be read.
pub fn text(name: &str) -> Result<String> {
    if let Some(text) = World::builtin_text(name) {
        return Ok(text.to_string());
    }
    inputs::world_text(Path::new(name)).map_err(|reason| anyhow!("cannot read the world `{name}`: {reason}"))
}

fn read_map(path: &Path) -> Result<OccupancyGrid> {
    let MapFile { grid, warnings } = ros_map(path)?;
    for warning in warnings {
        console::note(&warning);
    }
    Ok(grid)
}
