//! Cluttered courses of which the robot knows nothing, at 2 m/s: Perille, Truong, Xiao, Stone 2020,
//! "Benchmarking Metric Ground Navigation", and the challenge that came of it.

mod course;

use super::statistics::wilson_95;
use super::trials::run_all;
use super::{Arguments, jobs, progress, write_files};
use crate::console::Console;
use crate::status::Status;
use anyhow::{Result, bail};
use course::{COURSES, Course};
use rpl_robot::geometry::Point;
use rpl_robot::navigation::{
    Drive, DriveLimits, DriveStatus, Grain, MaplessNavigation, NavigationEvent, NavigationInput, Speeds, Target,
};
use rpl_robot::simulator::{Commands, SimulatorModel, SimulatorSettings};
use std::sync::Arc;

/// Speed of the robot.
const SPEED_MPS: f64 = 2.0;

/// A trial that takes longer has failed.
const TIME_UP_S: f64 = 100.0;

/// A goal is reached from here.
const GOAL_M: f64 = 1.0;

const ROWS: [(&str, Method); 2] = [("seen so far", Method::Mapless), ("window alone", Method::Window)];

/// How the robot finds its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Method {
    /// It plans on what it has seen, and drives by the dynamic window.
    Mapless,
    /// The dynamic window heads for the goal.
    Window,
}

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ending {
    Arrived,
    Touched,
    GaveUp,
    TimeUp,
}

/// One drive over a course.
#[derive(Clone, Copy, Debug)]
struct Drove {
    course: u64,
    ending: Ending,
    time_s: f64,
    optimum_s: f64,
}

impl Drove {
    /// The challenge's score since 2023: 0.5 for a drive in less than twice the time of the shortest
    /// way at full speed, down to 0.125 for eight times that and more.
    fn score(&self) -> f64 {
        match self.ending {
            Ending::Arrived => self.optimum_s / self.time_s.clamp(2.0 * self.optimum_s, 8.0 * self.optimum_s),
            Ending::Touched | Ending::GaveUp | Ending::TimeUp => 0.0,
        }
    }
}

/// Drives over the courses, with each method or the one that is asked for.
///
/// # Errors
/// No row has the name, or the results cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let wanted = arguments.row.as_deref();
    let rows: Vec<_> = ROWS.iter().filter(|(name, _)| wanted.is_none_or(|wanted| wanted == *name)).collect();
    if rows.is_empty() {
        let names = ROWS.map(|(name, _)| name);
        bail!("the experiment `barn` has no row `{}`; it has {}", wanted.unwrap_or(""), names.join(", "));
    }
    let courses: Vec<u64> = (0..u64::from(arguments.runs.get()))
        .map(|run| run * COURSES / u64::from(arguments.runs.get()).max(1))
        .collect();
    let mut lines = vec![format!(
        "{:18} {:>9} {:>15} {:>8} {:>9} {:>9} {:>9} {:>9}",
        "barn", "arrived", "95 %", "score", "touched", "gave up", "time up", "time/opt."
    )];
    let mut raw = "row,course,ending,time_s,optimum_s,score\n".to_string();
    for (name, method) in rows {
        let bar = progress(courses.len() as u64, console);
        bar.set_message((*name).to_string());
        let one = |course: u64| drive(&Course::new(course, arguments.seed), *method, course, arguments.seed);
        let drives = run_all(&courses, jobs(arguments), one, || bar.inc(1));
        bar.finish_and_clear();
        lines.push(line(name, &drives));
        for drove in &drives {
            let Drove { course, ending, time_s, optimum_s } = drove;
            raw.push_str(&format!("{name},{course},{ending:?},{time_s:.2},{optimum_s:.3},{:.4}\n", drove.score()));
        }
    }
    lines.push(
        "score: the mean of 1[arrived] · OT / clip(AT, 2 OT, 8 OT), OT the shortest way at 2 m/s; at most 0.5.".into(),
    );
    console.print(&lines.join("\n"))?;
    write_files(arguments, &[("runs.csv".to_string(), raw)])?;
    Ok(Status::Succeeded)
}

