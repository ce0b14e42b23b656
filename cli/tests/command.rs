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
    assert_eq!((stdout(&found), stderr(&found), status(&found)), ("a\n5.0\n", "value: 5.0\n", 0));
    let quiet = run("good.rpl", "(log 'logged) (wait-time 5) (log 'later) (list 1 \"two\")", &["-q"]);
    assert_eq!((stdout(&quiet), stderr(&quiet)), ("", "0.0 s  logged\n5.0 s  later\n"));
    let nothing = run("nothing.rpl", "(print \"a\") nil", &[]);
    assert_eq!((stdout(&nothing), stderr(&nothing)), ("a\n", ""));
    let long = run("long.rpl", "(let ((l nil)) (dotimes (i 2000) (push i l)) l)", &[]);
    assert!(
        stderr(&long).len() < 600 && stderr(&long).contains("characters; `--json` has them all)"),
        "{}",
        stderr(&long)
    );
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
    assert_eq!((stdout(&found), stderr(&found)), ("(2 3 4)\n", "value: (2 3 4)\n"));
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
fn what_is_mistyped_is_told_with_what_was_probably_meant() {
    for (line, meant) in [
        (&["rnu", "x.rpl"][..], "'run'"),
        (&["experimnt", "rotated"], "'experiment'"),
        (&["run", "x.rpl", "--wrold", "dept"], "'--world'"),
        (&["test", "x.rpl", "--jnuit", "x.xml"], "'--junit'"),
        (&["--colour", "never"], "'--color'"),
        (&["--color", "allways"], "'always'"),
        (&["run", "x.rpl", "--map", "nome"], "'none'"),
        (&["completions", "bsh"], "'bash'"),
    ] {
        let found = output(line);
        assert!(stderr(&found).contains("similar") && stderr(&found).contains(meant), "{line:?}: {}", stderr(&found));
        assert_eq!((stdout(&found), status(&found)), ("", 2), "{line:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_written_is_told() {
    let folder = folder("full");
    let plan = plan(&folder, "plan.rpl", "(print 1)");
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").expect("it is always full");
    for line in [
        &["--help"][..],
        &["--version"],
        &["run", "--help"],
        &["worlds"],
        &["examples"],
        &["doc"],
        &["completions", "bash"],
        &["run", &plan],
        &["eval", "1"],
        &["eval", "1", "--json"],
        &["check", &plan],
        &["check", "--json", &plan],
        &["experiment", &plan, "--runs", "1"],
    ] {
        let found = rpl(line).stdout(full()).output().expect("the command runs");
        assert_eq!(status(&found), 2, "{line:?}");
        let told = "error: cannot write to standard output: No space left";
        assert!(stderr(&found).starts_with(told), "{line:?}: {}", stderr(&found));
    }
}

#[test]
fn whoever_closes_the_pipe_has_read_enough() {
    for line in [&["--help"][..], &["doc"], &["worlds"], &["examples", "delivery"], &["completions", "bash"]] {
        let mut child = rpl(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        drop(child.stdout.take());
        let found = child.wait_with_output().expect("it ends");
        assert_eq!((stderr(&found), status(&found)), ("", 0), "{line:?}");
    }
}

#[test]
fn the_version_is_told() {
    let version = env!("CARGO_PKG_VERSION");
    for line in ["--version", "-V"] {
        assert!(stdout(&output(&[line])).starts_with(&format!("rpl {version}")));
    }
}

/// A command that reads a text from standard input.
fn with_input(arguments: &[&str], text: &str) -> Output {
    let mut command = rpl(arguments);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("it starts");
    // What refuses its arguments does not read.
    child.stdin.take().expect("it reads").write_all(text.as_bytes()).ok();
    child.wait_with_output().expect("it ends")
}

#[test]
fn a_plan_comes_from_standard_input() {
    let folder = folder("stdin");
    plan(&folder, "loaded.rpl", "(defvar loaded 'beside)");
    let found = with_input(&["run", "-"], "(print (+ 1 2))");
    assert_eq!((stdout(&found), stderr(&found), status(&found)), ("3\n", "value: 3\n", 0));
    let found = with_input(&["run", "-", "--json"], "(fail \"no\")");
    assert_eq!(status(&found), 1);
    assert!(stdout(&found).contains("\"file\":\"<stdin>\""), "{}", stdout(&found));
    let found = with_input(&["run", "-"], "(print");
    assert!(stderr(&found).contains("<stdin>:1:1") && status(&found) == 2, "{}", stderr(&found));
    assert!(stdout(&with_input(&["check", "-"], "(print 1)")).contains("<stdin>: no findings"));
    assert!(stdout(&with_input(&["test", "-"], "(deftest a (assert (= 1 1)))")).contains("1 test, all ok"));
    assert!(stdout(&with_input(&["experiment", "-", "--runs", "2"], "(wait-time 3)")).contains("succeeded 2 of 2"));
    // Files beside are reached from the working folder.
    let mut command = rpl(&["run", "-"]);
    command.current_dir(&folder).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().expect("it starts");
    let text = b"(load \"loaded.rpl\") (print loaded)";
    child.stdin.take().expect("it reads").write_all(text).expect("it takes the text");
    assert_eq!(stdout(&child.wait_with_output().expect("it ends")), "beside\n");
    // What is read once cannot be read again, and the prompt reads its lines there.
    let found = with_input(&["check", "-", "-"], "(print 1)");
    assert!(stderr(&found).contains("`-` stands for it in two places"), "{}", stderr(&found));
    assert_eq!(status(&found), 2);
    let found = with_input(&["repl", "-"], "(print 1)");
    assert!(stderr(&found).contains("`rpl run -` runs a plan from there"), "{}", stderr(&found));
    assert_eq!(status(&found), 2);
}

/// A folder with plans in folders, and with what is none.
fn folder_of_plans(name: &str) -> PathBuf {
    let folder = folder(name);
    fs::remove_dir_all(&folder).expect("the folder of the last time can go");
    for inner in ["b/deep", ".hidden", "target", "empty"] {
        fs::create_dir_all(folder.join(inner)).expect("the folder can be made");
    }
    let text = "(deftest works\n  (assert (= 1 1)))\n";
    for file in ["z.rpl", "b/a.rpl", "b/deep/c.rpl"] {
        plan(&folder, file, text);
    }
    for file in [".hidden/x.rpl", "target/x.rpl", "b/.x.rpl", "b/x.txt"] {
        plan(&folder, file, "(not a plan");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&folder, folder.join("b/up")).expect("links can be made");
        std::os::unix::fs::symlink(folder.join("b"), folder.join("empty/around")).expect("links can be made");
        std::os::unix::fs::symlink("nowhere.rpl", folder.join("b/dangling.rpl")).expect("links can be made");
    }
    folder
}

#[test]
fn a_folder_stands_for_the_plans_below_it() {
    let folder = folder_of_plans("folders");
    let in_folder = |arguments: &[&str]| rpl(arguments).current_dir(&folder).output().expect("the command runs");
    let found = in_folder(&["check", "."]);
    assert_eq!(stdout(&found), "b/a.rpl: no findings\nb/deep/c.rpl: no findings\nz.rpl: no findings\n");
    assert_eq!((stderr(&found), status(&found)), ("", 0));
    // Each file once, however it is named; files that are named themselves are checked in any case.
    let found = in_folder(&["check", "z.rpl", "b", "."]);
    assert_eq!(stdout(&found), "z.rpl: no findings\nb/a.rpl: no findings\nb/deep/c.rpl: no findings\n");
    assert_eq!(status(&in_folder(&["check", "b/.x.rpl"])), 2);
    let found = in_folder(&["test", "."]);
    assert!(stdout(&found).starts_with("b/a.rpl\nok "), "{}", stdout(&found));
    assert!(stdout(&found).contains("3 tests, all ok"), "{}", stdout(&found));
    let found = in_folder(&["fmt", "--check", "b"]);
    assert_eq!((stdout(&found), status(&found)), ("", 0));
    plan(&folder, "b/ugly.rpl", "( print   1)\n");
    let found = in_folder(&["fmt", "--check", "."]);
    assert_eq!((stdout(&found), status(&found)), ("b/ugly.rpl\n", 1));
    #[cfg(target_os = "linux")]
    {
        use std::os::unix::ffi::OsStrExt;
        let name = std::ffi::OsStr::from_bytes(b"\xff.rpl");
        fs::write(folder.join(name), "(print 1)").expect("the file can be written");
        let found = in_folder(&["check", "."]);
        assert!(
            stderr(&found).contains(".rpl` is not UTF-8") && stdout(&found).contains("z.rpl"),
            "{}",
            stderr(&found)
        );
        assert_eq!(status(&found), 2);
        fs::remove_file(folder.join(name)).expect("the file can go");
    }
    for command in ["check", "test", "fmt"] {
        let found = in_folder(&[command, "empty", "z.rpl"]);
        assert!(stderr(&found).contains("there is no plan in the folder `empty`"), "{}", stderr(&found));
        assert_eq!(status(&found), 2, "{command}");
    }
}

#[test]
fn fmt_shows_what_it_would_change() {
    let folder = folder("fmt-diff");
    let ugly = plan(&folder, "ugly.rpl", "(print 1)\n(print 2)\n(print 3)\n(print 4)\n( print 5)\n(print 6)");
    let good = plan(&folder, "good.rpl", "(print 1)\n");
    let found = output(&["fmt", "--diff", &ugly, &good]);
    let expected = format!(
        "--- {ugly}\n+++ {ugly}\n@@ -2,5 +2,5 @@\n (print 2)\n (print 3)\n (print 4)\n-( print 5)\n-(print 6)\n\\ No newline at end of file\n+(print 5)\n+(print 6)\n"
    );
    assert_eq!((stdout(&found), stderr(&found), status(&found)), (expected.as_str(), "", 1));
    assert!(text_in(&folder, "ugly.rpl").contains("( print 5)"));
    let found = output(&["fmt", "--diff", &good]);
    assert_eq!((stdout(&found), status(&found)), ("", 0));
    let found = with_input(&["fmt", "--diff", "-"], "( print 1)\n");
    assert!(stdout(&found).ends_with("-( print 1)\n+(print 1)\n"), "{}", stdout(&found));
    assert_eq!(status(&found), 1);
    assert_eq!(status(&output(&["fmt", "--diff", "--check", &good])), 2);
}

#[test]
fn test_reports_as_junit() {
    let folder = folder("junit");
    let tests = plan(
        &folder,
        "a&b.rpl",
        "(deftest good (wait-time 5))\n(deftest <bad&> (print \"x & \\u{1b}\") (fail \"1 < 2 & \\\"3\\\"\"))\n(deftest slow :until 10s (wait-time 60))\n",
    );
    let wrong = plan(&folder, "wrong.rpl", "(deftest a (undefined))");
    let report = folder.join("report.xml").display().to_string();
    let found = output(&["test", &tests, &wrong, "--junit", &report, "--seed", "4"]);
    assert_eq!(status(&found), 2, "{}", stderr(&found));
    assert!(stdout(&found).contains("3 tests, 2 failed"), "{}", stdout(&found));
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

#[test]
fn every_command_has_its_manual_page() {
    let folder = folder("man").join("man1");
    let found = output(&["man", &folder.display().to_string()]);
    assert_eq!(status(&found), 0, "{}", stderr(&found));
    let help = output(&["--help"]);
    let list = stdout(&help).split("Commands:\n").nth(1).and_then(|rest| rest.split("\n\n").next()).expect("a list");
    let begins = |line: &&str| line.starts_with("  ") && !line.starts_with("   ");
    let names: Vec<&str> = list.lines().filter(begins).filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.len() > 12, "{names:?}");
    for name in names.iter().filter(|name| **name != "help") {
        let page = text_in(&folder, &format!("rpl-{name}.1"));
        assert!(page.contains(&format!("rpl\\-{name}")) && page.contains(".SH OPTIONS"), "{page}");
    }
    let page = text_in(&folder, "rpl.1");
    assert!(page.contains(".TH rpl 1") && page.contains("Exit status"), "{page}");
    assert!(text_in(&folder, "rpl-trace-diff.1").contains(".SH SYNOPSIS"));
    let found = output(&["man", &plan(&folder, "file", "")]);
    assert!(stderr(&found).contains("cannot make the folder"), "{}", stderr(&found));
    assert_eq!(status(&found), 2);
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
    assert!(tables[0].contains("time [s]     6  90.00    0.00"), "{}", tables[0]);
}

/// The file of a folder, as text.
fn text_in(folder: &Path, name: &str) -> String {
    fs::read_to_string(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn an_experiment_writes_its_figures_as_json() {
    let folder = folder("experiment-json");
    let text = "(wait-time (random 10.0)) (when (< (now) 5) (fail \"too \\\"soon\\\"\"))";
    let plan = plan(&folder, "coin & \"toss\".rpl", text);
    let found = output(&["experiment", &plan, "--runs", "20", "--seed", "3", "--json"]);
    let figures: Value = serde_json::from_str(stdout(&found)).expect("one JSON object");
    assert_eq!(
        (&figures["experiment"], &figures["runs"], &figures["seed"]),
        (&plan.as_str().into(), &20.into(), &3.into())
    );
    let row = &figures["rows"][0];
    let failures = row["failures"].as_array().expect("a list");
    assert_eq!(row["succeeded"]["count"].as_u64().map(|count| count as usize), Some(20 - failures.len()));
    assert!(!failures.is_empty() && failures.len() < 20, "{row}");
    assert_eq!(
        (&row["seeds"], &failures[0]["fault"]),
        (&serde_json::json!([3, 22]), &"plan-failure: too \"soon\"".into())
    );
    let interval = row["succeeded"]["interval_95"].as_array().expect("two numbers");
    let rate = row["succeeded"]["rate"].as_f64().expect("a number");
    assert!(interval[0].as_f64() < Some(rate) && interval[1].as_f64() > Some(rate), "{row}");
    // The same figures as in the table.
    let time = &row["measures"][0];
    let table = output(&["experiment", &plan, "--runs", "20", "--seed", "3"]);
    let number = |key: &str| format!("{:.2}", time[key].as_f64().expect("a number"));
    for key in ["mean", "half_95", "deviation", "min", "median", "max"] {
        assert!(stdout(&table).contains(&number(key)), "{key}\n{}", stdout(&table));
    }
}

#[test]
fn an_experiment_on_a_plan_of_ones_own_draws_charts() {
    let folder = folder("experiment-charts");
    let plan = plan(&folder, "a & b.rpl", "(wait-time (random 10.0))");
    let results = folder.join("results");
    let found = output(&["experiment", &plan, "--runs", "3", "--results", &results.display().to_string()]);
    assert_eq!(status(&found), 0, "{}", stderr(&found));
    let chart = text_in(&results, "success.svg");
    assert!(chart.contains("<polyline") && chart.contains("a &amp; b"), "{chart}");
    assert_eq!(text_in(&results, "runs.csv").lines().count(), 4);
    // Without a robot there is no estimate that could be off.
    assert!(!results.join("error.svg").exists());
}

#[test]
fn a_row_that_is_not_there_is_told_with_those_that_are() {
    for (experiment, row, meant) in
        [("rotated", "undisturbd", "undisturbed"), ("barn", "seen so fer", "seen so far"), ("worlds", "rign", "ring")]
    {
        let found = output(&["experiment", experiment, "--row", row, "--runs", "1"]);
        assert!(stderr(&found).contains(&format!("did you mean `{meant}`?")), "{}", stderr(&found));
        assert_eq!(status(&found), 2);
    }
    let found = output(&["experiment", "first-steps", "--row", "rotated"]);
    assert!(stderr(&found).contains("a plan of your own has one row"), "{}", stderr(&found));
    assert_eq!(status(&found), 2);
}

#[test]
fn a_door_closed_on_the_way_holds_a_delivery_up_and_no_more() {
    let found = output(&["experiment", "doors", "--row", "flat", "--runs", "1", "--seed", "9001"]);
    assert_eq!(status(&found), 0, "{}{}", stdout(&found), stderr(&found));
    assert!(
        stdout(&found).lines().any(|line| line.starts_with("flat ") && line.contains(" 1/1 ")),
        "{}",
        stdout(&found)
    );
    let unknown = output(&["experiment", "doors", "--row", "flt"]);
    assert!(stderr(&unknown).contains("the experiment `doors` has no row `flt`; did you mean `flat`?"));
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

/// The line of a finding as it is drawn.
fn drawn_line(told: &str) -> &str {
    let place = told.split("╭─[ ").nth(1).expect("a place is drawn").split(" ]").next().expect("it ends");
    place.rsplit(':').nth(1).expect("it has a line")
}

#[test]
fn a_line_has_one_number_wherever_it_is_told() {
    let folder = folder("lines");
    // Only line feeds and carriage returns end lines; the failing form stands in the seventh.
    let text =
        "; a\u{b}b\u{c}c\u{85}d\u{2028}e\u{2029}f\r; g\r\n(defvar x 1)\u{c}\n\u{b}\r\r\n; h\n(/ x 0) ; the seventh\r";
    let plan = plan(&folder, "lines.rpl", text);
    let told = output(&["run", &plan]);
    let json = output(&["run", "--json", &plan]);
    let record: Value = serde_json::from_str(stdout(&json).lines().last().expect("a record")).expect("it is JSON");
    assert_eq!((drawn_line(stderr(&told)), record["failure"]["line"].as_u64()), ("7", Some(7)), "{}", stderr(&told));
    let fault = self::plan(&folder, "fault.rpl", &text.replace("(/ x 0)", "(/ y 0)"));
    assert_eq!(drawn_line(stderr(&output(&["run", &fault]))), "7");
    let trace = folder.join("lines.jsonl");
    let trace = trace.to_str().expect("a path");
    fs::remove_file(trace).ok();
    output(&["run", "--trace", trace, &plan]);
    assert!(fs::read_to_string(trace).expect("the trace is there").contains("lines.rpl:7:1"));
    let formatted = output(&["fmt", &plan]);
    assert_eq!(status(&formatted), 0, "{}", stderr(&formatted));
    let formatted = fs::read_to_string(&plan).expect("the plan is there");
    assert!(!formatted.contains('\r') && formatted.contains("; g\n(defvar x 1)\n"), "{formatted:?}");
}

#[test]
fn nothing_of_a_plan_reaches_the_terminal_as_a_command_but_what_it_prints() {
    let folder = folder("escapes");
    let text = "(defvar name (intern \"a\\u{1b}[31mb\\0c\\u{202e}d\"))
                (print \"\\u{1b}[1mplan\")
                (execute-plan `(process ,name (fail \"red \\u{1b}[31m and \\u{7} bell\")))";
    let plan = plan(&folder, "escapes.rpl", text);
    let trace = folder.join("escapes.jsonl");
    let trace = trace.to_str().expect("a path");
    fs::remove_file(trace).ok();
    let found = output(&["run", "--trace", trace, &plan]);
    assert!(stdout(&found).starts_with("\u{1b}[1mplan\n"), "what a plan prints is its own");
    let shown = output(&["trace", trace]);
    for (what, told) in [("stderr", stderr(&found)), ("trace", stdout(&shown))] {
        let raw = told.chars().find(|&c| (c.is_control() && c != '\n') || c == '\u{202e}');
        assert_eq!(raw, None, "{what}\n{told:?}");
        assert!(told.contains("a\\u{1b}[31mb\\0c\\u{202e}d"), "{what}\n{told}");
    }
    assert!(stderr(&found).contains("red \\u{1b}[31m and \\u{7} bell"), "{}", stderr(&found));
}

#[test]
fn a_first_value_that_fails_is_shown_as_given_by_set() {
    let folder = folder("set-fails");
    let plan = plan(&folder, "speed.rpl", "(defvar speed 1 \"how fast\")\n(print speed)");
    let found = output(&["run", &plan, "--set", "speed=(/ 1 0)"]);
    assert!(stderr(&found).contains("(defvar speed (/ 1 0) #| by --set |# \"how fast\")"), "{}", stderr(&found));
    let twice = output(&["run", &plan, "--set", "speed=1", "--set", "speed=2"]);
    assert_eq!(status(&twice), 2);
    assert!(
        stderr(&twice).contains("`speed` is given twice: `--set speed=1` and `--set speed=2`"),
        "{}",
        stderr(&twice)
    );
}

#[test]
fn a_test_that_fails_for_itself_is_not_told_to_look_for_a_robot() {
    let folder = folder("no-robot");
    let text = "(def-plan patrol () (go-to 'kitchen))
                (deftest of-itself (assert (= 1 2)))
                (deftest of-the-robot (patrol))";
    let plan = plan(&folder, "robot.rpl", text);
    let found = output(&["test", &plan]);
    let told = stdout(&found);
    let (itself, robot) = told.split_once("of-the-robot").expect("both tests are told");
    assert!(!itself.contains(":world") && itself.contains("this should be true"), "{told}");
    assert!(robot.contains(":world \"dept\""), "{told}");
}

#[test]
fn places_are_looked_up_in_the_world_that_is_named() {
    let folder = folder("check-world");
    let text = "(go-to 'a-118)\n(deliver 'mail 'mailroom 'nowhere)\n(print (distance-to 'start))\n(print 'nowhere)";
    let plan = plan(&folder, "places.rpl", text);
    let unknown = output(&["check", &plan]);
    assert_eq!((stderr(&unknown), status(&unknown)), ("", 0), "without a world no place is wrong");
    let found = output(&["check", "--world", "dept", &plan]);
    let names: Vec<&str> = stderr(&found)
        .lines()
        .filter_map(|line| line.strip_prefix("warning[unknown-place]: there is no place `"))
        .filter_map(|line| line.split('`').next())
        .collect();
    let world = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../robot/worlds/dept.toml"));
    let world = world.expect("the world is there");
    let missing = |name: &&str| !world.contains(&format!("name = \"{name}\""));
    let expected: Vec<&str> = ["a-118", "mailroom", "nowhere", "start"].into_iter().filter(missing).collect();
    assert_eq!(names, expected, "{}", stderr(&found));
    assert_eq!(status(&output(&["check", "--world", "nosuch", &plan])), 2);
}
