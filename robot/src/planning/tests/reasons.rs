//! Ways without doors, and what is said where there is none.

use super::*;

/// Two halves; what stands between them is added.
const HALVES: &str = "name = \"w\"\nsize = [10.0, 6.0]\nstart = [2.0, 3.0, 0]\n\
    [[wall]]\nline = [[0.1, 0.1], [9.9, 0.1], [9.9, 5.9], [0.1, 5.9], [0.1, 0.1]]\nthickness = 0.2\n\
    [[room]]\nname = \"east\"\nrect = [5.1, 0.2, 9.8, 5.8]\n\
    [[place]]\nname = \"Bed\"\npose = [8.0, 3.0, 0]\nroom = \"east\"\n";

const WALL: &str = "[[wall]]\nline = [[5.0, 0.1], [5.0, 5.9]]\n";

/// A passage of 1.2 m without a door.
const GAP: &str = "[[wall]]\nline = [[5.0, 0.1], [5.0, 2.4]]\n[[wall]]\nline = [[5.0, 3.6], [5.0, 5.9]]\n";

fn door(more: &str) -> String {
    format!("{WALL}[[door]]\nroom = \"east\"\nat = [5.0, 3.0]\naxis = \"y\"\n{more}")
}

fn building(between: &str) -> Building {
    let text = format!("{HALVES}{between}");
    Building::new(World::parse(&text, "w.toml").unwrap_or_else(|error| panic!("{error}")))
}

fn plan_to_bed(building: &Building) -> Result<NavigationPlan, Unreachable> {
    let place = building.world.place("bed").expect("a place");
    building.plan(building.world.start_in_map, place)
}

#[test]
fn a_narrow_gap_is_gone_through_straight_like_a_door() {
    let through: Vec<Point> =
        plan_to_bed(&building(GAP)).expect("a way").targets.iter().map(|target| target.point_in_frame).collect();
    assert!(through.len() == 3 && through[..2].iter().all(|point| (point.y - 3.0).abs() < 0.06), "{through:?}");
}

#[test]
fn what_is_missing_is_named() {
    for (between, parts) in [
        (WALL.to_string(), &["room `east` has no door"][..]),
        (door("width = 0.9\nopen = false\n"), &["the door of room `east` at (5.00, 3.00) is closed in the map"]),
        (door("width = 0.5\n"), &["the door of room `east` at (5.00, 3.00) is 0.50 m wide, too narrow"]),
        (
            door("width = 0.9\n") + "[[object]]\nname = \"cot\"\nrect = [5.3, 0.2, 6.0, 5.8]\n",
            &["the object `cot` stands"],
        ),
        (
            door("width = 0.9\n") + "[[object]]\nname = \"cot\"\nrect = [7.5, 2.5, 8.5, 3.5]\n",
            &["at (8.00, 3.00) the robot does not fit", "inside the object `cot`"],
        ),
        (
            door("width = 0.9\n") + "[[wall]]\nline = [[8.4, 3.0], [8.6, 3.0]]\nthickness = 1.0\n",
            &["the robot does not fit: inside", "a wall"],
        ),
    ] {
        let Err(Unreachable { reason }) = plan_to_bed(&building(&between)) else { panic!("there is a way\n{between}") };
        let told = parts.iter().flat_map(|part| part.split(": ")).all(|part| reason.contains(part));
        assert!(told, "{reason}\nshould say {parts:?}");
    }
}

/// Walls with gaps and doors, rooms anywhere, things: where a way leads over the floor, there is a
/// plan, and where there is none, there is a reason.
#[test]
fn there_is_a_plan_exactly_where_there_is_a_way() {
    let (mut with, mut without) = (0, 0);
    for seed in 0..60 {
        let mut stream = Stream::new(seed, "ways");
        let mut text = "name = \"w\"\nsize = [12.0, 8.0]\nstart = [0.6, 0.6, 0]\n".to_string();
        for line in 1..=2 {
            let x = 4.0 * f64::from(line);
            let (from, to) = (stream.uniform_in(1.2, 6.0), stream.uniform_in(0.2, 2.0));
            text += &format!(
                "[[wall]]\nline = [[{x}, 0], [{x}, {from}]]\n[[wall]]\nline = [[{x}, {}], [{x}, 8]]\n",
                from + to
            );
            let room = format!("r{line}");
            let (left, right) = (x + 0.08, x + stream.uniform_in(2.0, 3.9));
            text +=
                &format!("[[room]]\nname = \"{room}\"\nrect = [{left}, {}, {right}, 8]\n", stream.uniform_in(0.0, 4.0));
            if stream.chance(0.6) {
                let open = stream.chance(0.5);
                let width = stream.uniform_in(0.4, 1.1);
                text += &format!(
                    "[[door]]\nroom = \"{room}\"\nat = [{x}, 0.6]\nwidth = {width}\naxis = \"y\"\nopen = {open}\n"
                );
            }
        }
        for thing in 0..6 {
            let (x, y) = (stream.uniform_in(1.5, 10.0), stream.uniform_in(1.5, 7.0));
            let (width, height) = (stream.uniform_in(0.2, 1.5), stream.uniform_in(0.2, 3.0));
            text += &format!("[[object]]\nname = \"o{thing}\"\nrect = [{x}, {y}, {}, {}]\n", x + width, y + height);
        }
        // Not every draw is a world: a door may stand off its room.
        let Ok(world) = World::parse(&text, "w.toml") else { continue };
        let building = Building::new(world);
        for _ in 0..12 {
            let mut pose = || {
                let (x_m, y_m) = (stream.uniform_in(0.0, 12.0), stream.uniform_in(0.0, 8.0));
                Pose::new(x_m, y_m, 0.0)
            };
            let (start, goal) = (pose(), pose());
            let place = Place { name: "goal".to_owned(), pose_in_map: goal, room: None, charges: false };
            let way = building.planner.cost_to_go(goal.point()).path(start.point());
            match building.plan(start, &place) {
                Ok(plan) => {
                    assert!(way.is_some(), "seed {seed}: {start:?} {goal:?} {plan:?}\n{text}");
                    with += 1;
                }
                Err(Unreachable { reason }) => {
                    assert!(way.is_none() && !reason.is_empty(), "seed {seed}: {start:?} {goal:?} {reason}\n{text}");
                    without += 1;
                }
            }
        }
    }
    assert!(with > 80 && without > 80, "{with} with a way, {without} without");
}

