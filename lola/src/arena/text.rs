//! An arena as the text of a world file.

use super::area::Area;
use super::floor_plan::{Doorway, FloorPlan, Opening};
use super::furniture::Furniture;
use super::interval::Millimetres;
use super::walls::WallLine;
use rpl_robot::world::Axis;

/// The head of a text, and what the rooms are called.
pub struct Titles<'a> {
    /// The name of the world.
    pub name: &'a str,
    /// Comments at the head, without the sign.
    pub head: &'a [String],
    /// The numbers of the rooms that have a name of their own.
    pub named: &'a [(usize, &'a str)],
    /// How many people walk about.
    pub people: usize,
}

/// Millimetres as metres, without zeros at the end.
struct Metres(Millimetres);

impl std::fmt::Display for Metres {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (whole, rest) = (self.0 / 1000, self.0 % 1000);
        let decimals = format!("{rest:03}");
        let decimals = decimals.trim_end_matches('0');
        write!(f, "{whole}.{}", if decimals.is_empty() { "0" } else { decimals })
    }
}

/// The world file.
pub fn write(plan: &FloorPlan, furniture: &Furniture, titles: &Titles<'_>) -> String {
    let mut text: String = titles.head.iter().map(|line| format!("# {line}\n")).collect();
    let (width, height) = (Metres(plan.size_mm.0), Metres(plan.size_mm.1));
    let (x, y) = (Metres(furniture.start_mm.0), Metres(furniture.start_mm.1));
    text += &format!("\nname = \"{}\"\nsize = [{width}, {height}]\n", titles.name);
    text += &format!("start = [{x}, {y}, \"{}deg\"]\n", furniture.start_heading_deg);
    if titles.people > 0 {
        text += &format!("people = {}\n", titles.people);
    }
    text.extend(plan.walls.iter().map(|wall| written_wall(wall, plan.walls_mm)));
    for (index, room) in plan.rooms.iter().enumerate() {
        let named = titles.named.iter().find(|(number, _)| *number == index);
        let name = named.map_or_else(|| format!("room-{}", index + 1), |(_, name)| (*name).to_string());
        text += &written_room(plan, index, &room.opening, &name);
    }
    let hallways = (0..plan.hallways.len()).map(|hallway| rect(plan.hallway_area(hallway)));
    text.extend(hallways.map(|rect| format!("\n[[region]]\nmode = \"hallway\"\nrect = {rect}\n")));
    let boxes = (1..).zip(&furniture.boxes);
    text.extend(
        boxes.map(|(number, found)| format!("\n[[object]]\nname = \"box-{number}\"\nrect = {}\n", rect(*found))),
    );
    let markers = furniture.markers_mm.iter();
    text.extend(markers.map(|(x_mm, y_mm)| format!("\n[[marker]]\nat = [{}, {}]\n", Metres(*x_mm), Metres(*y_mm))));
    text
}

fn written_wall(wall: &WallLine, walls_mm: Millimetres) -> String {
    let at = |along_mm: Millimetres| match wall.axis {
        Axis::X => format!("[{}, {}]", Metres(along_mm), Metres(wall.across_mm)),
        Axis::Y => format!("[{}, {}]", Metres(wall.across_mm), Metres(along_mm)),
    };
    let (from, to) = (at(wall.along_mm.0), at(wall.along_mm.1));
    format!("\n[[wall]]\nline = [{from}, {to}]\nthickness = {}\n", Metres(walls_mm))
}

/// A room with its door. What nobody can get into is no room.
fn written_room(plan: &FloorPlan, index: usize, opening: &Opening, name: &str) -> String {
    let rect = rect(plan.clear_area(index));
    let room = format!("\n[[room]]\nname = \"{name}\"\nrect = {rect}\n");
    match opening {
        Opening::None => String::new(),
        Opening::Foyer { .. } => room,
        Opening::Door(door) => room + &written_door(plan, door, name),
    }
}

fn written_door(plan: &FloorPlan, door: &Doorway, name: &str) -> String {
    let (axis, (x_mm, y_mm)) = match plan.hallways[door.hallway].axis {
        Axis::X => ("x", (door.middle_mm(), door.wall_mm)),
        Axis::Y => ("y", (door.wall_mm, door.middle_mm())),
    };
    let (x, y, width) = (Metres(x_mm), Metres(y_mm), Metres(door.along_mm.1 - door.along_mm.0));
    let open = door.open;
    format!("\n[[door]]\nroom = \"{name}\"\nat = [{x}, {y}]\nwidth = {width}\naxis = \"{axis}\"\nopen = {open}\n")
}

fn rect(area: Area) -> String {
    let ((x0, x1), (y0, y1)) = (area.x_mm, area.y_mm);
    format!("[{}, {}, {}, {}]", Metres(x0), Metres(y0), Metres(x1), Metres(y1))
}
