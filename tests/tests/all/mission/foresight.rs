//! Projections with a robot: what they know is what the robot knows.

use rpl_lang::compile::NoFiles;
use rpl_mission::libraries::robot_library;
use rpl_mission::modules::own_modules;
use rpl_mission::robot::Robot;
use rpl_mission::run::{Reached, run_to};
use rpl_mission::site::Site;
use rpl_robot::foresight::abstract_robot::Experience;
use rpl_robot::foresight::models::Chances;
use rpl_robot::office::{AbstractSetting, Board, Forecast};
use rpl_robot::world::World;
use rpl_runtime::robot::Outside;
use rpl_runtime::run::system::Outcome;
use rpl_runtime::state::projected::Grain;
use rpl_tests::mission::{self, Grid, in_abstract_world, model};
use std::any::TypeId;
use std::ops::ControlFlow::Continue;

fn site_in(world: World) -> Site {
    let library = robot_library(own_modules(), Vec::new()).unwrap_or_else(|error| panic!("{error}"));
    Site::of(library, model(world, Grid::Coarse.settings()), own_modules().clone())
}

/// The value of a plan in a world, as it is printed, and when it ended.
fn value_in(world: World, plan: &str) -> (String, f64) {
    let site = site_in(world);
    let robot = site.office_robot(1).expect("there is one");
    value_of(&site, Robot::Office(Box::new(robot)), plan)
}

fn value_of(site: &Site, robot: Robot, plan: &str) -> (String, f64) {
    let plan = site.compile("plan.rpl", plan, &mut NoFiles).unwrap_or_else(|error| panic!("{error}"));
    let mut system = site.start_traced_with(robot, plan, 1);
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
    for grain in [":abstract", ":simulated"] {
        let plan = format!(
            "(let ((p (project '(go-to 'corner) :runs 20 :grain {grain})))
               (append (projection-success p) (projection-time p)))"
        );
        assert_eq!(value_in(closed.clone(), &plan), value_in(test_room(), &plan), "{grain}");
    }
}

// r[project.knowledge]
#[test]
fn a_simulated_robot_is_where_the_real_one_believes_itself_to_be() {
    // It was carried off to the corner, and has not noticed: by what it believes all the way is left.
    let plan = "(list (second (projection-time (project '(go-to 'corner) :runs 8 :grain :simulated))))";
    let site = site_in(test_room());
    let in_corner = test_room().place("corner").expect("it is there").pose_in_map;
    let foreseen_s = |is_carried: bool| {
        let mut robot = site.office_robot(1).expect("there is one");
        if is_carried {
            let host = &mut robot.host;
            host.model.clone().teleport(&mut host.state, in_corner).expect("there is room");
        }
        numbers(&value_of(&site, Robot::Office(Box::new(robot)), plan).0)[0]
    };
    assert!(foreseen_s(true) > 0.8 * foreseen_s(false) && foreseen_s(false) > 10.0);
}

// r[project.grain]
#[test]
fn a_simulated_drive_takes_about_as_long_as_the_drive_itself() {
    let plan = "(let ((p (project '(go-to 'corner) :runs 8 :grain :simulated)) (begun (now)))
                  (go-to 'corner)
                  (list (second (projection-time p)) (- (now) begun)))";
    let times_s = numbers(&value_in(test_room(), plan).0);
    assert!((times_s[0] / times_s[1] - 1.0).abs() < 0.15, "foreseen and taken: {times_s:?}");
}

