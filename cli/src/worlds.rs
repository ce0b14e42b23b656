//! `rpl worlds [NAME]`: the built-in worlds, and what is in one.

use crate::console::Console;
use crate::figures::{self, Figure};
use crate::mission;
use crate::status::Status;
use anyhow::{Context, Result};
use rpl_robot::occupancy::{Cell, OccupancyGrid};
use rpl_robot::world::World;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Edge of a cell in drawings of a world; a pixel of an image.
const RESOLUTION_M: f64 = 0.05;

/// Arguments of `rpl worlds`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// A built-in world, or a .toml file
    #[arg(value_name = "NAME")]
    name: Option<String>,
    /// Draws the robot's map of the world into this file
    #[arg(long, value_name = "FILE", requires = "name")]
    svg: Option<PathBuf>,
    /// The same as an image, 5 cm a pixel: black is occupied, grey is unknown
    #[arg(long, value_name = "FILE", requires = "name")]
    png: Option<PathBuf>,
}

/// Lists the worlds, or shows one, drawing it if asked to.
///
/// # Errors
/// No world has the name, or a drawing cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let Some(name) = &arguments.name else {
        for name in World::builtin_names() {
            console.print(&format!("{name:10}  {}", purpose(name)))?;
        }
        return Ok(Status::Succeeded);
    };
    let world = mission::world(name)?;
    console.print(&describe(&world))?;
    let map = world.map(RESOLUTION_M);
    if let Some(path) = &arguments.svg {
        let drawing = figures::draw(&Figure::of_map(&world.name, &map, &world.rooms));
        std::fs::write(path, drawing).with_context(|| cannot_draw(path))?;
    }
    if let Some(path) = &arguments.png {
        write_png(path, &map).with_context(|| cannot_draw(path))?;
    }
    Ok(Status::Succeeded)
}

fn cannot_draw(path: &Path) -> String {
    format!("cannot write the drawing `{}`", path.display())
}

fn write_png(path: &Path, map: &OccupancyGrid) -> Result<()> {
    let file = BufWriter::new(File::create(path)?);
    let mut encoder = png::Encoder::new(file, u32::try_from(map.columns)?, u32::try_from(map.rows)?);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels(map))?;
    writer.finish()?;
    Ok(())
}

/// A byte for each cell, the top row of the image first, which is the last of the grid.
fn pixels(map: &OccupancyGrid) -> Vec<u8> {
    let rows = (0..map.rows).rev();
    let cells = rows.flat_map(|row| (0..map.columns).map(move |column| map.get(column, row)));
    let shade = |cell| match cell {
        Cell::Free => 255,
        Cell::Unknown => 205,
        Cell::Occupied => 0,
    };
    cells.map(shade).collect()
}

/// The first comment line of a world's text.
fn purpose(name: &str) -> &'static str {
    let text = World::builtin_text(name).unwrap_or_default();
    text.lines().find(|line| line.starts_with('#')).unwrap_or_default().trim_start_matches('#').trim()
}

fn describe(world: &World) -> String {
    let start = world.start_in_map;
    let mut lines = vec![
        format!("{}: {:.1} m by {:.1} m", world.name, world.size_m.x, world.size_m.y),
        format!("start   ({:.2}, {:.2}), heading {:.0}°", start.x_m, start.y_m, start.heading_rad.to_degrees()),
    ];
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
    let unmapped = world.objects.iter().filter(|object| !object.mapped).count();
    lines.push(format!(
        "{} objects, {unmapped} of them not in the map; {} people",
        world.objects.len(),
        world.people.len()
    ));
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::geometry::Point;

    #[test]
    fn the_top_of_the_image_is_the_top_of_the_map() {
        let mut map = OccupancyGrid::filled(Point::origin(), 1.0, 2, 2, Cell::Free);
        map.set(0, 1, Cell::Occupied);
        map.set(1, 0, Cell::Unknown);
        assert_eq!(pixels(&map), [0, 255, 255, 205]);
    }
}
