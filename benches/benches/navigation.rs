//! Navigation and simulation: the value of every cell, rays, decisions, steps, and whole missions.
//!
//! Each row checks the result of what it times. `dijkstra` and `iteration` are what textbooks do with
//! the same grid, compiled here.

use rpl_benches::{Question, Report, least_ms};
use rpl_lang::compile::NoFiles;
use rpl_mission::error::SiteError;
use rpl_mission::robot::Robot;
use rpl_mission::site::{Setup, Site};
use rpl_random::Stream;
use rpl_robot::avoidance::{CANDIDATES, DriveLimits, WindowInput, best_velocity, open_distance_m};
use rpl_robot::geometry::{Point, Pose, Velocity, distance_m};
use rpl_robot::navigation::{MappedNavigation, NavigationEvent, NavigationInput, NavigationModel};
use rpl_robot::obstacles::ObstacleMemory;
use rpl_robot::occupancy::{Cell, DistanceField, OccupancyGrid};
use rpl_robot::planning::{Inflation, PlannerModel, TopologicalModel};
use rpl_robot::sensors::SonarScan;
use rpl_robot::simulator::{Commands, SimulatorModel, SimulatorSettings, SimulatorState, drive_arc};
use rpl_robot::world::{TravelMode, World};
use rpl_runtime::run::system::Outcome;
use std::cell::RefCell;
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::hint::black_box;
use std::sync::Arc;

const RUNS: usize = 25;

/// 30 × 30 m: a corridor through the middle, rooms with doors on both sides, furniture in them.
fn department(resolution_m: f64) -> OccupancyGrid {
    let cells = (30.0 / resolution_m).round() as usize;
    let mut map = OccupancyGrid::filled(Point::new(0.0, 0.0), resolution_m, cells, cells, Cell::Free);
    let fill = |map: &mut OccupancyGrid, x: f64, y: f64, width: f64, height: f64| {
        let at = |m: f64| ((m / resolution_m).round() as usize).min(cells - 1);
        for row in at(y)..=at(y + height) {
            (at(x)..=at(x + width)).for_each(|column| map.set(column, row, Cell::Occupied));
        }
    };
    for edge in [0.0, 30.0] {
        fill(&mut map, 0.0, edge, 30.0, 0.0);
        fill(&mut map, edge, 0.0, 0.0, 30.0);
    }
    for room in 0..6 {
        let x = f64::from(room) * 5.0;
        for wall in [13.5, 16.0] {
            fill(&mut map, x, wall, 2.0, 0.1);
            fill(&mut map, x + 3.1, wall, 1.9, 0.1);
        }
        fill(&mut map, x, 0.0, 0.1, 13.5);
        fill(&mut map, x, 16.0, 0.1, 14.0);
    }
    let mut stream = Stream::new(1, "department");
    for _ in 0..60 {
        let (x, y) = (stream.uniform_in(0.5, 28.5), stream.uniform_in(0.5, 28.5));
        if !(12.0..17.5).contains(&y) {
            fill(&mut map, x, y, 0.6, 0.6);
        }
    }
    map
}

fn main() {
    let report = Report::from_arguments();
    fields(&report);
    rays(&report);
    decisions(&report);
    steps(&report);
    missions(&report);
    rotated(&report);
}

const NAV2: &str = "Nav2 NavFn 5.1, 1.0, 0.40 at 5, 10, 15 cm";

fn fields(report: &Report) {
    let sizes = [
        (["field-5", "dijkstra-5", "iteration-5", "change-5"], 0.05, [5.0, 12.5, 800.0, 5.0]),
        (["field-10", "dijkstra-10", "iteration-10", "change-10"], 0.10, [1.0, 3.0, 85.0, 1.0]),
        (["field-15", "dijkstra-15", "iteration-15", "change-15"], 0.15, [0.4, 1.15, 25.0, 0.4]),
    ];
    for (names, resolution_m, targets) in sizes {
        println!("30 × 30 m at {:.0} cm:", resolution_m * 100.0);
        let floor = Floor::new(resolution_m);
        let target = floor.map.centre(floor.map.columns / 10, floor.map.rows / 10);
        let row = |index: usize, what, peers| Question::new(names[index], what, "ms", targets[index], peers);
        report.row(row(0, "value of every cell, with clearance", NAV2), || {
            floor.check(target, &floor.values(target));
            floor.least_ms(|| drop(black_box(floor.planner.cost_to_go(target))))
        });
        report.row(row(3, "the same after a box has appeared in the map", "D* Lite repairs only what changed"), || {
            let side = |cell: i32| f64::from(cell % 7 - 3) * 0.1;
            let points: Vec<Point> = (0..49).map(|cell| Point::new(15.0 + side(cell), 15.0 + side(cell / 7))).collect();
            let around = floor.planner.cost_to_go_around(target, &points);
            assert!(around.cost_m(points[24]).is_none() && around.cost_m(Point::new(2.5, 14.8)).is_some());
            floor.least_ms(|| drop(black_box(floor.planner.cost_to_go_around(target, &points))))
        });
        report.row(row(1, "Dijkstra with a binary heap", "as in textbooks"), || {
            floor.check(target, &floor.dijkstra(target));
            floor.least_ms(|| drop(black_box(floor.dijkstra(target))))
        });
        report.row(row(2, "value iteration, sweeps in turn until nothing changes", "as in textbooks"), || {
            floor.check(target, &floor.iterated(target));
            least_ms(3, true, || (), || drop(black_box(floor.iterated(target))))
        });
    }
}

