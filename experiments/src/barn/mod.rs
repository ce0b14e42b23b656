//! Cluttered courses of which the robot knows nothing, at 2 m/s: Perille, Truong, Xiao, Stone 2020,
//! "Benchmarking Metric Ground Navigation", and the challenge that came of it.

mod course;

use super::conduct::chosen;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::request::ExperimentRequest;
use super::statistics::{Dispersion, Proportion};
use anyhow::Result;
use course::{COURSES, Course, RADIUS_M};
use rpl_robot::avoidance::DriveLimits;
use rpl_robot::description::{Driving, Laser, Motors, RobotDescription};
use rpl_robot::geometry::{Point, Velocity};
use rpl_robot::navigation::{DriveStatus, LocalDrive, MaplessNavigation, NavigationEvent, NavigationInput};
use rpl_robot::planning::Target;
use rpl_robot::sensors::{LaserScan, LaserScanner, RangeSensor};
use rpl_robot::simulator::{Commands, SimulatorModel, SimulatorSettings};
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::sync::Arc;

/// Speed of the robot.
const SPEED_MPS: f64 = 2.0;

/// A trial that takes longer has failed.
const TIME_UP_S: f64 = 100.0;

/// A goal is reached from here.
const GOAL_M: f64 = 1.0;

static ROWS: [(&str, Method); 2] = [("seen so far", Method::Mapless), ("window alone", Method::Window)];

/// How the robot finds its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Method {
    /// It plans on what it has seen, and drives by the dynamic window.
    Mapless,
    /// The dynamic window heads for the goal.
    Window,
}

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum CourseEnd {
    Arrived,
    Touched,
    GaveUp,
    TimeUp,
}

/// One drive over a course.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Drove {
    course: u64,
    ending: CourseEnd,
    time_s: f64,
    optimum_s: f64,
}

impl Drove {
    /// The challenge's score since 2023: 0.5 for a drive in less than twice the time of the shortest
    /// way at full speed, down to 0.125 for eight times that and more.
    fn score(&self) -> f64 {
        match self.ending {
            CourseEnd::Arrived => self.optimum_s / self.time_s.clamp(2.0 * self.optimum_s, 8.0 * self.optimum_s),
            CourseEnd::Touched | CourseEnd::GaveUp | CourseEnd::TimeUp => 0.0,
        }
    }
}

/// What came of the drives of a row.
#[derive(Clone, Debug, Serialize)]
struct BarnRow {
    name: &'static str,
    arrived: Proportion,
    score: f64,
    touched: usize,
    gave_up: usize,
    time_up: usize,
    /// Median over the drives that arrived.
    time_by_optimum: Option<f64>,
}

impl BarnRow {
    fn of(name: &'static str, drives: &[Drove]) -> Self {
        let count = |ending: CourseEnd| drives.iter().filter(|drove| drove.ending == ending).count();
        let arrived = drives.iter().filter(|drove| drove.ending == CourseEnd::Arrived);
        let ratios: Vec<f64> = arrived.map(|drove| drove.time_s / drove.optimum_s).collect();
        Self {
            name,
            arrived: Proportion::new(count(CourseEnd::Arrived), drives.len()),
            score: drives.iter().map(Drove::score).sum::<f64>() / drives.len().max(1) as f64,
            touched: count(CourseEnd::Touched),
            gave_up: count(CourseEnd::GaveUp),
            time_up: count(CourseEnd::TimeUp),
            time_by_optimum: Dispersion::of(&ratios).map(|spread| spread.median),
        }
    }
}

/// Drives over the courses, with each method or the one that is asked for.
pub struct Barn {
    request: ExperimentRequest,
    methods: Vec<&'static (&'static str, Method)>,
}

impl Barn {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let methods = chosen(&request, &ROWS, |(name, _)| name)?;
        Ok(Self { request, methods })
    }
}

impl ExperimentKind for Barn {
    type Ground = ();
    type Record = Drove;
    type Tally = Vec<Drove>;

    fn series(&self) -> Vec<String> {
        self.methods.iter().map(|(name, _)| (*name).to_string()).collect()
    }

    fn ground(&self, _: usize) -> Result<()> {
        Ok(())
    }

    /// The seed is that of the whole set of courses; of these an even selection is driven.
    fn run(&self, series: usize, _: &(), run: Run) -> Result<Drove> {
        let course = run.number * COURSES / u64::from(self.request.runs).max(1);
        let seed = self.request.first_seed;
        Ok(drive(&Course::new(course, seed), self.methods[series].1, course, seed))
    }

    fn head(&self, _: &Drove) -> String {
        "row,course,ending,time_s,optimum_s,score".to_string()
    }

    fn lines(&self, series: &str, _: Run, drove: &Drove) -> String {
        let Drove { course, ending, time_s, optimum_s } = drove;
        format!("{series},{course},{ending:?},{time_s:.2},{optimum_s:.3},{:.4}\n", drove.score())
    }

    fn findings(&self, tallies: Vec<Vec<Drove>>, _: bool) -> Result<Findings> {
        let rows = self.methods.iter().zip(&tallies).map(|((name, _), drives)| BarnRow::of(name, drives));
        let rows: Vec<BarnRow> = rows.collect();
        let (blocks, figures) = (blocks(&rows), json!({ "rows": rows }));
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings: Vec::new() })
    }
}

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    ROWS.iter().map(|(name, _)| *name).collect()
}

