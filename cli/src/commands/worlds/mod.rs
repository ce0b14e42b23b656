//! `rpl worlds [NAME]`: the built-in worlds, and what is in one.

mod ros_map;

use anyhow::{Result, bail};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_drive::show::figures;
use rpl_mission::cost::{MEMORY_GIB, TooLarge};
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Point, distance_m};
use rpl_robot::occupancy::{Cell, OccupancyGrid};
use rpl_robot::office::{OfficeModel, OfficeSettings};
use rpl_robot::simulator::PERSON_RADIUS_M;
use rpl_robot::world::{Landmark, Marker, MarkerColour, World};
use rpl_shell::arguments::completion;
use rpl_shell::files::outputs::{OutputFile, OutputFolder};
use rpl_shell::files::{robot_files, world_files};
use rpl_shell::sites;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Edge of a cell in drawings of a world; a pixel of an image.
const RESOLUTION_M: f64 = 0.05;

/// A larger drawing would fill the memory.
const MOST_PIXELS: f64 = 67e6;

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
    /// Draw the robot's map of the world into this file, as SVG
    #[arg(long, value_name = "FILE", requires = "name", value_hint = ValueHint::FilePath)]
    svg: Option<PathBuf>,
    /// Write the robot's map of the world for ROS into this folder: `map.yaml` and `map.pgm`, 5 cm a cell
    #[arg(long, value_name = "FOLDER", requires = "name", value_hint = ValueHint::DirPath)]
    map: Option<PathBuf>,
    /// Draw the world as an image, 5 cm a pixel: black is occupied, grey unknown, orange there but not in the
    /// map, green in the map but not there, blue people on their paths, red the robot; markers and landmarks have
    /// their own colours
    #[arg(long, value_name = "FILE", requires = "name", value_hint = ValueHint::FilePath)]
    png: Option<PathBuf>,
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
    let (svg, png) = (arguments.svg.as_ref().map(open).transpose()?, arguments.png.as_ref().map(open).transpose()?);
    console.explain(&describe(&world))?;
    if let Some(arena) = world_files::arena(name, arguments.seed) {
        console.explain(&format!("the way from `start` into `goal`: {}", arena.told()))?;
    }
    for warning in warnings(name, arguments.seed, &world, &robot)? {
        console.note(&format!("warning: {warning}"));
    }
    if let Some(toml) = toml {
        if world_files::file_name(name).is_none() {
            bail!("the world `{name}` is a recorded map and has no text; leave `--toml` away");
        }
        toml.write(world_files::text(name, arguments.seed)?.as_bytes())?;
    }
    let map = arguments.map.as_deref().map(|folder| OutputFolder::open(folder, "worlds")).transpose()?;
    if svg.is_some() || png.is_some() {
        draw(&world, robot.radius_m, svg, png)?;
    }
    if let Some(folder) = map {
        refuse_huge(&world)?;
        let map = world.map(RESOLUTION_M);
        folder.write("map.yaml", ros_map::yaml(&map))?;
        folder.write("map.pgm", ros_map::pgm(&map))?;
    }
    Ok(Status::Succeeded)
}

fn refuse_huge(world: &World) -> Result<()> {
    let pixels = world.size_m.x * world.size_m.y / (RESOLUTION_M * RESOLUTION_M);
    if pixels > MOST_PIXELS {
        bail!(
            "a drawing of the world `{}` at {RESOLUTION_M} m a pixel would have {:.0} million pixels, and at most {:.0} million are drawn; \
             crop the world to what is used",
            world.name,
            pixels / 1e6,
            MOST_PIXELS / 1e6
        );
    }
    Ok(())
}

fn draw(world: &World, robot_radius_m: f64, svg: Option<OutputFile>, png: Option<OutputFile>) -> Result<()> {
    refuse_huge(world)?;
    let map = world.map(RESOLUTION_M);
    if let Some(svg) = svg {
        svg.write(figures::world(world).as_bytes())?;
    }
    if let Some(png) = png {
        png.write(&png_bytes(world, &map, robot_radius_m)?)?;
    }
    Ok(())
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

fn png_bytes(world: &World, map: &OccupancyGrid, robot_radius_m: f64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, u32::try_from(map.columns)?, u32::try_from(map.rows)?);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels(world, map, robot_radius_m))?;
    writer.finish()?;
    Ok(bytes)
}

type Colour = [u8; 3];

/// It is there, and not in the map: furniture, a door that is closed.
const UNMAPPED: Colour = [230, 120, 0];
/// It is in the map, and not there: a door that is open.
const VANISHED: Colour = [0, 160, 80];
/// A person at the beginning of a path.
const PERSON: Colour = [30, 90, 220];
/// Where the robot starts.
const ROBOT: Colour = [200, 0, 60];

/// A marker on the floor, or a landmark.
fn of_marker(colour: MarkerColour) -> Colour {
    match colour {
        MarkerColour::Pink => [255, 60, 190],
        MarkerColour::Orange => [255, 150, 60],
        MarkerColour::Green => [120, 240, 90],
        MarkerColour::Blue => [40, 150, 255],
    }
}

