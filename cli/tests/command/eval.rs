//! `rpl eval`: an expression and its value.

use crate::rpl::{feed, rpl, run};

#[test]
fn eval_prints_the_value_as_it_could_be_read() {
    let found = run(&["eval", "(print \"hello\") (list 1 2.0 \"three\" 'four)"]);
    assert_eq!(found.out, "hello\n(1 2.0 \"three\" four)\n");
    assert_eq!((found.errors.as_str(), found.status), ("", 0));
}

#[test]
fn eval_reads_standard_input() {
    assert_eq!(feed(&mut rpl(&["eval", "-"]), "(+ 1\n2)").out, "3\n");
}

#[test]
fn eval_has_the_robot_of_a_world_and_lays_out_the_plan_it_makes() {
    let found = run(&["eval", "(generate-navigation-plan 'corner)", "--world", "test-room"]);
    let plan = &found.out;
    assert!(plan.starts_with("(with-policies (") && plan.lines().count() > 2, "{plan}{}", found.errors);
    assert!(plan.contains("(run-behaviour navigation :targets"), "{plan}");
    let found = run(&["eval", "(go-to 'shlf)", "--world", "test-room"]);
    assert!(found.errors.contains("`shlf` is not in world `test-room`"), "{}", found.errors);
    assert_eq!(found.status, 1);
}
