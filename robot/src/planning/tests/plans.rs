//! Topological plans in `dept`.

use super::*;

/// How many others, spread over a large building, a place of it is tried with.
const MOST_GOALS: usize = 30;

fn place_pairs(world: &World) -> Vec<(&Place, &Place)> {
    let step = world.places.len().div_ceil(MOST_GOALS).max(1);
    let goals = |from: usize| world.places.iter().skip(from % step).step_by(step);
    let pairs = world.places.iter().enumerate().flat_map(|(index, from)| goals(index).map(move |to| (from, to)));
    pairs.filter(|(from, to)| from.name != to.name).collect()
}

/// The built-in worlds whose maps differ.
fn buildings() -> impl Iterator<Item = Building> {
    let names = World::builtin_names().filter(|name| !name.starts_with("dept-") && !name.ends_with("-crowded"));
    names.map(|name| Building::new(World::builtin(name).expect("built in")))
}

#[test]
fn every_pair_of_places_of_every_world_has_a_plan_of_free_connected_targets() {
    for building in buildings() {
        for (index, (from, to)) in place_pairs(&building.world).into_iter().enumerate() {
            let plan = building.plan(from.pose_in_map, to).expect("a plan");
            let mut here = from.pose_in_map.point();
            for target in &plan.targets {
                let (point, world) = (target.point_in_frame, &building.world.name);
                let clear_m = building.planner.obstacle_distance_m(point);
                assert!(clear_m >= 0.3, "{world}: {} {}: {point} {clear_m}", from.name, to.name);
                // The planner has looked; a few are looked at again.
                if index % 7 == 0 {
                    assert!(building.planner.cost_to_go(point).path(here).is_some());
                }
                here = point;
            }
            let last = plan.targets.last().copied();
            assert_eq!(last, Some(Target::at(to.pose_in_map)), "the destination comes last");
            assert!(plan.targets[..plan.targets.len() - 1].iter().all(|target| target.heading_rad.is_none()));
        }
    }
}

#[test]
fn ways_cross_doors_orthogonally_and_enter_no_other_office() {
    for building in buildings() {
        let room_at = |point: Point| building.world.room_at(point).map(|room| room.name.as_str());
        // In a gallery the rooms are one behind the other.
        let has_corridor =
            building.world.regions.iter().any(|region| {
                region.mode == TravelMode::Hallway && building.world.room_at(region.rect.centre()).is_none()
            });
        for (from, to) in place_pairs(&building.world) {
            let plan = building.plan(from.pose_in_map, to).expect("a plan");
            let mut points = vec![from.pose_in_map.point()];
            points.extend(plan.targets.iter().map(|target| target.point_in_frame));
            let ends = [room_at(points[0]), room_at(points[points.len() - 1])];
            for leg in points.windows(2) {
                let (world, way) = (&building.world.name, leg[1] - leg[0]);
                if room_at(leg[0]) != room_at(leg[1]) {
                    let is_orthogonal = way.x.abs() < 1e-9 || way.y.abs() < 1e-9;
                    assert!(is_orthogonal, "{world}: {} {}: {leg:?}", from.name, to.name);
                }
                let room = room_at(leg[1]);
                let is_other = room.is_some() && !ends.contains(&room);
                assert!(!has_corridor || !is_other, "{world}: {} {}: {room:?}", from.name, to.name);
            }
        }
    }
}

#[test]
fn the_way_from_a_to_b_is_that_of_figure_12() {
    let building = Building::builtin("dept");
    let place = |name: &str| building.world.places.iter().find(|place| place.name.contains(name)).expect("a place");
    let plan = building.plan(place("desk").pose_in_map, place("wolfram")).expect("a plan");
    let rooms: Vec<Option<&str>> = plan
        .targets
        .iter()
        .map(|target| building.world.room_at(target.point_in_frame).map(|room| room.name.as_str()))
        .collect();
    assert_eq!((rooms[0], rooms[rooms.len() - 1]), (Some("A"), Some("B")));
    let modes: Vec<TravelMode> = plan.regions.iter().map(|region| region.mode).collect();
    use TravelMode::{Doorway, Hallway, Office};
    assert_eq!(modes, [Office, Doorway, Hallway, Doorway, Office]);
}

#[test]
fn a_robot_on_its_way_gets_no_target_behind_it() {
    let building = Building::builtin("dept");
    let goal = building.world.places.iter().find(|place| place.name.contains("wolfram")).expect("a place");
    let start = Pose::new(18.1, 12.0, 1.57);
    let plan = building.plan(start, goal).expect("a plan");
    assert!(plan.targets.iter().all(|target| target.point_in_frame.y > start.y_m), "{plan:?}");
}

#[test]
fn closed_doors_are_not_used() {
    let mut world = World::builtin("dept").expect("a built-in world");
    let goal = world.places.iter().find(|place| place.name.contains("wolfram")).cloned().expect("a place");
    for door in world.doors.iter_mut().filter(|door| door.room == "B") {
        door.mapped_open = false;
    }
    let building = Building::new(world);
    let planned = building.plan(building.world.start_in_map, &goal);
    assert!(planned.is_err_and(|unreachable| unreachable.reason.contains("room `B`")));
}

#[test]
fn a_robot_in_the_doorway_between_two_rooms_has_a_way_to_both() {
    let building = Building::new(World::builtin("gallery").expect("built in"));
    let door =
        building.world.doors.iter().find(|door| distance_m(door.at, Point::new(4.2, 8.2)) < 0.1).expect("a door");
    for (dx_m, dy_m) in [(0.0, 0.0), (0.05, -0.05), (-0.05, 0.05)] {
        let start = Pose::new(door.at.x + dx_m, door.at.y + dy_m, 0.0);
        for place in &building.world.places {
            let plan = building.plan(start, place);
            assert!(plan.is_ok(), "({dx_m}, {dy_m}) {}: {plan:?}", place.name);
        }
    }
}
