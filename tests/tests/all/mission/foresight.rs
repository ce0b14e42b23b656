//! Projections with a robot: what they know is what the robot knows.

use rpl_lang::compile::NoFiles;
use rpl_mission::libraries::robot_library;
use rpl_mission::modules::own_modules;
use rpl_mission::run::{Reached, run_to};
use rpl_mission::site::Site;
use rpl_robot::world::World;
use rpl_runtime::run::system::Outcome;
use rpl_tests::mission::{Grid, model};
use std::ops::ControlFlow::Continue;

/// The value of a plan in a world, as it is printed, and when it ended.
fn value_in(world: World, plan: &str) -> (String, f64) {
    let library = robot_library(own_modules(), Vec::new()).unwrap_or_else(|error| panic!("{error}"));
    let site = Site::of(library, model(world, Grid::Coarse.settings()), own_modules().clone());
    let plan = site.compile("plan.rpl", plan, &mut NoFiles).unwrap_or_else(|error| panic!("{error}"));
    let mut system = site.start(plan, 1);
    match run_to(&mut system, 3_600_000_000, |_| Continue(())) {
        Reached::End(Outcome::Succeeded(value)) => {
            (system.machine.write(&system.program, value), system.machine.now_s())
        }
        Reached::End(Outcome::Failed(failure)) => panic!("{}", system.machine.show(&system.program, failure)),
        other => panic!("{other:?}"),
    }
}

fn test_room() -> World {
    World::builtin("test-room").expect("built in")
}

fn numbers(text: &str) -> Vec<f64> {
    let words = text.split(['(', ')', ' ']).filter(|word| !word.is_empty());
    words.map(|word| word.parse().unwrap_or_else(|_| panic!("{text}"))).collect()
}

// r[project.knowledge]
#[test]
fn a_projection_follows_the_belief_where_the_truth_is_another() {
    // The door is really closed, and the map shows it open: nobody has been there to see it.
    let mut closed = test_room();
    assert!(closed.doors[0].mapped_open, "the map shows the door open");
    closed.doors[0].open = false;
    let plan =
        "(let ((p (project '(go-to 'table-side) :runs 20))) (append (projection-success p) (projection-time p)))";
    assert_eq!(value_in(closed, plan), value_in(test_room(), plan));
}

#[test]
fn a_drive_takes_about_as_long_as_it_is_foreseen() {
    let plan = "(let ((p (project '(go-to 'table-side) :runs 40)) (begun (now)))
                  (go-to 'table-side)
                  (list (second (projection-time p)) (- (now) begun)))";
    let times_s = numbers(&value_in(test_room(), plan).0);
    assert!((times_s[0] / times_s[1] - 1.0).abs() < 0.2, "foreseen and taken: {times_s:?}");
}

#[test]
fn a_drive_that_goes_on_is_projected_from_where_the_robot_is() {
    let plan = "(defvar rest nil)
                (par (:tag job (go-to 'table-side))
                     (seq (wait-time 2) (setq rest (project-rest :task job :runs 10))))
                (list (second (projection-time (project '(progn) :runs 1))) (second (projection-time rest)) (now))";
    let times_s = numbers(&value_in(test_room(), plan).0);
    assert!((2.0 + times_s[1] - times_s[2]).abs() < 0.25 * times_s[2], "{times_s:?}");
}

// r[project.refused]
#[test]
fn a_behaviour_without_a_model_is_named() {
    let plan = "(with-failure-handling ((projection-failure (f) (failure-message f)))
                  (project '(with-valve wheels (run-behaviour wall-follow)) :runs 2))";
    let (told, _) = value_in(test_room(), plan);
    assert!(told.contains("no model of what the behaviour `wall-follow` does"), "{told}");
}

#[test]
fn the_real_run_is_what_it_would_be_without_the_question() {
    let (_, without_s) = value_in(test_room(), "(go-to 'table-side)");
    let (_, with_s) = value_in(test_room(), "(project '(fetch 'parcel 'table-side) :runs 1) (go-to 'table-side)");
    assert!((with_s - without_s).abs() < 0.5, "thinking takes a moment, and nothing else is different");
}
