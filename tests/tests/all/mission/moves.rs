//! Turns and straight stretches by the odometry, forgetting what was seen, and recoveries made of them.

use rpl_robot::foresight::models::Chances;
use rpl_robot::office::{AbstractSetting, Forecast};
use rpl_tests::mission::{Mission, Run, dept, in_abstract_world, test_room};
use rpl_tests::outcome_text;

/// What a form turns and drives by its odometry, in degrees and centimetres to the left and ahead of where it
/// stood, with its failure, if any, and whether something touched the robot.
const MEASURED: &str = "
(defvar turned 0)
(defvar touched nil)
(def-plan watch ()
  (let ((last (third (odometry-pose))))
    (loop (wait-time 0.1)
          (when (value bumped?*) (setf touched t))
          (let ((heading (third (odometry-pose))))
            (incf turned (normalize-angle (- heading last)))
            (setf last heading)))))
(defmacro measured (form)
  `(let ((from (odometry-pose)) (begun (now)) (failure nil))
     (setf turned 0)
     (pursue (seq (with-failure-handling ((failure (f) (setf failure (failure-class f)))) ,form)
                  (wait-time 0.3))
             (watch))
     (let ((to (odometry-pose)))
       (let ((dx (- (first to) (first from))) (dy (- (second to) (second from))) (o (third from)))
         (print (list (round (rad->deg turned))
                      (round (* 100 (+ (* dx (cos o)) (* dy (sin o)))))
                      (round (* 100 (- (* dy (cos o)) (* dx (sin o)))))
                      failure touched (round (- (now) begun))))))))
";

/// One line of `measured`: degrees, centimetres ahead and to the left, failure, contact, seconds.
#[derive(Debug)]
struct Measured {
    turned_deg: i64,
    ahead_cm: i64,
    left_cm: i64,
    failure: String,
    touched: String,
    took_s: i64,
}

fn run(world: &str, plan: &str) -> Run {
    let model = if world == "dept" { dept() } else { test_room() };
    Mission::new(model, &format!("{MEASURED}{plan}")).run(1, 600.0)
}

fn measured(world: &str, plan: &str) -> Vec<Measured> {
    let run = run(world, plan);
    assert!(run.outcome().starts_with("=>"), "{}", run.outcome());
    let line = |line: &String| {
        let words: Vec<&str> = line.trim_matches(['(', ')']).split(' ').collect();
        let number = |at: usize| words[at].parse().unwrap_or_else(|_| panic!("{line}"));
        Measured {
            turned_deg: number(0),
            ahead_cm: number(1),
            left_cm: number(2),
            failure: words[3].to_string(),
            touched: words[4].to_string(),
            took_s: number(5),
        }
    };
    run.output.iter().map(line).collect()
}

#[test]
fn a_spin_turns_as_far_as_it_says_and_stays_where_it_is() {
    for world in ["test-room", "dept"] {
        let plan = "(measured (spin 90deg)) (measured (spin -45deg)) (measured (spin 360deg)) (measured (spin 810deg))";
        for (found, wanted_deg) in measured(world, plan).iter().zip([90, -45, 360, 810]) {
            assert!((found.turned_deg - wanted_deg).abs() <= 5, "{found:?} of {wanted_deg}");
            assert!(found.ahead_cm.abs() <= 5 && found.left_cm.abs() <= 5, "{found:?}");
            assert_eq!(found.failure, "nil");
        }
    }
}

#[test]
fn who_is_lost_turns_and_backs_up_all_the_same() {
    let plan = "(doubt-position) (wait-for position-lost*) (measured (spin 90deg)) (measured (back-up 20cm))";
    let found = measured("test-room", plan);
    assert!((found[0].turned_deg - 90).abs() <= 5 && found[0].failure == "nil", "{found:?}");
    assert!((found[1].ahead_cm + 20).abs() <= 5 && found[1].failure == "nil", "{found:?}");
}

#[test]
fn straight_stretches_are_as_long_as_they_say() {
    for world in ["test-room", "dept"] {
        let found =
            measured(world, "(measured (drive-ahead 50cm)) (measured (back-up 30cm)) (measured (drive-ahead -10cm))");
        for (found, wanted_cm) in found.iter().zip([50, -30, -10]) {
            assert!((found.ahead_cm - wanted_cm).abs() <= 5 && found.left_cm.abs() <= 5, "{found:?} of {wanted_cm}");
            assert_eq!((found.failure.as_str(), found.touched.as_str()), ("nil", "nil"));
        }
    }
}

/// The room is eight metres long, and the robot stands a metre and a half from its west wall.
#[test]
fn before_a_wall_it_stands_and_soon_says_that_it_is_blocked() {
    let found = measured("test-room", "(measured (back-up 5m)) (measured (drive-ahead 20m :patience 2))");
    let [back, ahead] = &found[..] else { panic!("{found:?}") };
    for found in [back, ahead] {
        assert_eq!((found.failure.as_str(), found.touched.as_str()), ("blocked", "nil"), "{found:?}");
    }
    assert!((-115..=-85).contains(&back.ahead_cm) && back.took_s <= 20, "{back:?}");
    assert!((650..=720).contains(&ahead.ahead_cm) && ahead.took_s <= 40, "{ahead:?}");
}

#[test]
fn a_move_that_was_interrupted_begins_anew() {
    let plan = "(measured (with-policy (seq (wait-time 1) (with-valve wheels (wait-time 3))) (spin 180deg)))";
    let found = measured("test-room", plan);
    assert!(found[0].failure == "nil" && (185..=300).contains(&found[0].turned_deg), "{found:?}");
}

/// r[behaviour.states]
#[test]
fn what_is_no_move_is_refused() {
    for wrong in [":turn 1 :ahead 1", "", ":turn 'left", ":ahead +inf.0", ":turn 1 :patience -1"] {
        let plan = format!("(measured (with-valve wheels (run-behaviour move-by-odometry {wrong})))");
        let found = measured("test-room", &plan);
        assert!(found[0].failure == "type-error" && found[0].took_s == 0, "{wrong}: {found:?}");
    }
}

#[test]
fn moves_are_foreseen() {
    let plan = "(defun ends (plan)
                  (let ((p (project plan :runs 4)))
                    (list (> (first (projection-success p)) 0.5) (second (first (projection-failures p))))))
                (list (ends '(spin 360deg)) (ends '(back-up 30cm)) (ends '(back-up 5m))
                      (< 3 (second (projection-time (project '(spin 360deg) :runs 4))) 20)
                      (ends '(seq (spin 90deg) (drive-ahead 1m))))";
    let expected = "=> ((t nil) (t nil) (nil blocked) t (t nil))";
    assert_eq!(Mission::new(test_room(), plan).run(1, 100.0).outcome(), expected);
    let simulated = plan.replace(":runs 4", ":runs 4 :grain :simulated");
    assert_eq!(Mission::new(test_room(), &simulated).run(1, 100.0).outcome(), expected);
}

#[test]
fn in_an_abstract_world_a_move_leads_where_it_says() {
    let plan = "(let ((x (value x*)) (o (value o*)))
                  (drive-ahead 1m)
                  (spin 90deg)
                  (list (< 0.9 (- (value x*) x) 1.1) (< 85deg (- (value o*) o) 95deg) (> (now) 2)))";
    let chances = Chances { grasp_misses: 0.0, release_fails: 0.0, thing_missing: 0.0, door_closed: 0.0, held_up: 0.0 };
    let setting = AbstractSetting { chances, battery: 1.0, messages: Vec::new(), forecast: Forecast::Undisturbed };
    let system = in_abstract_world(test_room(), setting, plan);
    assert_eq!(outcome_text(&system), "=> (t t t)");
}

/// A door that was found closed is waited for in what is projected, until the robot forgets it, and not if it forgets
/// something else.
#[test]
fn a_door_found_closed_is_forgotten_when_a_plan_says_so() {
    let plan = "(defun takes () (second (projection-time (project '(go-to 'corner) :runs 20))))
                (ignore-failures (blocked) (go-to 'corner :patience 10))
                (let* ((closed (takes))
                       (elsewhere (progn (forget-obstacles 1 1 50cm) (takes)))
                       (there (progn (forget-obstacles 5 3 1m) (takes))))
                  (list (> closed (+ there 5)) (> elsewhere (+ there 5))))";
    let run = Mission::new(test_room(), plan).with_scenario("(close-door! 'east)").run(1, 200.0);
    assert_eq!(run.outcome(), "=> (t t)");
}

#[test]
fn what_is_forgotten_is_everything_or_around_a_point() {
    let plan = "(with-failure-handling ((type-error (f) 'refused)) (forget-obstacles 1 2))";
    assert_eq!(Mission::new(test_room(), plan).run(1, 10.0).outcome(), "=> refused");
    assert_eq!(Mission::new(test_room(), "(forget-obstacles)").run(1, 10.0).outcome(), "=> nil");
}

const RECOVERIES: &str = include_str!("../../../../examples/recoveries.rpl");

#[test]
fn recoveries_are_tried_in_turn_until_the_way_is_free() {
    let plan = RECOVERIES.replace("(go-to-recovering 'wolframs-shelf)", "(go-to-recovering 'corner :patience 5)");
    let scenario = "(close-door! 'east) (wait-time 40) (open-door! 'east)";
    let run = Mission::new(test_room(), &plan).with_scenario(scenario).run(1, 300.0);
    let tried: Vec<&str> = run.output.iter().filter_map(|line| line.split("recovery ").nth(1)).collect();
    let expected = ["1: (forget-obstacles)", "2: (spin 1.5707963267948966)", "3: (wait-time 5)", "4: (back-up 0.3)"];
    assert!(tried.len() >= 2 && expected.starts_with(&tried[..tried.len().min(4)]), "{:?}", run.output);
    assert!(run.outcome().starts_with("=>"), "{}\n{:?}", run.outcome(), run.output);
}

#[test]
fn after_six_recoveries_the_failure_is_passed_on() {
    let plan = RECOVERIES.replace("(go-to-recovering 'wolframs-shelf)", "(go-to-recovering 'corner :patience 2)");
    let run = Mission::new(test_room(), &plan).with_scenario("(close-door! 'east)").run(1, 600.0);
    assert_eq!(run.output.iter().filter(|line| line.contains("recovery")).count(), 6, "{:?}", run.output);
    assert!(run.outcome().starts_with("failed: blocked"), "{}", run.outcome());
}
