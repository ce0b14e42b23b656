//! Times: what the clock takes, and what it says of the rest.

use rpl_tests::run;

/// r[time.end]
#[test]
fn a_time_behind_the_end_of_the_clock_is_an_error_and_not_cut() {
    for form in [
        "(wait-time 1e13)",
        "(wait-time 8000000001)",
        "(wait-time +inf.0)",
        "(at-time 1e10)",
        "(with-timeout 1e10 (wait-time 1))",
        "(with-timeout +inf.0 nil)",
        "(wait-for (create-fluent nil) :timeout 1e10)",
        "(loop (wait-time 1000000000))",
        "(seq (wait-time 8000000000) (wait-time 0.000001))",
    ] {
        let ended = run(form);
        assert!(ended.starts_with("failed: arithmetic-error: "), "{form}\n{ended}");
        assert!(ended.contains("the clock ends at 8000000000 s"), "{form}\n{ended}");
    }
    // Up to there every microsecond is exact.
    let last = "(wait-time 7999999999) (wait-time 0.999999) (print (now)) (at-time 8000000000) (print (now))";
    assert_eq!(run(last), "7999999999.999999\n8000000000.0\n=> 8000000000.0");
}

/// r[time.waits]
#[test]
fn what_is_no_time_is_refused_wherever_a_time_is_taken() {
    for form in [
        "(wait-time +nan.0)",
        "(at-time +nan.0)",
        "(with-timeout +nan.0 nil)",
        "(wait-for (create-fluent nil) :timeout +nan.0)",
        "(with-timeout nil nil)",
        "(at-time \"5\")",
    ] {
        let ended = run(form);
        assert!(ended.starts_with("failed: type-error: "), "{form}\n{ended}");
    }
    assert!(run("(wait-time -1)").contains("must not be negative, and it is the integer -1"));
    // What has passed has passed.
    assert_eq!(run("(at-time -5) (at-time -inf.0) (now)"), "=> 0.0");
    assert_eq!(run("(wait-for (create-fluent nil) :timeout -3)"), "=> nil");
    assert_eq!(run("(with-timeout -3 'done)"), "=> done");
}
