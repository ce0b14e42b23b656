//! Told to stop in the middle of driving: clean-ups run, and the robot stands.

use super::world::wheels_are_free;
use rpl_runtime::robot::{Outbox, Outside};
use rpl_runtime::run::system::{Outcome, Progress};
use rpl_tests::mission::{Mission, Run, run_until, test_room};

const PLAN: &str = "
(with-policy (relocalize-when-necessary)
  (evap-protect
    (go-to 'corner)
    (log (format \"~,2f clean-up begins\" (now)))
    (wait-time 0.5)
    (log (format \"~,2f clean-up ends\" (now)))))";

/// r[cleanup.stop]
#[test]
fn clean_ups_run_and_the_robot_stands() {
    let mut system = Mission::new(test_room(), PLAN).start(1);
    assert!(run_until(&mut system, 10.0, |system| system.machine.now_s() >= 3.0));
    assert!(system.outside.host.state.translation_mps > 0.2, "it drives");
    system.stop();
    while system.advance() == Progress::Running {
        assert!(system.machine.now_s() < 10.0, "it does not end");
    }
    assert_eq!(system.outcome(), Some(Outcome::Evaporated));
    assert!(wheels_are_free(&system));
    assert_eq!(system.outside.host.state.translation_mps, 0.0, "half a second is enough to stop");
    let before = system.outside.true_pose_in_map();
    for _ in 0..20 {
        system.outside.step(0, system.machine.phases(), &mut Outbox::default());
    }
    assert_eq!(system.outside.true_pose_in_map(), before, "nothing is commanded any more");
    let run = Run::of(system);
    assert_eq!(run.output, ["log: 3.00 clean-up begins", "log: 3.50 clean-up ends"]);
}

#[test]
fn at_any_moment_a_stop_ends_the_run() {
    let start = Mission::new(test_room(), PLAN).start(1);
    for tenths in [0, 1, 7, 30, 55, 80] {
        let mut system = start.fork();
        run_until(&mut system, 60.0, |system| system.machine.now_us >= tenths * 100_000);
        system.stop();
        system.run_until(system.machine.now_us + 2_000_000);
        assert!(system.outcome().is_some(), "stopped at {tenths} tenths of a second");
        assert!(wheels_are_free(&system));
    }
}
