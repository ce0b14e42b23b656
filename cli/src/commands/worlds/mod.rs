//! `rpl worlds [NAME]`: the built-in worlds, and what is in one.

mod ros_map;

use anyhow::{Result, bail};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_drawing::export;
use rpl_drive::show::figures;
use rpl_mission::cost::{MEMORY_GIB, TooLarge};
use rpl_robot::description::RobotDescription;
use rpl_robot::occupancy::{Cell, OccupancyGrid};
use rpl_robot::office::{OfficeModel, OfficeSettings};
use rpl_robot::world::World;
use rpl_shell::arguments::completion;
use rpl_shell::files::outputs::{OutputFile, OutputFolder};
use rpl_shell::files::{robot_files, world_files};
use rpl_shell::sites;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Edge of a cell of a map, which is a pixel of its image.
const RESOLUTION_M: f64 = 0.05;

/// A larger map would fill the memory.
const MOST_PIXELS: f64 = 67e6;

/// As images say it of themselves.
const DRAWN_BY: &str = "rpl worlds";

/// Columns of the names in the list.
const NAME_COLUMNS: usize = 16;

/// List the worlds, or show one
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Built-in world, .toml file, or ROS map
    #[arg(value_name = "NAME", add = ArgValueCompleter::new(completion::worlds))]
    name: Option<String>,
    /// Robot that will drive there: a built-in name or a .toml file (default: b21)
    #[arg(long, value_name = "R", requires = "name", add = ArgValueCompleter::new(completion::robots))]
    robot: Option<String>,
    /// Seed of an arena
    #[arg(long, value_name = "N", requires = "name", default_value_t = 1)]
    seed: u64,
    /// Write the world to this file, for `--world`
    #[arg(long, value_name = "FILE", requires = "name", value_hint = ValueHint::FilePath)]
    toml: Option<PathBuf>,
    /// Draw the world as it is into this file, as SVG: what the robot's map shows otherwise is marked
    #[arg(long, value_name = "FILE", requires = "name", value_hint = ValueHint::FilePath)]
    svg: Option<PathBuf>,
    /// The same drawing as PNG
    #[arg(long, value_name = "FILE", requires = "name", value_hint = ValueHint::FilePath)]
    png: Option<PathBuf>,
    /// The same drawing as PDF
    #[arg(long, value_name = "FILE", requires = "name", value_hint = ValueHint::FilePath)]
    pdf: Option<PathBuf>,
    /// Write the robot's map of the world for ROS into this folder: `map.yaml` and `map.pgm`, 5 cm a cell
    #[arg(long, value_name = "FOLDER", requires = "name", value_hint = ValueHint::DirPath)]
    map: Option<PathBuf>,
}

/// Lists the worlds, or shows one, drawing it if asked to.
///
/// # Errors
/// No world has the name, or a drawing cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let Some(name) = &arguments.name else {
        for (name, purpose) in world_files::names() {
            console.explain_hanging(&format!("{name:NAME_COLUMNS$}  {purpose}"), NAME_COLUMNS + 2)?;
        }
        return Ok(Status::Succeeded);
    };
    let robot = robot_files::named(arguments.robot.as_deref())?;
    let world = world_files::named(name, &robot, arguments.seed)?;
    let open = |path: &PathBuf| OutputFile::open(path, "the drawing");
    let toml = arguments.toml.as_ref().map(|path| OutputFile::open(path, "the world")).transpose()?;
    let [svg, png, pdf] = [&arguments.svg, &arguments.png, &arguments.pdf];
    let (svg, png) = (svg.as_ref().map(open).transpose()?, png.as_ref().map(open).transpose()?);
    let pdf = pdf.as_ref().map(open).transpose()?;
    if toml.is_some() && world_files::file_name(name).is_none() {
        bail!("the world `{name}` is a recorded map and has no text; leave `--toml` away");
    }
    let map = arguments.map.as_deref().map(|folder| map_folder(folder, &world)).transpose()?;
    console.explain(&describe(&world))?;
    if let Some(arena) = world_files::arena(name, arguments.seed) {
        console.explain(&format!("the way from `start` into `goal`: {}", arena.told()))?;
    }
    for warning in warnings(name, arguments.seed, &world, &robot)? {
        console.note(&format!("warning: {warning}"));
    }
    if let Some(toml) = toml {
        toml.write(world_files::text(name, arguments.seed)?.as_bytes())?;
    }
    if svg.is_some() || png.is_some() || pdf.is_some() {
        let drawing = figures::world(&world, robot.radius_m);
        png.map(|file| file.write(&export::png(&drawing, DRAWN_BY)?)).transpose()?;
        pdf.map(|file| file.write(&export::pdf(&drawing, DRAWN_BY)?)).transpose()?;
        svg.map(|file| file.write(drawing.as_bytes())).transpose()?;
    }
    if let Some(folder) = map {
        let map = world.map(RESOLUTION_M);
        folder.write("map.yaml", ros_map::yaml(&map))?;
        folder.write("map.pgm", ros_map::pgm(&map))?;
    }
    Ok(Status::Succeeded)
}

