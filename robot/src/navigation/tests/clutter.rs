//! Collision avoidance alone, without a map, in random clutter.

use super::*;
use proptest::prelude::*;

/// An empty hall of 7 × 7 m, and what stands in it.
fn hall(clutter: &[(f64, f64, f64, bool)], seen_by: SeenBy) -> World {
    let text = "name = \"hall\"\nsize = [7.0, 7.0]\nstart = [3.5, 3.5, \"0deg\"]\n\
                [[wall]]\nline = [[0.1, 0.1], [6.9, 0.1], [6.9, 6.9], [0.1, 6.9], [0.1, 0.1]]\nthickness = 0.2\n";
    let mut world = World::parse(text, "hall.toml").expect("a world");
    let start = world.start_in_map.point();
    for &(x, y, half_m, is_round) in clutter {
        let centre = Point::new(x, y);
        let half = crate::geometry::Vector::repeat(half_m);
        let shape = if is_round {
            Shape::Circle { centre, radius_m: half_m }
        } else {
            Shape::Rect(Rect { min: centre - half, max: centre + half })
        };
        if distance_m(centre, start) > 0.4 + 1.5 * half_m {
            let name = format!("thing-{}", world.objects.len());
            world.objects.push(Object { name, shape, mapped: false, seen_by });
        }
    }
    world
}

#[derive(Clone, Copy, Debug)]
enum Sensors {
    Sonar,
    Laser,
    Both,
}

/// Drives from target to target for a minute; what it touched, and how far it got.
fn drive_about(world: World, sensors: Sensors, seed: u64) -> (crate::simulator::Contacts, f64) {
    let robot = if matches!(sensors, Sensors::Sonar) { "b21" } else { "b21-laser" };
    let simulator = SimulatorModel::new(Arc::new(world), SimulatorSettings::of(builtin(robot)));
    let mut state = simulator.start(seed);
    let mut stream = Stream::new(seed, "targets");
    let mut drive = LocalDrive::follow(Vec::new());
    let limits = DriveLimits::default();
    let sonars_on = !matches!(sensors, Sensors::Laser);
    let mut commands = Commands { sonars_on, ..Commands::default() };
    for step in 0..1200 {
        let percept = simulator.step(&mut state, &commands);
        if step % 200 == 0 {
            let target = Point::new(stream.uniform_in(-3.2, 3.2), stream.uniform_in(-3.2, 3.2));
            drive.task = DriveTask::Follow { path_in_odom: vec![target] };
        }
        let output = drive.step(&limits, &input(&simulator, &percept), 0.65);
        commands.translation_mps = output.velocity.translation_mps;
        commands.rotation_radps = output.velocity.rotation_radps;
    }
    (state.contacts(), state.distance_driven_m())
}

fn clutter() -> impl Strategy<Value = Vec<(f64, f64, f64, bool)>> {
    proptest::collection::vec((0.6..6.4f64, 0.6..6.4f64, 0.05..0.35f64, any::<bool>()), 0..14)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn nothing_the_sonars_hear_is_touched(things in clutter(), seed in 0u64..1000) {
        let (contacts, _) = drive_about(hall(&things, SeenBy { sonar: true, laser: false }), Sensors::Sonar, seed);
        prop_assert_eq!(contacts.caused, 0);
    }

    #[test]
    fn nothing_the_laser_sees_is_touched(things in clutter(), seed in 0u64..1000) {
        let (contacts, _) = drive_about(hall(&things, SeenBy { sonar: false, laser: true }), Sensors::Laser, seed);
        prop_assert_eq!(contacts.caused, 0);
    }

    #[test]
    fn what_one_of_two_sensors_misses_the_other_sees(things in clutter(), seed in 0u64..1000, sonar in any::<bool>()) {
        let seen_by = SeenBy { sonar, laser: !sonar };
        let (contacts, _) = drive_about(hall(&things, seen_by), Sensors::Both, seed);
        prop_assert_eq!(contacts.caused, 0);
    }
}

#[test]
fn an_empty_hall_is_driven_through() {
    for sensors in [Sensors::Sonar, Sensors::Laser, Sensors::Both] {
        let (contacts, way_m) = drive_about(hall(&[], SeenBy { sonar: true, laser: true }), sensors, 1);
        assert!(contacts.caused == 0 && way_m > 6.0, "{sensors:?}: {way_m}");
    }
}

#[test]
fn a_robot_boxed_in_stands_turning_and_gets_out_when_it_can() {
    // A pen with its opening behind the robot.
    let pen: Vec<(f64, f64, f64, bool)> = (-6..=6)
        .map(|step| f64::from(step) * 0.4)
        .map(|angle| (3.5 + 0.75 * libm::cos(angle), 3.5 + 0.75 * libm::sin(angle), 0.12, true))
        .collect();
    let (contacts, way_m) = drive_about(hall(&pen, SeenBy { sonar: true, laser: true }), Sensors::Sonar, 2);
    assert!(contacts.caused == 0 && way_m > 2.0, "{way_m}");
}

/// Else a robot that got stuck on one path would be stuck on the next before it has begun.
#[test]
fn what_held_the_robot_up_on_one_path_says_nothing_against_the_next() {
    let pen: Vec<(f64, f64, f64, bool)> = (0..16)
        .map(|step| f64::from(step) * std::f64::consts::PI / 8.0)
        .map(|angle| (3.5 + 0.75 * libm::cos(angle), 3.5 + 0.75 * libm::sin(angle), 0.16, true))
        .collect();
    let world = hall(&pen, SeenBy { sonar: true, laser: false });
    let simulator = SimulatorModel::new(Arc::new(world), SimulatorSettings::default());
    let mut state = simulator.start(1);
    let mut drive = LocalDrive::follow(vec![Point::new(3.0, 0.0)]);
    let mut commands = Commands { sonars_on: true, ..Commands::default() };
    let mut status = DriveStatus::Driving;
    for _ in 0..1200 {
        let percept = simulator.step(&mut state, &commands);
        let output = drive.step(&DriveLimits::default(), &input(&simulator, &percept), 0.3);
        (commands.translation_mps, commands.rotation_radps) =
            (output.velocity.translation_mps, output.velocity.rotation_radps);
        status = output.status;
    }
    assert_eq!(status, DriveStatus::Stuck);
    drive.task = DriveTask::Follow { path_in_odom: vec![Point::new(0.0, 3.0)] };
    drive.forget_being_held_up();
    let percept = simulator.step(&mut state, &commands);
    assert_eq!(drive.step(&DriveLimits::default(), &input(&simulator, &percept), 0.3).status, DriveStatus::Driving);
}

/// Nothing sees the thing that stands in the way: the bumper alone tells of it.
#[test]
fn what_the_robot_has_run_into_is_driven_around() {
    let mut world = hall(&[], SeenBy { sonar: true, laser: true });
    let shape = Shape::Rect(Rect { min: Point::new(3.4, 2.9), max: Point::new(3.6, 4.1) });
    let unseen = SeenBy { sonar: false, laser: false };
    world.objects.push(Object { name: "pane".to_owned(), shape, mapped: false, seen_by: unseen });
    world.start_in_map = Pose::new(1.5, 3.5, 0.0);
    let scene = Scene::new(world);
    for seed in 0..4 {
        let goal = Target::at(Pose::new(5.8, 3.5, 0.0));
        let outcome = drive(&scene, scene.world.start_in_map, vec![goal], seed, 0.0);
        assert_eq!(outcome.event, Some(NavigationEvent::Arrived), "seed {seed}: {outcome:?}");
        assert!((1..=4).contains(&outcome.contacts), "seed {seed}: {outcome:?}");
    }
}
