//! Plans and whole drives in the simulator.

mod clutter;
mod doors;
mod drives;
mod mapless;

use super::*;
use crate::avoidance::DriveLimits;
use crate::description::{OdometryDrift, RobotDescription};
use crate::geometry::{Point, Pose, Velocity, distance_m};
use crate::planning::{CostToGo, Inflation, NavigationPlan, PlannerModel, Target, TopologicalModel, path_length_m};
use crate::sensors::{LaserScan, RangeSensor, SonarScan};
use crate::simulator::{Commands, Percept, SimulatorModel, SimulatorSettings, SimulatorState};
use crate::world::{Object, Place, Rect, SeenBy, Shape, TravelMode, World};
use rpl_random::Stream;
use std::sync::Arc;

/// Of the robots in these tests.
const PATIENCE_S: f64 = 30.0;

struct Scene {
    world: Arc<World>,
    simulator: SimulatorModel,
    topology: TopologicalModel,
    model: NavigationModel,
    /// What really stands there, at the price of length alone: for the shortest ways there are.
    shortest: PlannerModel,
    /// From where the start of the world can be reached.
    reachable: CostToGo,
}

impl Scene {
    fn new(world: World) -> Self {
        let world = Arc::new(world);
        let mut all_mapped = (*world).clone();
        all_mapped.objects.iter_mut().for_each(|object| object.mapped = true);
        let real_map = all_mapped.map(0.05);
        let length_only = Inflation { closeness_weight: 0.0, ..Inflation::of_robot(0.3) };
        let shortest = PlannerModel::new(&real_map, length_only);
        let model = NavigationModel::new(&world, DriveLimits::default());
        Self {
            reachable: shortest.cost_to_go(world.start_in_map.point()),
            shortest,
            simulator: SimulatorModel::new(world.clone(), SimulatorSettings::default()),
            topology: TopologicalModel::new(&world, &model.planner),
            model,
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
    let mut journey = Journey::new(scene, state, targets);
    journey.noise = noise;
    journey.until_event()
}

/// A robot that navigates in the simulator, knowing its pose but for some noise.
struct Journey<'s> {
    scene: &'s Scene,
    state: SimulatorState,
    navigation: MappedNavigation,
    noise: PoseNoise,
    commands: Commands,
}

impl<'s> Journey<'s> {
    fn new(scene: &'s Scene, state: SimulatorState, targets: Vec<Target>) -> Self {
        let mut navigation = MappedNavigation::default();
        navigation.start(targets, PATIENCE_S);
        let noise = PoseNoise { scale: 0.0, error: [0.0; 3], stream: Stream::new(0, "pose noise") };
        let commands = Commands { sonars_on: true, ..Commands::default() };
        Self { scene, state, navigation, noise, commands }
    }

    fn step(&mut self) -> Option<NavigationEvent> {
        let percept = self.scene.simulator.step(&mut self.state, &self.commands);
        let estimated_in_map = self.noise.step(self.state.true_pose());
        let mode = self.scene.mode_at(estimated_in_map.point());
        let output =
            self.navigation.step(&self.scene.model, estimated_in_map, &input(&self.scene.simulator, &percept), mode);
        self.commands = Commands {
            translation_mps: output.velocity.translation_mps,
            rotation_radps: output.velocity.rotation_radps,
            sonars_on: mode != TravelMode::Doorway || output.needs_sonars,
            ..Commands::default()
        };
        output.event.filter(|&event| event != NavigationEvent::TargetReached)
    }

    fn until_event(&mut self) -> Outcome {
        let begin_us = self.state.time_us;
        let mut event = None;
        while event.is_none() && self.state.time_us < begin_us + 400_000_000 {
            event = self.step();
        }
        Outcome {
            event,
            time_s: (self.state.time_us - begin_us) as f64 * 1e-6,
            way_m: self.state.distance_driven_m(),
            contacts: self.state.contacts().caused + self.state.contacts().unseen,
            end_in_map: self.state.true_pose(),
        }
    }
}

fn builtin(robot: &str) -> RobotDescription {
    RobotDescription::clone(&RobotDescription::builtin(robot).expect("built in"))
}

fn input<'a>(simulator: &'a SimulatorModel, percept: &'a Percept) -> NavigationInput<'a> {
    let sonar = simulator.sensors.sonars.as_ref().zip(percept.sonar_m.as_deref());
    let laser = simulator.sensors.laser.as_ref().zip(percept.laser_m.as_deref());
    NavigationInput {
        odometry_in_odom: percept.odometry_in_odom,
        velocity: Velocity { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps },
        sonar: sonar.map(|(sonars, ranges_m)| SonarScan { sonars, ranges_m }),
        laser: laser.map(|(laser, ranges_m)| LaserScan { laser, ranges_m }),
        bumped: percept.bumped,
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
    let path = scene.shortest.cost_to_go(goal.point()).path(start.point())?;
    let place = Place { name: "goal".to_owned(), pose_in_map: goal, room: None, charges: false };
    let plan = scene.topology.plan(&scene.model.planner, start, &place, &[]).expect("a plan");
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
