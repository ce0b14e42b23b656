//! How long a robot waits before a closed door.

use super::world::wheels_are_free;
use rpl_tests::mission::{Mission, Run, test_room};

/// The only door between the rooms is closed for 80 seconds.
const CLOSED: &str = "(wait-time 1) (close-door! 'east) (wait-time 80) (open-door! 'east)";

fn run(plan: &str) -> Run {
    let run = Mission::new(test_room(), plan).with_scenario(CLOSED).run(1, 400.0);
    assert!(wheels_are_free(&run.system), "{}", run.trace());
    run
}

#[test]
fn a_door_that_opens_in_a_while_is_waited_for() {
    for plan in ["(go-to 'corner)", "(go-to-point 6.8 5.0)", "(deliver 'cup 'table-side 'corner)"] {
        let run = run(plan);
        assert!(run.outcome().starts_with("=>"), "{plan}: {}", run.outcome());
        assert!(run.system.machine.now_s() > 81.0, "{plan}");
        assert_eq!(run.system.outside.contacts().caused, 0, "{plan}");
    }
}

/// Each of these comes to the door within half a minute, and waits for ten seconds there.
#[test]
fn who_has_no_patience_gives_up_soon() {
    for plan in [
        "(go-to 'corner :patience 10)",
        "(go-to-point 6.8 5.0 0 10)",
        "(progn (go-to 'table-side) (pick-up 'cup) (bring 'cup 'corner :patience 10))",
        "(deliver 'cup 'table-side 'corner :patience 10)",
        "(progn (go-to 'table-side) (fetch 'cup 'corner :patience 10))",
        "(with-valve wheels (execute-plan (generate-navigation-plan 'corner 10)))",
        "(with-valve wheels (run-behaviour navigation :targets '((6.8 5.0)) :patience 10))",
    ] {
        let run = run(&format!("(with-failure-handling ((blocked (f) 'gave-up)) {plan})"));
        assert_eq!(run.outcome(), "=> gave-up", "{plan}");
        assert!(run.system.machine.now_s() < 60.0, "{plan}: {}", run.system.machine.now_s());
    }
}

#[test]
fn a_patience_that_is_no_time_is_refused() {
    for plan in ["(go-to 'corner :patience 'long)", "(go-to 'corner :patience -1)"] {
        let outcome = run(plan).outcome();
        assert!(outcome.starts_with("failed: type-error") && outcome.contains(":patience 2min"), "{outcome}");
    }
}