fn blocks(rows: &[BarnRow]) -> Vec<Block> {
    let mut table = Table::new(&["barn", "arrived", "95 %", "score", "touched", "gave up", "time up", "time/opt."]);
    for row in rows {
        table.row([
            row.name.to_string(),
            row.arrived.fraction(),
            row.arrived.interval(),
            format!("{:.3}", row.score),
            row.touched.to_string(),
            row.gave_up.to_string(),
            row.time_up.to_string(),
            row.time_by_optimum.map_or(NOTHING.to_string(), |ratio| format!("{ratio:.2}")),
        ]);
    }
    let score = "score: the mean of 1[arrived] · OT / clip(AT, 2 OT, 8 OT), OT the shortest way at 2 m/s; at most 0.5.";
    vec![Block::Table(table), Block::Lines(score.into())]
}

/// A disc of the Jackal's size with its speed, and less acceleration than its controller allows, with the
/// laser of a B21 and no sonars.
fn jackal() -> RobotDescription {
    let motors = Motors {
        max_translation_mps: SPEED_MPS,
        max_rotation_radps: 3.0,
        translation_acceleration_mps2: 5.0,
        translation_deceleration_mps2: 6.0,
        rotation_acceleration_radps2: 12.0,
        halt_deceleration_mps2: 6.0,
        halt_deceleration_radps2: 12.0,
    };
    let b21 = RobotDescription::clone(&RobotDescription::papers());
    let driving = Driving {
        max_rotation_radps: motors.max_rotation_radps,
        translation_deceleration_mps2: 0.9 * motors.translation_deceleration_mps2,
        rotation_acceleration_radps2: 0.5 * motors.rotation_acceleration_radps2,
        ..b21.driving
    };
    let scanner = LaserScanner { readings: 181, resolution_deg: 1.0, range_m: 8.0 };
    let laser = Laser { scanner, noise_m: 0.01, dropout_probability: 0.002 };
    RobotDescription { radius_m: RADIUS_M, motors, driving, sonar: None, laser: Some(laser), ..b21 }
}

fn drive(course: &Course, method: Method, number: u64, seed: u64) -> Drove {
    let robot = jackal();
    let limits = DriveLimits::of(&robot);
    let goal_in_odom = course.world.start_in_map.inverse().transform(course.goal_in_map);
    let simulator = SimulatorModel::new(Arc::new(course.world.clone()), SimulatorSettings::of(robot));
    let mut state = simulator.start(seed.wrapping_add(number));
    let mut pilot = Pilot::new(method, goal_in_odom);
    let mut commands = Commands::default();
    let ending = loop {
        let percept = simulator.step(&mut state, &commands);
        let away_m = (state.true_pose().point() - course.goal_in_map).norm();
        let contacts = state.contacts();
        if contacts.caused + contacts.unseen > 0 {
            break CourseEnd::Touched;
        }
        if away_m <= GOAL_M {
            break CourseEnd::Arrived;
        }
        if state.time_us as f64 * 1e-6 > TIME_UP_S {
            break CourseEnd::TimeUp;
        }
        let input = NavigationInput {
            odometry_in_odom: percept.odometry_in_odom,
            velocity: Velocity { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps },
            sonar: None,
            laser: simulator
                .sensors
                .laser
                .as_ref()
                .zip(percept.laser_m.as_deref())
                .map(|(laser, ranges_m)| LaserScan { laser, ranges_m }),
            bumped: percept.bumped,
        };
        let Some(velocity) = pilot.step(&limits, &input) else { break CourseEnd::GaveUp };
        commands.translation_mps = velocity.translation_mps;
        commands.rotation_radps = velocity.rotation_radps;
    };
    Drove { course: number, ending, time_s: state.time_us as f64 * 1e-6, optimum_s: course.optimum_m / SPEED_MPS }
}

/// Who decides.
enum Pilot {
    Mapless(Box<MaplessNavigation>),
    Window(Box<LocalDrive>),
}

impl Pilot {
    fn new(method: Method, goal_in_odom: Point) -> Self {
        match method {
            Method::Mapless => {
                let mut navigation = MaplessNavigation::new(RangeSensor::Laser);
                navigation.start(vec![Target::through(goal_in_odom)], MaplessNavigation::PATIENCE_S);
                Pilot::Mapless(Box::new(navigation))
            }
            Method::Window => Pilot::Window(Box::new(LocalDrive::follow(vec![goal_in_odom]))),
        }
    }

    /// None if it gives up.
    fn step(&mut self, limits: &DriveLimits, input: &NavigationInput<'_>) -> Option<Velocity> {
        match self {
            Pilot::Mapless(navigation) => {
                let output = navigation.step(limits, input, SPEED_MPS);
                let has_failed = matches!(output.event, Some(NavigationEvent::Unreachable | NavigationEvent::Blocked));
                (!has_failed).then_some(output.velocity)
            }
            Pilot::Window(drive) => {
                let output = drive.step(limits, input, SPEED_MPS);
                (output.status != DriveStatus::Arrived).then_some(output.velocity)
            }
        }
    }
}
