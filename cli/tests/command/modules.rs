//! Modules in other processes: `--module`, the package for Python, and the example with a lamp.

use crate::folder::{folder, put};
use crate::rpl::{Ended, feed, rpl};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The root of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Runs `rpl` in a folder, where Python finds the package.
pub fn run_in(folder: &Path, arguments: &[&str]) -> Ended {
    let python = root().join("python").canonicalize().expect("it is there");
    rpl(arguments)
        .current_dir(folder)
        .env("PYTHONPATH", python)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .expect("it starts")
        .into()
}

/// A folder with the files of the lamp, a plan, and other text in the lamp's program.
pub fn folder_of_lamp(name: &str, plan: &str, exchanged: (&str, &str)) -> PathBuf {
    let folder = folder(name);
    for file in ["lamp.toml", "lamp.rpl", "lamp.py", "mail-with-lamp.rpl"] {
        let text = std::fs::read_to_string(root().join("examples/modules").join(file)).expect("it is there");
        put(&folder, file, text.replace(exchanged.0, exchanged.1));
    }
    put(&folder, "plan.rpl", plan);
    folder
}

const IN_A_ROOM: [&str; 6] = ["run", "plan.rpl", "--world", "test-room", "--module", "lamp.toml"];

#[test]
fn the_package_for_python_passes_its_tests() {
    let folder = root().join("python");
    let mut tests = Command::new("python3");
    tests.args(["-m", "unittest", "discover", "-s", "tests"]).current_dir(&folder);
    let ended = tests.env("PYTHONDONTWRITEBYTECODE", "1").output().expect("python3 is needed for this test");
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
}

