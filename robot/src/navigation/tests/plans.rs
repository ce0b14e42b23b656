//! Topological plans in `dept`.

use super::*;

fn place_pairs(world: &World) -> Vec<(&Place, &Place)> {
    let pairs = world.places.iter().flat_map(|from| world.places.iter().map(move |to| (from, to)));
    pairs.filter(|(from, to)| from.name != to.name).collect()
}

#[test]
fn every_pair_of_places_has_a_plan_of_free_connected_targets() {
    let scene = Scene::dept();
    for (from, to) in place_pairs(&scene.world) {
        let plan = scene.topology.plan(&scene.model.planner, from.pose_in_map, to, &[]).expect("a plan");
        let mut here = from.pose_in_map.point();
        for target in &plan.targets {
            let point = target.point_in_map;
            assert!(scene.model.planner.obstacle_distance_m(point) >= 0.3, "{} {}: {point}", from.name, to.name);
            assert!(scene.model.planner.value_field(point).path(here).is_some());
            here = point;
        }
        let last = plan.targets.last().copied();
        assert_eq!(last, Some(Target::at(to.pose_in_map)), "the destination comes last");
        assert!(plan.targets[..plan.targets.len() - 1].iter().all(|target| target.heading_rad.is_none()));
    }
}

#[test]
fn ways_cross_doors_orthogonally_and_enter_no_other_office() {
    let scene = Scene::dept();
    let room_at = |point: Point| scene.world.room_at(point).map(|room| room.name.as_str());
    for (from, to) in place_pairs(&scene.world) {
        let plan = scene.topology.plan(&scene.model.planner, from.pose_in_map, to, &[]).expect("a plan");
        let mut points = vec![from.pose_in_map.point()];
        points.extend(plan.targets.iter().map(|target| target.point_in_map));
        let ends = [room_at(points[0]), room_at(points[points.len() - 1])];
        for leg in points.windows(2) {
            if room_at(leg[0]) != room_at(leg[1]) {
                assert!((leg[1].x - leg[0].x).abs() < 1e-9, "the doors of dept are gone through along y");
            }
            let room = room_at(leg[1]);
            assert!(room.is_none() || ends.contains(&room), "{} {}: {room:?}", from.name, to.name);
        }
    }
}

#[test]
fn the_way_from_a_to_b_is_that_of_figure_12() {
    let scene = Scene::dept();
    let place = |name: &str| scene.world.places.iter().find(|place| place.name.contains(name)).expect("a place");
    let plan =
        scene.topology.plan(&scene.model.planner, place("desk").pose_in_map, place("wolfram"), &[]).expect("a plan");
    let rooms: Vec<Option<&str>> = plan
        .targets
        .iter()
        .map(|target| scene.world.room_at(target.point_in_map).map(|room| room.name.as_str()))
        .collect();
    assert_eq!((rooms[0], rooms[rooms.len() - 1]), (Some("A"), Some("B")));
    let modes: Vec<TravelMode> = plan.regions.iter().map(|region| region.mode).collect();
    use TravelMode::{Doorway, Hallway, Office};
    assert_eq!(modes, [Office, Doorway, Hallway, Doorway, Office]);
}

#[test]
fn a_robot_on_its_way_gets_no_target_behind_it() {
    let scene = Scene::dept();
    let goal = scene.world.places.iter().find(|place| place.name.contains("wolfram")).expect("a place");
    let start = Pose::new(18.1, 12.0, 1.57);
    let plan = scene.topology.plan(&scene.model.planner, start, goal, &[]).expect("a plan");
    assert!(plan.targets.iter().all(|target| target.point_in_map.y > start.y_m), "{plan:?}");
}

#[test]
fn closed_doors_are_not_used() {
    let mut world = World::builtin("dept").expect("a built-in world");
    let goal = world.places.iter().find(|place| place.name.contains("wolfram")).cloned().expect("a place");
    for door in world.doors.iter_mut().filter(|door| door.room == "B") {
        door.mapped_open = false;
    }
    let scene = Scene::new(world);
    let planned = scene.topology.plan(&scene.model.planner, scene.world.start_in_map, &goal, &[]);
    assert!(planned.is_err_and(|unreachable| unreachable.reason.contains("room B")));
}
