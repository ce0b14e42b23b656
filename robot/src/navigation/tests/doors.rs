//! Doors that are found closed.

use super::*;

/// Two rooms with two doors between them; the map shows both open.
fn two_doors() -> Scene {
    let door = "[[door]]\nroom = \"west\"\nat = [5.0, 1.0]\nwidth = 0.9\naxis = \"y\"\nopen = true\n\n";
    let text = World::builtin_text("test-room").expect("a built-in world");
    let world = World::parse(&format!("{text}\n{door}"), "two-doors.toml").expect("a world");
    Scene::new(world)
}

fn plan_to(scene: &Scene, place: &str, from: Pose, closed_doors: &[usize]) -> NavigationPlan {
    let place = scene.world.place(place).expect("a place");
    scene.topology.plan(&scene.model.planner, from, place, closed_doors).expect("a plan")
}

fn goes_through(plan: &NavigationPlan, door_y: f64) -> bool {
    plan.targets.iter().any(|target| (target.point_in_frame.y - door_y).abs() < 0.01)
}

#[test]
fn a_door_found_closed_is_planned_around_and_remembered() {
    let scene = two_doors();
    for seed in 0..4 {
        let mut state = scene.simulator.start(seed);
        let plan = plan_to(&scene, "corner", state.true_pose(), &[]);
        assert!(goes_through(&plan, 3.0), "the nearer door: {plan:?}");
        scene.simulator.close_door(&mut state, "east").expect("a door");
        let mut journey = Journey::new(&scene, state, plan.targets);
        let outcome = journey.until_event();
        assert_eq!((outcome.event, outcome.contacts), (Some(NavigationEvent::Arrived), 0), "seed {seed}: {outcome:?}");
        let closed = journey.navigation.closed_doors();
        assert_eq!(closed, [0]);
        let back = plan_to(&scene, "table-side", journey.state.true_pose(), &closed);
        assert!(goes_through(&back, 1.0) && !goes_through(&back, 3.0), "{back:?}");
        journey.navigation.start(back.targets, PATIENCE_S);
        assert_eq!(journey.navigation.closed_doors(), [0], "a new task forgets no door");
    }
}

#[test]
fn a_closed_door_is_tried_if_there_is_no_other() {
    let scene = two_doors();
    let plan = plan_to(&scene, "corner", scene.world.start_in_map, &[0, 1]);
    assert_eq!(plan, plan_to(&scene, "corner", scene.world.start_in_map, &[]));
}

/// The robot comes to the door after nine seconds and gives up after forty.
#[test]
fn a_door_opened_while_the_robot_waits_is_gone_through() {
    let scene = Scene::new(World::builtin("test-room").expect("a built-in world"));
    for seed in 0..4 {
        let mut state = scene.simulator.start(seed);
        let plan = plan_to(&scene, "corner", state.true_pose(), &[]);
        scene.simulator.close_door(&mut state, "east").expect("a door");
        let mut journey = Journey::new(&scene, state, plan.targets);
        while journey.state.time_us < 22_000_000 {
            assert_eq!(journey.step(), None);
        }
        assert_eq!(journey.navigation.closed_doors(), [0]);
        scene.simulator.open_door(&mut journey.state, "east").expect("a door");
        let outcome = journey.until_event();
        assert_eq!((outcome.event, outcome.contacts), (Some(NavigationEvent::Arrived), 0), "seed {seed}: {outcome:?}");
        assert_eq!(journey.navigation.closed_doors(), [], "it was seen open");
    }
}

/// While it turns away from the leaf it still touches it, and must not take that for something new
/// wherever it looks.
#[test]
fn a_robot_that_a_door_was_shut_on_gets_away_from_it() {
    let scene = Scene::new(World::builtin("test-room").expect("a built-in world"));
    for seed in 0..4 {
        let mut journey = Journey::new(&scene, scene.simulator.start(seed), Vec::new());
        let plan = plan_to(&scene, "corner", journey.state.true_pose(), &[]);
        journey.navigation.start(plan.targets, PATIENCE_S);
        let door = scene.world.doors.iter().find(|door| door.room == "east").expect("a door").at;
        while (journey.state.true_pose().x_m - door.x).abs() > 0.32 {
            assert_eq!(journey.step(), None);
        }
        scene.simulator.close_door(&mut journey.state, "east").expect("nobody is in the door");
        for _ in 0..20 {
            journey.step();
        }
        assert!(journey.state.contacts().run_into == 1, "seed {seed}: {:?}", journey.state.contacts());
        let mut touched_s = 0.0;
        while scene.simulator.step(&mut journey.state.clone(), &Commands::default()).bumped {
            journey.step();
            touched_s += 0.05;
            assert!(touched_s < 15.0, "seed {seed}");
        }
    }
}

#[test]
fn a_door_twelve_centimetres_wider_than_the_robot_is_passed_without_a_touch() {
    let text = World::builtin_text("test-room").expect("a built-in world").replace("width = 0.9", "width = 0.65");
    let scene = Scene::new(World::parse(&text, "narrow.toml").expect("a world"));
    for seed in 0..6 {
        let state = scene.simulator.start(seed);
        let plan = plan_to(&scene, "corner", state.true_pose(), &[]);
        let mut journey = Journey::new(&scene, state, plan.targets);
        journey.noise.scale = 0.3;
        let outcome = journey.until_event();
        assert_eq!((outcome.event, outcome.contacts), (Some(NavigationEvent::Arrived), 0), "seed {seed}: {outcome:?}");
    }
}

#[test]
fn a_robot_that_gets_no_nearer_is_held_up_unless_a_closed_door_explains_it() {
    let scene = Scene::new(World::builtin("test-room").expect("a built-in world"));
    let begun = |is_closed: bool| {
        let mut state = scene.simulator.start(1);
        let plan = plan_to(&scene, "corner", state.true_pose(), &[]);
        if is_closed {
            scene.simulator.close_door(&mut state, "east").expect("a door");
        }
        Journey::new(&scene, state, plan.targets)
    };
    let mut before_door = begun(true);
    while before_door.step() != Some(NavigationEvent::Blocked) {
        assert!(!before_door.navigation.is_held_up(), "at {} s", before_door.state.time_us / 1_000_000);
    }
    let mut stopped = begun(false);
    let mut held_up_s = None;
    while held_up_s.is_none() && stopped.state.time_us < 20_000_000 {
        stopped.step();
        stopped.commands = Commands { sonars_on: true, ..Commands::default() };
        held_up_s = stopped.navigation.is_held_up().then_some(stopped.state.time_us / 1_000_000);
    }
    assert_eq!(held_up_s, Some(15));
}
