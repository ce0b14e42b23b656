//! What stands where: walls, doors, furniture, rooms and places.

use super::frame::Frame;
use super::ink::Raster;
use super::labels::Labels;
use super::legend::{Legend, Sign, door_style, place_radius_px, place_sign};
use super::palette;
use super::writing::{SMALL_PX, rounded};
use rpl_robot::geometry::{Point, Vector};
use rpl_robot::occupancy::{Cell, OccupancyGrid};
use rpl_robot::world::{Door, Outline, Place, Rect, Room, SolidOrigin, World};
use std::fmt::Write;
use svg::node::element::{Group, Line, Path};

/// What is unknown is shown in squares of about this size on a sheet.
const UNKNOWN_CELLS: f64 = 480.0;

/// A wall is drawn at least so thick.
const THINNEST_PX: f64 = 1.2;

/// A plan of the floor.
pub struct FloorPlan {
    /// The rectangle that everything is in.
    pub bounds: Rect,
    grid: OccupancyGrid,
    /// Walls as they are; without them, the occupied cells of the grid are walls.
    walls: Vec<Outline>,
    objects: Vec<(Outline, bool)>,
    doors: Vec<Door>,
    rooms: Vec<Room>,
    places: Vec<Place>,
}

impl FloorPlan {
    /// That of a world as it is, with the names of its rooms and places; what its map shows otherwise is marked.
    pub fn of_world(world: &World) -> Self {
        let resolution_m = (world.size_m.x.max(world.size_m.y) / UNKNOWN_CELLS).max(0.05);
        let mut plan = Self {
            bounds: world.bounds(),
            grid: world.map(resolution_m),
            walls: Vec::new(),
            objects: Vec::new(),
            doors: world.doors.clone(),
            rooms: world.rooms.clone(),
            places: world.places.clone(),
        };
        for solid in world.solids() {
            match solid.origin {
                SolidOrigin::Wall => plan.walls.push(solid.outline),
                SolidOrigin::Object(index) => plan.objects.push((solid.outline, world.objects[index].mapped)),
                SolidOrigin::Door(_) => {}
            }
        }
        plan
    }

    /// That of a map.
    pub fn of_map(map: &OccupancyGrid) -> Self {
        let size_m = Vector::new(map.columns as f64, map.rows as f64) * map.resolution_m;
        Self {
            bounds: Rect { min: map.origin_in_frame, max: map.origin_in_frame + size_m },
            grid: map.clone(),
            walls: Vec::new(),
            objects: Vec::new(),
            doors: Vec::new(),
            rooms: Vec::new(),
            places: Vec::new(),
        }
    }

    /// With the names of these rooms only, and no places.
    #[must_use]
    pub fn naming(mut self, is_named: impl Fn(&Room) -> bool) -> Self {
        self.rooms.retain(is_named);
        self.places.clear();
        self
    }

    /// What the map does not know, below everything.
    pub fn unknown(&self, frame: Frame) -> Group {
        let unknown = self.raster().path(frame, |column, row| self.grid.get(column, row) == Cell::Unknown);
        unknown.into_iter().fold(Group::new(), |group, path| group.add(path.set("fill", palette::UNKNOWN)))
    }

    fn raster(&self) -> Raster {
        let OccupancyGrid { resolution_m, origin_in_frame, columns, rows, .. } = self.grid;
        Raster { origin_in_map: origin_in_frame, resolution_m, columns, rows }
    }

    /// Furniture, doors and walls, above a belief.
    pub fn solids(&self, frame: Frame) -> Group {
        let mut group = Group::new().set("class", "floor-plan");
        for (mapped, fill, dashes) in [(true, palette::FURNITURE, "none"), (false, palette::PAPER, "3 2")] {
            let outlines = self.objects.iter().filter(|object| object.1 == mapped).map(|object| &object.0);
            if let Some(path) = outlined(outlines, frame) {
                let path = path.set("fill", fill).set("stroke", palette::FURNITURE_EDGE).set("stroke-width", 0.8);
                group = group.add(path.set("stroke-dasharray", dashes));
            }
        }
        let walls = match self.walls.is_empty() {
            false => outlined(self.walls.iter(), frame),
            true => self.raster().path(frame, |column, row| self.grid.get(column, row) == Cell::Occupied),
        };
        if let Some(walls) = walls {
            let walls = walls.set("fill", palette::INK).set("class", "walls");
            let thin = self.walls.is_empty();
            group = group.add(if thin {
                walls
            } else {
                walls.set("stroke", palette::INK).set("stroke-width", THINNEST_PX)
            });
        }
        self.doors.iter().fold(group, |group, door| group.add(drawn_door(door, frame)))
    }

