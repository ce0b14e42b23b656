//! A scenario that fails, and one that is taken for a plan: both are told.

use crate::folder::{folder, put};
use crate::rpl::{Ended, run_in};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

/// Nobody can be carried there.
const FAILS: &str = "(wait-time 1)\n(teleport-robot! 1000 1000 0)\n";

/// Fails in about half of the runs.
const FAILS_AT_TIMES: &str = "(wait-time 1) (if (= (random 2) 0) (fail \"no luck\"))";

/// A folder with scenarios that fail and one that does not.
fn folder_of_scenarios(name: &str) -> PathBuf {
    let folder = folder(name);
    for (name, text) in [
        ("plan.rpl", "(wait-time 2)"),
        ("fails.rpl", FAILS),
        ("at-times.rpl", FAILS_AT_TIMES),
        ("tests.rpl", "(deftest alone :world \"test-room\" :scenario \"fails.rpl\" (wait-time 2))"),
        ("scenario.rpl", "(wait-time 1) (rotate-robot! 70deg) (print true-x*)"),
    ] {
        put(&folder, name, text);
    }
    folder
}

#[test]
fn a_scenario_that_fails_is_told_like_any_failure() {
    let folder = folder_of_scenarios("scenario-fails");
    let run = ["run", "plan.rpl", "--world", "test-room", "--scenario", "fails.rpl", "--json", "--trace", "t.jsonl"];
    for quiet in [&[][..], &["-q"]] {
        let Ended { out, errors, status } = run_in(&folder, &[&run[..], quiet].concat());
        assert_eq!(status, 1, "{errors}");
        assert!(errors.contains("the scenario failed: plan-failure: ") && errors.contains("fails.rpl:2:1"), "{errors}");
        let summary: Value = serde_json::from_str(&out).expect("one JSON object");
        assert_eq!((&summary["outcome"], &summary["failure"]), (&"succeeded".into(), &Value::Null));
        assert_eq!(
            (&summary["scenario_failure"]["class"], &summary["scenario_failure"]["line"]),
            (&"plan-failure".into(), &2.into())
        );
    }
    let trace = fs::read_to_string(folder.join("t.jsonl")).expect("the trace is there");
    let told: Vec<&str> = trace.lines().filter(|line| line.contains("scenario failed")).collect();
    assert!(told.len() == 1 && told[0].contains("\"time_s\":1.0") && told[0].contains("fails.rpl:2:1"), "{told:?}");
    let Ended { errors, status, .. } =
        run_in(&folder, &["eval", "(wait-time 2)", "--world", "test-room", "--scenario", "fails.rpl"]);
    assert!(errors.contains("the scenario failed: ") && status == 1, "{errors}");
}

#[test]
fn a_test_whose_scenario_fails_has_failed() {
    let folder = folder_of_scenarios("scenario-test");
    let Ended { out, status, .. } = run_in(&folder, &["test", "tests.rpl"]);
    assert!(out.contains("FAILED  alone") && out.contains("the scenario failed: plan-failure"), "{out}");
    assert_eq!(status, 1);
}

#[test]
fn a_run_whose_scenario_fails_is_not_measured() {
    let folder = folder_of_scenarios("scenario-experiment");
    let experiment = ["experiment", "plan.rpl", "--world", "test-room", "--scenario", "at-times.rpl", "--runs", "8"];
    let Ended { out, errors, status } = run_in(&folder, &[&experiment[..], &["--results", "results"]].concat());
    let rows = fs::read_to_string(folder.join("results/runs.csv")).expect("the results are there");
    let unmeasured = rows.lines().filter(|line| line.contains("not measured: plan-failure: no luck")).count();
    assert!((1..8).contains(&unmeasured), "{rows}");
    let measured = 8 - unmeasured;
    assert!(out.contains(&format!("succeeded {measured} of {measured}: 100.0 %")), "{out}{errors}");
    assert!(out.contains(&format!("not measured: {unmeasured} of 8, because the scenario failed with seed ")), "{out}");
    assert_eq!(status, 1, "an experiment that was not measured as it was meant has not succeeded");
}

#[test]
fn a_scenario_cannot_project() {
    let folder = folder_of_scenarios("scenario-projects");
    put(&folder, "projects.rpl", "(wait-time 1) (project '(wait-time 1))");
    let found = run_in(&folder, &["run", "plan.rpl", "--world", "test-room", "--scenario", "projects.rpl"]);
    assert!(found.errors.contains("projection-failure: a scenario cannot project"), "{}", found.errors);
    assert_eq!(found.status, 1);
}

#[test]
fn a_scenario_that_is_taken_for_a_plan_is_recognised() {
    let folder = folder_of_scenarios("scenario-check");
    for arguments in
        [&["check", "scenario.rpl"][..], &["run", "scenario.rpl"], &["run", "scenario.rpl", "--world", "dept"]]
    {
        let Ended { errors, status, .. } = run_in(&folder, arguments);
        assert_eq!(status, 2, "{errors}");
        for name in ["`rotate-robot!`", "`true-x*`"] {
            assert!(errors.contains(&format!("{name} belongs to scenarios")), "{errors}");
        }
        assert!(errors.contains("`rpl check --scenario FILE`") && !errors.contains("did you mean"), "{errors}");
    }
    let Ended { errors, status, .. } = run_in(&folder, &["check", "--scenario", "scenario.rpl"]);
    assert_eq!(status, 0, "{errors}");
}
