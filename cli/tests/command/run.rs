//! `rpl run`: outcome, summary, trace, options.

use crate::folder::{folder, put};
use crate::rpl::{run, run_in};
use serde_json::Value;
use std::fs;

#[test]
fn exit_statuses_tell_how_a_plan_ended() {
    let folder = folder("statuses");
    let run_text = |name: &str, text: &str, more: &[&str]| {
        let plan = put(&folder, name, text);
        run(&[&["run", &plan], more].concat())
    };
    let found = run_text("good.rpl", "(print \"a\") (wait-time 5) (print (now))", &[]);
    assert_eq!((found.out.as_str(), found.errors.as_str(), found.status), ("a\n5.0\n", "value: 5.0\n", 0));
    let quiet = run_text("good.rpl", "(log 'logged) (wait-time 5) (log 'later) (list 1 \"two\")", &["-q"]);
    assert_eq!((quiet.out.as_str(), quiet.errors.as_str()), ("", "0.0 s  logged\n5.0 s  later\n"));
    let nothing = run_text("nothing.rpl", "(print \"a\") nil", &[]);
    assert_eq!((nothing.out.as_str(), nothing.errors.as_str()), ("a\n", ""));
    let long = run_text("long.rpl", "(let ((l nil)) (dotimes (i 2000) (push i l)) l)", &[]);
    assert!(long.errors.len() < 600 && long.errors.contains("characters; `--json` has them all)"), "{}", long.errors);
    let found = run_text("fails.rpl", "(fail \"no ~a\" 'luck)", &[]);
    assert_eq!(found.status, 1);
    assert!(found.errors.contains("plan-failure: no luck"), "{}", found.errors);
    assert_eq!(run_text("wrong.rpl", "(print", &[]).status, 2);
    let text = "(loop (print (now)) (wait-time 1))";
    let found = run_text("endless.rpl", text, &["--until", "2500ms"]);
    assert_eq!((found.out.as_str(), found.status), ("0.0\n1.0\n2.0\n", 3));
    // What happens at the very moment still happens.
    assert_eq!(run_text("endless.rpl", text, &["--until", "2s"]).out, "0.0\n1.0\n2.0\n");
}

#[test]
fn json_has_its_keys_whatever_the_outcome() {
    let folder = folder("json");
    let plan = put(&folder, "plan.rpl", "(defvar ok t) (wait-time 2) (if ok '(1 \"x\") (fail \"not ok\"))");
    let summary = |more: &[&str]| -> Value {
        let found = run(&[&["run", &plan, "--json"], more].concat());
        serde_json::from_str(&found.out).expect("one JSON object")
    };
    let good = summary(&["--seed", "7"]);
    for key in ["outcome", "value", "time_s", "failure", "contacts", "distance_m", "relocalizations", "wall_s", "seed"]
    {
        assert!(good.get(key).is_some(), "`{key}` is missing");
    }
    assert_eq!((&good["outcome"], &good["value"]), (&"succeeded".into(), &"(1 \"x\")".into()));
    assert_eq!((&good["time_s"], &good["seed"], &good["failure"]), (&2.0.into(), &7.into(), &Value::Null));
    let bad = summary(&["--set", "ok=nil"]);
    assert_eq!(bad["outcome"], "failed");
    let failure = &bad["failure"];
    assert_eq!((&failure["class"], &failure["message"]), (&"plan-failure".into(), &"not ok".into()));
    assert_eq!((&failure["file"], &failure["line"]), (&plan.as_str().into(), &1.into()));
    assert_eq!(failure["path"], "main");
    assert!(failure["causes"].as_array().is_some_and(Vec::is_empty));
    assert_eq!(summary(&["--until", "1s"])["outcome"], "timeout");
}

