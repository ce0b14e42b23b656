//! Behaviours as a plan sees them: their states, fluents and signals.

use super::world::{closed_room, wheels_are_free};
use rpl_robot::office::OfficeModel;
use rpl_tests::mission::{Mission, Run, test_room};
use std::sync::Arc;

/// What the table tells of navigation: `(navigation-active?* nr-of-nav-goals*)`.
const STATE: &str = "(defun state () (list (value navigation-active?*) (value nr-of-nav-goals*)))\n";

/// Two targets on the way to the table.
const TARGETS: &str = "'((2.2 3.4) (3.0 4.1))";

fn run_in(model: Arc<OfficeModel>, body: &str) -> Run {
    let body = body.replace("TARGETS", TARGETS);
    Mission::new(model, &format!("{STATE}{body}")).run(1, 300.0)
}

fn outcome(body: &str) -> String {
    run_in(test_room(), body).outcome()
}

/// r[behaviour.states]
#[test]
fn before_its_activation_navigation_has_no_goals() {
    assert_eq!(outcome("(state)"), "=> (nil 0)");
}

/// r[behaviour.states], r[behaviour.activate], r[behaviour.one-assignment]
#[test]
fn activation_sets_all_goals_at_once() {
    assert_eq!(
        outcome(
            "(def-fluent mixtures 0)
             (with-policy (whenever (and navigation-active?* (= nr-of-nav-goals* 0)) (incf (value mixtures)))
               (with-valve wheels (activate navigation :targets TARGETS) (list (state) (value mixtures))))"
        ),
        "=> ((t 2) 0)"
    );
}

