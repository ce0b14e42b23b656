//! Going back in time: a ten-minute mission recorded as the prompt does, and earlier instants of it
//! taken back at random. Each is compared with what it was when it was the present.

use rpl_benches::{Question, Report, resident_bytes};
use rpl_lang::compile::NoFiles;
use rpl_robot::geometry::Pose;
use rpl_robot::office::{self, OfficeModel, OfficeRobot, OfficeSettings, SimulatedHost};
use rpl_robot::random::Stream;
use rpl_robot::world::World;
use rpl_runtime::library::Library;
use rpl_runtime::system::System;
use rpl_runtime::timeline::Timeline;
use std::sync::Arc;
use std::time::Instant;

const MISSION: &str = "
(dotimes (i 60)
  (let ((place (nth (random 6) '(mail-slots wolframs-shelf a-desk c-centre d-centre west-end))))
    (ignore-failures (blocked unreachable) (go-to place))))";
const MISSION_US: u64 = 600_000_000;

/// Instants that are taken back, and how often each.
const INSTANTS: usize = 300;
const TRIES: usize = 3;

/// What is looked at of an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Glance {
    now_us: u64,
    robot_in_map: Pose,
}

fn glance(system: &System<OfficeRobot>) -> Glance {
    Glance { now_us: system.machine.now_us, robot_in_map: system.outside.true_pose_in_map() }
}

fn mission(start_known: bool) -> System<OfficeRobot> {
    let settings = OfficeSettings { start_known, ..OfficeSettings::default() };
    let Some(world) = World::builtin("dept") else { panic!("the world is built in") };
    let model = OfficeModel::new(world, settings).unwrap_or_else(|error| panic!("{error}"));
    let model = Arc::new(model);
    let robot = OfficeRobot::new(model.clone(), SimulatedHost::new(model.simulator.clone(), 1, None), 1);
    let natives = [rpl_runtime::natives::natives(), rpl_stdlib::natives(), office::natives()].concat();
    let texts = [("prelude", rpl_stdlib::PRELUDE), ("robot", office::PLANS)];
    let library =
        Library::new(natives, &texts, &robot, &[]).unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    let mut system =
        System::session(&Arc::new(library), robot).unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    system.machine.seed_random(1);
    system
}

/// Runs the mission, tells each instant, and gives the seconds it took.
fn drive(system: &mut System<OfficeRobot>, mut each: impl FnMut(&System<OfficeRobot>, Instant)) -> f64 {
    let began = Instant::now();
    while system.machine.now_us < MISSION_US {
        let instant = Instant::now();
        system.settle();
        assert!(system.answer().is_none(), "the mission is too short");
        system.next_instant();
        system.machine.trace.take();
        system.machine.output.clear();
        each(system, instant);
    }
    began.elapsed().as_secs_f64()
}

fn submit(system: &mut System<OfficeRobot>) {
    if let Err(rejected) = system.submit("mission", MISSION, &mut NoFiles) {
        panic!("{}", rejected.render(false));
    }
}

/// The milliseconds of the slowest way back, and the megabytes that the history holds.
fn measure(start_known: bool) -> [f64; 2] {
    let mut system = mission(start_known);
    let mut alone = system.clone();
    submit(&mut alone);
    let alone_s = drive(&mut alone, |_, _| {});
    drop(alone);

    let before = resident_bytes().unwrap_or(f64::NAN);
    let mut timeline = Timeline::new(&system);
    submit(&mut system);
    timeline.handed_in(&system);
    let mut glances = vec![];
    let recorded_s = drive(&mut system, |system, began| {
        timeline.next_instant(system, began.elapsed());
        glances.push(glance(system));
    });
    let held_mb = (resident_bytes().unwrap_or(f64::NAN) - before) / 1e6;
    println!(
        "             {} instants in {recorded_s:.1} s ({alone_s:.1} s without a history), {} copies",
        glances.len(),
        timeline.copies()
    );

    let mut stream = Stream::new(7, "instants");
    let mut times_ms: Vec<f64> = Vec::new();
    for _ in 0..INSTANTS {
        let wanted = glances[stream.index(glances.len())];
        let mut least_ms = f64::INFINITY;
        for _ in 0..TRIES {
            let began = Instant::now();
            let past = timeline.at_time(wanted.now_us);
            least_ms = least_ms.min(began.elapsed().as_secs_f64() * 1e3);
            assert_eq!(past.system.machine.now_us, wanted.now_us);
            assert_eq!(past.system.outside.true_pose_in_map(), wanted.robot_in_map);
        }
        times_ms.push(least_ms);
    }
    let sum: f64 = times_ms.iter().sum();
    println!("             mean {:.1} ms", sum / times_ms.len() as f64);
    [times_ms.into_iter().fold(0.0, f64::max), held_mb]
}

fn main() {
    let report = Report::from_arguments();
    for (start_known, name, what) in [
        (true, "tracked", "ten minutes among places, the position known from the start"),
        (false, "global", "the same, beginning with global localization"),
    ] {
        let question =
            |unit, target, what| Question { name, what, unit, target, peers: "–", anchors: None, anchor_scale: 1.0 };
        let mut held_mb = f64::NAN;
        println!("{what}:");
        report.row(question("ms", 200.0, "worst of 300 instants taken back"), || {
            let [worst_ms, mb] = measure(start_known);
            held_mb = mb;
            worst_ms
        });
        report.row(question("MB", 500.0, "held by the history"), || held_mb);
    }
}