/// The cells on both sides of a landmark's sheet, in its colour.
fn sheet_cells(landmark: &Landmark, map: &OccupancyGrid) -> Vec<((usize, usize), Colour)> {
    let [left, right] = landmark.edges_in_map();
    let half_m = map.resolution_m / 2.0;
    let steps = (landmark.width_m / half_m).ceil() as usize;
    let along = (0..=steps).map(|step| left + (right - left) * (step as f64 / steps as f64));
    let both = along.flat_map(|at| [at - landmark.facing() * half_m, at + landmark.facing() * half_m]);
    both.filter_map(|at| Some((map.cell_at(at)?, of_marker(landmark.colour)))).collect()
}

/// Three bytes for each cell, the top row of the image first, which is the last of the grid.
fn pixels(world: &World, map: &OccupancyGrid, robot_radius_m: f64) -> Vec<u8> {
    let floor = world.floor(map.resolution_m, |door| world.doors[door].open);
    let sheets: BTreeMap<_, _> = world.landmarks.iter().flat_map(|landmark| sheet_cells(landmark, map)).collect();
    let is_on = |centre: Point, reach_m: f64, at: Point| distance_m(centre, at) <= reach_m;
    let shade = |column: usize, row: usize| -> Colour {
        let centre = map.centre(column, row);
        let is_there = floor.get(column, row) == Cell::Occupied;
        if is_on(centre, robot_radius_m, world.start_in_map.point()) {
            return ROBOT;
        }
        if world.people.iter().any(|person| is_on(centre, PERSON_RADIUS_M, person.path[0])) {
            return PERSON;
        }
        if let Some(colour) = sheets.get(&(column, row)) {
            return *colour;
        }
        let is_marked = |marker: &&Marker| (centre - marker.at).amax() <= marker.size_m / 2.0;
        if let Some(marker) = world.markers.iter().find(is_marked).filter(|_| !is_there) {
            return of_marker(marker.colour);
        }
        match (map.get(column, row), is_there) {
            (Cell::Occupied, true) => [0; 3],
            (Cell::Occupied, false) => VANISHED,
            (Cell::Free | Cell::Unknown, true) => UNMAPPED,
            (Cell::Free, false) => [255; 3],
            (Cell::Unknown, false) => [205; 3],
        }
    };
    let rows = (0..map.rows).rev();
    rows.flat_map(|row| (0..map.columns).map(move |column| (column, row)))
        .flat_map(|(column, row)| shade(column, row))
        .collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_image_shows_the_map_and_what_is_otherwise() {
        let text = "name = \"w\"\nsize = [4.0, 3.0]\nstart = [1.0, 1.0, 0]\n\
                    [[wall]]\nline = [[0, 2], [4, 2]]\nthickness = 0.2\n\
                    [[room]]\nname = \"r\"\nrect = [0, 2.1, 4, 3]\n\
                    [[door]]\nroom = \"r\"\nat = [1, 2]\nwidth = 1\naxis = \"x\"\nopen = false\nmapped_open = true\n\
                    [[door]]\nroom = \"r\"\nat = [3, 2]\nwidth = 1\naxis = \"x\"\nopen = true\nmapped_open = false\n\
                    [[object]]\nname = \"box\"\nrect = [2, 0.5, 2.4, 0.9]\nmapped = false\n\
                    [[person]]\npath = [[3, 0.5], [3, 1]]\nspeed = 1\n\
                    [[marker]]\nat = [3.5, 1.5]\ncolour = \"green\"\n\
                    [[wall]]\nline = [[0, 1], [0, 2]]\nthickness = 0.2\n\
                    [[landmark]]\nname = \"west\"\npose = [0.1, 1.5, 0]\ncolour = \"blue\"\n";
        let world = World::parse(text, "w.toml").expect("no faults");
        let map = world.map(0.05);
        let image = pixels(&world, &map, 0.265);
        let at = |x: f64, y: f64| {
            let (column, row) = map.cell_at(Point::new(x, y)).expect("inside");
            let pixel = ((map.rows - 1 - row) * map.columns + column) * 3;
            [image[pixel], image[pixel + 1], image[pixel + 2]]
        };
        assert_eq!(at(2.0, 1.95), [0; 3], "a wall");
        assert_eq!(at(2.0, 2.5), [255; 3], "free floor");
        assert_eq!(at(1.0, 2.0), UNMAPPED, "a closed door that is open in the map");
        assert_eq!(at(3.0, 2.0), VANISHED, "an open door that is closed in the map");
        assert_eq!(at(2.2, 0.7), UNMAPPED, "an object that is not in the map");
        assert_eq!((at(3.0, 0.5), at(1.0, 1.0)), (PERSON, ROBOT));
        assert_eq!((at(3.4, 1.6), at(3.7, 1.5)), (of_marker(MarkerColour::Green), [255; 3]), "a marker and beside it");
        assert_eq!((at(0.08, 1.5), at(0.08, 1.2)), (of_marker(MarkerColour::Blue), [0; 3]), "a landmark and its wall");
    }
}
