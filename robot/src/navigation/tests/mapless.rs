//! Whole drives of a robot that has no map.

use super::*;

/// A robot that is to go to a point given from where it stands.
struct Stranger<'s> {
    scene: &'s Scene,
    state: SimulatorState,
    navigation: MaplessNavigation,
    commands: Commands,
}

const LATEST_US: u64 = 1_200_000_000;

impl<'s> Stranger<'s> {
    fn new(scene: &'s Scene, start: Pose, goal: Point, seed: u64) -> Self {
        Self::with(RangeSensor::Sonar, scene, start, goal, seed)
    }

    fn with(grain: RangeSensor, scene: &'s Scene, start: Pose, goal: Point, seed: u64) -> Self {
        let mut state = scene.simulator.start(seed);
        scene.simulator.teleport(&mut state, start).expect("a free start");
        let mut navigation = MaplessNavigation::new(grain);
        navigation.start(vec![Target::through(start.inverse().transform(goal))], PATIENCE_S);
        Self { scene, state, navigation, commands: Commands { sonars_on: true, ..Commands::default() } }
    }

    fn step(&mut self) -> Option<NavigationEvent> {
        let percept = self.scene.simulator.step(&mut self.state, &self.commands);
        let output = self.navigation.step(&self.scene.model.limits, &input(&self.scene.simulator, &percept), 0.65);
        self.commands.translation_mps = output.velocity.translation_mps;
        self.commands.rotation_radps = output.velocity.rotation_radps;
        output.event
    }

    fn until_event(&mut self) -> Outcome {
        let mut event = None;
        while event.is_none() && self.state.time_us < LATEST_US {
            event = self.step();
        }
        self.outcome(event)
    }

    fn outcome(&self, event: Option<NavigationEvent>) -> Outcome {
        Outcome {
            event,
            time_s: self.state.time_us as f64 * 1e-6,
            way_m: self.state.distance_driven_m(),
            contacts: self.state.contacts().caused + self.state.contacts().unseen,
            end_in_map: self.state.true_pose(),
        }
    }
}

/// Thirty random drives in three buildings. What the odometry is off by is no fault of the navigation:
/// the goal is where the odometry has it.
#[test]
fn random_points_of_unknown_buildings_are_reached() {
    for name in ["small-office", "dept", "lab"] {
        let mut scene = Scene::new(World::builtin(name).expect("a built-in world"));
        scene.simulator = SimulatorModel::new(scene.world.clone(), SimulatorSettings::of(without_drift("b21")));
        let mut runs = Vec::new();
        for pair in 0..10 {
            let mut stream = Stream::new(pair, "pair");
            let (start, goal) = (scene.unobstructed_pose(&mut stream), scene.unobstructed_pose(&mut stream));
            let path = scene.shortest.cost_to_go(goal.point()).path(start.point()).expect("a way");
            let outcome = Stranger::new(&scene, start, goal.point(), pair).until_event();
            runs.push(Run { start, goal, optimum_m: path_length_m(&path), outcome });
        }
        report(name, &runs);
        for Run { goal, outcome, .. } in runs {
            assert_eq!((outcome.event, outcome.contacts), (Some(NavigationEvent::Arrived), 0), "{outcome:?}");
            assert!(distance_m(outcome.end_in_map.point(), goal.point()) < 0.35, "{outcome:?} {goal:?}");
        }
    }
}

fn without_drift(robot: &str) -> RobotDescription {
    RobotDescription { odometry: OdometryDrift::NONE, ..builtin(robot) }
}

/// A hall with walls in it, and the robot at (3, 5), looking along x.
fn hall_with(walls: &str) -> Scene {
    let text = format!(
        "name = \"hall\"\nsize = [14.0, 10.0]\nstart = [3.0, 5.0, \"0deg\"]\n\
         [[wall]]\nline = [[0.1, 0.1], [13.9, 0.1], [13.9, 9.9], [0.1, 9.9], [0.1, 0.1]]\n{walls}"
    );
    Scene::new(World::parse(&text, "hall.toml").expect("a world"))
}

/// Deeper than the obstacle memory reaches, and longer to drive out of than it lasts.
const DEAD_END: &str = "[[wall]]\nline = [[4.0, 3.5], [9.0, 3.5], [9.0, 6.5], [4.0, 6.5]]\n";

#[test]
fn a_dead_end_is_remembered_and_left() {
    let scene = hall_with(DEAD_END);
    for seed in 0..4 {
        let goal = Point::new(11.5, 5.0);
        let mut robot = Stranger::new(&scene, scene.world.start_in_map, goal, seed);
        let mut farthest_in_m = 0.0_f64;
        let mut event = None;
        while event.is_none() && robot.state.time_us < LATEST_US {
            event = robot.step();
            let here = robot.state.true_pose();
            let is_inside = (4.0..9.0).contains(&here.x_m) && (3.5..6.5).contains(&here.y_m);
            farthest_in_m = farthest_in_m.max(if is_inside { here.x_m } else { 0.0 });
        }
        let outcome = robot.outcome(event);
        assert_eq!((outcome.event, outcome.contacts), (Some(NavigationEvent::Arrived), 0), "seed {seed}: {outcome:?}");
        assert!(farthest_in_m > 6.0, "seed {seed}: it went in, to {farthest_in_m}");
        let off_m = distance_m(outcome.end_in_map.point(), goal);
        assert!(off_m < 0.06 * outcome.way_m, "seed {seed}: no farther than the odometry drifts: {outcome:?}");
    }
}

