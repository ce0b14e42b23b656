//! Whole drives in the simulator.

use super::dynamic_window::{WindowInput, best_speeds};
use super::*;
use crate::geometry::{Point, Pose, distance_m};
use crate::random::Stream;
use crate::simulator::{Commands, SimulatorModel, SimulatorSettings, SimulatorState};
use crate::world::{Object, Place, Rect, SeenBy, Shape, TravelMode, World};
use std::sync::Arc;

const DEBUG: bool = false;

struct Scene {
    world: Arc<World>,
    simulator: SimulatorModel,
    topology: TopologicalModel,
    model: NavigationModel,
    /// What really stands there, at the price of length alone: for the shortest ways there are.
    shortest: PlannerModel,
    /// From where the start of the world can be reached.
    reachable: ValueField,
}

impl Scene {
    fn new(world: World) -> Self {
        let world = Arc::new(world);
        let map = world.map(0.1);
        let mut all_mapped = (*world).clone();
        all_mapped.objects.iter_mut().for_each(|object| object.mapped = true);
        let real_map = all_mapped.map(0.05);
        let planner = PlannerModel::new(&map, PlannerParameters::default());
        let length_only =
            PlannerParameters { robot_radius_m: 0.3, closeness_weight: 0.0, ..PlannerParameters::default() };
        let shortest = PlannerModel::new(&real_map, length_only);
        Self {
            reachable: shortest.value_field(world.start_in_map.point()),
            shortest,
            simulator: SimulatorModel::new(world.clone(), SimulatorSettings::default()),
            topology: TopologicalModel::new(&world),
            model: NavigationModel { planner, limits: DriveLimits::default() },
            world,
        }
    }

    fn dept() -> Self {
        Self::new(World::builtin("dept").expect("a built-in world"))
    }

    /// A free pose where nothing unmapped stands either.
    fn unobstructed_pose(&self, stream: &mut Stream) -> Pose {
        let state = self.simulator.start(0);
        loop {
            let pose = self.free_pose(stream);
            if self.simulator.in_the_way(&state, pose.point(), 0.45).is_none() {
                return pose;
            }
        }
    }

    fn mode_at(&self, point: Point) -> TravelMode {
        self.topology.region_at(point).map_or(TravelMode::Office, |region| region.mode)
    }

    /// A pose somewhere with room to stand, from which the start of the world can be reached.
    fn free_pose(&self, stream: &mut Stream) -> Pose {
        loop {
            let pose = Pose::new(
                stream.uniform_in(0.0, self.world.size_m.x),
                stream.uniform_in(0.0, self.world.size_m.y),
                stream.uniform_in(-3.1, 3.1),
            );
            let has_room = self.model.planner.obstacle_distance_m(pose.point()) > 0.4;
            if has_room && self.reachable.cost_m(pose.point()).is_some() {
                return pose;
            }
        }
    }
}

/// An error of the estimate that wanders slowly: 10 cm and 3° at scale 1.
struct PoseNoise {
    scale: f64,
    error: [f64; 3],
    stream: Stream,
}

impl PoseNoise {
    fn step(&mut self, robot_in_map: Pose) -> Pose {
        const KEPT: f64 = 0.98;
        let fresh = (1.0 - KEPT * KEPT).sqrt();
        for (error, sigma) in self.error.iter_mut().zip([0.1, 0.1, 3.0_f64.to_radians()]) {
            *error = KEPT * *error + fresh * sigma * self.scale * self.stream.normal();
        }
        Pose::new(
            robot_in_map.x_m + self.error[0],
            robot_in_map.y_m + self.error[1],
            robot_in_map.heading_rad + self.error[2],
        )
    }
}

#[derive(Debug)]
struct Outcome {
    event: Option<NavigationEvent>,
    time_s: f64,
    way_m: f64,
    contacts: u32,
    end_in_map: Pose,
}

fn drive(scene: &Scene, start: Pose, targets: Vec<Target>, seed: u64, noise_scale: f64) -> Outcome {
    let mut state = scene.simulator.start(seed);
    scene.simulator.teleport(&mut state, start).expect("a free start");
    let noise = PoseNoise { scale: noise_scale, error: [0.0; 3], stream: Stream::new(seed, "pose noise") };
    drive_on(scene, &mut state, targets, noise)
}