/// The folder for the map, tried.
fn map_folder(path: &Path, world: &World) -> Result<OutputFolder> {
    let pixels = world.size_m.x * world.size_m.y / (RESOLUTION_M * RESOLUTION_M);
    if pixels > MOST_PIXELS {
        bail!(
            "a map of the world `{}` at {RESOLUTION_M} m a pixel would have {:.0} million pixels, and at most {:.0} million are written; \
             crop the world to what is used",
            world.name,
            pixels / 1e6,
            MOST_PIXELS / 1e6
        );
    }
    OutputFolder::open(path, "worlds")
}

/// What is probably not meant as it stands in a world, with its place in the file if there is one.
fn warnings(name: &str, seed: u64, world: &World, robot: &Arc<RobotDescription>) -> Result<Vec<String>> {
    let settings = OfficeSettings::of(robot.clone());
    if let Some(too_large) = TooLarge::of(world, &settings, MEMORY_GIB) {
        let unseen = "it has not been looked over for places the robot cannot get to";
        return Ok(vec![format!("{}\n{unseen}", sites::refusal(&too_large))]);
    }
    let concerns = OfficeModel::survey(&Arc::new(world.clone()), &settings);
    let Some(file) = world_files::file_name(name) else {
        return Ok(concerns.into_iter().map(|concern| format!("{}: {}", world.name, concern.message)).collect());
    };
    let text = if concerns.is_empty() { String::new() } else { world_files::text(name, seed)? };
    Ok(concerns.iter().map(|concern| concern.in_file(&file, &text).to_string()).collect())
}

fn describe(world: &World) -> String {
    let start = world.start_in_map;
    let mut lines = vec![
        format!("{}: {:.1} m by {:.1} m", world.name, world.size_m.x, world.size_m.y),
        format!("start   ({:.2}, {:.2}), heading {:.0}°", start.x_m, start.y_m, start.heading_rad.to_degrees()),
    ];
    lines.extend(world.recorded.as_ref().map(describe_map));
    lines.push("rooms".to_string());
    for room in &world.rooms {
        let (min, max) = (room.rect.min, room.rect.max);
        lines.push(format!("  {:14} {:.1} m by {:.1} m", room.name, max.x - min.x, max.y - min.y));
    }
    lines.push("doors".to_string());
    for door in &world.doors {
        let is = if door.open { "open" } else { "closed" };
        let mapped = if door.open == door.mapped_open { "" } else { ", the map says otherwise" };
        lines.push(format!("  {:14} {:.2} m wide, {is}{mapped}", door.room, door.width_m));
    }
    lines.push("places".to_string());
    for place in &world.places {
        let pose = place.pose_in_map;
        let room = place.room.as_deref().map_or(String::new(), |room| format!(" in {room}"));
        lines.push(format!("  {:14} ({:.2}, {:.2}){room}", place.name, pose.x_m, pose.y_m));
    }
    if !world.landmarks.is_empty() {
        lines.push("landmarks".to_string());
    }
    for landmark in &world.landmarks {
        let (pose, colour) = (landmark.pose_in_map, landmark.colour.name());
        let degrees = pose.heading_rad.to_degrees().rem_euclid(360.0);
        lines.push(format!("  {:14} ({:.2}, {:.2}), {colour}, faces {degrees:.0}°", landmark.name, pose.x_m, pose.y_m));
    }
    let unmapped = world.objects.iter().filter(|object| !object.mapped).count();
    lines.push(format!(
        "{} objects, {unmapped} of them not in the map; {} people",
        world.objects.len(),
        world.people.len() + world.crowd
    ));
    lines.join("\n")
}

/// How large a recorded map is, and what it knows.
fn describe_map(map: &OccupancyGrid) -> String {
    let share =
        |kind: Cell| 100.0 * map.cells.iter().filter(|&&cell| cell == kind).count() as f64 / map.cells.len() as f64;
    format!(
        "map     {} by {} cells of {} m: {:.1} % free, {:.1} % occupied, {:.1} % unknown",
        map.columns,
        map.rows,
        map.resolution_m,
        share(Cell::Free),
        share(Cell::Occupied),
        share(Cell::Unknown)
    )
}