// r[project.grain]
#[test]
fn a_simulated_drive_goes_on_from_where_the_robot_is_and_as_it_moves() {
    let plan = "(defvar rest nil)
                (par (:tag job (go-to 'corner))
                     (seq (wait-time 4) (setq rest (project-rest :task job :runs 8 :grain :simulated))))
                (list (second (projection-time rest)) (now))";
    let times_s = numbers(&value_in(test_room(), plan).0);
    assert!((4.0 + times_s[0] - times_s[1]).abs() < 0.15 * times_s[1], "{times_s:?}");
}

// r[project.grain]
#[test]
fn simulated_runs_differ_and_the_same_question_has_the_same_answer() {
    let plan = "(let ((p (project '(fetch 'parcel 'corner) :runs 12 :grain :simulated)))
                  (append (projection-success p) (projection-time p)))";
    let (first, _) = value_in(test_room(), plan);
    assert_eq!(first, value_in(test_room(), plan).0);
    let figures = numbers(&first);
    assert!(figures[0] > 0.6 && figures[5] - figures[3] > 0.05, "chance is in it: {first}");
}

// r[project.grain]
#[test]
fn a_door_found_closed_is_closed_in_both_grains_as_long_as_nobody_opens_it() {
    let mut closed = test_room();
    closed.doors[0].open = false;
    let late = |grain: &str| {
        let plan = format!(
            "(let ((before (project '(go-to 'corner) :runs 16 :grain {grain})))
               (ignore-failures (failure) (go-to 'corner :patience 10))
               (let ((after (project '(go-to 'corner :patience 1) :runs 16 :grain {grain})))
                 (list (first (projection-success before)) (first (projection-success after)))))"
        );
        numbers(&value_in(closed.clone(), &plan).0)
    };
    for grain in [":abstract", ":simulated"] {
        let shares = late(grain);
        assert!(shares[0] > 0.8 && shares[1] < 0.5, "{grain}: {shares:?}");
    }
}

// r[project.grain]
#[test]
fn there_are_two_grains_and_a_projection_says_which_is_its_own() {
    let plan = "(list (projection-grain (project '(progn) :grain :simulated)) (projection-grain (project '(progn)))
                      (with-failure-handling ((projection-failure (f) (failure-message f)))
                        (project '(progn) :grain :fine)))";
    let (told, _) = value_in(test_room(), plan);
    assert!(told.starts_with("(:simulated :abstract "), "{told}");
    assert!(told.contains("no grain :fine; write `:grain :abstract`"), "{told}");
}

// r[project.knowledge]
#[test]
fn no_belief_is_carried_into_projected_runs() {
    let site = site_in(test_room());
    let robot = site.office_robot(1).expect("there is one");
    assert!(robot.localization().is_some());
    let plan = site.compile("plan.rpl", "(go-to 'corner)", &mut NoFiles).unwrap_or_else(|error| panic!("{error}"));
    let mut system = site.start_traced_with(Robot::Office(Box::new(robot)), plan, 1);
    run_to(&mut system, 3_000_000, |_| Continue(()));
    for grain in Grain::ALL {
        let foreseen = system.outside.foresee(3_000_000, system.machine.phases(), grain);
        let mut foreseen = foreseen.unwrap_or_else(|_| panic!("{grain:?}"));
        let board = foreseen.part(TypeId::of::<Board>()).and_then(|board| board.downcast_mut::<Board>());
        assert!(board.expect("it has one").position.localization().is_none(), "{grain:?}");
    }
}

// r[project.grain]
#[test]
fn what_has_no_controller_is_not_simulated() {
    let plan = "(with-failure-handling ((projection-failure (f) (failure-message f)))
                  (project '(progn) :grain :simulated))";
    let told = value_in_abstract(NOTHING_BETWEEN, &[], Forecast::Undisturbed, plan);
    assert!(told.contains("has no controller that could be simulated"), "{told}");
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

/// What rules make of a day with three deliveries, projected by a text for its `:failures` and its `:timeline`.
fn ruled(rule: &str, failures: &str, timeline: &str, of: &str) -> String {
    let plan = format!(
        "(let ((p (make-projection :failures '({failures}) :timeline '({timeline}) :fluents '((battery* 0.1 0.2 0.3)))))
           ({rule} p '{of}))"
    );
    value_in(World::builtin("dept").expect("built in"), &plan).0
}

const DAY: &str = "(seq (:tag a (go-to 'mail-slots)) (:tag b (go-to 'a-desk)) (:tag c (go-to 'c-centre)))";

/// A step of it that is not done again once it is finished.
fn step(name: &str, form: &str) -> String {
    format!("(:tag {name} (library:unless (library:finished? {name}) {form}))")
}

fn go_to(place: &str) -> String {
    format!("(go-to (quote {place}))")
}

// r[rule.robot]
#[test]
fn each_rule_of_the_robot_gives_its_text() {
    let [a, b, c] = [("a", "mail-slots"), ("b", "a-desk"), ("c", "c-centre")].map(|(tag, at)| step(tag, &go_to(at)));
    // Of all runs b begins in all, c in less than half: it is b that fails.
    let at_b = "(\"main/b\" 1.0 1 1 1) (\"main/c\" 0.4 2 2 2)";
    let blocked = "(0.6 blocked \"\" \"\" 1)";
    let made = |rule: &str| ruled(rule, blocked, at_b, DAY);
    assert_eq!(made("elsewhere-meanwhile"), format!("(seq {a} {c} {b})"));
    assert_eq!(made("what-becomes-impossible-first"), format!("(seq {b} {a} {c})"));
    let around = |tag: &str, at: &str| step(tag, &format!("(library:go-by-another-way (quote {at}))"));
    assert_eq!(
        made("another-way"),
        format!("(seq {} {} {})", around("a", "mail-slots"), around("b", "a-desk"), around("c", "c-centre"))
    );
    assert_eq!(
        made("charge-before"),
        format!("(seq (:tag charging (library:charge (quote west-end) 0.95)) {a} {b} {c})")
    );
    assert_eq!(made("give-up-in-time"), "nil", "four of ten come through");
    let given_up = ruled("give-up-in-time", "(0.95 blocked \"\" \"\" 1)", "(\"main/b\" 1.0 1 1 1)", DAY);
    assert_eq!(
        given_up,
        format!("(seq {a} (:tag b (library:give-up (quote b))) {c} (:tag end (fail given-up \"b was given up\")))")
    );
    let asked = ruled("ask-somebody", "(0.5 grasp-failure \"\" \"\" 1)", "", "(fetch 'cup 'a-desk :patience 60)");
    assert_eq!(asked, "(library:fetch-asking (quote cup) (quote a-desk) :patience 60)");
    assert_eq!(made("ask-somebody"), "nil", "nothing is missing");
    assert_eq!(ruled("position-before", "(0.5 grasp-failure \"\" \"\" 1)", "", DAY), "nil", "nobody has touched it");
}

// r[rule.robot]
#[test]
fn deliveries_follow_one_another_where_one_way_leads_to_the_next() {
    let deliver =
        |tag: &str, from: &str, to: &str| format!("(:tag {tag} (deliver (quote {tag}) (quote {from}) (quote {to})))");
    let (far, near, on) = (
        deliver("far", "c-centre", "a-desk"),
        deliver("near", "mail-slots", "wolframs-shelf"),
        deliver("on", "wolframs-shelf", "d-centre"),
    );
    let made = ruled("nearest-delivery-next", "", "", &format!("(seq {far} {near} {on})"));
    let places: Vec<usize> =
        ["(:tag near", "(:tag on", "(:tag far"].map(|tag| made.find(tag).unwrap_or_else(|| panic!("{made}"))).to_vec();
    assert!(places.is_sorted(), "{made}");
    assert_eq!(ruled("nearest-delivery-next", "", "", &format!("(seq {near} {on})")), "nil", "they do already");
}

// r[rule.robot]
#[test]
fn a_rule_of_the_robot_is_installed_where_it_pays() {
    // To the table and back is quicker in the other order only where the way leads there anyhow.
    let plan = "(def-plan closing () (if (> (now) 20) (fail \"closed\") (wait-time 1)))
                (with-foresight (:rules (elsewhere-meanwhile what-becomes-impossible-first) :horizon 10min)
                  (seq (:tag drive (go-to 'table-side)) (:tag rest (wait-time 30)) (:tag post (closing))))
                (list (now))";
    assert!(numbers(&value_in(test_room(), plan).0)[0] > 30.0, "all of it was done, although the last closes");
}

// r[project.knowledge]
#[test]
fn what_foresight_is_made_of_holds_nothing_that_the_map_does_not_show() {
    let mut world = World::builtin("dept-furnished").expect("built in");
    world.doors[0].open = !world.doors[0].mapped_open;
    assert!(world.objects.iter().any(|object| !object.mapped) && !world.items.is_empty());
    let model = model(world, Grid::Coarse.settings());
    let known = model.known();
    for world in [&known.world, &known.simulator.world] {
        assert!(world.objects.iter().all(|object| object.mapped) && world.items.is_empty() && world.people.is_empty());
        assert!(world.crowd == 0 && world.doors.iter().all(|door| door.open == door.mapped_open));
    }
}

// r[project.knowledge]
#[test]
fn a_battery_that_is_empty_ends_a_drive_also_in_what_is_projected() {
    let plan = "(let ((p (project '(seq (wait-for (< battery* 0.0005)) (go-to 'table-side)) :runs 4 :horizon 24h)))
                  (map second (projection-failures p)))";
    assert_eq!(value_in(test_room(), plan).0, "(blocked)");
}

/// What a plan in an abstract world gives, as it is printed.
fn value_in_abstract(chances: Chances, messages: &[(u64, &str)], forecast: Forecast, plan: &str) -> String {
    let messages = messages
        .iter()
        .map(|&(at_s, words)| (at_s * 1_000_000, words.split(' ').map(str::to_string).collect()))
        .collect();
    let setting = AbstractSetting { chances, battery: 1.0, messages, forecast };
    let system = in_abstract_world(mission::test_room(), setting, plan);
    match system.outcome() {
        Some(Outcome::Succeeded(value)) => system.machine.write(&system.program, value),
        Some(Outcome::Failed(failure)) => panic!("{}", system.machine.show(&system.program, failure)),
        Some(Outcome::Evaporated) | None => panic!("{plan} has no value"),
    }
}

const NOTHING_BETWEEN: Chances =
    Chances { grasp_misses: 0.0, release_fails: 0.0, thing_missing: 0.0, door_closed: 0.0, held_up: 0.0 };

// r[project.knowledge]
#[test]
fn a_robot_in_an_abstract_world_foresees_by_what_it_has_learned_and_not_by_what_is_so() {
    let missing = Chances { thing_missing: 1.0, ..NOTHING_BETWEEN };
    let learned = || Forecast::Learned(Experience::default());
    let plan = "(let ((p (project '(fetch 'parcel 'table-side) :runs 20)))
                  (append (projection-success p) (projection-time p)))";
    let foreseen = |chances| value_in_abstract(chances, &[], learned(), plan);
    assert_eq!(foreseen(missing), foreseen(NOTHING_BETWEEN), "whether the thing is there is not known");
    let truly = |chances| {
        let plan = "(first (projection-success (project '(fetch 'parcel 'table-side) :runs 20)))";
        value_in_abstract(chances, &[], Forecast::Truth, plan).parse::<f64>().expect("a share")
    };
    assert!(truly(missing) < 0.1 && truly(NOTHING_BETWEEN) > 0.9, "the truth is what the chances make of it");
}

// r[project.knowledge]
#[test]
fn what_people_will_say_is_foreseen_by_the_truth_alone() {
    let plan = "(first (projection-success (project '(wait-for (> messages* 0)) :runs 4 :horizon 5min)))";
    let told = |forecast| {
        value_in_abstract(NOTHING_BETWEEN, &[(60, "deliver parcel")], forecast, plan).parse::<f64>().expect("a share")
    };
    assert!(told(Forecast::Learned(Experience::default())) < 0.5);
    assert!(told(Forecast::Undisturbed) < 0.5);
    assert!(told(Forecast::Truth) > 0.5);
    let said = "(wait-for (> messages* 0)) (list (round (now)) (read-message))";
    assert_eq!(
        value_in_abstract(NOTHING_BETWEEN, &[(60, "deliver parcel")], Forecast::Truth, said),
        "(60 (deliver parcel))"
    );
}

// r[project.knowledge]
#[test]
fn what_is_under_way_in_an_abstract_world_goes_on_in_what_is_projected() {
    let plan = "(defvar rest nil)
                (par (:tag job (fetch 'parcel 'table-side))
                     (seq (wait-time 2) (setq rest (project-rest :task job :runs 4))))
                (list (second (projection-time rest)) (now))";
    let times_s = numbers(&value_in_abstract(NOTHING_BETWEEN, &[], Forecast::Undisturbed, plan));
    assert!((2.0 + times_s[0] - times_s[1]).abs() < 0.05 * times_s[1], "{times_s:?}");
}

// r[project.knowledge]
#[test]
fn a_door_counts_once_in_a_run_and_as_closed_also_where_the_robot_waits_for_it() {
    let learned = |door_closed, plan| {
        let chances = Chances { door_closed, ..NOTHING_BETWEEN };
        let setting = AbstractSetting { chances, battery: 1.0, messages: Vec::new(), forecast: Forecast::Undisturbed };
        let system = in_abstract_world(mission::test_room(), setting, plan);
        let drives = &system.outside.robot().experience.drives;
        (drives.drives.len(), drives.doors_open, drives.doors_closed)
    };
    let to_and_fro = "(go-to 'corner :patience 1000) (go-to 'table-side :patience 1000) (go-to 'corner)";
    assert_eq!(learned(0.0, to_and_fro), (3, 1, 0));
    assert_eq!(learned(1.0, to_and_fro), (3, 0, 1), "it waited, and came through");
    let in_vain = "(ignore-failures (blocked) (go-to 'corner :patience 0))";
    assert_eq!(learned(1.0, in_vain), (0, 0, 1), "it did not come through");
}
