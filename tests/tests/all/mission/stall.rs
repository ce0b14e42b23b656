//! A run that waits in vain while the world goes on is reported and does not fail.

use rpl_runtime::state::trace::EventKind::Warning;
use rpl_tests::detail;
use rpl_tests::mission::{Mission, Run, is, test_room};

fn run(plan: &str, until_s: f64) -> Run {
    Mission::new(test_room(), plan).run(1, until_s)
}

fn reports(run: &Run) -> Vec<(f64, String)> {
    let stalls =
        run.events.iter().filter(|event| is(event, Warning, &[]) && detail(event, "text").starts_with("stalled"));
    stalls.map(|event| (event.time_us as f64 / 1e6, detail(event, "text").to_string())).collect()
}

const NEVER: &str = "(def-fluent never nil) ";

/// r[deadlock.stalled]
#[test]
fn after_two_minutes_without_progress_every_task_is_named_once() {
    let run = run(
        &format!(
            "{NEVER} (def-valve door)
             (with-policy (whenever (> pos-certainty* 2) (print 'never))
               (with-policy (loop (wait-time 1))
                 (par (wait-for never)
                      (with-valve door (wait-for never))
                      (:tag second (with-valve door (print 'never))))))"
        ),
        400.0,
    );
    let found = reports(&run);
    assert_eq!(found.len(), 1, "{found:?}");
    let (time_s, text) = &found[0];
    assert!((120.0..121.0).contains(time_s), "{time_s}");
    for waiting in
        ["waits for fluent never", "second waits for valve door", "with-policy[0] waits for (> pos-certainty* 2)"]
    {
        assert!(text.contains(waiting), "{waiting} is not in {text}");
    }
    assert_eq!(run.output, [format!("log: warning: {text}")]);
    assert_eq!(run.outcome(), "still running");
}

/// r[deadlock.stalled]
#[test]
fn what_drives_waits_for_a_time_or_goes_on_is_not_stalled() {
    // It stands still after some seconds of driving; the two minutes count from there.
    let driving = run(
        &format!("{NEVER} (with-valve wheels (activate navigation :targets '((2.2 3.4) (3.0 4.1))) (wait-for never))"),
        122.0,
    );
    assert_eq!(reports(&driving), []);
    assert_eq!(reports(&run(&format!("{NEVER} (par (wait-for never) (wait-time 200))"), 180.0)), []);
    let going_on = format!("{NEVER} (par (wait-for never) (loop (wait-time 100)))");
    assert_eq!(reports(&run(&going_on, 350.0)), []);
    let twice =
        run(&format!("{NEVER} (par (wait-for never) (seq (wait-for never :timeout 150) (wait-for never)))"), 300.0);
    let times: Vec<f64> = reports(&twice).iter().map(|(time_s, _)| time_s.floor()).collect();
    assert_eq!(times, [270.0], "until 150 s a deadline is pending; progress then begins a new count");
    let timeout =
        format!("{NEVER} (par (wait-for never) (ignore-failures (timeout) (with-timeout 300 (wait-for never))))");
    let times: Vec<f64> = reports(&run(&timeout, 450.0)).iter().map(|(time_s, _)| time_s.floor()).collect();
    assert_eq!(times, [420.0], "until 300 s a deadline is pending");
    let policy = format!(
        "{NEVER} (with-policy (ignore-failures (timeout) (with-timeout 500 (wait-for never))) (wait-for never))"
    );
    assert_eq!(reports(&run(&policy, 130.0)).len(), 1, "a deadline of a policy is nobody's progress");
}
