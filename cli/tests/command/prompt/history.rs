//! Going back in time, and runs kept side by side.

use super::session;

#[test]
fn a_run_goes_back_a_step_and_on_again_to_the_same_end() {
    let shown = session(
        &["repl"],
        "(defvar log nil)\n:step (progn (push (now) log) (wait-time 1) (push (now) log) (reverse log))\n:next\n:next\n:next\n:back\n:continue\n:back 1s\n",
    );
    assert!(shown.out.contains("(0.0 1.0)\n"), "{}", shown.out);
    assert_eq!(shown.out.matches("(0.0 1.0)").count(), 1);
    assert_eq!(shown.status, 0);
}

#[test]
fn going_back_before_the_start_stops_at_the_start() {
    let shown = session(&["repl"], "(wait-time 5)\n:back 100\n(now)\n:at 3h\n");
    assert!(shown.errors.contains("this is the start"), "{}", shown.errors);
    assert!(shown.errors.contains("has not come yet; `:until 3h` goes there"), "{}", shown.errors);
    assert!(shown.out.ends_with("0.0\n"), "{}", shown.out);
}

#[test]
fn going_back_no_step_changes_nothing() {
    let shown = session(&["repl"], "(defvar n 1)\n(wait-time 5)\n(setf n 2)\n:back 0\n(list n (now))\n");
    assert_eq!((shown.errors.as_str(), shown.out.as_str()), ("", "1\nnil\n2\n5.000 s\n(2 5.0)\n"));
}

#[test]
fn going_back_by_a_time_before_the_start_stops_at_the_start() {
    let shown = session(&["repl"], "(wait-time 5)\n:back 10s\n(now)\n");
    assert_eq!((shown.errors.as_str(), shown.out.as_str()), ("this is the start\n", "nil\n0.000 s\n0.0\n"));
}

#[test]
fn definitions_go_back_with_the_run_and_that_is_told() {
    let lines = "(def-plan tea () 'green)\n:fork first\n(wait-time 5)\n(def-plan tea () 'black)\n\
                 (def-plan cake () 'good)\n(wait-time 5)\n:back 7s\n(tea)\n:switch first\n";
    let shown = session(&["repl"], lines);
    let told = "definitions are those of this instant: here `cake` is not defined, `tea` has another text\n";
    assert_eq!(shown.errors, format!("kept as `first`; `:switch first` goes there\n`tea` is defined anew\n{told}"));
    assert!(shown.out.contains("green\n"), "{}", shown.out);
}

#[test]
fn a_definition_changed_in_the_past_counts_from_there_on() {
    let lines = "(def-plan beat () (wait-time 1) 'slow)\n(list (beat) (beat) (now))\n:at 0s\n\
                 (def-plan beat () (wait-time 0.25) 'fast)\n:continue\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.contains("(slow slow 2.0)") && shown.out.ends_with("(slow fast 1.25)\n"), "{}", shown.out);
    assert!(shown.errors.contains("the old text still runs in main/beat"), "{}", shown.errors);
}

#[test]
fn forks_are_kept_side_by_side() {
    let lines = "(defvar n 1)\n:fork before\n(incf n)\n:switch before\nn\n:switch main\nn\n:forks\n:switch nowhere\n";
    let shown = session(&["repl"], lines);
    let numbers: Vec<&str> = shown.out.lines().filter(|line| line.parse::<i64>().is_ok()).collect();
    assert_eq!(numbers, ["1", "2", "1", "2"]);
    assert!(shown.errors.contains("no run is called `nowhere`"), "{}", shown.errors);
}

#[test]
fn a_run_goes_back_to_where_its_failure_was_raised() {
    let lines = "(def-plan pour (cups) (unwind-protect (dotimes (i cups) (wait-time 1) (when (= i 2) (car i))) (print 'clean)))\n\
                 :back failure\n(par (pour 4) (wait-time 9))\n:back failure\n(list cups i)\n:tasks\n:back\n:continue\n:abort\n(now)\n";
    let shown = session(&["repl"], lines);
    assert!(shown.errors.contains("no form has failed yet"), "{}", shown.errors);
    assert!(shown.out.contains("3.000 s  main/par[0]/pour  <1>:1:"), "{}", shown.out);
    assert!(shown.out.contains("cups = 4, i = 2\n(4 2)\n"), "{}", shown.out);
    assert!(
        shown.out.contains("par[1]  waits for time until 9.000 s, in 6.000 s"),
        "the other tasks live: {}",
        shown.out
    );
    assert_eq!(shown.out.matches("clean\n").count(), 2, "before and after going back: {}", shown.out);
    assert_eq!(shown.errors.matches("failed: type-error").count(), 2, "{}", shown.errors);
    assert_eq!(shown.status, 2);
}