/// r[behaviour.states]
#[test]
fn a_target_reached_is_one_goal_less() {
    assert_eq!(
        outcome(
            "(with-valve wheels
               (activate navigation :targets TARGETS)
               (wait-for (/= nr-of-nav-goals* 2))
               (list (state) (at-destination? 'table-side)))"
        ),
        "=> ((t 1) nil)"
    );
}

/// r[behaviour.states], r[behaviour.one-assignment]
#[test]
fn arrival_is_success_at_the_destination_and_nobody_sees_it_active_without_goals() {
    assert_eq!(
        outcome(
            "(def-fluent mixtures 0)
             (with-policy (whenever (and navigation-active?* (= nr-of-nav-goals* 0)) (incf (value mixtures)))
               (with-valve wheels
                 (activate navigation :targets TARGETS)
                 (let ((signal (await-signal navigation)))
                   (list signal (state) (at-destination? 'table-side) (value mixtures)))))"
        ),
        "=> (t (nil 0) t 0)"
    );
}

/// r[behaviour.states]
#[test]
fn without_a_way_navigation_fails_with_unreachable() {
    let run = run_in(
        closed_room(),
        "(with-valve wheels
           (with-failure-handling ((unreachable (f) (list (state) (eq (failure-slot f 'behaviour) navigation))))
             (activate navigation :targets '((6.8 5.0)))
             (await-signal navigation)))",
    );
    assert_eq!(run.outcome(), "=> ((nil 0) t)");
}

/// r[behaviour.states]
#[test]
fn on_a_way_that_stays_blocked_navigation_fails_with_blocked() {
    let plan = format!(
        "{STATE}(with-valve wheels
           (with-failure-handling ((blocked (f) (state)))
             (activate navigation :targets '((4.0 3.0) (6.0 3.0)))
             (await-signal navigation)))"
    );
    let run = Mission::new(test_room(), &plan).with_scenario("(wait-time 1) (close-door! 'east)").run(1, 300.0);
    assert_eq!(run.outcome(), "=> (nil 0)", "{}", run.trace());
}

/// r[behaviour.states]
#[test]
fn what_blocks_the_way_is_told_with_its_place() {
    let told = |scenario: &str| {
        let plan = "(with-failure-handling
                        ((blocked (f)
                           (print (failure-message f))
                           (map (lambda (slot) (failure-slot f slot)) '(obstacle room x y))))
                      (go-to-point 6.0 3.0))";
        let run = Mission::new(test_room(), plan).with_scenario(scenario).run(1, 1800.0);
        (run.output.join("\n"), run.outcome())
    };
    let (message, slots) = told("(wait-time 1) (close-door! 'east)");
    assert_eq!(slots, "=> (door east 5.0 3.0)");
    assert!(message.contains("stays blocked: the door of `east` at 5.0 3.0 is closed"), "{message}");
    let (message, slots) = told("(wait-time 1) (add-object! 'shelves 4.0 0.2 4.2 5.8)");
    assert!(slots.starts_with("=> (thing west "), "{slots}");
    assert!(message.contains("stays blocked: a thing or a person that is not in the map stands at "), "{message}");
}

#[test]
fn who_has_read_a_message_does_not_wait_for_it_again() {
    let plan = "(defvar heard nil)
                (def-plan hear () (loop (wait-for (> messages* 0)) (push (list (round (now)) (read-message)) heard)))
                (with-policy (hear) (wait-time 3))
                (reverse heard)";
    let said = "(wait-time 1) (send-message! 'one) (send-message! 'two) (wait-time 1) (send-message! 'three)";
    let run = Mission::new(test_room(), plan).with_scenario(said).run(1, 10.0);
    assert_eq!(run.outcome(), "=> ((1 (one)) (1 (two)) (2 (three)))", "{}", run.trace());
}

/// r[behaviour.states], r[behaviour.interrupted]
#[test]
fn who_loses_the_wheels_gets_its_signal_when_it_runs_again() {
    let run = run_in(
        test_room(),
        "(def-fluent bell nil)
         (def-plan look-at-it () (log (format \"~,1f ~a\" (now) (state))))
         (with-policy (whenever bell (with-valve wheels (look-at-it) (wait-time 2)))
           (par
             (seq (wait-time 1) (setf (value bell) t))
             (with-valve wheels
               (activate navigation :targets TARGETS)
               (with-failure-handling ((interrupted (f) (look-at-it)))
                 (await-signal navigation)))))
         (state)",
    );
    assert_eq!(run.output, ["log: 1.0 (t 0)", "log: 3.0 (t 0)"], "{}", run.trace());
    assert_eq!(run.outcome(), "=> (nil 0)", "the activation ends with its task");
}

/// r[behaviour.one], r[behaviour.interrupted]
#[test]
fn who_takes_the_wheels_may_drive_and_the_interrupted_task_still_gets_its_signal() {
    for after_activation in ["", "(wait-for over)"] {
        let run = run_in(
            test_room(),
            &format!(
                "(def-fluent bell nil)
                 (def-fluent over nil)
                 (with-policy (whenever bell
                                (with-valve wheels
                                  (run-behaviour navigation :targets '((1.2 1.2)))
                                  (log (format \"there ~a\" (> (now) 2))))
                                (setf (value over) t))
                   (par
                     (seq (wait-time 1) (setf (value bell) t))
                     (with-valve wheels
                       (activate navigation :targets TARGETS)
                       {after_activation}
                       (with-failure-handling ((interrupted (f) (log \"interrupted\")))
                         (await-signal navigation))
                       (list (run-behaviour navigation :targets TARGETS) (state)))))"
            ),
        );
        assert_eq!(run.output, ["log: there t", "log: interrupted"], "{after_activation} {}", run.trace());
        assert_eq!(run.outcome(), "=> (t (nil 0))", "{after_activation}");
        assert!(wheels_are_free(&run.system));
    }
}

/// r[behaviour.states], r[behaviour.own]
#[test]
fn removing_all_goals_interrupts() {
    assert_eq!(
        outcome(
            "(with-valve wheels
               (activate navigation :targets TARGETS)
               (wait-time 1)
               (plan-remove-all-goals)
               (let ((before (state)))
                 (list before (with-failure-handling ((interrupted (f) (now))) (await-signal navigation)) (state))))"
        ),
        "=> ((t 0) 1.0 (t 0))"
    );
}

/// r[behaviour.states]
#[test]
fn deactivation_gives_no_signal() {
    let run = run_in(
        test_room(),
        "(with-valve wheels
           (activate navigation :targets TARGETS)
           (wait-time 1)
           (deactivate navigation)
           (log (format \"~a\" (state)))
           (with-failure-handling ((timeout (f) 'no-signal)) (with-timeout 5 (await-signal navigation))))",
    );
    assert_eq!(run.output, ["log: (nil 0)"]);
    assert_eq!(run.outcome(), "=> no-signal");
    assert_eq!(run.system.outside.host.state.translation_mps, 0.0);
}

/// r[behaviour.valve]
#[test]
fn what_drives_needs_the_wheels() {
    for behaviour in ["navigation :targets '((3.0 4.1))", "active-localization"] {
        let outcome = outcome(&format!("(activate {behaviour})"));
        assert!(outcome.starts_with("failed: valve-error"), "{outcome}");
        assert!(outcome.contains("wrap it in `(with-valve wheels …)`"), "{outcome}");
    }
    let outcome = outcome("(with-valve wheels (activate gripper :release t))");
    assert!(outcome.contains("`arm`"), "{outcome}");
}

/// r[behaviour.one]
#[test]
fn an_activation_has_one_owner() {
    let run = run_in(
        test_room(),
        "(with-valve wheels
           (par (seq (activate navigation :targets TARGETS) (wait-time 2))
                (seq (wait-time 1)
                     (with-failure-handling ((behaviour-failure (f) (failure-message f)))
                       (activate navigation :targets '((1.0 1.0)))))))",
    );
    let outcome = run.outcome();
    assert!(outcome.starts_with("=> \"`navigation` is already activated by main/"), "{outcome}");
    assert!(wheels_are_free(&run.system));
}

#[test]
fn a_thing_that_is_not_there_cannot_be_grasped() {
    let run = run_in(test_room(), "(with-failure-handling ((grasp-failure (f) (failure-message f))) (pick-up 'spoon))");
    assert_eq!(run.outcome(), "=> \"the gripper does not hold `spoon`\"");
    assert!(run.system.machine.now_s() > 9.0, "three tries of three seconds");
}

#[test]
fn a_thing_is_picked_up_where_the_world_file_puts_it() {
    let run = run_in(
        test_room(),
        "(go-to 'table-side) (pick-up 'cup) (list (value holding*) (progn (put-down) (value holding*)))",
    );
    assert_eq!(run.outcome(), "=> (cup nil)");
}

/// r[behaviour.states]
#[test]
fn active_localization_has_nothing_to_do_where_the_position_is_known() {
    let run = run_in(
        test_room(),
        "(let ((before (value pos-certainty*)))
           (with-valve wheels
             (activate active-localization)
             (let ((at-once (value pos-certainty*)))
               (list (> before 0.8) (= before at-once) (await-signal active-localization)))))",
    );
    assert_eq!(run.outcome(), "=> (t t t)", "{}", run.trace());
}

/// r[behaviour.states]
#[test]
fn position_tracking_runs_whether_activated_or_not() {
    assert_eq!(
        outcome("(activate position-tracking) (deactivate position-tracking) (> (value pos-certainty*) 0.8)"),
        "=> t"
    );
    let run = run_in(test_room(), "(deactivate position-tracking) (go-to 'table-side) (at-destination? 'table-side)");
    assert_eq!(run.outcome(), "=> t");
}

/// r[behaviour.states], r[behaviour.run]
#[test]
fn active_localization_succeeds_when_the_position_is_known_again() {
    let run = run_in(
        test_room(),
        "(doubt-position)
         (wait-for (<= pos-certainty* 0.8))
         (with-valve wheels
           (list (run-behaviour active-localization) (> (value pos-certainty*) 0.8)))",
    );
    assert_eq!(run.outcome(), "=> (t t)", "{}", run.trace());
    assert!(wheels_are_free(&run.system));
}

/// r[behaviour.states]
#[test]
fn active_localization_that_is_deactivated_stops_and_gives_no_signal() {
    let run = run_in(
        test_room(),
        "(doubt-position)
         (wait-for (<= pos-certainty* 0.8))
         (with-valve wheels
           (activate active-localization)
           (deactivate active-localization)
           (with-failure-handling ((timeout (f) 'no-signal)) (with-timeout 5 (await-signal active-localization))))",
    );
    assert_eq!(run.outcome(), "=> no-signal");
    assert_eq!(run.system.outside.distance_driven_m(), 0.0);
}

/// r[behaviour.states], r[behaviour.interrupted]
#[test]
fn active_localization_loses_the_wheels_like_navigation() {
    let run = run_in(
        test_room(),
        "(with-policy (seq (wait-time 1) (with-valve wheels (wait-time 1)))
           (with-valve wheels
             (doubt-position)
             (wait-for (<= pos-certainty* 0.8))
             (activate active-localization)
             (with-failure-handling ((interrupted (f) (list 'interrupted (now))))
               (await-signal active-localization))))",
    );
    assert_eq!(run.outcome(), "=> (interrupted 2.0)", "{}", run.trace());
}

/// r[behaviour.interrupted]
#[test]
fn a_search_for_the_position_that_loses_the_wheels_goes_on_when_they_come_back() {
    let run = run_in(
        test_room(),
        "(with-policy
             (seq (wait-for (<= pos-certainty* 0.8))
                  (wait-time 0.05)
                  (with-valve wheels
                    (log (format \"taken ~a\" (<= (value pos-certainty*) 0.8)))
                    (wait-time 1)
                    (doubt-position)))
           (with-policy (relocalize-when-necessary)
             (doubt-position)
             (wait-for (<= pos-certainty* 0.8))
             (wait-time 1.2)
             (wait-for (> pos-certainty* 0.8))
             'found))",
    );
    assert_eq!(run.output, ["log: taken t"], "{}", run.trace());
    assert_eq!(run.outcome(), "=> found", "{}", run.trace());
    assert!(run.trace().contains("interrupted"), "{}", run.trace());
    let begun = run.trace().matches("behaviour=active-localization  what=activated").count();
    assert_eq!(begun, 2, "{}", run.trace());
}
