//! Worlds that the command line names: built-in ones, world files, recorded maps, and arenas, which are drawn
//! from the seed of what runs in them.

use super::inputs;
use super::maps::{MAP_FILE, MapFile, ros_map};
use crate::terminal::console;
use anyhow::{Context, Result, anyhow, bail};
use rpl_lang::suggest::suggest;
use rpl_lang::visible::visible;
use rpl_lola::arena::{ARENAS, Arena, ArenaSettings};
use rpl_robot::description::RobotDescription;
use rpl_robot::occupancy::OccupancyGrid;
use rpl_robot::world::World;
use std::borrow::Cow;
use std::path::Path;

/// The names of all worlds that need no file, each with what it is in a sentence.
pub fn names() -> impl Iterator<Item = (&'static str, Cow<'static, str>)> {
    let builtin =
        World::builtin_names().map(|name| (name, Cow::Owned(World::builtin_purpose(name).unwrap_or_default())));
    builtin.chain(ARENAS.iter().map(|(name, purpose, _)| (*name, Cow::Borrowed(*purpose))))
}

/// The arena of a name and a seed, if the name is that of one.
pub fn arena(name: &str, seed: u64) -> Option<Arena> {
    ArenaSettings::named(name).map(|settings| Arena::draw(seed, &settings))
}

/// Whether a world is another one for each seed.
pub fn is_drawn(name: &str) -> bool {
    ArenaSettings::named(name).is_some()
}

/// A world that is the same for all seeds, for a robot that is to start in it.
///
/// # Errors
/// It is drawn from a seed; or as for [`named`].
pub fn for_all_seeds(name: &str, robot: &RobotDescription) -> Result<World> {
    if is_drawn(name) {
        bail!(
            "`{name}` is another world for each seed, and this needs one for all; \
             `rpl worlds {name} --seed N --toml FILE.toml` writes one of them as a file to name here"
        );
    }
    named(name, robot, 0)
}

/// A world by its name, or from a file, for a robot that is to start in it; an arena is drawn from the seed.
///
/// # Errors
/// No world has the name, the file has faults, or the robot has no room at the start.
pub fn named(name: &str, robot: &RobotDescription, seed: u64) -> Result<World> {
    let world = read(name, robot, seed)?;
    let Err(taken) = world.room_at_start(robot.radius_m) else { return Ok(world) };
    match file_name(name) {
        Some(file) => bail!("the world `{}` has faults\n{}", visible(name), taken.in_file(&file, &text(name, seed)?)),
        None => bail!("the world `{}` has faults\n{taken}", visible(name)),
    }
}

fn read(name: &str, robot: &RobotDescription, seed: u64) -> Result<World> {
    if let Some(world) = World::builtin(name).or_else(|| arena(name, seed).map(|arena| arena.world)) {
        return Ok(world);
    }
    let path = Path::new(name);
    if is_map(path) {
        let title = path.file_stem().map_or(name.into(), |stem| stem.to_string_lossy());
        let map = read_map(path)?;
        return World::from_map(&title, map, robot.radius_m)
            .with_context(|| format!("the map `{}` is no world", visible(name)));
    }
    let is_there = path.metadata().is_ok_and(|known| !known.is_dir());
    if path.extension().is_some_and(|extension| extension == "toml") || is_there {
        let text = text(name, seed)?;
        let beside = path.parent().unwrap_or(Path::new("."));
        let load_map = |map: &str| read_map(&beside.join(map)).map_err(|error| format!("{error:#}"));
        return World::parse_with_map(&text, name, load_map)
            .map_err(|error| anyhow!("the world `{}` has faults\n{error}", visible(name)));
    }
    match suggest(name, names().map(|(known, _)| known)) {
        Some(meant) => bail!("no world is called `{}`; did you mean `{meant}`?", visible(name)),
        None => {
            let names: Vec<&str> = names().map(|(known, _)| known).collect();
            bail!(
                "no world is called `{}`; there are {}, files that end in .toml, and ROS maps (a map.yaml or its folder)",
                visible(name),
                names.join(", ")
            )
        }
    }
}

/// What a world file is called in messages about it; none for a recorded map, which has no text.
pub fn file_name(name: &str) -> Option<String> {
    if World::builtin_text(name).is_some() || is_drawn(name) {
        return Some(format!("{name}.toml"));
    }
    let path = Path::new(name);
    (!is_map(path)).then(|| name.to_string())
}

fn is_map(path: &Path) -> bool {
    let is_yaml = path.extension().is_some_and(|extension| extension == "yaml" || extension == "yml");
    is_yaml || path.join(MAP_FILE).is_file()
}

/// The text of a world file, of a built-in world, or of an arena.
///
/// # Errors
/// It cannot be read.
pub fn text(name: &str, seed: u64) -> Result<String> {
    let builtin = World::builtin_text(name).map(str::to_string);
    if let Some(text) = builtin.or_else(|| arena(name, seed).map(|arena| arena.text)) {
        return Ok(text);
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
