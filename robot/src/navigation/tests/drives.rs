//! Whole drives in the simulator.

use super::*;
use crate::obstacles::{ObstacleMemory, aligned};

#[test]
fn a_goal_behind_walls_is_unreachable() {
    let scene = Scene::new(World::builtin("corridor").expect("a built-in world"));
    let outside = Target::through(Point::new(-3.0, -3.0));
    let outcome = Journey::new(&scene, scene.simulator.start(1), vec![outside]).until_event();
    assert_eq!(outcome.event, Some(NavigationEvent::Unreachable));
}

#[test]
fn a_door_found_closed_is_reported_as_blocked() {
    let scene = Scene::dept();
    let mut state = scene.simulator.start(3);
    scene.simulator.close_door(&mut state, "B").expect("a door");
    let goal = scene.world.places.iter().find(|place| place.name.contains("wolfram")).expect("a place");
    let plan = scene.topology.plan(&scene.model.planner, state.true_pose(), goal, &[]).expect("a plan in the map");
    let outcome = Journey::new(&scene, state, plan.targets).until_event();
    assert_eq!(outcome.event, Some(NavigationEvent::Blocked), "{outcome:?}");
    assert_eq!(outcome.contacts, 0, "{outcome:?}");
}

/// Two halves with a passage of 1.2 m without a door, or without any wall between them.
#[test]
fn a_room_without_a_door_is_entered_where_no_wall_is() {
    const HALVES: &str = "name = \"w\"\nsize = [10.0, 6.0]\nstart = [2.0, 3.0, 0]\n\
        [[wall]]\nline = [[0.1, 0.1], [9.9, 0.1], [9.9, 5.9], [0.1, 5.9], [0.1, 0.1]]\nthickness = 0.2\n\
        [[room]]\nname = \"east\"\nrect = [5.1, 0.2, 9.8, 5.8]\n\
        [[place]]\nname = \"Bed\"\npose = [8.0, 3.0, 0]\nroom = \"east\"\n";
    const GAP: &str = "[[wall]]\nline = [[5.0, 0.1], [5.0, 2.4]]\n[[wall]]\nline = [[5.0, 3.6], [5.0, 5.9]]\n";
    for between in [GAP, ""] {
        let scene = Scene::new(World::parse(&format!("{HALVES}{between}"), "w.toml").expect("a world"));
        let (start, bed) = (scene.world.start_in_map, scene.world.place("bed").expect("a place"));
        let plan = scene.topology.plan(&scene.model.planner, start, bed, &[]).expect("a way");
        let outcome = drive(&scene, start, plan.targets, 1, 0.0);
        assert_eq!((outcome.event, outcome.contacts), (Some(NavigationEvent::Arrived), 0), "{outcome:?}");
    }
}

/// Between `armchair` and `shelf` 68 cm are left, and the cones of the sonars are wider than that.
#[test]
fn a_gap_the_robot_just_fits_through_is_driven_through() {
    let scene = Scene::new(World::builtin("flat").expect("a built-in world"));
    let goal = Target::at(scene.world.place("shelf-front").expect("a place").pose_in_map);
    let mut arrived = 0;
    for (x_m, y_m, heading_rad) in [(4.05, 7.0, 1.6), (3.0, 8.5, 0.0), (4.2, 8.3, 3.0), (2.0, 6.4, 0.5)] {
        for seed in 0..3 {
            let outcome = drive(&scene, Pose::new(x_m, y_m, heading_rad), vec![goal], seed, 0.25);
            assert_eq!(outcome.contacts, 0, "{outcome:?}");
            arrived += u32::from(outcome.event == Some(NavigationEvent::Arrived));
        }
    }
    assert!(arrived >= 10, "{arrived} of 12");
}

/// Replaces the state by its saved and reloaded copy at every step when `reloading`.
fn speeds_of_a_drive(scene: &Scene, reloading: bool) -> Vec<Velocity> {
    let mut state = scene.simulator.start(5);
    let goal = Target::at(Pose::new(17.0, 9.5, 2.0));
    let mut navigation = MappedNavigation::default();
    navigation.start(vec![goal], PATIENCE_S);
    let mut commands = Commands { sonars_on: true, ..Commands::default() };
    let mut velocity = Vec::new();
    for _ in 0..300 {
        if reloading {
            let bytes = postcard::to_allocvec(&navigation).expect("bytes");
            let reloaded: MappedNavigation = postcard::from_bytes(&bytes).expect("the state");
            assert_eq!(reloaded, navigation);
            navigation = reloaded;
        }
        let percept = scene.simulator.step(&mut state, &commands);
        let output =
            navigation.step(&scene.model, state.true_pose(), &input(&scene.simulator, &percept), TravelMode::Hallway);
        commands.translation_mps = output.velocity.translation_mps;
        commands.rotation_radps = output.velocity.rotation_radps;
        velocity.push(output.velocity);
    }
    velocity
}

#[test]
fn a_state_saved_and_reloaded_at_every_step_drives_the_same_way() {
    let scene = Scene::dept();
    let velocity = speeds_of_a_drive(&scene, false);
    assert!(velocity.iter().any(|velocity| velocity.translation_mps > 0.5));
    assert_eq!(velocity, speeds_of_a_drive(&scene, true));
}

