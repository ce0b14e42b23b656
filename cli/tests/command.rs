//! The command as a user types it: output, exit status, files.

use serde_json::Value;
use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

fn rpl(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rpl"));
    command.args(arguments);
    command
}

fn output(arguments: &[&str]) -> Output {
    rpl(arguments).output().expect("the command runs")
}

fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).expect("the output is text")
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("the errors are text")
}

fn status(output: &Output) -> i32 {
    output.status.code().expect("the command exits by itself")
}

/// A folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).expect("the folder can be made");
    folder
}

fn plan(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    fs::write(&path, text).expect("the plan can be written");
    path.display().to_string()
}

fn wait_for_line(child: &mut Child) {
    let mut byte = [0];
    let out = child.stdout.as_mut().expect("the output is piped");
    while out.read(&mut byte).expect("the output can be read") == 1 && byte[0] != b'\n' {}
}

#[test]
fn eval_prints_the_value_as_it_could_be_read() {
    let found = output(&["eval", "(print \"hello\") (list 1 2.0 \"three\" 'four)"]);
    assert_eq!(stdout(&found), "hello\n(1 2.0 \"three\" four)\n");
    assert_eq!((stderr(&found), status(&found)), ("", 0));
}

#[test]
fn eval_reads_standard_input() {
    let mut child = rpl(&["eval", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("it starts");
    child.stdin.take().expect("it reads").write_all(b"(+ 1\n2)").expect("it takes the text");
    assert_eq!(stdout(&child.wait_with_output().expect("it ends")), "3\n");
}

#[test]
fn eval_has_the_robot_of_a_world_and_lays_out_the_plan_it_makes() {
    let found = output(&["eval", "(generate-navigation-plan 'corner)", "--world", "test-room"]);
    let plan = stdout(&found);
    assert!(plan.starts_with("(with-policies (") && plan.lines().count() > 2, "{plan}{}", stderr(&found));
    assert!(plan.contains("(run-behaviour navigation :targets"), "{plan}");
    let found = output(&["eval", "(go-to 'shlf)", "--world", "test-room"]);
    assert!(stderr(&found).contains("`shlf` is not in world `test-room`"), "{}", stderr(&found));
    assert_eq!(status(&found), 1);
}

#[test]
fn check_tells_all_findings_and_says_when_there_are_none() {
    let folder = folder("check");
    let good = plan(&folder, "good.rpl", "(print 1)");
    let bad = plan(&folder, "bad.rpl", "(print undefined-1)\n(print undefined-2)");
    let found = output(&["check", &good]);
    assert_eq!(stdout(&found), format!("{good}: no findings\n"));
    assert_eq!(status(&found), 0);
    let found = output(&["check", &bad, &good]);
    assert_eq!(stdout(&found), format!("{good}: no findings\n"));
    assert!(stderr(&found).contains("undefined-1") && stderr(&found).contains("undefined-2"));
    assert_eq!(status(&found), 2);
}

#[test]
fn every_example_is_free_of_errors() {
    let listed = output(&["examples"]);
    let names: Vec<&str> = stdout(&listed).lines().filter_map(|line| line.split_whitespace().next()).collect();
    const IN_EXPERIMENTS: [&str; 6] = ["about-face", "global", "kidnapped", "office-day", "rotated", "turned"];
    let is_scenario = |name: &&str| {
        let experiment = name.strip_prefix("experiments/").and_then(|name| name.strip_suffix(".rpl"));
        name.starts_with("scenarios/") || experiment.is_some_and(|name| IN_EXPERIMENTS.contains(&name))
    };
    let (scenarios, plans): (Vec<&str>, Vec<&str>) = names.into_iter().partition(is_scenario);
    for found in
        [output(&[&["check"], &plans[..]].concat()), output(&[&["check", "--scenario"], &scenarios[..]].concat())]
    {
        assert_eq!(status(&found), 0, "{}", stderr(&found));
    }
}

#[test]
fn exit_statuses_tell_how_a_plan_ended() {
    let folder = folder("statuses");
    let run = |name: &str, text: &str, more: &[&str]| {
        let plan = plan(&folder, name, text);
        output(&[&["run", &plan], more].concat())
    };
    let found = run("good.rpl", "(print \"a\") (wait-time 5) (print (now))", &[]);
    assert_eq!((stdout(&found), stderr(&found), status(&found)), ("a\n5.0\n", "", 0));
    let found = run("fails.rpl", "(fail \"no ~a\" 'luck)", &[]);
    assert_eq!(status(&found), 1);
    assert!(stderr(&found).contains("plan-failure: no luck"), "{}", stderr(&found));
    assert_eq!(status(&run("wrong.rpl", "(print", &[])), 2);
    let text = "(loop (print (now)) (wait-time 1))";
    let found = run("endless.rpl", text, &["--until", "2500ms"]);
    assert_eq!((stdout(&found), status(&found)), ("0.0\n1.0\n2.0\n", 3));
    // What happens at the very moment still happens.
    assert_eq!(stdout(&run("endless.rpl", text, &["--until", "2s"])), "0.0\n1.0\n2.0\n");
}

#[test]
fn json_has_its_keys_whatever_the_outcome() {
    let folder = folder("json");
    let plan = plan(&folder, "plan.rpl", "(defvar ok t) (wait-time 2) (if ok '(1 \"x\") (fail \"not ok\"))");
    let summary = |more: &[&str]| -> Value {
        let found = output(&[&["run", &plan, "--json"], more].concat());
        serde_json::from_str(stdout(&found)).expect("one JSON object")
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
    let traces = [1, 2].map(|run| {
        let path = folder.join(format!("trace-{run}.jsonl"));
        let found = output(&["run", "first-steps", "--trace", &path.display().to_string()]);
        assert_eq!(status(&found), 0, "{}", stderr(&found));
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

#[test]
fn a_closed_pipe_ends_quietly_and_runs_clean_ups() {
    let folder = folder("pipe");
    let trace = folder.join("pipe.jsonl").display().to_string();
    let plan = plan(&folder, "pipe.rpl", "(unwind-protect (loop (print 1) (wait-time 1)) (print 2))");
    let mut command = rpl(&["run", &plan, "--trace", &trace]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    wait_for_line(&mut child);
    drop(child.stdout.take());
    let found = child.wait_with_output().expect("it ends");
    assert_eq!((stderr(&found), status(&found)), ("", 0));
    let trace = fs::read_to_string(trace).expect("the trace is there");
    let last: Value = serde_json::from_str(trace.lines().last().unwrap_or_default()).expect("a whole object");
    assert_eq!((&last["task"], &last["kind"], &last["state"]), (&"main".into(), &"end".into(), &"evaporated".into()));
}

#[test]
fn an_endless_loop_that_prints_is_seen_and_ends_with_its_reader() {
    let folder = folder("printing");
    for text in ["(loop (print 1))", "(wait-time 1) (loop (print 1))"] {
        let plan = plan(&folder, "endless.rpl", text);
        let mut child = rpl(&["run", &plan]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        wait_for_line(&mut child);
        drop(child.stdout.take());
        let found = child.wait_with_output().expect("it ends");
        assert_eq!((stderr(&found), status(&found)), ("", 0));
    }
}

#[cfg(unix)]
/// r[cleanup.stop]
#[test]
fn an_interrupt_runs_the_clean_ups_and_says_130() {
    let folder = folder("interrupt");
    let text = "(unwind-protect (loop (print 'going) (wait-time 1)) (seq (wait-time 1) (print 'clean)))";
    let plan = plan(&folder, "endless.rpl", text);
    for signal in ["-INT", "-TERM"] {
        let mut command = rpl(&["run", &plan, "--realtime", "20"]);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        // By the first line the signals are caught.
        wait_for_line(&mut child);
        let id = child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().expect("kill runs").success());
        let found = child.wait_with_output().expect("it ends");
        assert_eq!(status(&found), 130, "{}", stderr(&found));
        assert!(stdout(&found).ends_with("clean\n"), "{}", stdout(&found));
    }
}

/// r[cleanup.stop]
#[test]
fn a_second_interrupt_ends_the_program_at_once() {
    let folder = folder("interrupt-twice");
    let text = "(unwind-protect (seq (print 'going) (wait-time 1000)) (seq (print 'cleaning) (wait-time 1000) (print 'clean)))";
    let plan = plan(&folder, "patient.rpl", text);
    let mut command = rpl(&["run", &plan, "--realtime", "1"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let id = child.id().to_string();
    for _ in ["going", "cleaning"] {
        wait_for_line(&mut child);
        assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    }
    let found = child.wait_with_output().expect("it ends");
    assert_eq!((stdout(&found), status(&found)), ("", 130), "{}", stderr(&found));
}

/// r[limit.steps]
#[test]
fn the_budget_of_steps_can_be_set() {
    let folder = folder("steps");
    let plan = plan(&folder, "busy.rpl", "(dotimes (i 100000) i) 'done");
    let found = output(&["run", &plan, "--max-steps", "1000"]);
    assert!(stderr(&found).contains("runaway: 1000 steps"), "{}", stderr(&found));
    assert_eq!((status(&found), status(&output(&["run", &plan]))), (1, 0));
}

/// r[eval.load]
#[test]
fn a_file_that_loads_itself_is_an_error_of_the_text() {
    let folder = folder("circle");
    let first = plan(&folder, "first.rpl", "(load \"second.rpl\")");
    plan(&folder, "second.rpl", "(load \"first.rpl\")");
    let found = output(&["run", &first]);
    assert!(stderr(&found).contains("loads itself"), "{}", stderr(&found));
    assert_eq!(status(&found), 2);
}

#[test]
fn missing_files_are_told_with_what_was_probably_meant() {
    let folder = folder("missing");
    plan(&folder, "kitchen.rpl", "(print 1)");
    let found = rpl(&["run", "kitchn.rpl"]).current_dir(&folder).output().expect("the command runs");
    assert_eq!(status(&found), 2);
    assert!(stderr(&found).contains("did you mean `kitchen.rpl`?"), "{}", stderr(&found));
    let found = output(&["run", "first-stps.rpl"]);
    assert!(stderr(&found).contains("did you mean `first-steps.rpl`?"), "{}", stderr(&found));
    let found = output(&["run", "first-steps", "--world", "dpt"]);
    assert!(stderr(&found).contains("did you mean `dept`?"), "{}", stderr(&found));
    let found = output(&["run", &folder.display().to_string()]);
    assert!(stderr(&found).contains("it is a folder"), "{}", stderr(&found));
    assert_eq!(status(&found), 2);
}

#[test]
fn without_a_map_there_are_points_and_no_places() {
    let folder = folder("mapless");
    plan(&folder, "drive.rpl", "(go-to-point 1 0)");
    plan(&folder, "place.rpl", "(go-to 'corner)");
    let run = |rest: &[&str]| {
        let arguments = [&["run"], rest].concat();
        rpl(&arguments).current_dir(&folder).output().expect("the command runs")
    };
    let driven = run(&["drive.rpl", "--world", "test-room", "--map", "none"]);
    assert_eq!(status(&driven), 0, "{}", stderr(&driven));
    let lost = run(&["place.rpl", "--world", "test-room", "--map", "none"]);
    assert_eq!(status(&lost), 1);
    assert!(stderr(&lost).contains("drive to a point with (go-to-point X Y)"), "{}", stderr(&lost));
    let unknown = run(&["drive.rpl", "--world", "test-room", "--map", "nome"]);
    assert_eq!(status(&unknown), 2);
    assert!(stderr(&unknown).contains("'none'"), "{}", stderr(&unknown));
    let nowhere = run(&["drive.rpl", "--map", "none"]);
    assert_eq!(status(&nowhere), 2);
    assert!(stderr(&nowhere).contains("--world"), "{}", stderr(&nowhere));
}

/// r[eval.load]
#[test]
fn a_plan_loads_files_beside_it_and_none_outside() {
    let folder = folder("load");
    fs::create_dir_all(folder.join("main/parts")).expect("the folder can be made");
    plan(&folder, "secret.rpl", "(print 'secret)");
    plan(&folder, "main/parts/two.rpl", "(defvar two 2) (load \"three.rpl\")");
    plan(&folder, "main/parts/three.rpl", "(load \"../four.rpl\") (defvar three 3)");
    plan(&folder, "main/four.rpl", "(defvar four 4)");
    let good = plan(&folder, "main/good.rpl", "(load \"parts/two.rpl\") (print (list two three four))");
    let found = output(&["run", &good]);
    assert_eq!((stdout(&found), stderr(&found)), ("(2 3 4)\n", ""));
    let here = rpl(&["run", "good.rpl"]).current_dir(folder.join("main")).output().expect("the command runs");
    assert_eq!(stdout(&here), "(2 3 4)\n");
    let absolute = folder.join("secret.rpl").display().to_string();
    for outside in ["../secret.rpl", "parts/../../secret.rpl", "../nothing-there.rpl", absolute.as_str()] {
        let bad = plan(&folder, "main/bad.rpl", &format!("(load {outside:?})"));
        let found = output(&["run", &bad]);
        assert_eq!((stdout(&found), status(&found)), ("", 2));
        assert!(stderr(&found).contains("outside the folder of the main file"), "{}", stderr(&found));
    }
}

#[test]
fn deep_nesting_is_an_error_of_the_text() {
    let folder = folder("nesting");
    let deep = plan(&folder, "deep.rpl", &format!("{}{}", "(".repeat(100_000), ")".repeat(100_000)));
    let open = plan(&folder, "open.rpl", &"(".repeat(100_000));
    for plan in [deep, open] {
        let found = output(&["run", &plan]);
        assert_eq!(status(&found), 2, "{}", stderr(&found));
        assert!(stderr(&found).starts_with("error["), "{}", stderr(&found));
    }
}

#[test]
fn the_command_line_is_explained() {
    for wrong in [&["run"][..], &["rnu", "x.rpl"], &["run", "first-steps", "--until", "soon"], &["--no-such"]] {
        let found = output(wrong);
        assert_eq!((stdout(&found), status(&found)), ("", 2), "{wrong:?}");
        assert!(!stderr(&found).is_empty(), "{wrong:?}");
    }
    assert!(stdout(&output(&["--help"])).contains("Exit status"));
    assert!(stdout(&output(&["completions", "bash"])).contains("rpl"));
}

#[test]
fn names_are_documented() {
    assert!(stdout(&output(&["doc", "try-all"])).contains("Succeeds at the first success"));
    assert!(stdout(&output(&["doc", "wait-time"])).starts_with("(wait-time "));
    assert!(stdout(&output(&["doc", "behaviours"])).contains("active-localization"));
    assert!(stdout(&output(&["doc", "waiting"])).contains("wait-for"));
    assert!(stdout(&output(&["doc", "timeout"])).starts_with("timeout below failure, with seconds\n"));
    assert!(stdout(&output(&["doc", "fmt"])).starts_with("rpl fmt "));
    let found = output(&["doc", "semaphore"]);
    assert!(stdout(&found).contains("def-valve"), "{}", stdout(&found));
    let found = output(&["doc", "try-al"]);
    assert!(stderr(&found).contains("did you mean `try-all`?"), "{}", stderr(&found));
    assert_eq!(status(&found), 2);
}

#[test]
fn worlds_and_examples_are_listed_and_shown() {
    assert!(stdout(&output(&["worlds"])).contains("dept"));
    assert!(stdout(&output(&["worlds", "test-room"])).contains("table-side"));
    assert!(stdout(&output(&["examples"])).contains("first-steps.rpl"));
    assert!(stdout(&output(&["examples", "first-steps"])).starts_with(';'));
}

#[test]
fn an_experiment_makes_a_table_however_many_jobs() {
    let tables = ["1", "4"].map(|jobs| {
        let found = output(&["experiment", "first-steps", "--runs", "6", "--jobs", jobs]);
        assert_eq!(status(&found), 0, "{}", stderr(&found));
        stdout(&found).to_string()
    });
    assert_eq!(tables[0], tables[1]);
    assert!(tables[0].contains("succeeded 6 of 6: 100.0 %"), "{}", tables[0]);
    assert!(tables[0].contains("time [s]                  6      90.00     0.00"), "{}", tables[0]);
}

#[test]
fn fmt_formats_files_in_place_and_check_only_lists_them() {
    let folder = folder("fmt");
    let ugly = plan(&folder, "ugly.rpl", "(par (wait-time 1)\n(wait-time   2) ; long\n)\n");
    let good = plan(&folder, "good.rpl", "(print 1)\n");
    let wrong = plan(&folder, "wrong.rpl", "(print  (1)");
    let found = output(&["fmt", "--check", &ugly, &good]);
    assert_eq!((stdout(&found), status(&found)), (format!("{ugly}\n").as_str(), 1));
    let found = output(&["fmt", &wrong, &ugly, &good]);
    assert_eq!(status(&found), 2);
    assert!(stderr(&found).contains("never closed") && stderr(&found).contains("left as it is"), "{}", stderr(&found));
    assert_eq!(fs::read_to_string(&wrong).expect("it is there"), "(print  (1)");
    let formatted = "(par (wait-time 1)\n     (wait-time 2)) ; long\n";
    assert_eq!(fs::read_to_string(&ugly).expect("it is there"), formatted);
    let found = output(&["fmt", "--check", &ugly, &good]);
    assert_eq!((stdout(&found), stderr(&found), status(&found)), ("", "", 0));
    let left: Vec<_> = fs::read_dir(&folder).expect("it is a folder").collect();
    assert_eq!(left.len(), 3, "{left:?}");
}

#[test]
fn fmt_formats_standard_input() {
    let mut command = rpl(&["fmt", "-"]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("it starts");
    child.stdin.take().expect("it reads").write_all(b"( print\n1 )").expect("it takes the text");
    assert_eq!(stdout(&child.wait_with_output().expect("it ends")), "(print\n  1)\n");
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
    let tests = plan(&folder, "tests.rpl", TESTS);
    let found = output(&["test", &tests]);
    let shown = stdout(&found);
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
    assert_eq!(status(&found), 1);
    let found = output(&["test", &tests, "--filter", "nothing"]);
    assert!(stderr(&found).contains("no test has a name with `nothing` in it"), "{}", stderr(&found));
    assert_eq!(status(&found), 2);
    let wrong = plan(&folder, "wrong.rpl", "(deftest a (undefined))");
    let found = output(&["test", &wrong, &tests, "--filter", "waits"]);
    assert!(stderr(&found).contains("`undefined` is not defined anywhere"), "{}", stderr(&found));
    assert_eq!((status(&found), stdout(&found).lines().next()), (2, Some(tests.as_str())));
}

#[test]
fn test_reports_as_json() {
    let folder = folder("test-json");
    let tests = plan(&folder, "tests.rpl", TESTS);
    let found = output(&["test", &tests, "--json", "--seed", "4"]);
    let report: Value = serde_json::from_str(stdout(&found)).expect("one JSON object");
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
fn a_test_that_cannot_be_set_up_has_failed_and_the_others_run() {
    let folder = folder("test-set-up");
    let broken = plan(&folder, "broken.toml", "this is no world");
    let tests = plan(
        &folder,
        "tests.rpl",
        &format!(
            "; nothing else\n(deftest one (assert (= 1 1)))\n(deftest nowhere :world \"dpt\" (wait-time 1))\n\
             (deftest broken :world {broken:?} (wait-time 1))\n\
             (deftest without :world \"test-room\" :scenario \"none.rpl\" (wait-time 1))\n\
             (deftest wrong :world \"test-room\" :scenario {:?} (wait-time 1))\n(deftest last (assert (= 1 1)))",
            plan(&folder, "wrong.rpl", "(undefined)")
        ),
    );
    let found = output(&["test", &tests]);
    let shown = stdout(&found);
    let lines: Vec<&str> = shown.lines().filter(|line| line.starts_with("ok") || line.starts_with("FAILED")).collect();
    assert_eq!(lines.len(), 6, "{shown}");
    assert!(lines[0].starts_with("ok") && lines[5].starts_with("ok"), "{shown}");
    for expected in [
        "did you mean `dept`?",
        "broken.toml",
        "there is no plan `none.rpl`",
        "`undefined` is not defined anywhere",
        "6 tests, 4 failed",
    ] {
        assert!(shown.contains(expected), "{expected}\n{shown}");
    }
    assert_eq!(status(&found), 1);
    let found = output(&["test", &tests, "--json"]);
    let report: Value = serde_json::from_str(stdout(&found)).expect("one JSON object");
    assert_eq!((&report["succeeded"], &report["failed"]), (&2.into(), &4.into()));
    assert_eq!((&report["tests"][1]["failure"]["class"], &report["tests"][1]["line"]), (&"set-up".into(), &3.into()));
}

#[test]
fn a_test_runs_in_the_world_it_names() {
    let folder = folder("test-world");
    let tests = plan(
        &folder,
        "tests.rpl",
        "(deftest sure :world \"test-room\" (assert (> (value pos-certainty*) 0.5)))\n(deftest alone (assert (= 1 1)))\n(deftest lost (go-to 'corner))",
    );
    let found = output(&["test", &tests]);
    let words: Vec<&str> =
        stdout(&found).lines().filter_map(|line| line.strip_prefix("ok").map(str::trim_start)).collect();
    assert_eq!(words.len(), 2, "{}", stdout(&found));
    assert!(stdout(&found).contains("it ran without a robot"), "{}", stdout(&found));
}
