//! A scenario that fails, and one that is taken for a plan: both are told.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Nobody can be carried there.
const FAILS: &str = "(wait-time 1)\n(teleport-robot! 1000 1000 0)\n";

/// Fails in about half of the runs.
const FAILS_AT_TIMES: &str = "(wait-time 1) (if (= (random 2) 0) (fail \"no luck\"))";

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // The one before may not be there.
    fs::remove_dir_all(&folder).ok();
    fs::create_dir_all(&folder).expect("the folder can be made");
    for (name, text) in [
        ("plan.rpl", "(wait-time 2)"),
        ("fails.rpl", FAILS),
        ("at-times.rpl", FAILS_AT_TIMES),
        ("tests.rpl", "(deftest alone :world \"test-room\" :scenario \"fails.rpl\" (wait-time 2))"),
        ("scenario.rpl", "(wait-time 1) (rotate-robot! 70deg) (print true-x*)"),
    ] {
        fs::write(folder.join(name), text).expect("the text can be written");
    }
    folder
}

fn rpl(folder: &Path, arguments: &[&str]) -> (String, String, Option<i32>) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rpl"));
    let Output { status, stdout, stderr } =
        command.current_dir(folder).args(arguments).output().expect("the command runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    (text(stdout), text(stderr), status.code())
}

#[test]
fn a_scenario_that_fails_is_told_like_any_failure() {
    let folder = folder("scenario-fails");
    let run = ["run", "plan.rpl", "--world", "test-room", "--scenario", "fails.rpl", "--json", "--trace", "t.jsonl"];
    for quiet in [&[][..], &["-q"]] {
        let (out, err, status) = rpl(&folder, &[&run[..], quiet].concat());
        assert_eq!(status, Some(1), "{err}");
        assert!(err.contains("the scenario failed: plan-failure: ") && err.contains("fails.rpl:2:1"), "{err}");
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
    let (_, err, status) = rpl(&folder, &["eval", "(wait-time 2)", "--world", "test-room", "--scenario", "fails.rpl"]);
    assert!(err.contains("the scenario failed: ") && status == Some(1), "{err}");
}

#[test]
fn a_test_whose_scenario_fails_has_failed() {
    let folder = folder("scenario-test");
    let (out, _, status) = rpl(&folder, &["test", "tests.rpl"]);
    assert!(out.contains("FAILED  alone") && out.contains("the scenario failed: plan-failure"), "{out}");
    assert_eq!(status, Some(1));
}

#[test]
fn a_run_whose_scenario_fails_is_not_measured() {
    let folder = folder("scenario-experiment");
    let experiment = ["experiment", "plan.rpl", "--world", "test-room", "--scenario", "at-times.rpl", "--runs", "8"];
    let (out, err, status) = rpl(&folder, &[&experiment[..], &["--results", "results"]].concat());
    let rows = fs::read_to_string(folder.join("results/runs.csv")).expect("the results are there");
    let unmeasured = rows.lines().filter(|line| line.contains("not measured: plan-failure: no luck")).count();
    assert!((1..8).contains(&unmeasured), "{rows}");
    let measured = 8 - unmeasured;
    assert!(out.contains(&format!("succeeded {measured} of {measured}: 100.0 %")), "{out}{err}");
    assert!(out.contains(&format!("not measured: {unmeasured} of 8, because the scenario failed with seed ")), "{out}");
    assert_eq!(status, Some(1), "an experiment that was not measured as it was meant has not succeeded");
}

#[test]
fn a_scenario_that_is_taken_for_a_plan_is_recognised() {
    let folder = folder("scenario-check");
    for arguments in
        [&["check", "scenario.rpl"][..], &["run", "scenario.rpl"], &["run", "scenario.rpl", "--world", "dept"]]
    {
        let (_, err, status) = rpl(&folder, arguments);
        assert_eq!(status, Some(2), "{err}");
        for name in ["`rotate-robot!`", "`true-x*`"] {
            assert!(err.contains(&format!("{name} belongs to scenarios")), "{err}");
        }
        assert!(err.contains("`rpl check --scenario FILE`") && !err.contains("did you mean"), "{err}");
    }
    let (_, err, status) = rpl(&folder, &["check", "--scenario", "scenario.rpl"]);
    assert_eq!(status, Some(0), "{err}");
}