#[test]
fn deleting_all_targets_stops_the_robot() {
    let scene = Scene::dept();
    let mut navigation = MappedNavigation::default();
    navigation.start(vec![Target::through(Point::new(10.0, 10.0))], PATIENCE_S);
    navigation.remove_all_targets();
    let input = NavigationInput {
        odometry_in_odom: Pose::default(),
        velocity: Velocity { translation_mps: 0.5, rotation_radps: 0.1 },
        sonar: None,
        laser: None,
        bumped: false,
    };
    let output = navigation.step(&scene.model, scene.world.start_in_map, &input, TravelMode::Hallway);
    assert_eq!(
        output,
        NavigationOutput { velocity: Velocity::default(), remaining_targets: 0, needs_sonars: false, event: None }
    );
}

fn drive_without_map(scene: &Scene, state: &mut SimulatorState, drive: &mut LocalDrive, steps: u32) -> DriveStatus {
    let mut commands = Commands { sonars_on: true, ..Commands::default() };
    let mut status = DriveStatus::Driving;
    for _ in 0..steps {
        let percept = scene.simulator.step(state, &commands);
        let output = drive.step(&scene.model.limits, &input(&scene.simulator, &percept), 0.4);
        commands.translation_mps = output.velocity.translation_mps;
        commands.rotation_radps = output.velocity.rotation_radps;
        status = output.status;
        if status == DriveStatus::Arrived {
            break;
        }
    }
    status
}

#[test]
fn a_path_in_odom_is_followed_to_its_end() {
    let scene = Scene::dept();
    let mut state = scene.simulator.start(2);
    let begin = state.true_pose();
    let mut drive = LocalDrive::follow(vec![Point::new(2.0, 0.0), Point::new(2.0, 1.0)]);
    assert_eq!(drive_without_map(&scene, &mut state, &mut drive, 1000), DriveStatus::Arrived);
    let end = state.true_pose().relative_to(begin);
    assert!(distance_m(end.point(), Point::new(2.0, 1.0)) < 0.3, "{end:?}");
}

#[test]
fn wandering_covers_ground_without_contact() {
    let scene = Scene::dept();
    for seed in 0..5 {
        let mut state = scene.simulator.start(seed);
        let mut drive = LocalDrive::wander(Stream::new(seed, "wander"));
        drive_without_map(&scene, &mut state, &mut drive, 2400);
        assert_eq!(state.contacts().caused, 0, "seed {seed}");
        assert!(state.distance_driven_m() > 15.0, "seed {seed}: {}", state.distance_driven_m());
    }
}

/// `dept` with unmapped boxes of 40 cm standing about.
fn furnished(seed: u64, boxes: usize) -> Scene {
    let plain = Scene::dept();
    let mut world = (*plain.world).clone();
    let mut stream = Stream::new(seed, "boxes");
    for index in 0..boxes {
        let at = plain.free_pose(&mut stream).point();
        let half = crate::geometry::Vector::repeat(0.2);
        world.objects.push(Object {
            name: format!("box-{index}"),
            shape: Shape::Rect(Rect { min: at - half, max: at + half }),
            mapped: false,
            seen_by: SeenBy { sonar: true, laser: true },
        });
    }
    Scene::new(world)
}

#[test]
fn drives_between_random_places_arrive_without_contact() {
    let scene = Scene::dept();
    for (name, noise_scale) in [("true pose", 0.0), ("10 cm, 3°", 1.0)] {
        let runs = drive_pairs(&scene, 0..30, noise_scale);
        report(name, &runs);
        for Run { goal, outcome, .. } in runs {
            assert_eq!(outcome.event, Some(NavigationEvent::Arrived), "{outcome:?}");
            assert_eq!(outcome.contacts, 0, "{outcome:?}");
            assert!(distance_m(outcome.end_in_map.point(), goal.point()) < 0.6);
        }
    }
}

#[test]
fn unmapped_boxes_are_driven_around() {
    let scene = furnished(0, 10);
    let runs = drive_pairs(&scene, 0..10, 0.0);
    report("boxes", &runs);
    for Run { outcome, .. } in runs {
        assert_eq!(outcome.event, Some(NavigationEvent::Arrived), "{outcome:?}");
        assert_eq!(outcome.contacts, 0, "{outcome:?}");
    }
}

#[test]
fn a_shifted_estimate_before_a_door_is_brought_back() {
    let scene = Scene::dept();
    let mut state = scene.simulator.start(4);
    scene.simulator.teleport(&mut state, Pose::new(8.9, 6.9, 1.57)).expect("a free pose");
    let mut memory = ObstacleMemory::default();
    let mut odometry_in_odom = Pose::default();
    let truth = state.true_pose();
    let wrong = Pose::new(truth.x_m, truth.y_m - 0.15, truth.heading_rad);
    for _ in 0..10 {
        let percept = scene.simulator.step(&mut state, &Commands { sonars_on: true, ..Commands::default() });
        odometry_in_odom = percept.odometry_in_odom;
        let odom_in_map = wrong.compose(odometry_in_odom.inverse());
        let off_map_m = |point_in_odom| scene.model.planner.off_obstacle_m(odom_in_map.transform(point_in_odom));
        memory.update(odometry_in_odom, input(&scene.simulator, &percept).sonar, None, 0.05, off_map_m);
    }
    let found = aligned(&scene.model.planner, &memory, odometry_in_odom, wrong);
    assert!(found.distance_m(truth) < 0.75 * wrong.distance_m(truth), "{found:?} {truth:?}");
    let blind = ObstacleMemory::default();
    assert_eq!(aligned(&scene.model.planner, &blind, odometry_in_odom, truth), truth);
}