/// The department as the planner prices it, with its own copy of the prices for the textbooks.
struct Floor {
    map: OccupancyGrid,
    planner: PlannerModel,
    /// In metres a metre, 0 where the robot does not fit; with a frame.
    prices: Vec<f32>,
    stride: usize,
}

impl Floor {
    fn new(resolution_m: f64) -> Self {
        let map = department(resolution_m);
        let planner = PlannerModel::new(&map, Inflation::of_robot(0.265));
        let stride = map.columns + 2;
        let mut prices = vec![0.0; stride * (map.rows + 2)];
        for row in 0..map.rows {
            for column in 0..map.columns {
                let price = planner.price(map.centre(column, row)).unwrap_or(0.0);
                prices[(row + 1) * stride + column + 1] = price as f32;
            }
        }
        Self { map, planner, prices, stride }
    }

    fn least_ms(&self, act: impl FnMut()) -> f64 {
        least_ms(RUNS, true, || (), act)
    }

    fn framed(&self, point: Point) -> usize {
        self.map.cell_at(point).map_or(0, |(column, row)| (row + 1) * self.stride + column + 1)
    }

    /// What the planner says of each cell.
    fn values(&self, target: Point) -> Vec<f32> {
        let costs = self.planner.cost_to_go(target);
        let mut values = vec![f32::INFINITY; self.prices.len()];
        for row in 0..self.map.rows {
            for column in 0..self.map.columns {
                let point = self.map.centre(column, row);
                values[self.framed(point)] = costs.cost_m(point).map_or(f32::INFINITY, |cost_m| cost_m as f32);
            }
        }
        values
    }

    /// The neighbours of a cell and what the way there costs; no cut corners.
    fn moves(&self, cell: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        const STEPS: [(isize, isize); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];
        let at = move |dx: isize, dy: isize| cell.wrapping_add_signed(dx + dy * self.stride as isize);
        let scale = self.map.resolution_m as f32 / 2.0;
        STEPS.into_iter().filter_map(move |(dx, dy)| {
            let next = at(dx, dy);
            let is_diagonal = dx != 0 && dy != 0;
            let cuts = is_diagonal && (self.prices[at(dx, 0)] == 0.0 || self.prices[at(0, dy)] == 0.0);
            let length = if is_diagonal { std::f32::consts::SQRT_2 } else { 1.0 };
            let cost = (self.prices[cell] + self.prices[next]) * length * scale;
            (self.prices[next] > 0.0 && !cuts).then_some((next, cost))
        })
    }

    fn dijkstra(&self, target: Point) -> Vec<f32> {
        let mut values = vec![f32::INFINITY; self.prices.len()];
        let start = self.framed(target);
        values[start] = 0.0;
        // Costs are positive, so their bits are in their order.
        let mut open = BinaryHeap::from([Reverse((0u32, start))]);
        while let Some(Reverse((bits, cell))) = open.pop() {
            if f32::from_bits(bits) > values[cell] {
                continue;
            }
            for (next, cost) in self.moves(cell) {
                let value = values[cell] + cost;
                if value < values[next] {
                    values[next] = value;
                    open.push(Reverse((value.to_bits(), next)));
                }
            }
        }
        values
    }

