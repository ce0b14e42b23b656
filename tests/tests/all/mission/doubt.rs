//! A position that leads to a contradiction is given up: `go-to` after a false relocalization.

use super::world::{closed_room, wheels_are_free};
use rpl_mission::modules::SiteRobot;
use rpl_robot::geometry::Pose;
use rpl_robot::localization::Spread;
use rpl_robot::office::ReportKind;
use rpl_tests::mission::{Mission, Run, run_until};

/// Another room, whose door is closed.
const ELSEWHERE: Pose = Pose { x_m: 6.5, y_m: 3.0, heading_rad: 0.0 };

fn believes_to_be_elsewhere(robot: &mut SiteRobot) {
    // It is sure of that.
    believes_to_be_about(robot, Spread { position_m: 0.1, heading_rad: 2_f64.to_radians() });
}

fn believes_to_be_about(robot: &mut SiteRobot, spread: Spread) {
    robot.tell_position(ELSEWHERE, spread);
}

#[test]
fn after_an_interruption_a_contradiction_is_a_wrong_position() {
    let plan = "(with-policy (seq (wait-time 1) (with-valve wheels (wait-time 1))) (go-to 'table-side))";
    let mut system = Mission::new(closed_room(), plan).start(1);
    assert!(run_until(&mut system, 10.0, |system| system.machine.now_s() >= 1.9));
    believes_to_be_elsewhere(&mut system.outside);
    system.run_until(400_000_000);
    let run = Run::of(system);
    assert_eq!(run.count(|event| ReportKind::of(event) == Some(ReportKind::PositionDoubted)), 1, "{}", run.trace());
    assert!(run.outcome().starts_with("=>"), "{}\n{}", run.outcome(), run.trace());
    let there = run.system.outside.model().world.place("table-side").expect("a place").pose_in_map;
    let pose = run.system.outside.true_pose_in_map();
    assert!(libm::hypot(pose.x_m - there.x_m, pose.y_m - there.y_m) < 0.5, "{pose:?}");
    assert!(wheels_are_free(&run.system));
}

#[test]
fn at_the_first_attempt_a_contradiction_reaches_the_caller() {
    let plan = "(with-failure-handling ((unreachable (f) (now))) (go-to 'table-side))";
    let mission = Mission::new(closed_room(), plan);
    let mut robot = mission.robot(1);
    believes_to_be_elsewhere(&mut robot);
    let mut system = mission.start_with(robot, 1);
    system.run_until(60_000_000);
    let run = Run::of(system);
    assert_eq!(run.outcome(), "=> 0.0");
    assert_eq!(run.count(|event| ReportKind::of(event) == Some(ReportKind::PositionDoubted)), 0);
}

/// It may have been called away from the search for its position.
#[test]
fn a_contradiction_to_a_position_that_is_not_quite_sure_is_a_wrong_position() {
    let mission = Mission::new(closed_room(), "(go-to 'table-side)");
    let mut robot = mission.robot(1);
    believes_to_be_about(&mut robot, Spread { position_m: 0.16, heading_rad: 4_f64.to_radians() });
    let certainty = robot.estimate().certainty;
    assert!(certainty > 0.8 && certainty < 0.9, "{certainty}");
    let mut system = mission.start_with(robot, 1);
    system.run_until(400_000_000);
    let run = Run::of(system);
    assert_eq!(run.count(|event| ReportKind::of(event) == Some(ReportKind::PositionDoubted)), 1, "{}", run.trace());
    assert!(run.outcome().starts_with("=>"), "{}\n{}", run.outcome(), run.trace());
}

#[test]
fn a_destination_that_really_has_no_way_is_given_up_after_two_doubts() {
    let plan = "(with-policy (seq (wait-time 1) (with-valve wheels (wait-time 1)))
                  (with-failure-handling ((unreachable (f) 'given-up)) (go-to 'table-side)))";
    let mission = Mission::new(closed_room(), plan);
    let mut system = mission.start(1);
    assert!(run_until(&mut system, 10.0, |system| system.machine.now_s() >= 1.9));
    let model = system.outside.model().clone();
    model.simulator.teleport(&mut system.outside.host.state, ELSEWHERE).expect("free");
    believes_to_be_elsewhere(&mut system.outside);
    system.run_until(900_000_000);
    let run = Run::of(system);
    assert_eq!(run.outcome(), "=> given-up", "{}", run.trace());
    assert_eq!(run.count(|event| ReportKind::of(event) == Some(ReportKind::PositionDoubted)), 2, "{}", run.trace());
}
