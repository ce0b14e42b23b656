//! Reading a world file.

use super::check;
use super::{Door, Item, Landmark, Marker, MarkerColour, Object, Person, Place, Region, Room, Shape, Wall, World};
use super::{LARGEST_M, Rect, SMALLEST_M, recorded};
use crate::file_text::{FileFaults, Findings, Placed, Reader, TomlTable};
use crate::geometry::{Point, Vector};
use crate::occupancy::OccupancyGrid;
use rpl_lang::symbol::fold_name;
use toml::de::DeTable;

/// Thickness of a wall that states none.
const WALL_THICKNESS_M: f64 = 0.15;

/// The keys at the top of a world file.
const WORLD_KEYS: [&str; 15] = [
    "name", "size", "map", "start", "people", "wall", "room", "door", "object", "place", "region", "person", "item",
    "marker", "landmark",
];

/// Colour and side of a marker that states none.
const MARKER: (MarkerColour, f64) = (MarkerColour::Pink, 0.3);

/// Colour of a landmark that states none, and its width, height and lower edge: at the height of a small robot's
/// camera.
const LANDMARK: (MarkerColour, [f64; 3]) = (MarkerColour::Pink, [0.3, 0.3, 0.2]);

/// Nobody can step over a sheet that is larger, or hang it on a wall.
const LARGEST_SHEET_M: f64 = 2.0;

/// More people would be a crush in any building.
const MOST_PEOPLE: usize = 200;

impl World {
    /// Reads the text of a world file that names no recorded map; `file_name` is for the messages only.
    ///
    /// # Errors
    /// As for [`World::parse_with_map`].
    pub fn parse(text: &str, file_name: &str) -> Result<World, FileFaults> {
        Self::parse_with_map(text, file_name, |_| Err("this world cannot read other files".to_owned()))
    }

    /// Reads the text of a world file; `load_map` gives the recorded map of the name that stands there.
    ///
    /// # Errors
    /// All faults of the file at once: text that is not TOML, unknown or missing keys, values of the
    /// wrong kind or size, names used twice or not at all, things outside the world or in a wall, a
    /// map that cannot be loaded.
    pub fn parse_with_map(
        text: &str,
        file_name: &str,
        load_map: impl FnOnce(&str) -> Result<OccupancyGrid, String>,
    ) -> Result<World, FileFaults> {
        let mut reader = Reader {
            kind: "world",
            keys_above: &["map", "start", "people"],
            file: file_name,
            text,
            findings: Findings::default(),
        };
        let (document, errors) = DeTable::parse_recoverable(text);
        reader.syntax_errors(&errors);
        let top = TomlTable { values: document.get_ref(), span: 0..0, header: String::new() };
        let world = if errors.is_empty() { read_world(&mut reader, &top, load_map) } else { None };
        reader.findings.or_value(world)
    }
}

fn read_world<'i>(
    reader: &mut Reader<'i>,
    top: &TomlTable<'_, 'i>,
    load_map: impl FnOnce(&str) -> Result<OccupancyGrid, String>,
) -> Option<World> {
    reader.only_keys(top, &WORLD_KEYS);
    let name = reader.text(top, "name", "\"my-lab\"");
    let ground = read_ground(reader, top, load_map);
    let start = reader.pose(top, "start", "[2.0, 3.0, \"90deg\"]");
    let start = start.map(|value| Placed { value, table: top.clone() });
    let crowd = reader.count(top, "people", MOST_PEOPLE);
    let walls = read_all(reader, top, "wall", read_wall);
    let rooms = read_all(reader, top, "room", read_room);
    let doors = read_all(reader, top, "door", read_door);
    let objects = read_all(reader, top, "object", read_object);
    let places = read_all(reader, top, "place", read_place);
    let regions = read_all(reader, top, "region", read_region);
    let people = read_all(reader, top, "person", read_person);
    let items = read_all(reader, top, "item", read_item);
    let markers = read_all(reader, top, "marker", read_marker);
    let landmarks = read_all(reader, top, "landmark", read_landmark);

    check::names(reader, &rooms, &places);
    check::item_names(reader, &items);
    check::landmark_names(reader, &landmarks);
    check::doors(reader, &doors, &rooms, &walls);
    check::floors(reader, &rooms, &doors);
    check::regions(reader, &regions);
    if let Some(ground) = &ground {
        check::inside(reader, ground.bounds, start.as_ref(), &doors, &objects, &places);
        check::items_inside(reader, ground.bounds, &items);
        check::markers_inside(reader, ground.bounds, &markers);
        check::people_inside(reader, ground.bounds, &people);
    }
    let ground = ground?;
    let hung: Vec<_> = landmarks.iter().map(|landmark| landmark.table.span_of("pose")).collect();
    let world = World {
        name: name?,
        origin_in_map: ground.bounds.min,
        size_m: ground.bounds.max - ground.bounds.min,
        recorded: ground.recorded,
        start_in_map: start.as_ref().map(|start| start.value)?,
        walls: values(walls),
        rooms: values(rooms),
        doors: values(doors),
        objects: values(objects),
        places: values(places),
        regions: values(regions),
        people: values(people),
        crowd,
        items: values(items),
        markers: values(markers),
        landmarks: values(landmarks),
    };
    check::landmarks_hang(reader, &world, &hung);
    check::start_is_free(reader, &world, top.span_of("start"));
    Some(world)
}