    fn iterated(&self, target: Point) -> Vec<f32> {
        let mut values = vec![f32::INFINITY; self.prices.len()];
        values[self.framed(target)] = 0.0;
        let free: Vec<usize> = (0..self.prices.len()).filter(|&cell| self.prices[cell] > 0.0).collect();
        let mut changed = true;
        let mut improve = |cell: usize, changed: &mut bool| {
            let least = self.moves(cell).map(|(next, cost)| values[next] + cost).fold(f32::INFINITY, f32::min);
            if least < values[cell] {
                values[cell] = least;
                *changed = true;
            }
        };
        while changed {
            changed = false;
            free.iter().for_each(|&cell| improve(cell, &mut changed));
            free.iter().rev().for_each(|&cell| improve(cell, &mut changed));
        }
        values
    }

    /// Each value is the least over the neighbours, and 0 at the target only.
    fn check(&self, target: Point, values: &[f32]) {
        let target = self.framed(target);
        let free = (0..values.len()).filter(|&cell| self.prices[cell] > 0.0);
        let reached = free
            .filter(|&cell| {
                let least = self.moves(cell).map(|(next, cost)| values[next] + cost).fold(f32::INFINITY, f32::min);
                let expected = if cell == target { 0.0 } else { least };
                let is_exact = values[cell] == expected || (values[cell] - expected).abs() < 1e-4 * (1.0 + expected);
                assert!(is_exact, "{cell}: {} and not {expected}", values[cell]);
                values[cell].is_finite()
            })
            .count();
        assert!(reached > self.map.cells.len() / 3, "{reached}");
    }
}

fn rays(report: &Report) {
    const RAYS: usize = 100_000;
    const MOST_M: f64 = 30.0;
    let map = department(0.05);
    let field = DistanceField::new(&map);
    let mut stream = Stream::new(3, "rays");
    let mut rays = Vec::with_capacity(RAYS);
    while rays.len() < RAYS {
        let from = Point::new(stream.uniform_in(0.0, 30.0), stream.uniform_in(0.0, 30.0));
        let angle_rad = stream.uniform_in(0.0, std::f64::consts::TAU);
        if map.at(from) == Cell::Free {
            rays.push((from, (angle_rad.cos(), angle_rad.sin())));
        }
    }
    let what = "a ray in a map of 5 cm, from anywhere in any direction (10 million a second: 100)";
    let peers = "RangeLibc, ray marching, 185";
    report.row(Question::new("ray", what, "ns", 100.0, peers), || {
        for (from, (cos, sin)) in rays.iter().step_by(97) {
            let cast_m = field.cast_m(*from, (*cos, *sin), MOST_M);
            let at = |way_m: f64| map.at(Point::new(from.x + cos * way_m, from.y + sin * way_m));
            let mut small_m = 0.0;
            while small_m < MOST_M && at(small_m) == Cell::Free {
                small_m += 0.002;
            }
            // A corner may be grazed by the one and missed by the other.
            let is_grazed = at(small_m + 0.05) == Cell::Free;
            assert!(is_grazed || (cast_m - small_m).abs() < 0.06, "{from} {cos} {sin}: {cast_m} {small_m}");
        }
        let ms = least_ms(
            RUNS,
            true,
            || (),
            || _ = black_box(rays.iter().map(|&(from, ray)| field.cast_m(from, ray, MOST_M)).sum::<f64>()),
        );
        ms * 1e6 / RAYS as f64
    });
}

/// What the robot remembers of random clutter around it, as many points as it can.
fn clutter(limits: &DriveLimits, seed: u64) -> Vec<Point> {
    let mut stream = Stream::new(seed, "clutter");
    let mut points = Vec::new();
    while points.len() < ObstacleMemory::CAPACITY {
        let point = Point::new(stream.uniform_in(-2.5, 2.5), stream.uniform_in(-2.5, 2.5));
        if point.coords.norm() > limits.robot_radius_m + 0.25 {
            points.push(point);
        }
    }
    points
}