fn line(name: &str, drives: &[Drove]) -> String {
    let count = |ending: Ending| drives.iter().filter(|drove| drove.ending == ending).count();
    let arrived = count(Ending::Arrived);
    let (low, high) = wilson_95(arrived, drives.len());
    let mut ratios: Vec<f64> = drives
        .iter()
        .filter(|drove| drove.ending == Ending::Arrived)
        .map(|drove| drove.time_s / drove.optimum_s)
        .collect();
    ratios.sort_by(f64::total_cmp);
    format!(
        "{name:18} {:>9} {:>15} {:>8.3} {:>9} {:>9} {:>9} {:>9}",
        format!("{arrived}/{}", drives.len()),
        format!("{:.1}–{:.1} %", 100.0 * low, 100.0 * high),
        drives.iter().map(Drove::score).sum::<f64>() / drives.len() as f64,
        count(Ending::Touched),
        count(Ending::GaveUp),
        count(Ending::TimeUp),
        ratios.get(ratios.len() / 2).map_or("–".to_string(), |ratio| format!("{ratio:.2}")),
    )
}

/// A disc with the area of the Jackal's 51 × 43 cm, its speed, and less acceleration than its
/// controller allows, with a laser and no sonars.
fn settings() -> SimulatorSettings {
    SimulatorSettings {
        max_translation_mps: SPEED_MPS,
        max_rotation_radps: 3.0,
        translation_acceleration_mps2: 5.0,
        translation_deceleration_mps2: 6.0,
        rotation_acceleration_radps2: 12.0,
        laser: true,
        laser_noise_m: 0.01,
        ..SimulatorSettings::default()
    }
}

fn drive(course: &Course, method: Method, number: u64, seed: u64) -> Drove {
    let settings = settings();
    let limits = DriveLimits {
        robot_radius_m: settings.robot_radius_m,
        max_rotation_radps: settings.max_rotation_radps,
        translation_acceleration_mps2: settings.translation_acceleration_mps2,
        translation_deceleration_mps2: 0.9 * settings.translation_deceleration_mps2,
        rotation_acceleration_radps2: 0.5 * settings.rotation_acceleration_radps2,
        ..DriveLimits::default()
    };
    let goal_in_odom = course.world.start_in_map.inverse().transform(course.goal_in_map);
    let simulator = SimulatorModel::new(Arc::new(course.world.clone()), settings);
    let mut state = simulator.start(seed.wrapping_add(number));
    let mut pilot = Pilot::new(method, goal_in_odom);
    let mut commands = Commands::default();
    let ending = loop {
        let percept = simulator.step(&mut state, &commands);
        let away_m = (state.true_pose().point() - course.goal_in_map).norm();
        let contacts = state.contacts();
        if contacts.caused + contacts.unseen > 0 {
            break Ending::Touched;
        }
        if away_m <= GOAL_M {
            break Ending::Arrived;
        }
        if state.time_us as f64 * 1e-6 > TIME_UP_S {
            break Ending::TimeUp;
        }
        let input = NavigationInput {
            odometry_in_odom: percept.odometry_in_odom,
            speeds: Speeds { translation_mps: percept.translation_mps, rotation_radps: percept.rotation_radps },
            sonar_m: None,
            laser_m: percept.laser_m.as_deref(),
            bumped: percept.bumped,
        };
        let Some(speeds) = pilot.step(&limits, &input) else { break Ending::GaveUp };
        commands.translation_mps = speeds.translation_mps;
        commands.rotation_radps = speeds.rotation_radps;
    };
    Drove { course: number, ending, time_s: state.time_us as f64 * 1e-6, optimum_s: course.optimum_m / SPEED_MPS }
}

/// Who decides.
enum Pilot {
    Mapless(Box<MaplessNavigation>),
    Window(Box<Drive>),
}

impl Pilot {
    fn new(method: Method, goal_in_odom: Point) -> Self {
        match method {
            Method::Mapless => {
                let mut navigation = MaplessNavigation::new(Grain::Laser);
                navigation.start(vec![Target::through(goal_in_odom)], MaplessNavigation::PATIENCE_S);
                Pilot::Mapless(Box::new(navigation))
            }
            Method::Window => Pilot::Window(Box::new(Drive::follow(vec![goal_in_odom]))),
        }
    }

    /// None if it gives up.
    fn step(&mut self, limits: &DriveLimits, input: &NavigationInput<'_>) -> Option<Speeds> {
        match self {
            Pilot::Mapless(navigation) => {
                let output = navigation.step(limits, input, SPEED_MPS);
                let has_failed = matches!(output.event, Some(NavigationEvent::Unreachable | NavigationEvent::Blocked));
                (!has_failed).then_some(output.speeds)
            }
            Pilot::Window(drive) => {
                let output = drive.step(limits, input, SPEED_MPS);
                (output.status != DriveStatus::Arrived).then_some(output.speeds)
            }
        }
    }
}
