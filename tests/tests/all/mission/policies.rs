//! Policies, valves, time-outs and clean-ups around a robot that drives.

use super::world::{closed_room, wheels_are_free};
use rpl_robot::office::ReportKind;
use rpl_runtime::state::trace::EventKind::Behaviour;
use rpl_tests::mission::{Mission, Run, dept, fluent_text, is, run_until, test_room};

/// A policy that takes the wheels for some seconds once the bell rings.
const BELL: &str = "
(def-fluent bell nil)
(def-plan answer-the-bell (seconds)
  (whenever bell
    (with-valve wheels
      (log (format \"~,1f the bell has the wheels\" (now)))
      (wait-time seconds))))
(def-plan ring-at (moment)
  (at-time moment)
  (setf (value bell) t))
";

fn with_bell(plan: &str) -> Run {
    let run = Mission::new(test_room(), &format!("{BELL}{plan}")).run(1, 120.0);
    assert!(wheels_are_free(&run.system), "{}", run.trace());
    run
}

/// r[behaviour.nested]
#[test]
fn the_same_policy_twice_gives_up_the_belief_once() {
    let plan = "(with-policy (relocalize-when-necessary) (go-to 'mail-slots))";
    let scenario = "(wait-time 6) (rotate-robot! 70deg)";
    let mut system = Mission::new(dept(), plan).with_scenario(scenario).start(2);
    let mut certainties = Vec::new();
    let (mut activations, mut given_up) = (0, 0);
    run_until(&mut system, 600.0, |system| {
        certainties.push(system.outside.estimate().certainty);
        let events = &system.machine.trace.events;
        let count = events
            .iter()
            .filter(|event| is(event, Behaviour, &[("behaviour", "active-localization"), ("what", "activated")]))
            .count();
        if count > activations {
            activations = count;
            given_up += usize::from(certainties.last().is_some_and(|certainty| *certainty <= 0.8));
        }
        false
    });
    let run = Run::of(system);
    assert!(run.outcome().starts_with("=>"), "{}", run.outcome());
    // The second policy finds the position known when it gets the wheels.
    assert_eq!(run.count(|event| ReportKind::of(event) == Some(ReportKind::PositionLost)), given_up, "{}", run.trace());
    assert_eq!(run.count(|event| ReportKind::of(event) == Some(ReportKind::PositionFound)), given_up);
    assert!(given_up > 0 && activations == given_up, "{given_up} of {activations}");
    assert!(wheels_are_free(&run.system));
}

#[test]
fn a_policy_inside_the_valve_takes_the_wheels_from_its_primary() {
    let run = with_bell(
        "(with-valve wheels
           (with-policy (answer-the-bell 1)
             (par (ring-at 2)
                  (with-failure-handling
                      ((interrupted (f) (log (format \"~,1f interrupted\" (now))) (retry)))
                    (run-behaviour navigation :targets '((3.0 4.1)))))
             (log \"arrived\")))",
    );
    assert_eq!(
        run.output,
        ["log: 2.0 the bell has the wheels", "log: 3.0 interrupted", "log: arrived"],
        "{}",
        run.trace()
    );
    assert!(run.outcome().starts_with("=>"), "{}", run.outcome());
}

#[test]
fn a_deadline_that_passes_during_an_interruption_ends_the_body_and_cleans_up() {
    let run = with_bell(
        "(with-policy (answer-the-bell 20)
           (with-failure-handling ((timeout (f) (log (format \"~,1f timeout\" (now)))))
             (with-timeout 5
               (with-valve wheels
                 (evap-protect
                   (par (ring-at 2) (run-behaviour navigation :targets '((6.8 5.0))))
                   (log (format \"~,1f clean-up\" (now))))))))",
    );
    assert_eq!(
        run.output,
        ["log: 2.0 the bell has the wheels", "log: 5.0 clean-up", "log: 5.0 timeout"],
        "{}",
        run.trace()
    );
    assert!(run.outcome().starts_with("=>"), "{}", run.outcome());
}

#[test]
fn what_is_evaporated_while_interrupted_cleans_up_at_once() {
    let mut system = Mission::new(
        test_room(),
        &format!(
            "{BELL}
             (with-policy (answer-the-bell 20)
               (pursue
                 (wait-time 4)
                 (with-valve wheels
                   (evap-protect
                     (par (ring-at 3) (run-behaviour navigation :targets '((6.8 5.0))))
                     (log (format \"~,1f clean-up\" (now)))))))
             (wait-time 3)"
        ),
    )
    .start(1);
    assert!(run_until(&mut system, 60.0, |system| system.machine.now_s() >= 2.9));
    assert!(system.outside.host.state.translation_mps > 0.1, "it drives");
    assert!(run_until(&mut system, 60.0, |system| system.machine.now_s() >= 4.5));
    assert_eq!(system.outside.host.state.translation_mps, 0.0, "it stands");
    assert_eq!(fluent_text(&system, "navigation-active?*"), "nil");
    assert!(wheels_are_free(&system));
    system.run_until(60_000_000);
    let run = Run::of(system);
    assert_eq!(run.output, ["log: 3.0 the bell has the wheels", "log: 4.0 clean-up"], "{}", run.trace());
}

#[test]
fn a_handler_answers_a_destination_without_a_way() {
    let plan = "(with-failure-handling ((unreachable (f) (list (now) (failure-slot f 'destination)))) (go-to 'corner))";
    let run = Mission::new(closed_room(), plan).run(1, 60.0);
    assert_eq!(run.outcome(), "=> (0.0 corner)");
    assert!(wheels_are_free(&run.system));
}

#[test]
fn an_unknown_place_is_a_failure_with_a_suggestion() {
    let run = Mission::new(test_room(), "(go-to 'cornre)").run(1, 60.0);
    let outcome = run.outcome();
    assert!(outcome.starts_with("failed: "), "{outcome}");
    assert!(outcome.contains("place `cornre` is not in world `test-room`; did you mean `corner`?"), "{outcome}");
}

#[test]
fn a_door_closed_on_the_way_is_a_failure_a_plan_can_handle() {
    let plan = "(with-failure-handling (((blocked unreachable) (f) (failure-class f))) (go-to 'corner))";
    let run = Mission::new(test_room(), plan).with_scenario("(wait-time 1.5) (close-door! 'east)").run(1, 600.0);
    assert_eq!(run.outcome(), "=> blocked", "{}", run.trace());
    assert_eq!(run.system.outside.contacts().caused, 0);
    assert!(wheels_are_free(&run.system));
}
