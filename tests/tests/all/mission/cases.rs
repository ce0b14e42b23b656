//! Driving by cases: routes made of remembered ones, behaviours that are retrieved, and what is learned.

use rpl_robot::description::RobotDescription;
use rpl_robot::office::{OfficeModel, OfficeSettings};
use rpl_robot::world::World;
use rpl_runtime::run::system::Progress;
use rpl_tests::mission::{Mission, Run, lines, model};
use std::sync::{Arc, OnceLock};

const SEED: u64 = 3;

/// A hall with a room on either side of it.
const HALL: &str = r#"
name = "hall-and-rooms"
size = [9.0, 9.0]
start = [2.0, 4.5, 0.0]
[[wall]]
line = [[0.1, 0.1], [8.9, 0.1], [8.9, 8.9], [0.1, 8.9], [0.1, 0.1]]
[[wall]]
line = [[0.1, 3.4], [8.9, 3.4]]
[[wall]]
line = [[0.1, 5.6], [8.9, 5.6]]
[[room]]
name = "south"
rect = [0.2, 0.2, 8.8, 3.3]
[[room]]
name = "north"
rect = [0.2, 5.7, 8.8, 8.8]
[[door]]
room = "south"
at = [6.5, 3.4]
width = 1.0
axis = "x"
[[door]]
room = "north"
at = [3.5, 5.6]
width = 1.0
axis = "x"
[[place]]
name = "hall-west"
pose = [3.5, 4.5, 0.0]
[[place]]
name = "hall-east"
pose = [6.5, 4.5, 0.0]
[[place]]
name = "in-south"
pose = [6.5, 1.8, 0.0]
room = "south"
[[place]]
name = "in-north"
pose = [3.5, 7.2, 0.0]
room = "north"
"#;

fn hall() -> Arc<OfficeModel> {
    static MODEL: OnceLock<Arc<OfficeModel>> = OnceLock::new();
    let build = || {
        let robot = RobotDescription::builtin("pioneer-2dx").expect("built in");
        model(World::parse(HALL, "hall.toml").expect("no faults"), OfficeSettings::of(robot))
    };
    MODEL.get_or_init(build).clone()
}

fn mission(plan: &str) -> Mission {
    Mission::new(hall(), plan)
}

fn run(plan: &str) -> Run {
    mission(plan).run(SEED, 300.0)
}

fn assert_value(plan: &str, wanted: &str) {
    let run = run(plan);
    assert_eq!(run.outcome(), format!("=> {wanted}"), "{}", run.output.join("\n"));
    assert_eq!(run.system.outside.contacts().caused, 0);
}

#[test]
fn a_place_is_reached_over_places_in_sight_of_each_other() {
    assert_value("(adapt-route 'in-south)", "(hall-west hall-east in-south)");
    assert_value("(seq (go-by-cases 'in-south) (at-destination? 'in-south))", "t");
}

#[test]
fn a_driven_route_is_remembered_once() {
    let kinds = "(map (lambda (case) (second case)) (cases))";
    assert_value(&format!("(seq (go-by-cases 'in-south) {kinds})"), "(behaviour route)");
    let again = "(seq (go-by-cases 'in-south) (go-by-cases 'in-north) (go-by-cases 'in-south) (length (cases)))";
    assert_value(again, "3");
}

#[test]
fn what_is_retrieved_on_the_way_is_a_behaviour_and_explains_itself() {
    let plan = "(pursue (go-by-cases 'in-south) (seq (wait-for case*) (list (value case*) (value case-kind*) (explain-case))))";
    let run = run(plan);
    assert!(run.outcome().starts_with("=> (0 behaviour \"case 0 (behaviour), distance "), "{}", run.outcome());
}

#[test]
fn who_takes_the_wheels_only_delays_it() {
    let plan = "(with-policy (seq (wait-for (eq short-term-goal* 'in-south)) (with-valve wheels (wait-time 3)))
                  (go-by-cases 'in-south)
                  (at-destination? 'in-south))";
    assert_value(plan, "t");
}

#[test]
fn a_case_that_is_forgotten_is_not_used() {
    assert_value("(list (forget-case 0) (forget-case 0) (retrieve-case) (cases))", "(t nil nil nil)");
    let run = run("(use-case 7)");
    assert!(run.outcome().contains("there is no case 7; `(cases)` lists them"), "{}", run.outcome());
}

#[test]
fn what_is_no_route_is_told() {
    let told = |plan: &str, message: &str| {
        let run = run(&format!("(with-valve wheels {plan})"));
        assert!(run.outcome().contains(message), "{}", run.outcome());
    };
    told("(run-behaviour case-navigation :route '(nowhere))", "the world has no place `nowhere`");
    told("(run-behaviour case-navigation :route nil)", "is no route; it is a list of places and points `(x y)`");
    told("(run-behaviour case-navigation :route '((1 2 3)))", "is no route");
    told("(adapt-route 'nowhere)", "place `nowhere` is not in world `hall-and-rooms`");
}

/// Saved and loaded at every fortieth step.
#[test]
fn reloading_on_the_way_changes_nothing() {
    let mission = mission("(go-by-cases 'in-south)");
    let mut system = mission.start(SEED);
    let (mut events, mut instants) = (Vec::new(), 0);
    while system.advance() == Progress::Running {
        events.append(&mut system.machine.trace.take());
        instants += 1;
        if instants % 40 == 0 {
            let bytes = system.save();
            system = mission.load(&bytes, SEED);
            assert!(bytes == system.save(), "the copy differs at {} s", system.machine.now_s());
        }
    }
    events.append(&mut system.machine.trace.take());
    assert_eq!(lines(&events), mission.run(SEED, 300.0).trace());
}