fn drive_on(scene: &Scene, state: &mut SimulatorState, targets: Vec<Target>, mut noise: PoseNoise) -> Outcome {
    let mut navigation = Navigation::default();
    navigation.start(targets);
    let mut commands = Commands { sonars_on: true, ..Commands::default() };
    let begin_us = state.time_us;
    let mut event = None;
    while state.time_us < begin_us + 400_000_000 {
        let percept = scene.simulator.step(state, &commands);
        let estimated_in_map = noise.step(state.true_pose());
        let mode = scene.mode_at(estimated_in_map.point());
        let input = NavigationInput {
            odometry_in_odom: percept.odometry_in_odom,
            speeds: Speeds { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps },
            sonar_m: percept.sonar_m.as_ref(),
            bumped: percept.bumped,
        };
        let output = navigation.step(&scene.model, estimated_in_map, &input, mode);
        commands = Commands {
            translation_mps: output.speeds.translation_mps,
            rotation_radps: output.speeds.rotation_radps,
            sonars_on: mode != TravelMode::Doorway || output.needs_sonars,
            ..Commands::default()
        };
        if DEBUG && state.time_us % 500_000 == 0 {
            println!(
                "{:.1} {:?} {:?} {:?} {:?}",
                state.time_us as f64 * 1e-6,
                state.true_pose(),
                output,
                mode,
                navigation.debug()
            );
        }
        if output.event.is_some_and(|event| event != NavigationEvent::TargetReached) {
            event = output.event;
            break;
        }
    }
    Outcome {
        event,
        time_s: (state.time_us - begin_us) as f64 * 1e-6,
        way_m: state.distance_driven_m(),
        contacts: state.contacts().caused + state.contacts().unseen,
        end_in_map: state.true_pose(),
    }
}

struct Run {
    start: Pose,
    goal: Pose,
    optimum_m: f64,
    outcome: Outcome,
}

/// Drives between random places and free points, where there really is a way.
fn drive_pairs(scene: &Scene, pairs: std::ops::Range<u64>, noise_scale: f64) -> Vec<Run> {
    pairs.filter_map(|pair| drive_pair(scene, pair, noise_scale)).collect()
}

fn drive_pair(scene: &Scene, pair: u64, noise_scale: f64) -> Option<Run> {
    let mut stream = Stream::new(pair, "pair");
    let start = scene.unobstructed_pose(&mut stream);
    let places = &scene.world.places;
    let to_place = stream.chance(0.5);
    let goal =
        if to_place { places[stream.index(places.len())].pose_in_map } else { scene.unobstructed_pose(&mut stream) };
    let path = scene.shortest.value_field(goal.point()).path(start.point())?;
    let place = Place { name: "goal".to_owned(), pose_in_map: goal, room: None };
    let plan = scene.topology.plan(&scene.model.planner, start, &place).expect("a plan");
    let outcome = drive(scene, start, plan.targets, pair, noise_scale);
    Some(Run { start, goal, optimum_m: path_length_m(&path), outcome })
}

fn report(name: &str, runs: &[Run]) {
    let arrived = runs.iter().filter(|run| run.outcome.event == Some(NavigationEvent::Arrived)).count();
    let contacts: u32 = runs.iter().map(|run| run.outcome.contacts).sum();
    let sum = |value: fn(&Run) -> f64| runs.iter().map(value).sum::<f64>();
    let way_m = sum(|run| run.outcome.way_m);
    println!(
        "{name}: {arrived}/{} arrived, {contacts} contacts, {:.2} m/s, way {:.3} of the optimum",
        runs.len(),
        way_m / sum(|run| run.outcome.time_s),
        way_m / sum(|run| run.optimum_m)
    );
    for run in runs {
        if run.outcome.event != Some(NavigationEvent::Arrived) || run.outcome.contacts > 0 {
            println!("  {:?} {:?} {:?}", run.start, run.goal, run.outcome);
        }
    }
}

fn place_pairs(world: &World) -> Vec<(&Place, &Place)> {
    let pairs = world.places.iter().flat_map(|from| world.places.iter().map(move |to| (from, to)));
    pairs.filter(|(from, to)| from.name != to.name).collect()
}