#[test]
fn a_plan_starts_its_behaviours_and_reads_its_fluents() {
    let plan = "
(pursue
  (whenever lamp-on?* (print 'on))
  (blink-lamp 2))
(print (< 0 (value light*) 1))
(with-failure-handling ((lamp-failure (f) (print (failure-slot f 'times))))
  (blink-lamp 0))";
    let folder = folder_of_lamp("module-lamp", plan, ("", ""));
    let Ended { out, errors, status } = run_in(&folder, &IN_A_ROOM);
    assert_eq!((out.as_str(), status), ("on\non\nt\n0\n", 0), "{errors}");
    let trace = [&IN_A_ROOM[..], &["--trace", "a.jsonl"]].concat();
    run_in(&folder, &trace);
    let first = std::fs::read(folder.join("a.jsonl")).expect("it is there");
    run_in(&folder, &trace);
    assert_eq!(std::fs::read(folder.join("a.jsonl")).expect("it is there"), first, "lock step is deterministic");
}

#[test]
fn a_delivery_goes_on_without_a_lamp_that_crashes() {
    let crash = ("self.steps_left = 4 * times", "print('no current'); import os; os._exit(7)");
    let folder = folder_of_lamp("module-crash", "", crash);
    let Ended { out, errors, status } =
        run_in(&folder, &["run", "mail-with-lamp.rpl", "--world", "dept", "--module", "lamp.toml", "-q"]);
    let told =
        "no lamp: the module `lamp` ended with exit status 7; the last it wrote to standard error:\n  no current\n";
    assert_eq!((out.matches(told).count(), status), (2, 0), "{out}{errors}");
    assert!(out.contains("mail delivered"), "{out}{errors}");
}

#[test]
fn plans_with_a_module_are_projected_by_what_its_manifest_says() {
    let plan = "
(let ((blinking (project '(with-valve lamp (run-behaviour blink :times 1)) :runs 400 :horizon 1min)))
  (destructuring-bind (low median high) (projection-time blinking) (print (< 0.2 low median high 2.0)))
  (let ((failure (first (projection-failures blinking))))
    (print (second failure))
    (print (< 0.05 (first failure) 0.15))))";
    let folder = folder_of_lamp("module-foreseen", plan, ("lamp-failure = 0.02", "lamp-failure = 0.1"));
    let Ended { out, errors, status } = run_in(&folder, &IN_A_ROOM);
    assert_eq!((out.as_str(), status), ("t\nlamp-failure\nt\n", 0), "{errors}");
    for (line, replaced, told) in [
        (
            "takes = [\"200ms\", \"600ms\", \"2s\"]\nfails = { lamp-failure = 0.1 }\n",
            "",
            "no model of what the behaviour `blink` does",
        ),
        ("takes = [\"200ms\", \"600ms\", \"2s\"]\n", "", "these need to know how long it takes"),
        ("\"600ms\"", "\"3s\"", "`takes` must be three times up to 10 minutes: at least, most likely, at most"),
        ("= 0.1 }", "= 1.1 }", "the probabilities of `fails` are more than 1 together"),
        ("lamp-failure = 0.1", "7 = 0.1", "\"7\" is no class of failures"),
    ] {
        let text = crate::folder::text_in(&folder, "lamp.toml");
        assert!(text.contains(line), "{line}");
        put(&folder, "other.toml", text.replace(line, replaced));
        let Ended { errors, status, .. } =
            run_in(&folder, &["run", "plan.rpl", "--world", "test-room", "--module", "other.toml"]);
        assert!(errors.contains(told) && status > 0, "{told}\n{errors}");
    }
}

#[test]
fn a_mistake_in_python_fails_the_behaviour_and_is_shown() {
    let mistake = ("self.steps_left -= 1", "self.steps_lft -= 1");
    let folder = folder_of_lamp("module-mistake", "(blink-lamp 1)", mistake);
    let Ended { errors, status, .. } = run_in(&folder, &IN_A_ROOM);
    assert!(errors.contains("module-failure") && errors.contains("AttributeError") && status == 1, "{errors}");
    let traceback = errors.lines().any(|line| line.starts_with("lamp:   File ") && line.contains("lamp.py"));
    assert!(traceback, "the traceback is passed on: {errors}");
}

#[test]
fn a_module_that_does_not_greet_is_refused_before_the_run() {
    let folder = folder_of_lamp("module-refused", "(print 'runs)", ("import math", "import moths"));
    let Ended { out, errors, status } = run_in(&folder, &IN_A_ROOM);
    assert_eq!((out.as_str(), status), ("", 2), "{errors}");
    assert!(errors.contains("the module `lamp` (lamp.toml) ended with exit status 1"), "{errors}");
    assert!(errors.contains("No module named 'moths'"), "{errors}");
    for (command, told) in [
        ("[\"no-such-program\"]", "cannot be started: there is no program `no-such-program`"),
        ("[\"./lamp\"]", "cannot be started: there is no file `./lamp` in the folder of its manifest"),
        ("[\"./lamp.py\"]", "cannot be started: `./lamp.py` may not be executed"),
    ] {
        let text = crate::folder::text_in(&folder, "lamp.toml").replace("[\"python3\", \"lamp.py\"]", command);
        put(&folder, "other.toml", text);
        let Ended { errors, status, .. } =
            run_in(&folder, &["eval", "1", "--world", "test-room", "--module", "other.toml"]);
        assert!(errors.contains(told) && status == 2, "{errors}");
    }
}

#[test]
fn all_faults_of_a_manifest_are_told_with_what_would_be_right() {
    let folder = folder("module-manifest");
    let manifest = "\
nme = \"lamp\"
doc = \"A lamp.\"
command = []
answer_within = \"soon\"
pace = \"lockstep\"
wants = [\"percepts\"]
valves = [\"lamp\", \"two words\"]

[[behaviour]]
name = \"lamp\"
doc = \"Blinks.\"
parameters = [\"times\"]

[[fluent]]
name = \"light*\"
doc = \"How bright it is.\"
type = \"float\"
";
    put(&folder, "lamp.toml", manifest);
    let Ended { errors, status, .. } = run_in(&folder, &["eval", "1", "--world", "test-room", "--module", "lamp.toml"]);
    assert_eq!(status, 2);
    for told in [
        "lamp.toml:1:1: unknown key `nme`, did you mean `name`?",
        "the manifest has no `name`",
        "lamp.toml:3:11: `command` names no program",
        "lamp.toml:4:17: `answer_within` must be a time above 0 and up to 10 minutes in quotes, found \"soon\"",
        "lamp.toml:5:8: \"lockstep\" is no `pace`, did you mean \"lock-step\"?",
        "lamp.toml:6:9: a module cannot want \"percepts\"",
        "lamp.toml:7:10: \"two words\" is no name that plans can write",
        "lamp.toml:10:8: `lamp` is there already, in line 7",
        "lamp.toml:12:14: \"times\" is no parameter",
        "lamp.toml:17:8: `type` must be \"truth\" or \"integer\" or",
    ] {
        assert!(errors.contains(told), "{told}\n{errors}");
    }
}

#[test]
fn names_that_have_a_meaning_are_refused_with_their_place() {
    let faults = [
        (
            "\"light*\"",
            "\"x*\"",
            "`x*` of the module `lamp` (lamp.toml:23:8) has a meaning already: the module `position-tracking` has one of that name",
        ),
        (
            "\"light*\"",
            "\"print\"",
            "`print` of the module `lamp` (lamp.toml:23:8) has a meaning in the language or its library",
        ),
        ("valve = \"lamp\"", "valve = \"lmp\"", "needs the valve `lmp`, and no module has it (lamp.toml:10:8)"),
    ];
    for (at, (from, to, told)) in faults.into_iter().enumerate() {
        let folder = folder_of_lamp(&format!("module-names-{at}"), "", (from, to));
        let Ended { errors, status, .. } = run_in(&folder, &IN_A_ROOM);
        assert!(errors.contains(told) && status == 2, "{errors}");
    }
    let folder = folder_of_lamp("module-names-twice", "", ("", ""));
    put(
        &folder,
        "other.toml",
        crate::folder::text_in(&folder, "lamp.toml").replace("name = \"lamp\"", "name = \"light\""),
    );
    let Ended { errors, status, .. } = run_in(&folder, &[&IN_A_ROOM[..], &["--module", "other.toml"]].concat());
    assert!(
        errors.contains(
            "of the module `light` (other.toml:10:8) has a meaning already: the module `lamp` (lamp.toml:10:8)"
        ),
        "{errors}"
    );
    assert_eq!(status, 2);
    let Ended { errors, .. } = run_in(&folder, &[&IN_A_ROOM[..], &["--module", "lamp.toml"]].concat());
    assert!(errors.contains("two modules are called `lamp`: `lamp.toml` and `lamp.toml`"), "{errors}");
}

#[test]
fn plans_for_a_module_are_checked_and_tested_with_it() {
    let tests = "(deftest blinks (blink-lamp 1) (assert (not (value lamp-on?*))))";
    let folder = folder_of_lamp("module-tests", tests, ("", ""));
    let module = ["--module", "lamp.toml"];
    let Ended { out, errors, status } = run_in(&folder, &[&["check", "plan.rpl"][..], &module].concat());
    assert_eq!(status, 0, "{out}{errors}");
    let Ended { errors, status, .. } = run_in(&folder, &["check", "plan.rpl"]);
    assert!(errors.contains("blink-lamp") && status == 2, "{errors}");
    let Ended { out, status, .. } =
        run_in(&folder, &[&["test", "plan.rpl", "--world", "test-room"][..], &module].concat());
    assert!(out.contains("1 test, all ok") && status == 0, "{out}");
}

#[test]
fn a_session_that_goes_back_hears_the_same_again_and_nothing_new() {
    let folder = folder_of_lamp("module-session", "", ("", ""));
    let after_going_back = |form: &str| {
        let python = root().join("python").canonicalize().expect("it is there");
        let mut session = rpl(&["repl", "--world", "test-room", "--module", "lamp.toml"]);
        session.current_dir(&folder).env("PYTHONPATH", python).env("PYTHONDONTWRITEBYTECODE", "1");
        let typed = format!("(wait-time 1)\n(blink-lamp 1)\n:at 0.5s\n:continue\n{form}\n");
        let Ended { out, errors, .. } = feed(&mut session, typed);
        out + &errors
    };
    let same = after_going_back("(blink-lamp 1)");
    assert!(same.matches("1.2 s  blink is done").count() == 2 && !same.contains("module-failure"), "{same}");
    let other = after_going_back("(blink-lamp 2)");
    assert!(
        other.contains("module-failure: the module `lamp` cannot be asked: ") && other.contains("\"times\":1"),
        "{other}"
    );
}

#[test]
fn a_recorded_run_is_repeated_without_its_module() {
    let folder = folder_of_lamp("module-record", "(blink-lamp 2) (blink-lamp 1) (wait-time 1)", ("", ""));
    let live = [&IN_A_ROOM[..], &["--record", "r.jsonl", "--trace", "live.jsonl"]].concat();
    let Ended { errors, status, .. } = run_in(&folder, &live);
    assert_eq!(status, 0, "{errors}");
    std::fs::remove_file(folder.join("lamp.py")).expect("it was there");
    let Ended { errors, status, .. } = run_in(&folder, &["replay", "r.jsonl", "--trace", "again.jsonl"]);
    assert_eq!(status, 0, "{errors}");
    let trace = |name: &str| std::fs::read(folder.join(name)).expect("it was written");
    assert!(trace("live.jsonl") == trace("again.jsonl"), "the traces differ");
    put(&folder, "plan.rpl", "(blink-lamp 2) (blink-lamp 5)");
    let Ended { errors, status, .. } = run_in(&folder, &["replay", "r.jsonl"]);
    assert!(errors.contains("the run acts differently from ") && errors.contains("\"times\":5"), "{errors}");
    assert_eq!(status, 1);
    put(&folder, "lamp.toml", crate::folder::text_in(&folder, "lamp.toml").replace("to 1.", "to one."));
    let Ended { errors, .. } = run_in(&folder, &["replay", "r.jsonl"]);
    assert!(errors.contains("`lamp.toml` is not what it was when the run was recorded"), "{errors}");
}
