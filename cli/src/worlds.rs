//! `rpl worlds [NAME]`: the built-in worlds, and what is in one.

use crate::console::Console;
use crate::figures::{self, Figure};
use crate::mission;
use crate::status::Status;
use anyhow::{Context, Result};
use rpl_robot::world::World;
use std::path::Path;

/// Edge of a cell in drawings of a world.
const RESOLUTION_M: f64 = 0.1;

/// Lists the worlds, or shows one, drawing it into `svg` if asked to.
///
/// # Errors
/// No world has the name, or the drawing cannot be written.
pub fn run(name: Option<&str>, svg: Option<&Path>, console: &mut Console) -> Result<Status> {
    let Some(name) = name else {
        for name in World::builtin_names() {
            console.print(&format!("{name:10}  {}", purpose(name)))?;
        }
        return Ok(Status::Succeeded);
    };
    let world = mission::world(name)?;
    console.print(&describe(&world))?;
    if let Some(path) = svg {
        let map = world.map(RESOLUTION_M);
        let drawing = figures::draw(&Figure::of_map(&world.name, &map, &world.rooms));
        std::fs::write(path, drawing).with_context(|| format!("cannot write the drawing `{}`", path.display()))?;
    }
    Ok(Status::Succeeded)
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
