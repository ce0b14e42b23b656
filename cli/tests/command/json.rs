//! What the commands write for programs is what the page about JSON says.

use crate::folder::{folder, put};
use crate::keys;
use crate::rpl::run_in;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// A folder with plans of all kinds, which nobody changes.
fn plans() -> &'static Path {
    static PLANS: OnceLock<PathBuf> = OnceLock::new();
    PLANS.get_or_init(folder_of_plans)
}

fn folder_of_plans() -> PathBuf {
    let folder = folder("json-keys");
    for (name, text) in [
        ("fails.rpl", "(def-plan inner () (fail \"no\"))\n(par (inner) (unwind-protect (inner) (fail \"x\")))\n"),
        ("idle.rpl", "(wait-time 1)\n"),
        ("tests.rpl", "(deftest good (print 1))\n(deftest bad (fail \"no\"))\n"),
        ("wrong.rpl", "(defun twice (x) x)\n(defun twice (y) 2)\n(undefined)\n(let ((unused 1)) (print 2))\n"),
    ] {
        put(&folder, name, text);
    }
    folder
}

/// The one JSON object that a command writes, as its last line.
fn object(arguments: &[&str]) -> Value {
    let found = run_in(plans(), arguments);
    let last = found.out.lines().last().unwrap_or_else(|| panic!("{}", found.errors));
    let value: Value = serde_json::from_str(last).expect("the last line is JSON");
    assert!(value.is_object(), "{last}");
    value
}

/// The section documents just the keys of these objects.
fn assert_documented(section: &str, lines: &[&[&str]]) {
    let found: BTreeSet<String> = lines.iter().flat_map(|line| keys::found(&object(line))).collect();
    let documented = keys::documented(section);
    assert!(!documented.is_empty(), "docs/json.md has no section `{section}`");
    let missing: Vec<_> = found.difference(&documented).collect();
    let invented: Vec<_> = documented.difference(&found).collect();
    assert!(missing.is_empty() && invented.is_empty(), "{section}: undocumented {missing:?}, not there {invented:?}");
}

#[test]
fn runs_are_as_documented() {
    let lines: [&[&str]; 3] =
        [&["run", "fails.rpl", "--json"], &["eval", "(+ 1 2)", "--json"], &["eval", "(fail)", "--json"]];
    assert_documented("rpl run", &lines);
    assert_eq!(object(&["eval", "(print 'out) (list 1 \"two\")", "--json"])["value"], "(1 \"two\")");
}

#[test]
fn findings_are_as_documented() {
    assert_documented("rpl check", &[&["check", "wrong.rpl", "fails.rpl", "nowhere.rpl", "--json"]]);
    let report = object(&["check", "wrong.rpl", "fails.rpl", "nowhere.rpl", "--json"]);
    let files = report["files"].as_array().expect("a list");
    let names: Vec<&Value> = files.iter().map(|file| &file["file"]).collect();
    assert_eq!(names, ["wrong.rpl", "fails.rpl", "nowhere.rpl"]);
    assert!(files[2]["error"].as_str().is_some_and(|error| error.contains("there is no plan `nowhere.rpl`")));
    let undefined =
        files[0]["findings"].as_array().expect("a list").iter().find(|finding| finding["severity"] == "error");
    let undefined = undefined.expect("an error");
    assert_eq!(
        (&undefined["line"], &undefined["column"], &undefined["end_line"], &undefined["end_column"]),
        (&3.into(), &2.into(), &3.into(), &11.into())
    );
    // Both kinds of errors are counted: those of the text, and files that are not there.
    assert_eq!(report["errors"], 2);
}

#[test]
fn tests_are_as_documented() {
    assert_documented("rpl test", &[&["test", "tests.rpl", "wrong.rpl", "--json"]]);
    let report = object(&["test", "tests.rpl", "wrong.rpl", "nowhere.rpl", "--json"]);
    assert_eq!(report["faulty_files"].as_array().map(Vec::len), Some(2));
}