fn values<T>(placed: Vec<Placed<'_, '_, T>>) -> Vec<T> {
    placed.into_iter().map(|placed| placed.value).collect()
}

fn read_all<'t, 'i, T>(
    reader: &mut Reader<'i>,
    top: &TomlTable<'t, 'i>,
    key: &str,
    read: impl Fn(&mut Reader<'i>, &TomlTable<'_, 'i>) -> Option<T>,
) -> Vec<Placed<'t, 'i, T>> {
    let tables = reader.tables(top, key);
    tables.iter().filter_map(|table| read(reader, table).map(|value| Placed { value, table: table.clone() })).collect()
}

/// Where the world lies, and its recorded map.
struct Ground {
    bounds: Rect,
    recorded: Option<OccupancyGrid>,
}

/// A world has a size, or a recorded map that has one.
fn read_ground<'i>(
    reader: &mut Reader<'i>,
    top: &TomlTable<'_, 'i>,
    load_map: impl FnOnce(&str) -> Result<OccupancyGrid, String>,
) -> Option<Ground> {
    if !top.values.contains_key("map") {
        let max = Point::from(read_size(reader, top)?);
        return Some(Ground { bounds: Rect { min: Point::origin(), max }, recorded: None });
    }
    if top.values.contains_key("size") {
        let help = "leave `size` out: the recorded map says how large the world is and where it lies";
        reader.note(top.span_of("size"), "size", "a world has either `size` or `map`", help);
    }
    let name = reader.text(top, "map", "\"map.yaml\"")?;
    match load_map(&name) {
        Ok(map) => {
            let bounds = Rect { min: map.origin_in_frame, max: map.origin_in_frame + recorded::size_m(&map) };
            Some(Ground { bounds, recorded: Some(map) })
        }
        Err(reason) => {
            reader.note(top.span_of("map"), "map", reason, "name the YAML file of a ROS map, relative to this file");
            None
        }
    }
}

fn read_size<'i>(reader: &mut Reader<'i>, top: &TomlTable<'_, 'i>) -> Option<Vector> {
    let size = reader.point(top, "size", "[12.0, 8.0]")?;
    let fine = |length_m: f64| (SMALLEST_M..=LARGEST_M).contains(&length_m);
    if fine(size.x) && fine(size.y) {
        return Some(size.coords);
    }
    let message = format!("`size` must be from {SMALLEST_M} m to {LARGEST_M} m, found {} by {}", size.x, size.y);
    reader.note(top.span_of("size"), "size", message, "write width and height in metres, like `size = [12.0, 8.0]`");
    None
}

fn read_wall<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Wall> {
    reader.only_keys(table, &["line", "thickness"]);
    let line = reader.points(table, "line", 2, "[[0.0, 0.0], [5.0, 0.0]]");
    let thickness_m = match table.values.get("thickness") {
        Some(value) => reader.size_value(value, "thickness", true, "0.15"),
        None => Some(WALL_THICKNESS_M),
    };
    Some(Wall { line: line?, thickness_m: thickness_m? })
}

fn read_room<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Room> {
    reader.only_keys(table, &["name", "rect"]);
    let name = reader.text(table, "name", "\"B\"");
    let rect = reader.rect(table, "rect");
    Some(Room { name: name?, rect: rect? })
}

fn read_door<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Door> {
    reader.only_keys(table, &["room", "at", "width", "axis", "open", "mapped_open"]);
    let room = reader.text(table, "room", "\"B\"");
    let at = reader.point(table, "at", "[4.0, 2.5]");
    let width_m = reader.size(table, "width", false, "0.9");
    let axis = reader.axis(table);
    let open = reader.flag(table, "open", true);
    let mapped_open = reader.flag(table, "mapped_open", open);
    Some(Door { room: room?, at: at?, width_m: width_m?, axis: axis?, open, mapped_open })
}

fn read_object<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Object> {
    reader.only_keys(table, &["name", "rect", "circle", "polygon", "mapped", "seen_by"]);
    let name = reader.text(table, "name", "\"desk\"");
    let shape = read_shape(reader, table);
    let mapped = reader.flag(table, "mapped", true);
    let seen_by = reader.seen_by(table);
    Some(Object { name: name?, shape: shape?, mapped, seen_by })
}

