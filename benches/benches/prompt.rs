//! Going back in time: a ten-minute mission recorded as the prompt does, and earlier instants of it
//! taken back at random. Each is compared with what it was when it was the present.
//!
//! All on one thread, in processor time, so that other work on the machine does not count.

use rpl_benches::{Question, Report, computed, resident_bytes};
use rpl_lang::compile::NoFiles;
use rpl_mission::modules::SiteRobot;
use rpl_mission::site::{Setup, Site};
use rpl_random::Stream;
use rpl_robot::geometry::Pose;
use rpl_robot::office::OfficeSettings;
use rpl_robot::world::World;
use rpl_runtime::run::stepping::Stop;
use rpl_runtime::run::system::System;
use rpl_runtime::run::timeline::Timeline;
use std::time::Duration;

const MISSION: &str = "
(dotimes (i 60)
  (let ((place (nth (random 6) '(mail-slots wolframs-shelf a-desk c-centre d-centre west-end))))
    (ignore-failures (blocked unreachable) (go-to place))))";
const MISSION_US: u64 = 600_000_000;

/// Instants that are taken back.
const INSTANTS: usize = 200;

/// Steps that are taken back from the end, each time.
const STEPS: &[usize] = &[1, 2, 3, 5, 10, 20, 30, 50];

/// What is looked at of an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Glance {
    now_us: u64,
    robot_in_map: Pose,
}

fn glance(system: &System<SiteRobot>) -> Glance {
    Glance { now_us: system.machine.now_us, robot_in_map: system.outside.true_pose_in_map() }
}

fn mission(start_known: bool) -> System<SiteRobot> {
    let settings = OfficeSettings { start_known, ..OfficeSettings::default() };
    let setup = Setup { world: World::builtin("dept"), settings, ..Setup::default() };
    let site = Site::new(setup).unwrap_or_else(|error| panic!("{error}"));
    let Some(robot) = site.office_robot(1) else { panic!("the world is built in") };
    System::session(&site.library, robot, 1).unwrap_or_else(|rejected| panic!("{}", rejected.render(false)))
}

/// Runs the mission, tells each instant, and gives the seconds it took.
fn drive(system: &mut System<SiteRobot>, mut each: impl FnMut(&System<SiteRobot>, Duration)) -> f64 {
    let began = computed();
    while system.machine.now_us < MISSION_US {
        let instant = computed();
        system.settle();
        assert!(system.answer().is_none(), "the mission is too short");
        system.next_instant();
        system.machine.trace.take();
        system.machine.output.clear();
        each(system, computed() - instant);
    }
    (computed() - began).as_secs_f64()
}

fn submit(system: &mut System<SiteRobot>) {
    if let Err(rejected) = system.submit("mission", MISSION, &mut NoFiles) {
        panic!("{}", rejected.render(false));
    }
}

/// Whether a user of the prompt stops there.
fn is_shown(system: &System<SiteRobot>, stop: &Stop) -> bool {
    !["session", "prelude"].contains(&&*system.program.sources.get(stop.span.source).name)
}

/// The milliseconds of the slowest ways back, to an instant and by steps, and the megabytes that the
/// history holds.
fn measure(start_known: bool) -> [f64; 3] {
    let mut system = mission(start_known);
    let mut alone = system.clone();
    submit(&mut alone);
    let alone_s = drive(&mut alone, |_, _| {});
    drop(alone);

    let before = resident_bytes().unwrap_or(f64::NAN);
    let mut timeline = Timeline::new(&system, SiteRobot::bytes_apart);
    submit(&mut system);
    timeline.handed_in(&system);
    let mut glances = vec![];
    let recorded_s = drive(&mut system, |system, computing| {
        timeline.next_instant(system, computing);
        glances.push(glance(system));
    });
    let held_mb = (resident_bytes().unwrap_or(f64::NAN) - before) / 1e6;
    println!(
        "             {} instants in {recorded_s:.1} s ({alone_s:.1} s without a history), {} copies of {:.0} MB",
        glances.len(),
        timeline.copies(),
        timeline.held_bytes() as f64 / 1e6
    );

    let mut stream = Stream::new(7, "instants");
    let mut times_ms: Vec<f64> = Vec::new();
    for _ in 0..INSTANTS {
        let wanted = glances[stream.index(glances.len())];
        let began = computed();
        let Some(past) = timeline.at_time(wanted.now_us, &|| false) else { panic!("nobody gave it up") };
        times_ms.push((computed() - began).as_secs_f64() * 1e3);
        assert_eq!(glance(&past.system), wanted);
    }
    let sum: f64 = times_ms.iter().sum();
    println!("             mean {:.1} ms", sum / times_ms.len() as f64);
    let steps_ms = STEPS.iter().map(|&steps| {
        let began = computed();
        let past = timeline.steps_before(timeline.position, steps, is_shown, &|| false);
        let taken_ms = (computed() - began).as_secs_f64() * 1e3;
        let now_s = past.map_or(f64::NAN, |past| past.system.machine.now_s());
        println!("             {steps} steps back, to {now_s:.1} s: {taken_ms:.1} ms");
        taken_ms
    });
    let steps_ms = steps_ms.fold(0.0, f64::max);
    [times_ms.into_iter().fold(0.0, f64::max), steps_ms, held_mb]
}

fn main() {
    let report = Report::from_arguments();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap_or_else(|error| panic!("{error}"));
    for (start_known, name, what) in [
        (true, "tracked", "ten minutes among places, the position known from the start"),
        (false, "global", "the same, beginning with global localization"),
    ] {
        let question = |unit, target, what| Question::new(name, what, unit, target, "–");
        let (mut steps_ms, mut held_mb) = (f64::NAN, f64::NAN);
        println!("{what}:");
        report.row(question("ms", 200.0, "worst of 200 instants taken back"), || {
            let [worst_ms, by_steps_ms, mb] = one.install(|| measure(start_known));
            (steps_ms, held_mb) = (by_steps_ms, mb);
            worst_ms
        });
        report.row(question("ms", 200.0, "worst of going back up to 50 steps"), || steps_ms);
        report.row(question("MB", 500.0, "held by the history"), || held_mb);
    }
}