#[test]
fn experiments_are_as_documented() {
    let rotated: &[&str] = &["experiment", "rotated", "--row", "rotated", "--runs", "1", "--json"];
    let failing: &[&str] = &["experiment", "fails.rpl", "--runs", "2", "--json"];
    let unmeasured: &[&str] =
        &["experiment", "idle.rpl", "--world", "test-room", "--scenario", "fails.rpl", "--runs", "1", "--json"];
    assert_documented("rpl experiment NAME", &[rotated, failing, unmeasured]);
    let calibration: &[&str] = &["experiment", "calibration", "--row", "rotated", "--runs", "1", "--json"];
    let found: BTreeSet<String> =
        keys::found(&object(calibration)).difference(&keys::found(&object(rotated))).cloned().collect();
    assert_eq!(found, keys::documented("rpl experiment calibration"));
}

#[test]
fn experiments_of_other_kinds_are_as_documented() {
    let barn: &[&str] = &["experiment", "barn", "--row", "seen so far", "--runs", "2", "--json"];
    assert_documented("rpl experiment barn", &[barn]);
    let sensing: &[&str] =
        &["experiment", "sensing", "--row", "sonars, random", "--runs", "1", "--until", "120s", "--json"];
    assert_documented("rpl experiment sensing", &[sensing]);
    let crowd: &[&str] = &["experiment", "crowd", "--row", "20 people", "--runs", "1", "--until", "20s", "--json"];
    assert_documented("rpl experiment crowd", &[crowd]);
    let buildings: &[&str] = &["experiment", "buildings", "--row", "flats", "--runs", "1", "--until", "20s", "--json"];
    assert_documented("rpl experiment buildings", &[buildings]);
    let choices: &[&str] = &["experiment", "choices", "--row", "turned by 180°", "--runs", "1", "--json"];
    assert_documented("rpl experiment choices", &[choices]);
    let projections: &[&str] = &["experiment", "projections", "--row", "fetch", "--runs", "1", "--json"];
    assert_documented("rpl experiment projections", &[projections]);
    let grains: &[&str] = &["experiment", "grains", "--row", "small-office", "--runs", "2", "--json"];
    assert_documented("rpl experiment grains", &[grains]);
    let foresight: &[&str] =
        &["experiment", "foresight", "--row", "deadlines", "--runs", "1", "--until", "8min", "--json"];
    assert_documented("rpl experiment foresight", &[foresight]);
}

#[test]
fn experiments_with_instructions_are_as_documented() {
    let features: &[&str] =
        &["experiment", "hallway-features", "--row", "sonar alone", "--runs", "1", "--until", "40s", "--json"];
    let matrices: &[&str] = &["experiment", "hallway-features", "--runs", "1", "--until", "1s", "--json"];
    assert_documented("rpl experiment hallway-features", &[features, matrices]);
    let openings: &[&str] =
        &["experiment", "count-openings", "--row", "state set", "--runs", "1", "--until", "40s", "--json"];
    assert_documented("rpl experiment count-openings", &[openings]);
    let right: &[&str] =
        &["experiment", "office-delivery", "--row", "sonar alone", "--runs", "1", "--until", "5s", "--json"];
    let wrong: &[&str] =
        &["experiment", "office-delivery", "--row", "wrong lists", "--runs", "2", "--until", "5s", "--json"];
    assert_documented("rpl experiment office-delivery", &[right, wrong]);
    let map: &[&str] = &["experiment", "topological-global", "--row", "sonar alone", "--runs", "3", "--json"];
    assert_documented("rpl experiment topological-global", &[map]);
}

#[test]
fn experiments_with_cases_are_as_documented() {
    let routes: &[&str] = &["experiment", "routes", "--row", "guided, learning", "--runs", "2", "--json"];
    assert_documented("rpl experiment routes", &[routes]);
    let kinds: &[&str] = &["experiment", "case-kinds", "--row", "weighted", "--runs", "1", "--json"];
    assert_documented("rpl experiment case-kinds", &[kinds]);
    let tuned: &[&str] = &["experiment", "behaviours", "--row", "tuned alone", "--runs", "2", "--seed", "4", "--json"];
    assert_documented("rpl experiment behaviours", &[tuned]);
}