/// r[trace.file], r[determinism.same]
#[test]
fn the_trace_is_the_same_every_time() {
    let folder = folder("trace");
    let traces = [1, 2].map(|turn| {
        let path = folder.join(format!("trace-{turn}.jsonl"));
        let found = run(&["run", "first-steps", "--trace", &path.to_string_lossy()]);
        assert_eq!(found.status, 0, "{}", found.errors);
        fs::read_to_string(path).expect("the trace is there")
    });
    assert_eq!(traces[0], traces[1]);
    let mut last = -1;
    for line in traces[0].lines().skip(1) {
        let event: Value = serde_json::from_str(line).expect("every line is an object");
        for key in ["time_s", "seq", "task", "kind"] {
            assert!(event.get(key).is_some(), "{line}");
        }
        let sequence = event["seq"].as_i64().expect("a number");
        assert!(sequence > last, "{line}");
        last = sequence;
    }
    assert!(traces[0].lines().nth(1).is_some_and(|first| first.contains("\"task\":\"main\",\"kind\":\"begin\"")));
}

/// r[limit.steps]
#[test]
fn the_budget_of_steps_can_be_set() {
    let folder = folder("steps");
    let plan = put(&folder, "busy.rpl", "(dotimes (i 100000) i) 'done");
    let found = run(&["run", &plan, "--max-steps", "1000"]);
    assert!(found.errors.contains("runaway: 1000 steps"), "{}", found.errors);
    assert_eq!((found.status, run(&["run", &plan]).status), (1, 0));
}

#[test]
fn without_a_map_there_are_points_and_no_places() {
    let folder = folder("mapless");
    put(&folder, "drive.rpl", "(go-to-point 1 0)");
    put(&folder, "place.rpl", "(go-to 'corner)");
    let run = |rest: &[&str]| {
        let arguments = [&["run"], rest].concat();
        run_in(&folder, &arguments)
    };
    let driven = run(&["drive.rpl", "--world", "test-room", "--map", "none"]);
    assert_eq!(driven.status, 0, "{}", driven.errors);
    let lost = run(&["place.rpl", "--world", "test-room", "--map", "none"]);
    assert_eq!(lost.status, 1);
    assert!(lost.errors.contains("drive to a point with (go-to-point X Y)"), "{}", lost.errors);
    let unknown = run(&["drive.rpl", "--world", "test-room", "--map", "nome"]);
    assert_eq!(unknown.status, 2);
    assert!(unknown.errors.contains("'none'"), "{}", unknown.errors);
    let nowhere = run(&["drive.rpl", "--map", "none"]);
    assert_eq!(nowhere.status, 2);
    assert!(nowhere.errors.contains("--world"), "{}", nowhere.errors);
}

#[test]
fn nothing_of_a_plan_reaches_the_terminal_as_a_command_but_what_it_prints() {
    let folder = folder("escapes");
    let text = "(defvar name (intern \"a\\u{1b}[31mb\\0c\\u{202e}d\"))
                (print \"\\u{1b}[1mplan\")
                (execute-plan `(process ,name (fail \"red \\u{1b}[31m and \\u{7} bell\")))";
    let plan = put(&folder, "escapes.rpl", text);
    let trace = folder.join("escapes.jsonl");
    let trace = trace.to_str().expect("a path");
    fs::remove_file(trace).ok();
    let found = run(&["run", "--trace", trace, &plan]);
    assert!(found.out.starts_with("\u{1b}[1mplan\n"), "what a plan prints is its own");
    let shown = run(&["trace", trace]);
    for (what, told) in [("stderr", &found.errors), ("trace", &shown.out)] {
        let raw = told.chars().find(|&c| (c.is_control() && c != '\n') || c == '\u{202e}');
        assert_eq!(raw, None, "{what}\n{told:?}");
        assert!(told.contains("a\\u{1b}[31mb\\0c\\u{202e}d"), "{what}\n{told}");
    }
    assert!(found.errors.contains("red \\u{1b}[31m and \\u{7} bell"), "{}", found.errors);
}

#[test]
fn a_first_value_that_fails_is_shown_as_given_by_set() {
    let folder = folder("set-fails");
    let plan = put(&folder, "speed.rpl", "(defvar speed 1 \"how fast\")\n(print speed)");
    let found = run(&["run", &plan, "--set", "speed=(/ 1 0)"]);
    assert!(found.errors.contains("(defvar speed (/ 1 0) #| by --set |# \"how fast\")"), "{}", found.errors);
    let twice = run(&["run", &plan, "--set", "speed=1", "--set", "speed=2"]);
    assert_eq!(twice.status, 2);
    assert!(twice.errors.contains("`speed` is given twice: `--set speed=1` and `--set speed=2`"), "{}", twice.errors);
}
