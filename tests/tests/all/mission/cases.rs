//! Driving by cases: routes made of remembered ones, behaviours that are retrieved, and what is learned.

use rpl_mission::modules::SiteRobot;
use rpl_robot::description::RobotDescription;
use rpl_robot::office::{OfficeModel, OfficeSettings};
use rpl_robot::world::World;
use rpl_runtime::run::system::{Progress, System};
use rpl_runtime::state::trace::Event;
use rpl_rupart::case::Kind;
use rpl_rupart::forgetting::Capacity;
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
    assert_value("(seq (go-by-cases 'in-south) (length (cases-of 'route)))", "1");
    let again =
        "(seq (go-by-cases 'in-south) (go-by-cases 'in-north) (go-by-cases 'in-south) (length (cases-of 'route)))";
    assert_value(again, "2");
}

#[test]
fn a_route_case_is_used_when_a_route_is_made_of_it_and_succeeds_when_that_is_driven() {
    let sums = "(let ((routes (cases-of 'route)))
                  (list (apply #'+ (map #'third routes)) (apply #'+ (map #'fourth routes))))";
    // The way back is made of the way there, as far as they go together.
    assert_value(&format!("(seq (go-by-cases 'in-south) (go-by-cases 'in-north) {sums})"), "(1 1)");
    let blocked = "(with-failure-handling ((blocked (f) nil)) (go-by-cases 'in-north :patience 0))";
    assert_value(&format!("(seq (go-by-cases 'in-south) {blocked} {sums})"), "(3 0)");
}

#[test]
fn what_is_retrieved_on_the_way_is_a_behaviour_and_explains_itself() {
    let plan = "(pursue (go-by-cases 'in-south) (seq (wait-for (eq case-kind* 'behaviour)) (list (value case*) (value case-kind*) (explain-case))))";
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
    assert_value("(list (forget-case 0) (forget-case 0) (retrieve-case) (length (cases)))", "(t nil 1 3)");
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

#[test]
fn of_two_goals_the_more_important_is_gone_to_first() {
    let plan = "(seq
                  (retain-goal 'in-south 0.2)
                  (retain-goal 'in-north 0.9)
                  (reach-goal (retrieve-next-case))
                  (print (list (at-destination? 'in-north) (length (cases-of 'goal))))
                  (reach-goals)
                  (list (at-destination? 'in-south) (cases-of 'goal)))";
    let run = run(plan);
    assert_eq!((run.outcome(), run.output.concat().trim()), ("=> (t nil)".to_string(), "(t 1)"));
}

#[test]
fn another_goal_that_is_more_urgent_comes_before_the_one_that_is_driven_to() {
    let plan = "(seq
                  (retain-goal 'in-south 0.3)
                  (with-policy (seq (wait-time 4) (retain-goal 'in-north 1.0))
                    (reach-goal (retrieve-next-case))
                    (print (list (at-destination? 'in-south) (case-goal (retrieve-next-case))))
                    (reach-goal (retrieve-next-case))
                    (print (at-destination? 'in-north))
                    (reach-goals))
                  (list (at-destination? 'in-south) (cases-of 'goal)))";
    let run = run(plan);
    assert_eq!(run.outcome(), "=> (t nil)");
    assert_eq!(run.output.join(" "), "(nil in-north) t");
}

#[test]
fn a_robot_that_is_turned_by_hand_reaches_its_goals() {
    let plan =
        "(seq (retain-goal 'in-south 0.9) (retain-goal 'in-north 0.2) (reach-goals) (at-destination? 'in-north))";
    let run = mission(plan).with_scenario("(wait-time 6) (rotate-robot! 70deg)").run(SEED, 300.0);
    assert_eq!(run.outcome(), "=> t");
}

#[test]
fn a_robot_that_is_lost_is_told_to_find_its_position_first() {
    let plan = "(seq
                  (retain-goal 'in-south)
                  (print (list (case-plan (retrieve-next-case)) (case-plan (retrieve-case 'in-south))))
                  (reach-goals)
                  (at-destination? 'in-south))";
    let mission = mission(plan);
    let mut robot = mission.robot(SEED);
    robot.forget_position();
    let mut system = mission.start_with(robot, SEED);
    system.run_until(600_000_000);
    let run = Run::of(system);
    assert_eq!((run.outcome(), run.output.concat().trim()), ("=> t".to_string(), "(localize-first localize-first)"));
}

#[test]
fn what_cannot_be_reached_is_tried_twice_and_remembered_as_what_to_train_for() {
    let plan = "(seq
                  (retain-goal 'in-south)
                  (with-failure-handling ((blocked (f) nil)) (reach-goals :patience 0))
                  (list (map #'rest (cases-of 'goal))
                    (map (lambda (case) (case-plan (first case))) (cases-of 'meta-plan))))";
    assert_value(plan, "(((goal 2 0)) (localize-first localize-first make-route train-behaviour))");
    let both = "(seq
                  (retain-goal 'in-south 0.9)
                  (retain-goal 'in-north 0.2)
                  (with-failure-handling ((blocked (f) nil)) (reach-goals :patience 0))
                  (map #'rest (cases-of 'goal)))";
    assert_value(both, "((goal 2 0) (goal 2 0))");
}

/// A box stands in the door to the south.
#[test]
fn a_goal_that_is_put_off_stays_remembered_as_it_is_while_the_others_are_reached() {
    let plan = "(with-policy (whenever (changed goals*) (print (list (value goals*) (at-destination? 'in-north))))
                  (retain-goal 'in-south 0.9 10min)
                  (retain-goal 'in-north 0.2)
                  (with-failure-handling ((blocked (f) 'in-vain))
                    (reach-goals :patience 5)))";
    let run = mission(plan).with_scenario("(add-object! 'box 5.9 3.2 7.1 3.6)").run(SEED, 600.0);
    assert_eq!(run.outcome(), "=> in-vain");
    assert_eq!(run.output.last().map(|line| line.trim()), Some("(1 t)"), "{:?}", run.output);
    let memory = run.system.outside.controller.modules.rupart.memory();
    let left: Vec<_> = memory.cases_of(Kind::Goal).map(|(_, case)| (case.index.priority, case.index.time_s)).collect();
    assert_eq!(left, [(Some(0.9), Some(600.0))]);
}

#[test]
fn as_many_goals_wait_as_a_robot_remembers() {
    let most = Capacity::USUAL.goals;
    let plan = format!(
        "(seq
           (dotimes (i {most}) (retain-goal 'in-south))
           (with-failure-handling ((too-many-goals (f) (list 'told (length (cases-of 'goal)))))
             (retain-goal 'in-north)))"
    );
    assert_value(&plan, &format!("(told {most})"));
}

#[test]
fn goals_that_are_none_are_told() {
    let told = |plan: &str, message: &str| assert!(run(plan).outcome().contains(message), "{}", run(plan).outcome());
    told("(retain-goal 'nowhere)", "place `nowhere` is not in world `hall-and-rooms`");
    told("(retain-goal 'in-south 2)", "a goal has a priority from 0 to 1");
    assert_value("(list (case-goal 0) (case-plan 0))", "(nil nil)");
}

/// Twenty moments, each for a run of its own.
fn moments_s() -> impl Iterator<Item = f64> {
    (0..20).map(|moment| 0.3 + f64::from(moment))
}

/// The wheels are taken.
#[test]
fn interrupted_at_any_moment_it_arrives_all_the_same() {
    for wait_s in moments_s() {
        let plan = format!(
            "(with-policy (seq (wait-time {wait_s}) (with-valve wheels (wait-time 1)))
               (go-by-cases 'in-south)
               (at-destination? 'in-south))"
        );
        assert_value(&plan, "t");
    }
}

/// Turned by hand, it loses its position and finds it again under the policy. Turned less than a metre or two before its
/// goal it has no way left to notice on, and looks around before it says that it is there.
#[test]
fn turned_at_any_moment_it_arrives_all_the_same() {
    let plan = "(seq (go-by-cases 'in-south) (at-destination? 'in-south))";
    for wait_s in moments_s() {
        let scenario = format!("(wait-time {wait_s}) (rotate-robot! 70deg)");
        let run = mission(plan).with_scenario(&scenario).run(SEED, 600.0);
        assert_eq!(run.outcome(), "=> t", "turned after {wait_s} s");
        let (truth, estimate) = (run.system.outside.true_pose_in_map(), run.system.outside.estimate().pose_in_map);
        assert!(truth.distance_m(estimate) < 0.5, "turned after {wait_s} s it takes {truth:?} for {estimate:?}");
    }
}

/// Whoever drives by cases is ended; nothing of it is left, and the next one arrives.
#[test]
fn evaporated_at_any_moment_it_leaves_nothing_behind() {
    for wait_s in moments_s() {
        let plan = format!(
            "(seq
               (pursue (go-by-cases 'in-south) (wait-time {wait_s}))
               (wait-time 0.2)
               (let ((left (list (value short-term-goal*) (with-valve wheels 'free))))
                 (go-by-cases 'in-south)
                 (append left (list (at-destination? 'in-south)))))"
        );
        assert_value(&plan, "(nil free t)");
    }
}

#[test]
fn a_fork_goes_on_as_the_run_does() {
    let mission = mission("(seq (go-by-cases 'in-south) (go-by-cases 'in-north))");
    let whole = mission.run(SEED, 300.0).trace();
    for instants in (0..600).step_by(30) {
        let mut system = mission.start(SEED);
        let mut events = Vec::new();
        for _ in 0..instants {
            assert_eq!(system.advance(), Progress::Running);
        }
        events.append(&mut system.machine.trace.take());
        let mut fork = system.clone();
        let mut of_fork = events.clone();
        let to_end = |system: &mut System<SiteRobot>, events: &mut Vec<Event>| {
            while system.advance() == Progress::Running {}
            events.append(&mut system.machine.trace.take());
        };
        // The fork first: what it learns must not reach the run.
        to_end(&mut fork, &mut of_fork);
        to_end(&mut system, &mut events);
        assert_eq!(lines(&of_fork), whole, "forked after {instants} instants");
        assert_eq!(lines(&events), whole, "the run that was forked after {instants} instants");
    }
}

/// A block in the middle, and places on one side of it.
const BLOCK: &str = r#"
name = "round-a-block"
size = [9.0, 9.0]
start = [1.5, 1.5, 0.0]
[[wall]]
line = [[0.1, 0.1], [8.9, 0.1], [8.9, 8.9], [0.1, 8.9], [0.1, 0.1]]
[[object]]
name = "block"
rect = [3.0, 3.0, 6.0, 6.0]
[[place]]
name = "west"
pose = [1.5, 1.5, 0.0]
[[place]]
name = "east"
pose = [7.5, 1.5, 0.0]
"#;

/// The short way is closed, which no map shows: no chain of places leads round the other side of the block.
#[test]
fn who_is_blocked_goes_round_and_knows_the_way_the_next_time() {
    let robot = RobotDescription::builtin("pioneer-2dx").expect("built in");
    let block = model(World::parse(BLOCK, "block.toml").expect("no faults"), OfficeSettings::of(robot));
    let plan = "(let ((before (adapt-route 'east)))
                  (go-by-cases 'east :patience 5)
                  (print (at-destination? 'east))
                  (go-by-cases 'west :patience 5)
                  (list before (length (remove-if #'symbolp (adapt-route 'east)))))";
    let closed = Mission::new(block, plan).with_scenario("(add-object! 'box 4.2 0.2 4.8 3.1)");
    let run = closed.run(SEED, 600.0);
    assert_eq!(run.output.concat().trim(), "t", "{}", run.outcome());
    let (told, corners) =
        run.outcome().rsplit_once(' ').map(|(told, corners)| (told.to_string(), corners.to_string())).expect("a list");
    assert_eq!(told, "=> ((west east)");
    assert!(corners.trim_end_matches(')').parse::<u32>().is_ok_and(|corners| corners >= 2), "{corners}");
}
