//! `rpl check`: findings, over the examples too.

use crate::folder::{folder, put};
use crate::rpl::run;
use std::fs;
use std::path::Path;

#[test]
fn check_tells_all_findings_and_says_when_there_are_none() {
    let folder = folder("check");
    let good = put(&folder, "good.rpl", "(print 1)");
    let bad = put(&folder, "bad.rpl", "(print undefined-1)\n(print undefined-2)");
    let found = run(&["check", &good]);
    assert_eq!(found.out, format!("{good}: no findings\n"));
    assert_eq!(found.status, 0);
    let found = run(&["check", &bad, &good]);
    assert_eq!(found.out, format!("{good}: no findings\n"));
    assert!(found.errors.contains("undefined-1") && found.errors.contains("undefined-2"));
    assert_eq!(found.status, 2);
}

#[test]
fn every_example_is_free_of_errors() {
    let listed = run(&["examples"]);
    let names: Vec<&str> = listed.out.lines().filter_map(|line| line.split_whitespace().next()).collect();
    const IN_EXPERIMENTS: [&str; 8] =
        ["about-face", "crowd", "global", "kidnapped", "office-day", "rotated", "turned", "turned-on-the-way"];
    let is_scenario = |name: &&str| {
        let experiment = name.strip_prefix("experiments/").and_then(|name| name.strip_suffix(".rpl"));
        name.starts_with("scenarios/") || experiment.is_some_and(|name| IN_EXPERIMENTS.contains(&name))
    };
    let (scenarios, plans): (Vec<&str>, Vec<&str>) = names.into_iter().partition(is_scenario);
    for found in [run(&[&["check"], &plans[..]].concat()), run(&[&["check", "--scenario"], &scenarios[..]].concat())] {
        assert_eq!(found.status, 0, "{}", found.errors);
    }
}

#[test]
fn places_are_looked_up_in_the_world_that_is_named() {
    let folder = folder("check-world");
    let text = "(go-to 'a-118)\n(deliver 'mail 'mailroom 'nowhere)\n(print (distance-to 'start))\n(print 'nowhere)";
    let plan = put(&folder, "places.rpl", text);
    let unknown = run(&["check", &plan]);
    assert_eq!((unknown.errors.as_str(), unknown.status), ("", 0), "without a world no place is wrong");
    let found = run(&["check", "--world", "dept", &plan]);
    let names: Vec<&str> = found
        .errors
        .lines()
        .filter_map(|line| line.strip_prefix("warning[unknown-place]: there is no place `"))
        .filter_map(|line| line.split('`').next())
        .collect();
    let world = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../robot/worlds/dept.toml"));
    let world = world.expect("the world is there");
    let missing = |name: &&str| !world.contains(&format!("name = \"{name}\""));
    let expected: Vec<&str> = ["a-118", "mailroom", "nowhere", "start"].into_iter().filter(missing).collect();
    assert_eq!(names, expected, "{}", found.errors);
    assert_eq!(run(&["check", "--world", "nosuch", &plan]).status, 2);
}
