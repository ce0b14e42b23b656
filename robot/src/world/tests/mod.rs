//! World files: what they mean, which faults are found in them, and what is drawn of them.

mod landmarks;
mod ros_map;

use super::*;
use crate::file_text::Finding;
use crate::occupancy::{Cell, OccupancyGrid};

fn dept() -> World {
    World::builtin("dept").expect("dept is built in")
}

/// The findings of a text, as "line:column key: message".
fn faults(text: &str) -> Vec<String> {
    let error = World::parse(text, "w.toml").expect_err("the text has faults");
    let short = |finding: &Finding| format!("{}:{} {}: {}", finding.line, finding.column, finding.key, finding.message);
    error.findings.iter().map(short).collect()
}

const SMALL: &str = "name = \"small\"\nsize = [4.0, 3.0]\nstart = [2.0, 1.5, \"90deg\"]\n";

#[test]
fn builtin_worlds_have_no_faults() {
    for name in World::builtin_names() {
        let text = World::builtin_text(name).expect("every name has a text");
        World::parse(text, name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(World::builtin(name).map(|world| world.name).as_deref(), Some(name));
    }
    assert!(World::builtin("no-such-world").is_none());
}

#[test]
fn angles_are_degrees_in_quotes_or_radians() {
    let world = World::parse(SMALL, "w.toml").expect("fine");
    assert!((world.start_in_map.heading_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    let radians = World::parse(&SMALL.replace("\"90deg\"", "1.5"), "w.toml").expect("fine");
    assert_eq!(radians.start_in_map.heading_rad, 1.5);
}

#[test]
fn what_other_tables_have_is_told_with_its_table() {
    let charger = World::parse(&format!("{SMALL}[[charger]]\nat = [1.0, 1.0]\n"), "w.toml").expect_err("no such table");
    assert!(charger.to_string().contains("`charges = true` in a [[place]]"), "{charger}");
    let room = "[[room]]\nname = \"A\"\nrect = [0, 0, 2, 2]\ncharges = true\n";
    let found = World::parse(&format!("{SMALL}{room}"), "w.toml").expect_err("a room does not charge").to_string();
    assert!(found.contains("`charges = true` in a [[place]]"), "{found}");
}

#[test]
fn a_misspelt_key_is_shown_in_its_line() {
    let text = format!(
        "{SMALL}[[wall]]\nline = [[0, 2], [4, 2]]\n[[room]]\nname = \"B\"\nrect = [0, 2, 4, 3]\n\
         [[door]]\nroom = \"B\"\nat = [2.0, 2.0]\nwidth = 0.9\nwidht = 0.9\naxis = \"x\"\n"
    );
    let error = World::parse(&text, "w.toml").expect_err("a key is misspelt");
    let shown = error.to_string();
    assert!(shown.starts_with("w.toml:13:1: unknown key `widht`, did you mean `width`?\n"), "{shown}");
    assert!(shown.contains("\n  13 | widht = 0.9\n     | ^^^^^\n"), "{shown}");
}

#[test]
fn all_faults_are_reported_at_once_and_in_order() {
    let text = "name = \"w\"\nsize = [4.0, nan]\nstart = [1.0, 1.0, \"north\"]\n\
                [[object]]\nname = \"o\"\npolygon = [[0, 0], [1, 1]]\n[[place]]\nname = \"p\"\n";
    assert_eq!(
        faults(text),
        [
            "2:14 size: `size` must be a finite number",
            "3:20 start: \"north\" is not an angle",
            "6:11 polygon: `polygon` must have at least 3 points, found 2",
            "7:1 pose: [[place]] has no `pose`",
        ]
    );
}

#[test]
fn values_out_of_bounds_are_faults() {
    let one = |text: &str| {
        let found = faults(&format!("{SMALL}{text}"));
        assert_eq!(found.len(), 1, "{found:?}");
        found[0].clone()
    };
    assert!(one("[[person]]\npath = [[1, 1], [2, 2]]\nspeed = -1").contains("must be more than 0, found -1"));
    assert!(one("[[wall]]\nline = [[1, 1], [2, 2]]\nthickness = inf").contains("finite"));
    assert!(one("[[object]]\nname = \"o\"\ncircle = [1, 1, 0]").contains("radius"));
    assert!(one("[[object]]\nname = \"o\"").contains("one outline, found none"));
    assert!(one("[[object]]\nname = \"o\"\ncircle = [1, 1, 1]\nrect = [0, 0, 1, 1]").contains("rect and circle"));
    assert!(one("[[room]]\nname = \"r\"\nrect = [2, 0, 1, 1]").contains("no area"));
    assert!(one("[[region]]\nmode = \"fast\"\nrect = [0, 0, 1, 1]").contains("\"hallway\" or"));
    assert!(one("[[region]]\nmode = \"halway\"\nrect = [0, 0, 1, 1]").ends_with("did you mean \"hallway\"?"));
    assert!(one("[[place]]\nname = \"p\"\npose = [9, 1, 0]").contains("outside the world"));
    assert!(one("[[wall]]\nline = [[0, 1.45], [4, 1.45]]").contains("the start is in the way of a wall"));
    assert!(one("[[wall]]\nline = 3").contains("must be an array of points, found 3"));
    assert!(one("wall = 3").contains("must be written as [[wall]]"));
}

#[test]
fn names_must_fit_together() {
    let room = "[[room]]\nname = \"B\"\nrect = [0, 2, 4, 3]\n";
    let wall = "[[wall]]\nline = [[0, 2], [4, 2]]\n";
    let door = "[[door]]\nroom = \"C\"\nat = [2.0, 2.0]\nwidth = 0.9\naxis = \"x\"\n";
    let found = faults(&format!("{SMALL}{room}{wall}{door}"));
    assert_eq!(found, ["10:8 room: the door belongs to the room `C`, which does not exist"]);
    let found = faults(&format!("{SMALL}{room}{}", door.replace("\"C\"", "\"B\"")));
    assert_eq!(found, ["9:6 at: the door of `B` at (2, 2) stands in no wall"]);
    let place = "[[place]]\nname = \"B\"\npose = [1, 1, 0]\n";
    let found = faults(&format!("{SMALL}{room}{place}"));
    assert_eq!(found, ["8:8 name: the place `B` has the name of a room above"]);
}

#[test]
fn items_lie_within_the_world_under_names_of_their_own() {
    let item = |name: &str, x: f64| format!("[[item]]\nname = \"{name}\"\nat = [{x}, 1.0]\n");
    let world = World::parse(&format!("{SMALL}{}", item("cup", 1.0)), "w.toml").expect("fine");
    assert_eq!(world.items, [Item { name: "cup".into(), at: Point::new(1.0, 1.0) }]);
    let found = faults(&format!("{SMALL}{}{}{}", item("cup", 1.0), item("CUP", 9.0), item("key", 1.0)));
    assert_eq!(
        found,
        [
            "8:8 name: the item `cup` has the name of an item above",
            "9:6 at: the item `cup` is at (9, 1), outside the world",
        ]
    );
    let found = faults(&format!("{SMALL}{}", item("cup", 1.0).replace("at =", "att =")));
    assert_eq!(found, ["4:1 at: [[item]] has no `at`", "6:1 att: unknown key `att`, did you mean `at`?"]);
}

#[test]
fn markers_lie_within_the_world_and_have_a_colour_and_a_size() {
    let marker = |more: &str| format!("[[marker]]\nat = [1.0, 1.0]\n{more}");
    let world = World::parse(&format!("{SMALL}{}", marker("")), "w.toml").expect("fine");
    assert_eq!(world.markers, [Marker { at: Point::new(1.0, 1.0), colour: MarkerColour::Pink, size_m: 0.3 }]);
    let orange = marker("colour = \"orange\"\nsize = 0.5");
    let world = World::parse(&format!("{SMALL}{orange}"), "w.toml").expect("fine");
    assert_eq!(world.markers, [Marker { at: Point::new(1.0, 1.0), colour: MarkerColour::Orange, size_m: 0.5 }]);
    let found = |text: String| faults(&format!("{SMALL}{text}"));
    assert_eq!(
        found(marker("").replace("1.0, 1.0", "9.0, 1.0")),
        ["5:6 at: the marker is at (9, 1), outside the world"]
    );
    let unknown = found(marker("colour = \"pinc\""));
    assert_eq!(unknown, ["6:10 colour: \"pinc\" is no `colour`, did you mean \"pink\"?"]);
    assert_eq!(found(marker("size = 0")), ["6:8 size: `size` must be more than 0, found 0"]);
    assert_eq!(found(marker("size = 3")), ["6:8 size: the `size` of a marker must be at most 2 m, found 3 m"]);
    assert_eq!(found(marker("color = \"pink\"")), ["6:1 color: unknown key `color`, did you mean `colour`?"]);
}

#[test]
fn text_that_is_not_toml_has_a_place() {
    let found = faults("name = \"w\nsize = [4.0, 3.0]\n");
    assert!(found[0].starts_with("1:"), "{found:?}");
}

#[test]
fn any_cut_of_a_world_file_is_read_or_refused_in_words() {
    let text = World::builtin_text("test-room").expect("test-room is built in");
    for end in 0..text.len() {
        if let Err(error) = World::parse(&text[..end], "cut.toml") {
            assert!(!error.findings.is_empty() && error.to_string().starts_with("cut.toml:"));
        }
    }
}

#[test]
fn an_unknown_place_gets_a_suggestion() {
    let error = dept().place("wolframs-shlef").expect_err("misspelt");
    assert_eq!(error.to_string(), "place `wolframs-shlef` is not in world `dept`; did you mean `wolframs-shelf`?");
    assert!(dept().place("mail-slots").is_ok());
}

#[test]
fn where_regions_overlap_the_doorway_wins() {
    let world = dept();
    assert_eq!(world.mode_at(Point::new(18.1, 12.0)), Some(TravelMode::Doorway));
    assert_eq!(world.mode_at(Point::new(18.1, 12.8)), Some(TravelMode::Doorway));
    assert_eq!(world.mode_at(Point::new(18.1, 15.0)), Some(TravelMode::Office));
    assert_eq!(world.mode_at(Point::new(13.5, 10.0)), Some(TravelMode::Hallway));
    assert_eq!(world.mode_at(Point::new(1.0, 10.0)), None);
    assert_eq!(world.room_at(Point::new(18.1, 15.0)).map(|room| room.name.as_str()), Some("B"));
    assert!(world.room_at(Point::new(13.5, 10.0)).is_none());
}

#[test]
fn rooms_regions_and_doors_must_make_sense_together() {
    let rooms = "[[room]]\nname = \"a\"\nrect = [0, 2, 2, 3]\n[[room]]\nname = \"b\"\nrect = [1.5, 2, 4, 3]\n";
    assert_eq!(faults(&format!("{SMALL}{rooms}")), ["9:8 rect: the rooms `a` and `b` overlap"]);
    let apart = rooms.replace("1.5, 2, 4, 3", "2, 2, 4, 3");
    assert!(World::parse(&format!("{SMALL}{apart}"), "w.toml").is_ok(), "a common edge is no common floor");
    let wall = "[[wall]]\nline = [[0, 2], [4, 2]]\nthickness = 0.1\n";
    let door = "[[door]]\nroom = \"a\"\nat = [3.4, 2.0]\nwidth = 0.9\naxis = \"x\"\n";
    let found = faults(&format!("{SMALL}{apart}{wall}{door}"));
    assert_eq!(found, ["14:8 room: the door at (3.4, 2) is 1.4 m away from its room `a`"]);
    let regions =
        "[[region]]\nmode = \"hallway\"\nrect = [1, 1, 2, 2]\n[[region]]\nmode = \"office\"\nrect = [0, 0, 4, 3]\n";
    let found = faults(&format!("{SMALL}{regions}"));
    assert_eq!(
        found,
        ["6:8 rect: the region counts nowhere: a region of another mode from (0, 0) to (4, 3) covers it"]
    );
    let swapped = regions.replace("hallway", "doorway");
    assert!(World::parse(&format!("{SMALL}{swapped}"), "w.toml").is_ok(), "a doorway in an office counts");
}

#[test]
fn people_are_counted_and_walk_within_the_world() {
    let crowd = |count: &str| World::parse(&format!("people = {count}\n{SMALL}"), "w.toml").map(|world| world.crowd);
    assert_eq!(crowd("7"), Ok(7));
    let refused = |count: &str| crowd(count).expect_err("no count").to_string();
    assert!(refused("-1").contains("`people` must be a whole number from 0 to 200, found -1"), "{}", refused("-1"));
    assert!(refused("2.5").contains("found 2.5") && refused("1000").contains("found 1000"));
    let found = faults(&format!("{SMALL}[[person]]\npath = [[1, 1], [9, 1]]\nspeed = 1\n"));
    assert_eq!(found, ["5:8 path: a person walks to (9, 1), outside the world"]);
}

#[test]
fn a_map_without_room_is_no_world_and_a_start_in_the_unknown_no_start() {
    let map = |cell| OccupancyGrid::filled(Point::origin(), 0.1, 30, 30, cell);
    for cell in [Cell::Occupied, Cell::Unknown] {
        let error = World::from_map("full", map(cell), 0.265).expect_err("there is no room").to_string();
        assert!(error.starts_with("the map has no free space that the robot fits into"), "{error}");
    }
    let text = "name = \"w\"\nmap = \"map.yaml\"\nstart = [1.5, 1.5, 0]\n";
    let found = |cell| World::parse_with_map(text, "w.toml", |_| Ok(map(cell)));
    assert!(found(Cell::Free).is_ok());
    let shown = |cell| found(cell).expect_err("nobody can start there").to_string();
    assert!(shown(Cell::Unknown).starts_with("w.toml:3:9: the start (1.5, 1.5) is where the map knows nothing"));
    assert!(shown(Cell::Occupied).starts_with("w.toml:3:9: the start is in the way of a wall"));
}

/// Half a turn about the middle of the corridor.
fn mirrored(point: Point) -> Point {
    Point::new(27.0 - point.x, 20.0 - point.y)
}

#[test]
fn the_corridor_of_dept_looks_the_same_after_half_a_turn() {
    let world = dept();
    for door in &world.doors {
        let twin = world.doors.iter().find(|other| (other.at - mirrored(door.at)).norm_squared() < 1e-18);
        let twin = twin.unwrap_or_else(|| panic!("the door of {} has no twin", door.room));
        assert_eq!(
            (twin.width_m, twin.axis, twin.open, twin.mapped_open),
            (door.width_m, door.axis, door.open, door.mapped_open)
        );
    }
    let outlines: Vec<Vec<Point>> = world
        .solids()
        .into_iter()
        .filter(|solid| solid.origin == SolidOrigin::Wall)
        .map(|solid| solid.outline.edges().map(|(a, _)| a).collect())
        .collect();
    for outline in &outlines {
        let twin = outlines.iter().find(|other| {
            let has = |point: &Point| other.iter().any(|corner| (corner - mirrored(*point)).norm_squared() < 1e-18);
            other.len() == outline.len() && outline.iter().all(has)
        });
        assert!(twin.is_some(), "the wall {outline:?} has no twin");
    }
}

#[test]
fn mirrored_points_of_the_corridor_fall_on_mirrored_cells() {
    for resolution_m in [0.05, 0.1, 0.15, 0.2, 0.33] {
        let grid = dept().map_centred(resolution_m);
        for row in 0..grid.rows {
            for column in 0..grid.columns {
                let centre = grid.centre(column, row);
                if (centre.x - 13.5).abs() > 11.9 || (centre.y - 10.0).abs() > 2.4 {
                    continue;
                }
                let (mirror_column, mirror_row) = (grid.columns - 1 - column, grid.rows - 1 - row);
                assert_eq!(grid.get(column, row), grid.get(mirror_column, mirror_row), "{resolution_m} {column} {row}");
                let mirror = grid.centre(mirror_column, mirror_row);
                assert!((mirror - mirrored(centre)).norm_squared() < 1e-18);
            }
        }
    }
}

#[test]
fn cells_reached_by_a_body_are_occupied_and_no_others() {
    for name in World::builtin_names() {
        let world = World::builtin(name).expect("built in");
        let bodies: Vec<Solid> = world
            .solids()
            .into_iter()
            .filter(|solid| match solid.origin {
                SolidOrigin::Door(index) => !world.doors[index].mapped_open,
                SolidOrigin::Object(index) => world.objects[index].mapped,
                SolidOrigin::Wall => true,
            })
            .collect();
        let grid = world.map(0.15);
        // One cell in seven of every row, another seventh in the next.
        for row in 0..grid.rows {
            for column in (row % 7..grid.columns).step_by(7) {
                // A body that comes within half an edge of the centre is in the cell; one that stays
                // farther off than half a diagonal is not.
                let centre = grid.centre(column, row);
                let distance_m =
                    bodies.iter().map(|body| body.outline.distance_m(centre)).fold(f64::INFINITY, f64::min);
                let occupied = grid.get(column, row) == Cell::Occupied;
                assert!(occupied || distance_m > 0.075 - 1e-5, "{name} {centre} {distance_m}");
                assert!(!occupied || distance_m < 0.075 * std::f64::consts::SQRT_2, "{name} {centre} {distance_m}");
            }
        }
    }
}

#[test]
fn the_map_shows_what_the_robot_was_told() {
    let text = World::builtin_text("test-room").expect("built in");
    let unmapped = text.replace("name = \"bin\"", "name = \"bin\"\nmapped = false");
    let closed = text.replace("open = true", "open = true\nmapped_open = false");
    let at = |text: &str, x: f64, y: f64| World::parse(text, "w.toml").expect("fine").map(0.1).at(Point::new(x, y));
    assert_eq!(at(text, 7.4, 0.6), Cell::Occupied);
    assert_eq!(at(&unmapped, 7.4, 0.6), Cell::Free);
    assert_eq!(at(text, 5.0, 3.0), Cell::Free);
    assert_eq!(at(&closed, 5.0, 3.0), Cell::Occupied);
    assert_eq!(dept().map(0.1).at(Point::new(1.0, 10.0)), Cell::Unknown);
    assert_eq!(dept().map(0.1).at(Point::new(8.9, 16.0)), Cell::Free);
}

#[test]
fn a_wall_without_thickness_occupies_both_sides() {
    let text = format!("{SMALL}[[wall]]\nline = [[0, 2], [4, 2]]\nthickness = 0\n").replace("1.5", "1.2");
    let grid = World::parse(&text, "w.toml").expect("fine").map(0.5);
    assert_eq!(grid.at(Point::new(1.1, 1.9)), Cell::Occupied);
    assert_eq!(grid.at(Point::new(1.1, 2.1)), Cell::Occupied);
    assert_eq!(grid.at(Point::new(1.1, 1.4)), Cell::Free);
}

#[test]
fn every_place_is_free_and_can_be_reached_with_room_to_spare() {
    const CLEARANCE_M: f64 = 0.3;
    for name in World::builtin_names() {
        let world = World::builtin(name).expect("built in");
        let bodies: Vec<Solid> = world
            .solids()
            .into_iter()
            .filter(|solid| !matches!(solid.origin, SolidOrigin::Door(index) if world.doors[index].open))
            .collect();
        let free = |point: Point| bodies.iter().all(|body| body.outline.distance_m(point) >= CLEARANCE_M);
        let grid = world.map(0.1);
        let mut reached = vec![false; grid.cells.len()];
        let mut open: Vec<_> = grid.cell_at(world.start_in_map.point()).into_iter().collect();
        while let Some((column, row)) = open.pop() {
            if reached[row * grid.columns + column] || !free(grid.centre(column, row)) {
                continue;
            }
            reached[row * grid.columns + column] = true;
            open.extend([(column + 1, row), (column, row + 1), (column - 1, row), (column, row - 1)]);
        }
        for place in &world.places {
            let (column, row) = grid.cell_at(place.pose_in_map.point()).expect("inside");
            assert!(free(place.pose_in_map.point()), "{} of {name} is not free", place.name);
            assert!(reached[row * grid.columns + column], "{} of {name} cannot be reached", place.name);
            let room = world.room_at(place.pose_in_map.point()).map(|room| room.name.as_str());
            assert_eq!(place.room.as_deref(), room, "{} of {name}", place.name);
        }
    }
}

#[test]
fn a_door_cuts_its_wall_and_nothing_else() {
    let world = World::builtin("test-room").expect("built in");
    let distance_m = |y: f64| {
        let walls = world.solids().into_iter().filter(|solid| solid.origin == SolidOrigin::Wall);
        walls.map(|wall| wall.outline.distance_m(Point::new(5.0, y))).fold(f64::INFINITY, f64::min)
    };
    assert!((distance_m(3.0) - 0.45).abs() < 1e-9);
    assert!((distance_m(2.65) - 0.1).abs() < 1e-9);
    assert_eq!(distance_m(2.5), 0.0);
}

#[test]
fn the_corridor_for_sensing_is_symmetric_to_the_laser_and_has_a_box_for_the_sonars() {
    let world = World::builtin("sensing").expect("a built-in world");
    let laser = world.map_centred_seen(0.05, |seen_by| seen_by.laser);
    let sonar = world.map_centred_seen(0.05, |seen_by| seen_by.sonar);
    assert_eq!(sonar, world.map_centred(0.05));
    let differ: Vec<usize> = (0..laser.cells.len()).filter(|&index| laser.cells[index] != sonar.cells[index]).collect();
    assert!((0..laser.cells.len()).all(|index| laser.cells[index] == laser.cells[laser.cells.len() - 1 - index]));
    // The box is 1.0 x 0.5 m.
    assert_eq!(differ.len(), 200);
    assert!(differ.iter().all(|&index| sonar.cells[index] == Cell::Occupied));
}

#[test]
fn names_fold_like_symbols() {
    let place = |name: &str| format!("[[place]]\nname = \"{name}\"\npose = [1, 1, 0]\n");
    let room = "[[room]]\nname = \"Lab\"\nrect = [0, 2, 4, 3]\n[[wall]]\nline = [[0, 2], [4, 2]]\n";
    let door = "[[door]]\nroom = \"lab\"\nat = [2.0, 2.0]\nwidth = 0.9\naxis = \"x\"\n";
    let item = "[[item]]\nname = \"Cup\"\nat = [1, 1]\n";
    let text = format!("{SMALL}{}{room}{door}{item}", place("Stove"));
    let world = World::parse(&text, "w.toml").unwrap_or_else(|error| panic!("{error}"));
    for name in ["stove", "Stove", "STOVE"] {
        assert_eq!(world.place(name).map(|place| place.name.as_str()), Ok("Stove"));
    }
    assert!(world.room("lab").is_ok() && world.door_of("LAB").is_ok());
    assert_eq!(world.items[0].name, "cup", "it comes back to plans as a symbol");
    let found = faults(&format!("{SMALL}{}{}", place("Stove"), place("stove")));
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("8:8 name: the place `stove` has the name of the place `Stove` above"), "{found:?}");
}

#[test]
fn numbers_and_names_no_world_has_are_faults() {
    let one = |text: &str| {
        let found = faults(&format!("{SMALL}{text}"));
        assert_eq!(found.len(), 1, "{found:?}");
        found[0].clone()
    };
    for number in ["1e308", "-1e308", "1e6"] {
        assert!(one(&format!("[[wall]]\nline = [[0, {number}], [4, 2]]")).contains("a number up to 100,000"));
    }
    assert!(one("[[region]]\nmode = \"hallway\"\nrect = [0, 0, inf, 1]").contains("a finite number"));
    assert!(one("[[place]]\nname = \"a\\u001b[2Jb\"\npose = [1, 1, 0]").contains("some that cannot be seen"));
    assert!(one(&format!("[[place]]\nname = \"{}\"\npose = [1, 1, 0]", "x".repeat(300))).contains("300 characters"));
    let found = faults("name = \"w\"\nsize = [1e-9, 4]\nstart = [0, 0, 0]\n");
    assert!(found.iter().any(|fault| fault.contains("`size` must be from 0.53 m to 1000 m")), "{found:?}");
}

#[test]
fn a_file_full_of_faults_shows_the_first_and_counts_the_others() {
    let text = format!("{SMALL}{}", "[[place]]\n".repeat(3_000));
    let error = World::parse(&text, "w.toml").expect_err("no place has a name");
    assert_eq!((error.findings.len(), error.more), (100, 5_900));
    assert!(error.to_string().ends_with("\n\nand 5900 more"));
    let text = format!("{SMALL}{}", "[[place]]\n".repeat(6_000));
    assert!(
        World::parse(&text, "w.toml").expect_err("too many").to_string().contains("at most 5000 [[place]], found 6000")
    );
    // A line of a megabyte is shown around the place.
    let long = format!("{SMALL}x = \"{}\"", "y".repeat(1 << 20));
    let shown = World::parse(&long, "w.toml").expect_err("an unknown key").to_string();
    assert!(shown.len() < 1_000, "{} bytes", shown.len());
}