#[test]
fn a_goal_inside_a_wall_or_behind_closed_walls_is_a_failure() {
    let closed = "[[wall]]\nline = [[8.0, 3.0], [11.0, 3.0], [11.0, 7.0], [8.0, 7.0], [8.0, 3.0]]\nthickness = 0.8\n";
    let mut scene = hall_with(closed);
    scene.simulator = SimulatorModel::new(scene.world.clone(), SimulatorSettings::of(without_drift("b21")));
    for goal in [Point::new(8.0, 5.0), Point::new(9.5, 5.0), Point::new(20.0, 5.0)] {
        let outcome = Stranger::new(&scene, scene.world.start_in_map, goal, 1).until_event();
        let has_failed = matches!(outcome.event, Some(NavigationEvent::Unreachable | NavigationEvent::Blocked));
        assert!(has_failed && outcome.contacts == 0, "{goal}: {outcome:?}");
    }
}

/// What stands before a goal at hand walks on, or it is a failure: nobody looks for a way through the whole building.
#[test]
fn a_goal_at_hand_is_not_gone_to_by_a_long_way() {
    let mut scene = hall_with("[[wall]]\nline = [[6.0, 0.1], [6.0, 8.0]]\nthickness = 0.2\n");
    scene.simulator = SimulatorModel::new(scene.world.clone(), SimulatorSettings::of(without_drift("b21")));
    let (start, goal) = (Pose::new(4.5, 2.0, 0.0), Point::new(7.5, 2.0));
    let by_any_way = Stranger::new(&scene, start, goal, 1).until_event();
    assert!(by_any_way.event == Some(NavigationEvent::Arrived) && by_any_way.way_m > 12.0, "{by_any_way:?}");
    let mut robot = Stranger::new(&scene, start, goal, 1);
    let target = Target::through(start.inverse().transform(goal));
    robot.navigation.start_nearby(target, PATIENCE_S, distance_m(start.point(), goal) + 4.0);
    let (mut event, mut farthest_m) = (None, 0.0_f64);
    while event.is_none() && robot.state.time_us < LATEST_US {
        event = robot.step();
        farthest_m = farthest_m.max(robot.state.true_pose().distance_m(start));
    }
    let outcome = robot.outcome(event);
    assert_eq!((outcome.event, outcome.contacts), (Some(NavigationEvent::Blocked), 0), "{outcome:?}");
    assert!(farthest_m < 3.5, "it stays where it waits: {farthest_m}");
}

#[test]
fn a_laser_alone_finds_the_way_as_well() {
    let mut scene = hall_with(DEAD_END);
    let settings = SimulatorSettings::of(without_drift("b21-laser"));
    scene.simulator = SimulatorModel::new(scene.world.clone(), settings);
    let mut robot = Stranger::with(RangeSensor::Laser, &scene, scene.world.start_in_map, Point::new(11.5, 5.0), 1);
    robot.commands.sonars_on = false;
    let outcome = robot.until_event();
    assert_eq!((outcome.event, outcome.contacts), (Some(NavigationEvent::Arrived), 0), "{outcome:?}");
}

/// The robot is 53 cm wide, a reading off by 1 cm.
#[test]
fn a_laser_finds_through_a_gap_of_sixty_centimetres() {
    let mut scene = hall_with(
        "[[wall]]\nline = [[6.0, 0.1], [6.0, 5.1]]\nthickness = 0.2\n\
         [[wall]]\nline = [[6.0, 5.9], [6.0, 9.9]]\nthickness = 0.2\n",
    );
    let mut robot = without_drift("b21-laser");
    robot.laser.as_mut().expect("it has one").noise_m = 0.01;
    scene.simulator = SimulatorModel::new(scene.world.clone(), SimulatorSettings::of(robot));
    for seed in 0..4 {
        let mut robot =
            Stranger::with(RangeSensor::Laser, &scene, scene.world.start_in_map, Point::new(9.0, 5.0), seed);
        robot.commands.sonars_on = false;
        let outcome = robot.until_event();
        assert_eq!((outcome.event, outcome.contacts), (Some(NavigationEvent::Arrived), 0), "seed {seed}: {outcome:?}");
        assert!(outcome.time_s < 20.0, "seed {seed}: {outcome:?}");
    }
}

#[test]
fn saved_and_reloaded_on_the_way_it_drives_the_same_way() {
    let scene = hall_with(DEAD_END);
    let mut robot = Stranger::new(&scene, scene.world.start_in_map, Point::new(11.5, 5.0), 5);
    for step in 0..1200 {
        if step % 97 == 0 {
            let bytes = postcard::to_allocvec(&robot.navigation).expect("bytes");
            let reloaded: MaplessNavigation = postcard::from_bytes(&bytes).expect("the state");
            assert_eq!(reloaded, robot.navigation);
            let (state, commands) = (robot.state.clone(), robot.commands.clone());
            let mut other = Stranger { scene: &scene, state, navigation: reloaded, commands };
            for _ in 0..60 {
                assert_eq!(other.step(), robot.step());
            }
            assert_eq!(other.state, robot.state, "step {step}");
        }
        robot.step();
    }
}