fn read_shape<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Shape> {
    let given: Vec<&str> =
        ["rect", "circle", "polygon"].into_iter().filter(|key| table.values.contains_key(*key)).collect();
    match given[..] {
        ["rect"] => reader.rect(table, "rect").map(Shape::Rect),
        ["circle"] => read_circle(reader, table),
        ["polygon"] => reader.points(table, "polygon", 3, "[[1.0, 1.0], [2.0, 1.0], [1.5, 2.0]]").map(Shape::Polygon),
        _ => {
            let found = if given.is_empty() { "none".to_owned() } else { given.join(" and ") };
            let message = format!("an object has one outline, found {found}");
            let help = "write `rect = [x0, y0, x1, y1]`, `circle = [x, y, radius]` or `polygon = [[x, y], ...]`";
            let key = given.get(1).copied().unwrap_or("rect");
            reader.note(table.span_of(key), key, message, help);
            None
        }
    }
}

fn read_circle<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Shape> {
    let [x, y, radius_m] = reader.circle(table, "circle", "[2.0, 1.0, 0.25]")?;
    if radius_m > 0.0 {
        return Some(Shape::Circle { centre: Point::new(x, y), radius_m });
    }
    let message = format!("the radius of `circle` must be more than 0, found {radius_m}");
    reader.note(table.span_of("circle"), "circle", message, "write it like `circle = [2.0, 1.0, 0.25]`");
    None
}

fn read_place<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Place> {
    reader.only_keys(table, &["name", "pose", "room", "charges"]);
    let name = reader.text(table, "name", "\"mail-slots\"");
    let pose = reader.pose(table, "pose", "[2.0, 3.0, \"90deg\"]");
    let room = match table.values.contains_key("room") {
        true => Some(reader.text(table, "room", "\"B\"")?),
        false => None,
    };
    let charges = reader.flag(table, "charges", false);
    Some(Place { name: name?, pose_in_map: pose?, room, charges })
}

fn read_region<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Region> {
    reader.only_keys(table, &["mode", "rect"]);
    let mode = reader.mode(table);
    let rect = reader.rect(table, "rect");
    Some(Region { mode: mode?, rect: rect? })
}

fn read_person<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Person> {
    reader.only_keys(table, &["path", "speed"]);
    let path = reader.points(table, "path", 2, "[[2.0, 3.0], [6.0, 3.0]]");
    let speed_mps = reader.size(table, "speed", false, "0.8");
    Some(Person { path: path?, speed_mps: speed_mps? })
}

fn read_item<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Item> {
    reader.only_keys(table, &["name", "at"]);
    let name = reader.text(table, "name", "\"mail\"");
    let at = reader.point(table, "at", "[2.0, 3.0]");
    // It comes back to plans as a symbol, which has no capitals.
    Some(Item { name: fold_name(&name?).into_owned(), at: at? })
}

fn read_marker<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Marker> {
    reader.only_keys(table, &["at", "colour", "size"]);
    let at = reader.point(table, "at", "[2.0, 3.0]");
    let colour = colour(reader, table, MARKER.0);
    let size_m = sheet_size(reader, table, "marker", "size", MARKER.1);
    Some(Marker { at: at?, colour: colour?, size_m: size_m? })
}

fn read_landmark<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>) -> Option<Landmark> {
    reader.only_keys(table, &["name", "pose", "width", "height", "bottom", "colour"]);
    let (usual_colour, [usual_width_m, usual_height_m, usual_bottom_m]) = LANDMARK;
    let name = reader.text(table, "name", "\"by-the-stairs\"");
    let pose_in_map = reader.pose(table, "pose", "[2.0, 3.0, \"90deg\"]");
    let width_m = sheet_size(reader, table, "landmark", "width", usual_width_m);
    let height_m = sheet_size(reader, table, "landmark", "height", usual_height_m);
    let bottom_m = match table.values.get("bottom") {
        Some(value) => reader.size_value(value, "bottom", true, "0.2"),
        None => Some(usual_bottom_m),
    };
    let colour = colour(reader, table, usual_colour);
    Some(Landmark {
        name: name?,
        pose_in_map: pose_in_map?,
        width_m: width_m?,
        height_m: height_m?,
        bottom_m: bottom_m?,
        colour: colour?,
    })
}

fn colour<'i>(reader: &mut Reader<'i>, table: &TomlTable<'_, 'i>, usual: MarkerColour) -> Option<MarkerColour> {
    match table.values.contains_key("colour") {
        true => reader.choice(table, "colour", &MarkerColour::ALL.map(|colour| (colour.name(), colour))),
        false => Some(usual),
    }
}

fn sheet_size(reader: &mut Reader, table: &TomlTable, kind: &str, key: &str, usual_m: f64) -> Option<f64> {
    let Some(value) = table.values.get(key) else { return Some(usual_m) };
    let size_m = reader.size_value(value, key, false, "0.3")?;
    if size_m <= LARGEST_SHEET_M {
        return Some(size_m);
    }
    let message = format!("the `{key}` of a {kind} must be at most {LARGEST_SHEET_M} m, found {size_m} m");
    reader.note(value.span(), key, message, format!("a {kind} is a sheet; write it like `{key} = 0.3`"));
    None
}
