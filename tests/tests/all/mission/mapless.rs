//! Missions without a map: odometry and sensors are all there is.

use rpl_robot::geometry::{Point, distance_m};
use rpl_robot::office::{OfficeModel, OfficeSettings};
use rpl_robot::world::World;
use rpl_runtime::run::system::System;
use rpl_tests::mission::{Grid, Mission, fluent_text, lines, model, run_until, test_room};
use std::sync::{Arc, OnceLock};

/// The test room, of which the robot knows nothing: it starts at (1.5, 3), looking along x, and the
/// way into the other room is through the door at (5, 3).
fn unknown_room() -> Arc<OfficeModel> {
    static MODEL: OnceLock<Arc<OfficeModel>> = OnceLock::new();
    let build = || {
        let settings = OfficeSettings { map_known: false, ..Grid::Coarse.settings() };
        model(World::builtin("test-room").expect("built in"), settings)
    };
    MODEL.get_or_init(build).clone()
}

fn outcome(plan: &str, until_s: f64) -> String {
    Mission::new(unknown_room(), plan).run(1, until_s).outcome()
}

#[test]
fn a_point_in_the_next_room_is_reached() {
    let model = unknown_room();
    let start_in_map = model.world.start_in_map;
    for seed in 0..3 {
        let run = Mission::new(model.clone(), "(go-to-point 5.0 -1.2 90deg) (list x* y* o*)").run(seed, 300.0);
        assert!(run.outcome().starts_with("=>"), "{}", run.outcome());
        let robot = &run.system.outside;
        let goal_in_map = start_in_map.transform(Point::new(5.0, -1.2));
        let away_m = distance_m(robot.true_pose_in_map().point(), goal_in_map);
        assert!(away_m < 0.6 && robot.contacts().caused == 0, "seed {seed}: {away_m}");
    }
}

#[test]
fn the_position_is_the_odometrys_and_never_lost() {
    let mut system = Mission::new(unknown_room(), "(go-to-point 2 0)").start(1);
    assert!(!run_until(&mut system, 200.0, |system| fluent_text(system, "pos-certainty*") != "1.0"
        && system.machine.now_s() > 0.1));
    let x_m: f64 = fluent_text(&system, "x*").parse().expect("a number");
    assert!((x_m - 2.0).abs() < 0.3, "{x_m}");
    assert_eq!(fluent_text(&system, "region*"), "nil");
    assert_eq!(fluent_text(&system, "nr-of-nav-goals*"), "0");
}

#[test]
fn a_point_inside_a_wall_is_a_failure_a_plan_can_handle() {
    let plan = "(with-failure-handling (((unreachable blocked) (f) (failure-class f))) (go-to-point -2.5 0))";
    let outcome = outcome(plan, 1800.0);
    assert!(["=> unreachable", "=> blocked"].contains(&outcome.as_str()), "{outcome}");
}

#[test]
fn what_needs_a_map_says_what_to_type() {
    for call in
        ["(go-to 'corner)", "(place-pose 'corner)", "(generate-navigation-plan 'corner)", "(distance-to 'corner)"]
    {
        let outcome = outcome(call, 10.0);
        assert!(outcome.contains("unreachable") && outcome.contains("(go-to-point X Y)"), "{call}: {outcome}");
    }
    for call in ["(doubt-position)", "(with-valve wheels (run-behaviour active-localization))"] {
        let outcome = outcome(call, 10.0);
        assert!(outcome.contains("localization-failure") && outcome.contains("--map none"), "{call}: {outcome}");
    }
    assert!(outcome("(belief-maxima)", 10.0).starts_with("=> ((0.0 0.0 0.0 1.0))"));
}

#[test]
fn another_task_takes_the_wheels_and_the_drive_goes_on() {
    let plan = "(par (go-to-point 3 0)
                     (with-policy (seq (wait-time 2) (with-valve wheels (wait-time 2))) (wait-time 5)))";
    let run = Mission::new(unknown_room(), plan).run(1, 200.0);
    assert!(run.outcome().starts_with("=>"), "{}\n{}", run.outcome(), run.trace());
    let pose = run.system.outside.estimate().pose_in_map;
    assert!(distance_m(pose.point(), Point::new(3.0, 0.0)) < 0.4, "{pose:?}");
}

#[test]
fn a_run_saved_and_loaded_on_the_way_goes_on_the_same() {
    let mission = Mission::new(unknown_room(), "(go-to-point 5.0 -1.2)");
    let mut system = mission.start(1);
    run_until(&mut system, 6.0, |_| false);
    system.machine.trace.take();
    let mut copy = mission.load(&system.save(), 1);
    system.run_until(300_000_000);
    copy.run_until(300_000_000);
    assert!(system.outcome().is_some());
    assert_eq!(lines(&system.machine.trace.take()), lines(&copy.machine.trace.take()));
}

#[test]
fn a_run_saved_without_a_map_is_not_taken_for_one_with_a_map() {
    let mission = Mission::new(unknown_room(), "(go-to-point 2 0)");
    let bytes = mission.start(1).save();
    let with_map = Mission::new(test_room(), "(go-to-point 2 0)");
    let library = mission.start(1).library;
    let loaded = System::load(&bytes, library, mission.plan.clone(), with_map.robot(1));
    let error = loaded.err().expect("another setting").to_string();
    assert!(error.contains("without a map"), "{error}");
}