fn concerns(building: &Building) -> Vec<String> {
    let concerns = building.topology.survey(&building.planner, Some(0.8));
    let table =
        |concern: &Concern| concern.table.map_or("top".to_string(), |(table, number)| format!("{table} {number}"));
    concerns.iter().map(|concern| format!("{} {}: {}", table(concern), concern.key, concern.message)).collect()
}

#[test]
fn nothing_is_said_about_the_built_in_worlds() {
    for name in World::builtin_names() {
        let building = Building::new(World::builtin(name).expect("built in"));
        assert_eq!(concerns(&building), [""; 0], "{name}");
    }
}

#[test]
fn what_cannot_be_got_to_is_told_with_its_key() {
    let item = "[[item]]\nname = \"cup\"\nat = [9.7, 5.7]\n";
    let cot = "[[object]]\nname = \"cot\"\nrect = [5.3, 0.2, 6.0, 5.8]\n";
    for (between, expected) in [
        (
            WALL.to_string(),
            &[
                "room 0 rect: nothing leads into room `east`",
                "place 0 pose: the robot cannot get from the start to the place `Bed`: room `east` has no door",
            ][..],
        ),
        (
            door("width = 0.5\n"),
            &["door 0 width: the door of room `east` at (5.00, 3.00) is 0.50 m wide", "place 0 pose: "],
        ),
        (
            door("width = 0.9\n") + cot,
            &[
                "door 0 at: the object `cot` stands before the door of room `east`",
                "place 0 pose: the robot cannot get from the start to the place `Bed`: the object `cot` stands",
            ],
        ),
        (
            door("width = 0.9\nopen = false\n"),
            &[
                "place 0 pose: the robot cannot get from the start to the place `Bed`: the door of room `east` at (5.00, 3.00) is closed in the map",
            ],
        ),
        (
            GAP.to_string() + "[[object]]\nname = \"box\"\ncircle = [8.0, 3.0, 0.3]\nmapped = false\n",
            &["place 0 pose: the object `box`, which is not in the map, stands where the place `Bed` is"],
        ),
        (
            GAP.to_string() + "[[object]]\nname = \"shelf\"\nrect = [7.9, 4.2, 9.8, 5.8]\n" + item,
            &["item 0 at: the robot cannot get the item `cup` at (9.70, 5.70)"],
        ),
        (
            GAP.to_string() + "[[person]]\npath = [[2.0, 3.0], [5.0, 1.0]]\nspeed = 1\n",
            &["person 0 path: a person walks to (5.00, 1.00), inside a wall"],
        ),
        (
            format!("{GAP}[[door]]\nroom = \"east\"\nat = [9.9, 3.0]\nwidth = 0.9\naxis = \"y\"\n"),
            &[
                "top size: the world ends in open floor along 0.8 m of its edge, the longest stretch from (10.00, 2.60) to",
                "door 0 at: the door of room `east` at (9.90, 3.00) leads nowhere",
            ],
        ),
    ] {
        let found = concerns(&building(&between));
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.starts_with(expected), "{found}\nshould begin with {expected}");
        }
    }
}

#[test]
fn why_the_robot_does_not_fit_is_what_is_nearest() {
    use crate::occupancy::{Cell, OccupancyGrid};
    // Floor of 4 × 4 m in a field that is not known, with a wall far off, and to the south the edge of the map.
    let mut map = OccupancyGrid::filled(Point::new(0.0, 0.0), 0.05, 160, 120, Cell::Unknown);
    for (column, row) in (0..80).flat_map(|column| (0..80).map(move |row| (column + 40, row))) {
        map.set(column, row, Cell::Free);
    }
    (0..80).for_each(|row| map.set(130, row, Cell::Occupied));
    let building = Building::new(World::from_map("field", map, 0.265).expect("there is room"));
    for (x, y, expected) in [
        (5.95, 2.0, "the robot does not fit: floor that the map does not know is 0.05 m away"),
        (6.3, 2.0, "the map knows no floor"),
        (4.0, 0.1, "the robot does not fit: the edge of the world is 0.10 m away"),
        (4.0, -2.0, "there is no floor: the world reaches from (0.00, 0.00) to (8.00, 6.00)"),
    ] {
        let why = building.topology.why_no_room(&building.planner, Point::new(x, y));
        assert!(why.starts_with(expected), "{why}\nshould begin with {expected}");
    }
}