    /// Keeps names off the walls.
    pub fn keep_off(&self, labels: &mut Labels, frame: Frame) {
        let raster = self.raster();
        for row in 0..raster.rows {
            for column in (0..raster.columns).filter(|&column| self.grid.get(column, row) == Cell::Occupied) {
                let (x_px, y_px) = frame.at(self.grid.centre(column, row));
                labels.cross((x_px, y_px, x_px, y_px));
            }
        }
    }

    /// Places with their signs, which no name may cover.
    pub fn place_signs(&self, labels: &mut Labels, frame: Frame) -> Group {
        let mut group = Group::new().set("class", "places");
        for place in &self.places {
            let (x_px, y_px) = frame.at(place.pose_in_map.point());
            let reach_px = place_radius_px(place.charges) + 0.4;
            labels.take((x_px - reach_px, y_px - reach_px, x_px + reach_px, y_px + reach_px));
            group = group.add(place_sign((x_px, y_px), place.charges));
        }
        group
    }

    /// The names of places, then those of rooms.
    pub fn names(&self, labels: &mut Labels, frame: Frame) {
        for place in &self.places {
            let reach_px = place_radius_px(place.charges) - 0.6;
            labels.beside(&place.name, frame.at(place.pose_in_map.point()), reach_px, SMALL_PX, palette::PLACE);
        }
        for room in &self.rooms {
            labels.around(&room.name, frame.at(room.rect.centre()), SMALL_PX, palette::QUIET);
        }
    }

    /// What its signs mean.
    pub fn explain(&self, legend: &mut Legend) {
        legend.add(Sign::Wall, if self.walls.is_empty() { "occupied" } else { "wall" });
        if self.grid.cells.contains(&Cell::Unknown) {
            legend.add(Sign::Unknown, "unknown to the map");
        }
        for (mapped, means) in [(true, "furniture"), (false, "furniture not in the robot's map")] {
            if self.objects.iter().any(|object| object.1 == mapped) {
                legend.add(Sign::Furniture(mapped), means);
            }
        }
        for (open, misdrawn, means) in [
            (true, false, "open door"),
            (false, false, "closed door"),
            (true, true, "open, but closed in the robot's map"),
            (false, true, "closed, but open in the robot's map"),
        ] {
            if self.doors.iter().any(|door| door.open == open && (door.open != door.mapped_open) == misdrawn) {
                legend.add(Sign::Door { open, misdrawn }, means);
            }
        }
        for (charges, means) in [(false, "place"), (true, "place where the robot is charged")] {
            if self.places.iter().any(|place| place.charges == charges) {
                legend.add(Sign::Place { charges }, means);
            }
        }
    }
}

/// Outlines as one path; none if there are none.
fn outlined<'o>(outlines: impl Iterator<Item = &'o Outline>, frame: Frame) -> Option<Path> {
    let mut data = String::new();
    for outline in outlines {
        match outline {
            Outline::Polygon(points) => {
                for (number, point) in points.iter().enumerate() {
                    let (x, y) = frame.at(*point);
                    let _ = write!(data, "{}{x} {y}", if number == 0 { "M" } else { "L" });
                }
                data.push('Z');
            }
            Outline::Disc { centre, radius_m } => {
                let ((x, y), r) = (frame.at(*centre), frame.length(*radius_m));
                let (left, right) = (rounded(x - r), rounded(x + r));
                let _ = write!(data, "M{left} {y}A{r} {r} 0 1 0 {right} {y}A{r} {r} 0 1 0 {left} {y}Z");
            }
        }
    }
    (!data.is_empty()).then(|| Path::new().set("d", data))
}

fn drawn_door(door: &Door, frame: Frame) -> Line {
    let reach = door.along() * (door.width_m / 2.0);
    let ends: [Point; 2] = [door.at - reach, door.at + reach];
    let [(x1, y1), (x2, y2)] = ends.map(|end| frame.at(end));
    let line = Line::new().set("class", "door").set("x1", x1).set("y1", y1).set("x2", x2).set("y2", y2);
    door_style(line, door.open, door.open != door.mapped_open)
}