#[test]
fn every_pair_of_places_has_a_plan_of_free_connected_targets() {
    let scene = Scene::dept();
    for (from, to) in place_pairs(&scene.world) {
        let plan = scene.topology.plan(&scene.model.planner, from.pose_in_map, to).expect("a plan");
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
        let plan = scene.topology.plan(&scene.model.planner, from.pose_in_map, to).expect("a plan");
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
    let plan = scene.topology.plan(&scene.model.planner, place("desk").pose_in_map, place("wolfram")).expect("a plan");
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
    let plan = scene.topology.plan(&scene.model.planner, start, goal).expect("a plan");
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
    let planned = scene.topology.plan(&scene.model.planner, scene.world.start_in_map, &goal);
    assert!(planned.is_err_and(|unreachable| unreachable.reason.contains("room B")));
}

#[test]
fn a_goal_behind_walls_is_unreachable() {
    let scene = Scene::new(World::builtin("corridor").expect("a built-in world"));
    let mut state = scene.simulator.start(1);
    let noise = PoseNoise { scale: 0.0, error: [0.0; 3], stream: Stream::new(1, "pose noise") };
    let outside = Target::through(Point::new(-3.0, -3.0));
    let outcome = drive_on(&scene, &mut state, vec![outside], noise);
    assert_eq!(outcome.event, Some(NavigationEvent::Unreachable));
}

#[test]
fn a_door_found_closed_is_reported_as_blocked() {
    let scene = Scene::dept();
    let mut state = scene.simulator.start(3);
    scene.simulator.close_door(&mut state, "B").expect("a door");
    let goal = scene.world.places.iter().find(|place| place.name.contains("wolfram")).expect("a place");
    let start = state.true_pose();
    let plan = scene.topology.plan(&scene.model.planner, start, goal).expect("a plan in the map");
    let noise = PoseNoise { scale: 0.0, error: [0.0; 3], stream: Stream::new(3, "pose noise") };
    let outcome = drive_on(&scene, &mut state, plan.targets, noise);
    assert_eq!(outcome.event, Some(NavigationEvent::Blocked), "{outcome:?}");
    assert_eq!(outcome.contacts, 0, "{outcome:?}");
}

/// Replaces the state by its saved and reloaded copy at every step when `reloading`.
fn speeds_of_a_drive(scene: &Scene, reloading: bool) -> Vec<Speeds> {
    let mut state = scene.simulator.start(5);
    let goal = Target::at(Pose::new(17.0, 9.5, 2.0));
    let mut navigation = Navigation::default();
    navigation.start(vec![goal]);
    let mut commands = Commands { sonars_on: true, ..Commands::default() };
    let mut speeds = Vec::new();
    for _ in 0..300 {
        if reloading {
            let bytes = postcard::to_allocvec(&navigation).expect("bytes");
            let reloaded: Navigation = postcard::from_bytes(&bytes).expect("the state");
            assert_eq!(reloaded, navigation);
            navigation = reloaded;
        }
        let percept = scene.simulator.step(&mut state, &commands);
        let input = NavigationInput {
            odometry_in_odom: percept.odometry_in_odom,
            speeds: Speeds { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps },
            sonar_m: percept.sonar_m.as_ref(),
            bumped: percept.bumped,
        };
        let output = navigation.step(&scene.model, state.true_pose(), &input, TravelMode::Hallway);
        commands.translation_mps = output.speeds.translation_mps;
        commands.rotation_radps = output.speeds.rotation_radps;
        speeds.push(output.speeds);
    }
    speeds
}

#[test]
fn a_state_saved_and_reloaded_at_every_step_drives_the_same_way() {
    let scene = Scene::dept();
    let speeds = speeds_of_a_drive(&scene, false);
    assert!(speeds.iter().any(|speeds| speeds.translation_mps > 0.5));
    assert_eq!(speeds, speeds_of_a_drive(&scene, true));
}

#[test]
fn deleting_all_targets_stops_the_robot() {
    let scene = Scene::dept();
    let mut navigation = Navigation::default();
    navigation.start(vec![Target::through(Point::new(10.0, 10.0))]);
    navigation.remove_all_targets();
    let input = NavigationInput {
        odometry_in_odom: Pose::default(),
        speeds: Speeds { translation_mps: 0.5, rotation_radps: 0.1 },
        sonar_m: None,
        bumped: false,
    };
    let output = navigation.step(&scene.model, scene.world.start_in_map, &input, TravelMode::Hallway);
    assert_eq!(
        output,
        NavigationOutput { speeds: Speeds::default(), remaining_targets: 0, needs_sonars: false, event: None }
    );
}

fn drive_without_map(scene: &Scene, state: &mut SimulatorState, drive: &mut Drive, steps: u32) -> DriveStatus {
    let mut commands = Commands { sonars_on: true, ..Commands::default() };
    let mut status = DriveStatus::Driving;
    for _ in 0..steps {
        let percept = scene.simulator.step(state, &commands);
        let input = NavigationInput {
            odometry_in_odom: percept.odometry_in_odom,
            speeds: Speeds { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps },
            sonar_m: percept.sonar_m.as_ref(),
            bumped: percept.bumped,
        };
        let output = drive.step(&scene.model.limits, &input, 0.4);
        commands.translation_mps = output.speeds.translation_mps;
        commands.rotation_radps = output.speeds.rotation_radps;
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
    let mut drive = Drive::follow(vec![Point::new(2.0, 0.0), Point::new(2.0, 1.0)]);
    assert_eq!(drive_without_map(&scene, &mut state, &mut drive, 1000), DriveStatus::Arrived);
    let end = state.true_pose().relative_to(begin);
    assert!(distance_m(end.point(), Point::new(2.0, 1.0)) < 0.3, "{end:?}");
}

#[test]
fn wandering_covers_ground_without_contact() {
    let scene = Scene::dept();
    for seed in 0..5 {
        let mut state = scene.simulator.start(seed);
        let mut drive = Drive::wander(Stream::new(seed, "wander"));
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
fn big() {
    let scene = Scene::dept();
    report("true pose", &drive_pairs(&scene, 0..200, 0.0));
    report("noise", &drive_pairs(&scene, 0..400, 1.0));
    for seed in 0..8 {
        let scene = furnished(seed, 10);
        report("boxes", &drive_pairs(&scene, 0..30, 0.0));
    }
    for seed in 0..4 {
        let scene = furnished(seed, 10);
        report("boxes, noise", &drive_pairs(&scene, 0..30, 1.0));
    }
}

#[test]
fn debug1() {
    let scene = furnished(5, 10);
    for object in scene.world.objects.iter().filter(|o| !o.mapped) {
        println!("{:?}", object.shape);
    }
    let start = Pose { x_m: 3.065741797930551, y_m: 15.071528396554692, heading_rad: -1.0235268741843258 };
    for pair in 0..30 {
        let run = drive_pair(&scene, pair, 0.0);
        if let Some(run) = run
            && run.start == start
        {
            println!("PAIR {pair} {:?}", run.outcome);
            break;
        }
    }
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
#[allow(clippy::disallowed_types)]
fn timing() {
    use std::time::Instant;
    let map =
        crate::occupancy::OccupancyGrid::filled(Point::new(0.0, 0.0), 0.1, 300, 300, crate::occupancy::Cell::Free);
    let model = PlannerModel::new(&map, PlannerParameters::default());
    let begin = Instant::now();
    for _ in 0..50 {
        std::hint::black_box(model.value_field(std::hint::black_box(Point::new(15.0, 15.0))));
    }
    println!("field 300x300 free {:?}", begin.elapsed() / 50);
    let mut map = map;
    for i in 0..600 {
        map.cells[(i * 7919 + i * i * 31) % 90000] = crate::occupancy::Cell::Occupied;
    }
    let begin = Instant::now();
    let model = PlannerModel::new(&map, PlannerParameters::default());
    println!("model {:?}", begin.elapsed());
    let begin = Instant::now();
    for _ in 0..50 {
        std::hint::black_box(model.value_field(std::hint::black_box(Point::new(15.0, 15.0))));
    }
    println!("field 300x300 cluttered {:?}", begin.elapsed() / 50);
    let scene = Scene::dept();
    let field = scene.model.planner.value_field(Point::new(17.0, 17.0));
    let begin = Instant::now();
    for _ in 0..50 {
        std::hint::black_box(scene.model.planner.value_field(std::hint::black_box(Point::new(17.0, 17.0))));
    }
    println!("field dept {:?}", begin.elapsed() / 50);
    let begin = Instant::now();
    for _ in 0..50 {
        std::hint::black_box(field.path(Point::new(3.4, 15.0)));
    }
    println!("path {:?}", begin.elapsed() / 50);
    let begin = Instant::now();
    for _ in 0..500 {
        std::hint::black_box(field.lookahead(Point::new(3.4, 15.0), 1.0));
    }
    println!("lookahead {:?}", begin.elapsed() / 500);
    let mut stream = Stream::new(3, "o");
    for count in [50, 150, 300] {
        let obstacles: Vec<Point> = (0..count)
            .map(|_| {
                Pose::new(0.0, 0.0, stream.uniform_in(-3.1, 3.1))
                    .transform(Point::new(stream.uniform_in(0.45, 2.0), 0.0))
            })
            .collect();
        let input = WindowInput {
            odometry_in_odom: Pose::default(),
            speeds: Speeds { translation_mps: 0.3, rotation_radps: 0.1 },
            obstacles_in_base: &obstacles,
            target_in_base: Point::new(1.0, 0.1),
            speed_limit_mps: 0.65,
            remaining_m: 9.0,
        };
        let begin = Instant::now();
        for _ in 0..500 {
            std::hint::black_box(best_speeds(&scene.model.limits, std::hint::black_box(&input)));
        }
        println!("window {count}: {:?}", begin.elapsed() / 500);
    }
    let mut memory = ObstacleMemory::default();
    let mut state = scene.simulator.start(1);
    let commands = Commands { sonars_on: true, translation_mps: 0.5, ..Commands::default() };
    let mut spent = std::time::Duration::ZERO;
    for _ in 0..400 {
        let percept = scene.simulator.step(&mut state, &commands);
        let begin = Instant::now();
        memory.update(percept.odometry_in_odom, percept.sonar_m.as_ref(), 5.0, 0.05);
        spent += begin.elapsed();
    }
    println!("memory {:?} {}", spent / 400, memory.points().len());
    let begin = Instant::now();
    for _ in 0..4000 {
        scene.simulator.step(&mut state, &Commands { sonars_on: true, ..Commands::default() });
    }
    println!("sim {:?}", begin.elapsed() / 4000);
}