fn decisions(report: &Report) {
    const SCENES: usize = 64;
    const { assert!(CANDIDATES >= 200) };
    let limits = DriveLimits::default();
    let mut stream = Stream::new(4, "scenes");
    let scenes: Vec<_> = (0..SCENES as u64)
        .map(|seed| {
            let target = Point::new(stream.uniform_in(0.5, 2.0), stream.uniform_in(-1.0, 1.0));
            let velocity =
                Velocity { translation_mps: stream.uniform_in(0.0, 0.3), rotation_radps: stream.uniform_in(-0.5, 0.5) };
            (clutter(&limits, seed), target, velocity)
        })
        .collect();
    let input = |(obstacles, target_in_base, velocity): &(Vec<Point>, Point, Velocity)| {
        let input = WindowInput {
            odometry_in_odom: Pose::default(),
            velocity: *velocity,
            obstacles_in_base: obstacles,
            target_in_base: *target_in_base,
            speed_limit_mps: 0.65,
            remaining_m: 5.0,
        };
        best_velocity(&limits, &input)
    };
    let what = "a decision of the dynamic window, 253 velocity among 400 obstacle points, mean of 64 scenes";
    report.row(Question::new("decision", what, "µs", 200.0, "Nav2 MPPI 20,000"), || {
        let mut drives = 0;
        for scene in &scenes {
            let chosen = input(scene);
            let ahead_m = open_distance_m(&limits, &scene.0, 0.0, 1.0);
            drives += usize::from(chosen.translation_mps > 0.0);
            let stopping_m = limits.stopping_distance_m(chosen.translation_mps);
            assert!(chosen.rotation_radps != 0.0 || stopping_m <= ahead_m.max(0.01), "{chosen:?} {ahead_m}");
            for step in 0..=50 {
                let share = stopping_m * f64::from(step) / 50.0;
                let turn_rad = share * chosen.rotation_radps / chosen.translation_mps.max(1e-9);
                let robot = drive_arc(Pose::default(), share, turn_rad).point();
                let is_free = scene.0.iter().all(|&point| distance_m(point, robot) > limits.robot_radius_m);
                assert!(is_free || chosen.translation_mps == 0.0, "{chosen:?}");
            }
        }
        assert!(drives > SCENES / 4, "{drives}");
        let ms = least_ms(
            RUNS,
            true,
            || (),
            || scenes.iter().for_each(|scene| assert!(black_box(input(scene)).translation_mps >= 0.0)),
        );
        ms * 1e3 / SCENES as f64
    });
}

/// The department with twenty people in its corridor.
fn crowded() -> World {
    let mut text = World::builtin_text("dept").unwrap_or_default().to_owned();
    for person in 0..20 {
        let y = 8.4 + 0.16 * f64::from(person);
        let (from, to) = if person % 2 == 0 { (2.5, 24.5) } else { (24.5, 2.5) };
        let speed = 0.6 + 0.03 * f64::from(person);
        text.push_str(&format!("\n[[person]]\npath = [[{from}, {y:.2}], [{to}, {y:.2}]]\nspeed = {speed:.2}\n"));
    }
    match World::parse(&text, "crowded.toml") {
        Ok(world) => world,
        Err(error) => panic!("{error}"),
    }
}

fn steps(report: &Report) {
    const STEPS: usize = 10_000;
    let simulator = SimulatorModel::new(Arc::new(crowded()), SimulatorSettings::default());
    let commands = |step: usize| Commands {
        translation_mps: 0.4,
        rotation_radps: if step % 40 < 20 { 0.2 } else { -0.2 },
        sonars_on: true,
        ..Commands::default()
    };
    let what = "a step of the simulator with 24 sonars and 20 people (100,000 a second: 10)";
    report.row(Question::new("step", what, "µs", 10.0, "rapier2d 29, ir-sim 500"), || {
        let state = RefCell::new(simulator.start(1));
        let mut heard = 0;
        let ms = least_ms(
            5,
            true,
            || *state.borrow_mut() = simulator.start(1),
            || {
                let state = &mut *state.borrow_mut();
                for step in 0..STEPS {
                    let percept = simulator.step(state, &commands(step));
                    heard += percept.sonar_m.is_some_and(|ranges_m| ranges_m.iter().any(|&m| m < 5.0)) as usize;
                }
            },
        );
        let state = state.borrow();
        assert!(heard == 5 * STEPS && state.people.len() == 20 && state.distance_driven_m() > 5.0, "{heard}");
        ms * 1e3 / STEPS as f64
    });
}

/// A delivery by a robot that is told where it is: to the mail slots, then to the shelf.
struct Errand {
    world: Arc<World>,
    simulator: SimulatorModel,
    topology: TopologicalModel,
    navigation: NavigationModel,
}

impl Errand {
    fn new() -> Self {
        let Some(world) = World::builtin("dept").map(Arc::new) else { panic!("`dept` is built in") };
        let navigation = NavigationModel::new(&world, DriveLimits::default());
        Self {
            simulator: SimulatorModel::new(world.clone(), SimulatorSettings::default()),
            topology: TopologicalModel::new(&world, &navigation.planner),
            navigation,
            world,
        }
    }

