//! What finding a room by instructions costs: registration and feature detection per scan of the sonars, the state
//! set per percept, and the judgement of an instruction, on a drive along a hallway of sixty metres.

use rpl_benches::{Question, Report, median};
use rpl_lola::arena::{ArenaSettings, SingleHallway};
use rpl_lola::feature::{Feature, Percept, Side};
use rpl_lola::features::FeatureDetection;
use rpl_lola::instruction::{Goal, MOST_ORDINAL};
use rpl_lola::judgement::{Expectation, Judgement, Look};
use rpl_lola::registration::{HallwayAxis, Registration};
use rpl_lola::state_set::{Inference, Matrix, StateSet};
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::Pose;
use rpl_robot::sensors::{SonarArray, SonarScan};
use rpl_robot::simulator::{Commands, SimulatorModel, SimulatorSettings};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

/// The hallway and the drive.
const SEED: u64 = 1;

/// Runs of which the median counts.
const RUNS: usize = 9;

/// How fast the robot drives: the hallways' speed of a B21.
const SPEED_MPS: f64 = 0.7;

/// How far before the hallway's end it stops.
const BEFORE_END_M: f64 = 2.0;

/// What the robot had of a drive along the middle of a hallway.
struct Drive {
    sonars: SonarArray,
    /// The odometry of each step, and what the sonars heard.
    scans: Vec<(Pose, Vec<f32>)>,
}

impl Drive {
    fn record() -> Self {
        let hallway = SingleHallway::draw(SEED, &ArenaSettings::CALM);
        let middle_m = (hallway.hallway.across_mm.0 + hallway.hallway.across_mm.1) as f64 / 2000.0;
        let end_m = hallway.hallway.along_mm.1 as f64 / 1000.0 - BEFORE_END_M;
        let robot = RobotDescription::builtin("b21").expect("it is built in");
        let model = SimulatorModel::new(Arc::new(hallway.world), SimulatorSettings::of(robot));
        let mut state = model.start(SEED);
        let mut scans = Vec::new();
        while state.robot_in_map.x_m < end_m {
            let aside_m = state.robot_in_map.y_m - middle_m;
            // It knows where it is, as nobody but the simulator does: what is measured is not how it keeps its lane.
            let rotation_radps = -state.robot_in_map.heading_rad - 0.5 * aside_m;
            let commands =
                Commands { sonars_on: true, translation_mps: SPEED_MPS, rotation_radps, ..Commands::default() };
            let percept = model.step(&mut state, &commands);
            scans.extend(percept.sonar_m.map(|ranges_m| (percept.odometry_in_odom, ranges_m)));
        }
        Self { sonars: model.sensors.sonars.clone().expect("a B21 has them"), scans }
    }

    fn scans(&self) -> impl Iterator<Item = (Pose, SonarScan<'_>)> {
        self.scans.iter().map(|(odometry, ranges_m)| (*odometry, SonarScan { sonars: &self.sonars, ranges_m }))
    }

    /// The axis after each scan.
    fn register(&self) -> Vec<Option<HallwayAxis>> {
        let mut registration = Registration::start(0.0);
        let axis = |(odometry_in_odom, scan)| {
            registration.take_in(odometry_in_odom, scan);
            registration.axis().copied()
        };
        self.scans().map(axis).collect()
    }

    /// What is perceived, by the axis after each scan.
    fn detect(&self, axes: &[Option<HallwayAxis>]) -> Vec<Percept> {
        let mut detection = None;
        let mut percepts = Vec::new();
        for ((odometry_in_odom, scan), axis) in self.scans().zip(axes) {
            if let Some(axis) = axis {
                let detection = detection.get_or_insert_with(|| FeatureDetection::start(axis, odometry_in_odom));
                percepts.extend(detection.take_in(axis, odometry_in_odom, scan, None));
            }
        }
        percepts
    }
}

/// Microseconds of one of `count` things that are done.
fn each_us(count: usize, mut act: impl FnMut()) -> f64 {
    let one_run = |_| {
        let began = Instant::now();
        act();
        began.elapsed().as_secs_f64() * 1e6 / count as f64
    };
    median((0..RUNS).map(one_run).collect())
}

fn main() {
    let report = Report::from_arguments();
    let drive = Drive::record();
    let axes = drive.register();
    let percepts = drive.detect(&axes);
    assert!(percepts.len() > 10, "a hallway has openings");
    let question = |name, what, target| Question::new(name, what, "µs", target, "–");
    let scans = drive.scans.len();
    report.row(question("registration", "the hallway's direction, for each scan of 24 sonars", 250.0), || {
        each_us(scans, || assert_eq!(black_box(drive.register()).len(), scans))
    });
    report.row(question("detection", "features on both sides, for each scan", 50.0), || {
        each_us(scans, || assert_eq!(black_box(drive.detect(&axes)), percepts))
    });
    let inference = Inference::of_robot(false);
    let goal = Goal { ordinal: MOST_ORDINAL, side: Side::Left, kind: Feature::Hallway };
    let on_left = percepts.iter().filter(|percept| percept.side == Side::Left).count();
    report.row(question("state-set", "the state set of a tenth opening, for each percept", 5.0), || {
        each_us(on_left, || {
            let mut state_set = StateSet::start(goal.instruction()).expect("it is counted");
            percepts.iter().for_each(|percept| state_set.progress(&inference, &[*percept], &[]));
            black_box(state_set.standing());
        })
    });
    let to_m = percepts.last().map_or(0.0, |percept| percept.to_m);
    let look = Look { from_m: 0.0, to_m, turned_at_m: None, percepts: percepts.clone(), hidden: Vec::new() };
    let looks = [look.clone(), look];
    let expectation = Expectation::of_event(Matrix::SONAR);
    report.row(question("judgement", "a tenth opening, by two looks along the whole hallway", 2000.0), || {
        each_us(1, || drop(black_box(Judgement::of(goal, &looks, Some(to_m), &expectation))))
    });
}
