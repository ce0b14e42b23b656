//! `rpl test`: what it tells of each test, as text, JSON and JUnit.

use crate::folder::{folder, put, text_in};
use crate::rpl::run;
use serde_json::Value;

#[test]
fn test_reports_as_junit() {
    let folder = folder("junit");
    let tests = put(
        &folder,
        "a&b.rpl",
        "(deftest good (wait-time 5))\n(deftest <bad&> (print \"x & \\u{1b}\") (fail \"1 < 2 & \\\"3\\\"\"))\n(deftest slow :until 10s (wait-time 60))\n",
    );
    let wrong = put(&folder, "wrong.rpl", "(deftest a (undefined))");
    let report = folder.join("report.xml").to_string_lossy().into_owned();
    let found = run(&["test", &tests, &wrong, "--junit", &report, "--seed", "4"]);
    assert_eq!(found.status, 2, "{}", found.errors);
    assert!(found.out.contains("3 tests, 2 failed"), "{}", found.out);
    let xml = text_in(&folder, "report.xml");
    for expected in [
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"rpl test\" tests=\"4\" failures=\"2\" errors=\"1\"",
        "a&amp;b.rpl\" tests=\"3\" failures=\"2\" errors=\"0\"",
        "<testcase name=\"good\" classname=",
        "<testcase name=\"&lt;bad&amp;&gt;\" classname=",
        "line=\"1\"",
        "<property name=\"seed\" value=\"4\"/>",
        "<property name=\"time_s\" value=\"5\"/>",
        "<failure type=\"plan-failure\" message=\"1 &lt; 2 &amp; &quot;3&quot;\">",
        "<failure type=\"timeout\" message=\"it had not ended after 10 s\">",
        "<system-out>x &amp; \\u{1b}</system-out>",
        "<error message=\"it cannot be compiled\">error[unbound-name]",
    ] {
        assert!(xml.contains(expected), "{expected}\n{xml}");
    }
    // It is XML: every tag that is opened is closed, and nothing stands there unescaped.
    let mut open = Vec::new();
    for tag in xml.split('<').skip(1).map(|rest| rest.split('>').next().unwrap_or_default()) {
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name), "{xml}"),
            None if tag.ends_with(['/', '?']) => {}
            None => open.push(tag.split(' ').next().unwrap_or_default()),
        }
    }
    assert!(open.is_empty(), "{open:?}");
    assert!(xml.chars().all(|c| !c.is_control() || c == '\n'), "{xml}");
    assert!(
        xml.split('&')
            .skip(1)
            .all(|rest| ["amp;", "lt;", "gt;", "quot;", "#"].iter().any(|known| rest.starts_with(known)))
    );
}

