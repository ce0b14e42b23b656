//! Every behaviour in each of its states: fluents and signals are those of the tables in the
//! chapter on behaviours. Navigation has its own in `behaviours.rs`.

use rpl_tests::mission::{Mission, test_room};

fn outcome(plan: &str) -> String {
    let run = Mission::new(test_room(), plan).run(1, 400.0);
    format!("{}{}", run.output.iter().map(|line| format!("{line}\n")).collect::<String>(), run.outcome())
}

#[track_caller]
fn check(plan: &str, expected: &str) {
    assert_eq!(outcome(plan), expected, "{plan}");
}

/// `(signal B SECONDS)`: the signal of a behaviour if there is one within that time.
const SIGNAL: &str = "
(defun signal (behaviour seconds)
  (with-failure-handling ((timeout () 'none) (failure (f) (failure-class f)))
    (with-timeout seconds (await-signal behaviour))))
(def-plan take-the-arm-at (moment seconds)
  (at-time moment)
  (with-valve arm (wait-time seconds)))
";

#[track_caller]
fn gripper(plan: &str, expected: &str) {
    check(&format!("{SIGNAL}{plan}"), expected);
}

/// r[behaviour.states]
#[test]
fn the_gripper_inactive_has_nothing_and_no_signal() {
    gripper("(list (value holding*) (signal gripper 5))", "=> (nil none)");
}

/// r[behaviour.states], r[behaviour.activate]
#[test]
fn the_gripper_active_does_not_hold_yet() {
    gripper(
        "(go-to 'table-side)
         (with-valve arm (activate gripper :grasp 'cup) (list (value holding*) (signal gripper 0.5) (value holding*)))",
        "=> (nil none nil)",
    );
}

/// r[behaviour.states]
#[test]
fn the_gripper_done_holds_what_it_took_or_tells_why_not() {
    gripper(
        "(go-to 'table-side)
         (with-valve arm
           (activate gripper :grasp 'cup)
           (list (signal gripper 20) (value holding*) (signal gripper 5)
                 (progn (activate gripper :release t) (value holding*)) (signal gripper 20) (value holding*)))",
        "=> (t cup none cup t nil)",
    );
    gripper(
        "(with-valve arm (activate gripper :grasp 'cup) (list (signal gripper 20) (value holding*)))",
        "=> (grasp-failure nil)",
    );
}

/// r[behaviour.states], r[behaviour.interrupted]
#[test]
fn the_gripper_interrupted_says_so_when_its_task_goes_on() {
    gripper(
        "(with-policy (take-the-arm-at 1 5)
           (with-valve arm (activate gripper :grasp 'cup) (list (signal gripper 20) (now) (value holding*))))",
        "=> (interrupted 6.0 nil)",
    );
}

/// r[behaviour.states]
#[test]
fn the_gripper_deactivated_gives_no_signal() {
    gripper(
        "(with-valve arm (activate gripper :grasp 'cup) (wait-time 0.5) (deactivate gripper) (signal gripper 9))",
        "=> none",
    );
}

/// r[behaviour.unlent]
#[test]
fn a_signal_is_kept_for_a_suspended_task() {
    gripper(
        "(par (:tag grasping (with-valve arm (activate gripper :grasp 'cup) (print (list (signal gripper 60) (now)))))
              (seq (wait-time 1) (suspend grasping) (wait-time 20) (resume grasping)))",
        "(grasp-failure 21.0)\n=> nil",
    );
}

/// r[behaviour.states]
#[test]
fn look_around_turns_to_both_sides_and_is_done() {
    gripper("(signal look-around 5)", "=> none");
    gripper(
        "(let ((o (value o*)) (left 0) (right 0))
           (with-valve wheels
             (activate look-around)
             (let ((end
                     (pursue (seq (await-signal look-around) 'done)
                             (loop (wait-time 0.05)
                                   (let ((off (normalize-angle (- (value o*) o))))
                                     (setf left (max left off))
                                     (setf right (min right off)))))))
               (list end (> left 20deg) (< right -20deg) (< (abs (normalize-angle (- (value o*) o))) 10deg)
                     (signal look-around 3)))))",
        "=> (done t t t none)",
    );
}

/// r[behaviour.states], r[behaviour.interrupted]
#[test]
fn a_move_by_odometry_in_each_of_its_states() {
    gripper("(signal move-by-odometry 5)", "=> none");
    gripper(
        "(with-valve wheels
           (activate move-by-odometry :turn 90deg)
           (list (signal move-by-odometry 0.5) (signal move-by-odometry 20) (signal move-by-odometry 3)))",
        "=> (none t none)",
    );
    gripper(
        "(with-policy (seq (wait-time 0.5) (with-valve wheels (wait-time 5)))
           (with-valve wheels (activate move-by-odometry :turn 90deg) (list (signal move-by-odometry 20) (now))))",
        "=> (interrupted 5.5)",
    );
    gripper(
        "(with-valve wheels
           (activate move-by-odometry :ahead 1m) (wait-time 1) (deactivate move-by-odometry) (wait-time 1)
           (let ((x (value x*)))
             (list (signal move-by-odometry 3) (< (abs (- (value x*) x)) 1cm))))",
        "=> (none t)",
    );
    gripper("(with-valve wheels (activate move-by-odometry :ahead -5m) (signal move-by-odometry 60))", "=> blocked");
}

/// r[behaviour.states], r[behaviour.interrupted]
#[test]
fn look_around_interrupted_or_deactivated_turns_no_more() {
    gripper(
        "(with-policy (seq (wait-time 0.5) (with-valve wheels (wait-time 5)))
           (with-valve wheels (activate look-around) (list (signal look-around 20) (now))))",
        "=> (interrupted 5.5)",
    );
    gripper(
        "(with-valve wheels
           (activate look-around) (wait-time 0.5) (deactivate look-around) (wait-time 1)
           (let ((o (value o*)))
             (list (signal look-around 3) (< (abs (normalize-angle (- (value o*) o))) 2deg))))",
        "=> (none t)",
    );
}

/// r[behaviour.states]
#[test]
fn position_tracking_is_always_active() {
    check(
        "(list (> (value pos-certainty*) 0.8)
               (progn (deactivate position-tracking) (wait-time 2) (> (value pos-certainty*) 0.8))
               (progn (activate position-tracking) (> (value pos-certainty*) 0.8))
               (with-failure-handling ((timeout () 'no-signal)) (with-timeout 5 (await-signal position-tracking))))",
        "=> (t t t no-signal)",
    );
    // Whoever has the wheels, it is not interrupted.
    check(
        "(with-policy (seq (wait-time 1) (with-valve wheels (wait-time 1)))
           (with-valve wheels
             (activate position-tracking)
             (with-failure-handling ((timeout () 'no-signal)) (with-timeout 5 (await-signal position-tracking)))))",
        "=> no-signal",
    );
}

/// r[behaviour.states]
#[test]
fn active_localization_before_and_after() {
    check(
        "(list (with-failure-handling ((timeout () 'no-signal)) (with-timeout 2 (await-signal active-localization)))
               (> (value pos-certainty*) 0.8) (value navigation-active?*) (value nr-of-nav-goals*))",
        "=> (no-signal t nil 0)",
    );
    // While it works it is no navigation.
    check(
        "(doubt-position)
         (wait-for (<= pos-certainty* 0.8))
         (with-valve wheels
           (activate active-localization)
           (let ((active (list (value navigation-active?*) (value nr-of-nav-goals*) (<= (value pos-certainty*) 0.8))))
             (list active (await-signal active-localization) (> (value pos-certainty*) 0.8)
                   (with-failure-handling ((timeout () 'one-signal)) (with-timeout 2 (await-signal active-localization))))))",
        "=> ((nil 0 t) t t one-signal)",
    );
}

/// r[behaviour.dead], r[behaviour.own]
#[test]
fn what_a_task_activated_ends_with_it_and_nobody_else_stops_it() {
    check(
        "(with-valve wheels
           (par (:tag driver (activate navigation :targets '((2.2 3.4) (3.0 4.1))) (wait-time 60))
                (seq (wait-time 1)
                     (deactivate navigation) (plan-remove-all-goals)
                     (print (list (value navigation-active?*) (value nr-of-nav-goals*)))
                     (evaporate driver)
                     (print (list (value navigation-active?*) (value nr-of-nav-goals*))))))",
        "(t 2)\n(nil 0)\n=> (nil 0)",
    );
}

/// r[behaviour.run]
#[test]
fn run_behaviour_deactivates_when_it_is_cut_short() {
    check(
        "(with-valve wheels
           (ignore-failures (timeout) (with-timeout 1 (run-behaviour navigation :targets '((2.2 3.4) (3.0 4.1)))))
           (list (value navigation-active?*) (value nr-of-nav-goals*)))",
        "=> (nil 0)",
    );
}

/// r[behaviour.one]
#[test]
fn activated_again_by_its_own_task_it_starts_anew() {
    check(
        "(with-valve wheels
           (activate navigation :targets '((2.2 3.4) (3.0 4.1)))
           (wait-time 1)
           (activate navigation :targets '((2.2 3.4)))
           (list (value nr-of-nav-goals*) (await-signal navigation)))",
        "=> (1 t)",
    );
}

/// r[behaviour.read-only], r[behaviour.one-assignment], r[behaviour.is]
#[test]
fn fluents_of_the_robot_have_values_from_the_start_and_are_read_only() {
    check(
        "(list (> (value x*) 0) (value navigation-active?*) (value nr-of-nav-goals*) (value bumped?*) (value speed*))",
        "=> (t nil 0 nil 0.0)",
    );
    let assigned = outcome("(setf (value x*) 1)");
    assert!(assigned.starts_with("failed: type-error") && assigned.contains("only read"), "{assigned}");
    let unknown = outcome("(activate 'dancing)");
    assert!(unknown.contains("a behaviour"), "{unknown}");
}

/// r[fluent.native]
#[test]
fn a_function_of_the_robot_wakes_a_condition() {
    check(
        "(par (seq (wait-for (at-destination? 'table-side)) (print 'there))
              (seq (go-to 'table-side) (print 'arrived)))",
        "there\narrived\n=> arrived",
    );
    check("(wait-for (< (distance-to 'table-side) 0) :timeout 1)", "=> nil");
}
