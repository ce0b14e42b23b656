//! Whole drives in the simulator.

use super::*;
use crate::geometry::{Point, Pose, distance_m};
use crate::random::Stream;
use crate::simulator::{Commands, SimulatorModel, SimulatorSettings, SimulatorState};
use crate::world::{Place, TravelMode, World};
use std::sync::Arc;

struct Scene {
    world: Arc<World>,
    simulator: SimulatorModel,
    topology: TopologicalModel,
    model: NavigationModel,
    /// Prices nothing but length: for the shortest ways there are.
    shortest: PlannerModel,
}

impl Scene {
    fn new(world: World) -> Self {
        let world = Arc::new(world);
        let map = world.map(0.1);
        let planner = PlannerModel::new(&map, PlannerParameters::default());
        let length_only = PlannerParameters { closeness_weight: 0.0, ..PlannerParameters::default() };
        Self {
            simulator: SimulatorModel::new(world.clone(), SimulatorSettings::default()),
            topology: TopologicalModel::new(&world),
            model: NavigationModel { planner, limits: DriveLimits::default() },
            shortest: PlannerModel::new(&map, length_only),
            world,
        }
    }

    fn dept() -> Self {
        Self::new(World::builtin("dept").expect("a built-in world"))
    }

    fn mode_at(&self, point: Point) -> TravelMode {
        self.topology.region_at(point).map_or(TravelMode::Office, |region| region.mode)
    }

    /// A pose somewhere with room to stand, from which the start of the world can be reached.
    fn free_pose(&self, stream: &mut Stream) -> Pose {
        let reachable = self.shortest.value_field(self.world.start_in_map.point());
        loop {
            let pose = Pose::new(
                stream.uniform_in(0.0, self.world.size_m.x),
                stream.uniform_in(0.0, self.world.size_m.y),
                stream.uniform_in(-3.1, 3.1),
            );
            let has_room = self.model.planner.obstacle_distance_m(pose.point()) > 0.4;
            if has_room && reachable.cost_m(pose.point()).is_some() {
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
            sonars_on: mode != TravelMode::Doorway,
            ..Commands::default()
        };
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

/// Drives between random places and free points.
fn drive_pairs(scene: &Scene, pairs: u64, noise_scale: f64) -> Vec<(Pose, Pose, f64, Outcome)> {
    let mut stream = Stream::new(1, "pairs");
    (0..pairs)
        .map(|pair| {
            let start = scene.free_pose(&mut stream);
            let goal = if stream.chance(0.5) {
                scene.world.places[stream.index(scene.world.places.len())].pose_in_map
            } else {
                scene.free_pose(&mut stream)
            };
            let place = Place { name: "goal".to_owned(), pose_in_map: goal, room: None };
            let plan = scene.topology.plan(&scene.model.planner, start, &place).expect("a plan");
            let path = scene.shortest.value_field(goal.point()).path(start.point()).expect("a way");
            (start, goal, path_length_m(&path), drive(scene, start, plan.targets, pair, noise_scale))
        })
        .collect()
}

fn report(name: &str, runs: &[(Pose, Pose, f64, Outcome)]) {
    let arrived = runs.iter().filter(|run| run.3.event == Some(NavigationEvent::Arrived)).count();
    let contacts: u32 = runs.iter().map(|run| run.3.contacts).sum();
    let (way_m, time_s) = runs.iter().fold((0.0, 0.0), |sum, run| (sum.0 + run.3.way_m, sum.1 + run.3.time_s));
    let optimum_m: f64 = runs.iter().map(|run| run.2).sum();
    println!(
        "{name}: {arrived}/{} arrived, {contacts} contacts, {:.2} m/s, way {:.3} of the optimum",
        runs.len(),
        way_m / time_s,
        way_m / optimum_m
    );
    for (index, (start, goal, _, outcome)) in runs.iter().enumerate() {
        if outcome.event != Some(NavigationEvent::Arrived) || outcome.contacts > 0 {
            println!("  {index}: {start:?} {goal:?} {outcome:?}");
        }
    }
}

#[test]
fn drives_between_random_places_arrive_without_contact() {
    let scene = Scene::dept();
    let runs = drive_pairs(&scene, 100, 0.0);
    report("true pose", &runs);
    let noisy = drive_pairs(&scene, 100, 1.0);
    report("10 cm, 3°", &noisy);
    for (_, goal, _, outcome) in runs.iter().chain(&noisy) {
        assert_eq!(outcome.event, Some(NavigationEvent::Arrived), "{outcome:?}");
        assert_eq!(outcome.contacts, 0, "{outcome:?}");
        assert!(distance_m(outcome.end_in_map.point(), goal.point()) < 0.5);
    }
}