const TESTS: &str = "(def-plan wait-a-while () (wait-time 5))
(print \"the main task\")
(deftest waits (wait-a-while) (assert (= (now) 5.0)))
(deftest waits-longer (print \"going\") (wait-a-while) (assert (= (now) 6.0)))
(deftest waits-forever :until 10s (loop (wait-a-while)))
";

#[test]
fn test_tells_each_test_in_a_line_and_why_it_failed() {
    let folder = folder("test");
    let tests = put(&folder, "tests.rpl", TESTS);
    let found = run(&["test", &tests]);
    let shown = &found.out;
    assert!(shown.starts_with("ok      waits               5.0 s\nFAILED  waits-longer        5.0 s\n"), "{shown}");
    for expected in [
        "(now) is 5.0",
        "tests.rpl:4",
        "printed: going",
        "FAILED  waits-forever      10.0 s\n        it had not ended after 10 s",
        "3 tests, 2 failed",
    ] {
        assert!(shown.contains(expected), "{expected}\n{shown}");
    }
    assert!(!shown.contains("the main task"), "{shown}");
    assert_eq!(found.status, 1);
    let found = run(&["test", &tests, "--filter", "nothing"]);
    assert!(found.errors.contains("no test has a name with `nothing` in it"), "{}", found.errors);
    assert_eq!(found.status, 2);
    let wrong = put(&folder, "wrong.rpl", "(deftest a (undefined))");
    let found = run(&["test", &wrong, &tests, "--filter", "waits"]);
    assert!(found.errors.contains("`undefined` is not defined anywhere"), "{}", found.errors);
    assert_eq!((found.status, found.out.lines().next()), (2, Some(tests.as_str())));
}

#[test]
fn test_reports_as_json() {
    let folder = folder("test-json");
    let tests = put(&folder, "tests.rpl", TESTS);
    let found = run(&["test", &tests, "--json", "--seed", "4"]);
    let report: Value = serde_json::from_str(&found.out).expect("one JSON object");
    let outcomes: Vec<&Value> =
        report["tests"].as_array().expect("a list").iter().map(|test| &test["outcome"]).collect();
    assert_eq!(outcomes, ["succeeded", "failed", "timeout"]);
    let failed = &report["tests"][1];
    assert_eq!(
        (&failed["failure"]["class"], &failed["line"], &failed["seed"]),
        (&"plan-failure".into(), &4.into(), &4.into())
    );
    assert_eq!((&report["succeeded"], &report["failed"]), (&1.into(), &2.into()));
}

#[test]
fn a_scenario_that_has_failed_is_told_beside_what_the_test_found() {
    let folder = folder("test-scenario-failed");
    let scenario = put(&folder, "full.rpl", "(set-battery! 25)");
    let text = format!(
        "(deftest charged :world \"test-room\" :scenario {scenario:?} (wait-time 1) (assert (= 1 2)))\n\
         (deftest endless :world \"test-room\" :scenario {scenario:?} :until 2 (wait-for (> (value battery*) 2)))"
    );
    let found = run(&["test", &put(&folder, "tests.rpl", text)]);
    let shown = &found.out;
    assert_eq!(shown.matches("the scenario failed").count(), 2, "{shown}");
    assert!(shown.contains("this should be true: (= 1 2)") && shown.contains("it had not ended after 2 s"), "{shown}");
    assert_eq!(found.status, 1);
}

#[test]
fn the_name_of_a_test_among_the_files_is_no_plan() {
    let folder = folder("test-by-name");
    let tests = put(&folder, "tests.rpl", "(deftest arrives (wait-time 1))\n(deftest stays (wait-time 1))");
    let found = run(&["test", &tests, "stays"]);
    assert_eq!((found.status, found.out.as_str()), (2, ""));
    assert!(found.errors.contains("`stays` is a test of"), "{}", found.errors);
    assert!(found.errors.contains(&format!("write `rpl test {tests} --filter stays`")), "{}", found.errors);
}

#[test]
fn a_test_that_cannot_be_set_up_has_failed_and_the_others_run() {
    let folder = folder("test-set-up");
    let broken = put(&folder, "broken.toml", "this is no world");
    let tests = put(
        &folder,
        "tests.rpl",
        format!(
            "; nothing else\n(deftest one (assert (= 1 1)))\n(deftest nowhere :world \"dpt\" (wait-time 1))\n\
             (deftest broken :world {broken:?} (wait-time 1))\n\
             (deftest without :world \"test-room\" :scenario \"none.rpl\" (wait-time 1))\n\
             (deftest wrong :world \"test-room\" :scenario {:?} (wait-time 1))\n(deftest last (assert (= 1 1)))",
            put(&folder, "wrong.rpl", "(undefined)")
        ),
    );
    let found = run(&["test", &tests]);
    let shown = &found.out;
    let lines: Vec<&str> = shown.lines().filter(|line| line.starts_with("ok") || line.starts_with("FAILED")).collect();
    assert_eq!(lines.len(), 6, "{shown}");
    assert!(lines[0].starts_with("ok") && lines[5].starts_with("ok"), "{shown}");
    for expected in [
        "did you mean `dept`?",
        "broken.toml",
        "there is no scenario `none.rpl`",
        "`undefined` is not defined anywhere",
        "6 tests, 4 failed",
    ] {
        assert!(shown.contains(expected), "{expected}\n{shown}");
    }
    assert_eq!(found.status, 1);
    let found = run(&["test", &tests, "--json"]);
    let report: Value = serde_json::from_str(&found.out).expect("one JSON object");
    assert_eq!((&report["succeeded"], &report["failed"]), (&2.into(), &4.into()));
    assert_eq!((&report["tests"][1]["failure"]["class"], &report["tests"][1]["line"]), (&"set-up".into(), &3.into()));
}

#[test]
fn a_test_runs_in_the_world_it_names() {
    let folder = folder("test-world");
    let tests = put(
        &folder,
        "tests.rpl",
        "(deftest sure :world \"test-room\" (assert (> (value pos-certainty*) 0.5)))\n(deftest alone (assert (= 1 1)))\n(deftest lost (go-to 'corner))",
    );
    let found = run(&["test", &tests]);
    let words: Vec<&str> = found.out.lines().filter_map(|line| line.strip_prefix("ok").map(str::trim_start)).collect();
    assert_eq!(words.len(), 2, "{}", found.out);
    assert!(found.out.contains("it ran without a robot"), "{}", found.out);
}

#[test]
fn a_test_that_fails_for_itself_is_not_told_to_look_for_a_robot() {
    let folder = folder("no-robot");
    let text = "(def-plan patrol () (go-to 'kitchen))
                (deftest of-itself (assert (= 1 2)))
                (deftest of-the-robot (patrol))";
    let plan = put(&folder, "robot.rpl", text);
    let found = run(&["test", &plan]);
    let told = &found.out;
    let (itself, robot) = told.split_once("of-the-robot").expect("both tests are told");
    assert!(!itself.contains(":world") && itself.contains("this should be true"), "{told}");
    assert!(robot.contains(":world \"dept\""), "{told}");
}
