//! `rpl explore`: orders in which something goes wrong, told and repeated.

use crate::folder::{folder, put, text_in};
use crate::rpl::run_in;

const PAGE: &str = include_str!("../../../docs/explore.md");

/// The first block of the page with this mark.
fn block(mark: &str) -> &'static str {
    let (_, rest) = PAGE.split_once(&format!("```{mark}\n")).expect("the page has such a block");
    rest.split_once("```").map_or(rest, |(block, _)| block)
}

#[test]
fn the_page_tells_what_is_printed_and_the_schedule_repeats_it() {
    let folder = folder("explore-page");
    put(&folder, "bell.rpl", block("lisp"));
    let found = run_in(&folder, &["explore", "bell.rpl", "--schedule", "bell.schedule"]);
    assert_eq!((found.out.as_str(), found.errors.as_str(), found.status), (block("text"), "", 1));
    let usual = run_in(&folder, &["run", "bell.rpl"]);
    assert_eq!((usual.out.as_str(), usual.status), ("coming\n", 0));
    let other = run_in(&folder, &["run", "bell.rpl", "--schedule", "bell.schedule"]);
    assert!(other.errors.contains("deadlock") && other.status == 1, "{other:?}");
    // Where the choice of a schedule does not come, it is told.
    put(&folder, "alone.rpl", "(print \"alone\")");
    let strange = run_in(&folder, &["run", "alone.rpl", "--schedule", "bell.schedule"]);
    assert!(strange.errors.contains("1 choice of the schedule did not come"), "{strange:?}");
    assert!(text_in(&folder, "bell.schedule").starts_with("rpl-schedule 1\n"));
}

#[test]
fn how_far_the_search_came_is_told_by_the_status_and_in_words() {
    let folder = folder("explore-bounds");
    put(&folder, "right.rpl", "(def-fluent done nil) (par (wait-for done) (setf (value done) t))");
    let found = run_in(&folder, &["explore", "right.rpl"]);
    assert!(found.out.starts_with("nothing is wrong in any order: ") && found.status == 0, "{found:?}");
    let found = run_in(&folder, &["explore", "right.rpl", "--deviations", "0"]);
    assert!(found.out.contains("not searched: orders with more than 0 deviations") && found.status == 3, "{found:?}");
    put(&folder, "clock.rpl", "(loop (wait-time 1) (print (now)))");
    let found = run_in(&folder, &["explore", "clock.rpl", "--until", "20s"]);
    assert!(found.out.contains("what comes after 20 s (`--until`)") && found.status == 3, "{found:?}");
    put(&folder, "wrong.rpl", "(seq (wait-time 1) (assert (= 1 2) \"no sum\"))");
    let found = run_in(&folder, &["explore", "wrong.rpl"]);
    assert!(found.out.starts_with("it fails in the usual order, at 1.000 s") && found.status == 1, "{found:?}");
    assert!(found.out.contains("failed: plan-failure: no sum"), "its last events are told: {found:?}");
    put(&folder, "last.rpl", "(defvar last nil) (par (setq last 'a) (setq last 'b)) last");
    let found = run_in(&folder, &["explore", "last.rpl", "--deterministic"]);
    assert!(found.out.starts_with("it ends otherwise in another order: `a`, and usually `b`"), "{found:?}");
}

#[test]
fn examples_without_a_robot_are_right_in_every_order() {
    let folder = folder("explore-examples");
    let examples = ["a-few-at-a-time", "evap-protect", "failure-handling", "first-steps", "fluents", "pick-and-place"];
    for name in examples.into_iter().chain(["plan-as-data", "policy", "restaurant", "try-all", "valve"]) {
        let found = run_in(&folder, &["explore", &format!("{name}.rpl")]);
        assert_eq!(found.status, 0, "{name}: {found:?}");
    }
}

#[test]
fn what_cannot_be_explored_is_said() {
    let folder = folder("explore-refused");
    put(&folder, "robot.rpl", "(go-to 'a-desk)");
    let found = run_in(&folder, &["explore", "robot.rpl"]);
    assert!(found.errors.contains("explored without a robot") && found.status == 2, "{found:?}");
    put(&folder, "tests.rpl", "(deftest home :world \"flat\" (assert t))\n(deftest sum (assert (= 2 2)))");
    let found = run_in(&folder, &["explore", "tests.rpl", "--test", "sum"]);
    assert_eq!(found.status, 0, "{found:?}");
    let found = run_in(&folder, &["explore", "tests.rpl", "--test", "home"]);
    assert!(found.errors.contains("is in a world") && found.status == 2, "{found:?}");
    let found = run_in(&folder, &["explore", "tests.rpl", "--test", "some"]);
    assert!(found.errors.contains("`home`, `sum`") && found.status == 2, "{found:?}");
    put(&folder, "no.schedule", "turn 1 takes 1\n");
    let found = run_in(&folder, &["run", "tests.rpl", "--schedule", "no.schedule"]);
    assert!(found.errors.contains("`rpl explore` writes it") && found.status == 2, "{found:?}");
}
