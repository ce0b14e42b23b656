//! A robot whose wheels do not turn although it is to drive.

use rpl_runtime::state::trace::EventKind::Robot;
use rpl_tests::mission::{Mission, is, test_room};

const HELD: &str = "(wait-time 3) (hold-wheels! 30)";

#[test]
fn wheels_that_are_held_are_told_after_two_seconds_whatever_drives() {
    for plan in ["(go-to 'corner)", "(go-to-point 6.8 5.0)", "(deliver 'cup 'table-side 'corner)"] {
        let plan = format!("(with-failure-handling ((immobile (f) 'immobile)) {plan})");
        let run = Mission::new(test_room(), &plan).with_scenario(HELD).run(1, 100.0);
        assert_eq!(run.outcome(), "=> immobile", "{plan}");
        // It brakes first.
        assert!((5.0..6.5).contains(&run.system.machine.now_s()), "{plan}: {}", run.system.machine.now_s());
        assert_eq!(run.count(|event| is(event, Robot, &[("what", "immobile")])), 1, "{plan}");
    }
}

#[test]
fn whoever_waits_until_they_are_free_goes_on() {
    let plan = "(with-retry-counters ((tries 20))
                  (with-failure-handling ((immobile (f) (wait-time 2) (do-retry tries (retry)) (refail)))
                    (go-to 'corner)))";
    let run = Mission::new(test_room(), plan).with_scenario(HELD).run(1, 200.0);
    assert!(run.outcome().starts_with("=>"), "{}", run.outcome());
    assert!(run.count(|event| is(event, Robot, &[("what", "immobile")])) >= 5);
}

#[test]
fn an_empty_battery_is_told_as_one() {
    let plan = "(with-failure-handling ((immobile (f) (failure-message f))) (go-to 'corner))";
    let run = Mission::new(test_room(), plan).with_scenario("(wait-time 3) (set-battery! 0)").run(1, 100.0);
    assert!(run.outcome().contains("its battery is empty"), "{}", run.outcome());
}