    /// Simulated seconds it takes.
    fn run(&self, seed: u64) -> f64 {
        let mut state = self.simulator.start(seed);
        for place in ["mail-slots", "wolframs-shelf"] {
            let Ok(place) = self.world.place(place) else { panic!("`dept` has {place}") };
            let Ok(plan) = self.topology.plan(&self.navigation.planner, state.robot_in_map, place, &[]) else {
                panic!("there is a way to {}", place.name)
            };
            let mut navigation = MappedNavigation::default();
            navigation.start(plan.targets, MappedNavigation::PATIENCE_S);
            self.drive(&mut state, navigation);
            let away_m = distance_m(state.robot_in_map.point(), place.pose_in_map.point());
            assert!(away_m < 0.5 && state.contacts.caused == 0, "{away_m} {:?}", state.contacts);
        }
        state.time_us as f64 * 1e-6
    }

    fn drive(&self, state: &mut SimulatorState, mut navigation: MappedNavigation) {
        let mut commands = Commands { sonars_on: true, ..Commands::default() };
        loop {
            let percept = self.simulator.step(state, &commands);
            let sonars = &self.simulator.sensors.sonars;
            let input = NavigationInput {
                odometry_in_odom: percept.odometry_in_odom,
                velocity: Velocity { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps },
                sonar: sonars
                    .as_ref()
                    .zip(percept.sonar_m.as_deref())
                    .map(|(sonars, ranges_m)| SonarScan { sonars, ranges_m }),
                laser: None,
                bumped: percept.bumped,
            };
            let here = state.robot_in_map;
            let mode = self.world.mode_at(here.point()).unwrap_or(TravelMode::Office);
            let output = navigation.step(&self.navigation, here, &input, mode);
            commands.translation_mps = output.velocity.translation_mps;
            commands.rotation_radps = output.velocity.rotation_radps;
            commands.sonars_on = mode != TravelMode::Doorway || output.needs_sonars;
            match output.event {
                Some(NavigationEvent::Arrived) => return,
                Some(NavigationEvent::TargetReached) | None => {}
                event => panic!("{event:?}"),
            }
        }
    }
}

fn missions(report: &Report) {
    const MISSIONS: u64 = 8;
    let errand = Errand::new();
    let mut simulated_s = 0.0;
    let mut ms = f64::NAN;
    let what = "a delivery in `dept` without localization (20 a second: 50)";
    report.row(Question::new("mission", what, "ms", 50.0, "38 for a C++ proxy"), || {
        simulated_s = (0..MISSIONS).map(|seed| errand.run(seed)).sum();
        ms = least_ms(3, true, || (), || (0..MISSIONS).for_each(|seed| assert!(black_box(errand.run(seed)) > 0.0)));
        ms / MISSIONS as f64
    });
    let what = "the same, a simulated second (real-time factor 500: 2)";
    report.row(Question::new("second", what, "ms", 2.0, "–"), || ms / simulated_s);
}

fn rotated(report: &Report) {
    let what = "`rotated`, models and all: delivery, turned by hand, localization at 15 cm and 2°; wall time";
    report.row(Question::new("rotated", what, "s", 3.0, "eight minutes on the real robot"), || {
        least_ms(3, false, || (), || run_rotated(2001)) / 1e3
    });
}

fn run_rotated(seed: u64) {
    let Some(world) = World::builtin("dept") else { panic!("`dept` is built in") };
    let goal = world.place("wolframs-shelf").map_or(Pose::default(), |place| place.pose_in_map);
    let turn = include_str!("../../examples/experiments/rotated.rpl");
    let delivery = include_str!("../../examples/delivery.rpl");
    let started = || {
        let site = Site::new(Setup { world: Some(world), ..Setup::default() })?;
        let site = site.with_scenario("rotated.rpl", turn, &mut NoFiles)?;
        Ok(site.start(site.compile("delivery.rpl", delivery, &mut NoFiles)?, seed))
    };
    let mut system = started().unwrap_or_else(|error: SiteError| panic!("{error}"));
    system.run_until(1_800_000_000);
    let Robot::Office(robot) = &system.outside else { panic!("a world has a robot") };
    let away_m = robot.true_pose_in_map().distance_m(goal);
    assert!(matches!(system.outcome(), Some(Outcome::Succeeded(_))), "the mail is delivered");
    assert!(away_m < 0.5 && robot.contacts().caused == 0, "{away_m} {:?}", robot.contacts());
}
