//! Ctrl-C and SIGTERM, whatever the command is doing when they come.
#![cfg(unix)]

use serde_json::Value;
use std::fs::{self, File};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// More steps than any machine takes in the time of a test.
const ENDLESS: &[&str] = &["--max-steps", "4294967295"];

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // The one before may not be there.
    fs::remove_dir_all(&folder).ok();
    fs::create_dir_all(&folder).expect("the folder can be made");
    folder
}

fn plan(folder: &Path, text: &str) -> String {
    let path = folder.join("plan.rpl");
    fs::write(&path, text).expect("the plan can be written");
    path.display().to_string()
}

fn start(arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rpl"));
    let command = command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("it starts")
}

fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    assert!(Command::new("kill").args([name, &id]).status().expect("kill runs").success());
}

/// The signal at the first line of its output, and what it had written from then on at its end.
fn signalled_at_first_line(mut child: Child, name: &str) -> (String, Output) {
    let mut lines = BufReader::new(child.stdout.take().expect("the output is piped"));
    let mut first = String::new();
    lines.read_line(&mut first).expect("there is a line");
    signal(&child, name);
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut lines, &mut rest).expect("the rest is text");
    (rest, child.wait_with_output().expect("it ends"))
}

fn stderr(found: &Output) -> String {
    String::from_utf8_lossy(&found.stderr).into_owned()
}

/// r[cleanup.stop]
#[test]
fn one_signal_stops_a_run_in_the_middle_of_an_instant() {
    let folder = folder("signal-instant");
    let sorting = "(let ((l (range 0 300000))) (loop (sort #'> l)))";
    let choosing = "(loop (sort (lambda (a b) (> a b)) (range 0 1000)))";
    for busy in ["(loop)", "(loop (par (dotimes (i 1000000) i)))", sorting, choosing] {
        let plan = plan(&folder, &format!("(unwind-protect (seq (print 'going) {busy}) (print 'clean))"));
        for name in ["-INT", "-TERM"] {
            let (rest, found) = signalled_at_first_line(start(&[&["run", &plan, "--json"], ENDLESS].concat()), name);
            assert_eq!(found.status.code(), Some(130), "{busy}: {}", stderr(&found));
            let (clean, summary) = rest.split_once('\n').expect("two lines");
            assert_eq!(clean, "clean", "{busy}");
            let summary: Value = serde_json::from_str(summary).expect("one JSON object");
            assert_eq!(summary["outcome"], "interrupted");
        }
    }
}

/// r[cleanup.stop]
#[test]
fn one_signal_ends_a_clean_up_that_computes_without_end() {
    let folder = folder("signal-clean-up");
    for clean_up in ["(loop)", "(loop (wait-time 0))", "(unwind-protect (loop) (loop))", "(loop (par (loop)))"] {
        let plan = plan(&folder, &format!("(unwind-protect (seq (print 'going) (loop)) {clean_up})"));
        let (_, found) = signalled_at_first_line(start(&[&["run", &plan], ENDLESS].concat()), "-INT");
        assert_eq!(found.status.code(), Some(130), "{clean_up}: {}", stderr(&found));
        assert!(stderr(&found).contains("given up"), "{clean_up}: {}", stderr(&found));
    }
}

#[test]
fn one_signal_ends_a_run_whose_output_nobody_takes() {
    let folder = folder("signal-output");
    let plan = plan(&folder, "(loop (print 'going))");
    let mut child = start(&["run", &plan]);
    let mut lines = BufReader::new(child.stdout.take().expect("the output is piped"));
    lines.read_line(&mut String::new()).expect("there is a line");
    signal(&child, "-INT");
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    drop(lines);
}

/// Named pipes that say nothing stand for whatever takes long before a plan runs.
#[test]
fn one_signal_ends_what_has_nothing_to_clean_up() {
    let folder = folder("signal-before");
    let pipe = folder.join("silent.toml");
    assert!(Command::new("mkfifo").arg(&pipe).status().expect("mkfifo runs").success());
    let name = pipe.display().to_string();
    for arguments in [
        &["run", &name][..],
        &["check", &name],
        &["fmt", &name],
        &["test", &name],
        &["experiment", &name],
        &["trace", &name],
        &["run", "first-steps", "--world", &name],
        &["localize", "--map", &name, "--log", &name],
        &["repl", &name],
    ] {
        let child = start(arguments);
        // It can be opened when somebody reads there.
        let silent = File::options().write(true).open(&pipe).expect("the pipe is there");
        signal(&child, "-INT");
        let found = child.wait_with_output().expect("it ends");
        assert_eq!(found.status.code(), Some(130), "{arguments:?}: {}", stderr(&found));
        drop(silent);
    }
}

#[test]
fn one_signal_ends_the_reading_of_standard_input() {
    for arguments in [&["eval", "-"][..], &["fmt", "-"], &["repl"]] {
        let mut child = start(arguments);
        // More than a pipe holds: when it is written, somebody reads.
        let mut input = child.stdin.take().expect("the input is piped");
        input.write_all(&[b' '; 1 << 18]).expect("it reads");
        signal(&child, "-TERM");
        let found = child.wait_with_output().expect("it ends");
        assert_eq!(found.status.code(), Some(130), "{arguments:?}: {}", stderr(&found));
        drop(input);
    }
}

#[test]
fn a_signal_ends_the_tests_with_their_summary() {
    let folder = folder("signal-test");
    let tests = plan(&folder, "(deftest quick 1) (deftest endless (loop (wait-time 0.0001))) (deftest last 1)");
    let (rest, found) = signalled_at_first_line(start(&["test", &tests, "--until", "100000h"]), "-INT");
    assert_eq!(found.status.code(), Some(130), "{}", stderr(&found));
    assert!(rest.starts_with("1 test, then interrupted, in "), "{rest}");
}

#[test]
fn a_signal_gives_up_what_a_script_runs_at_the_prompt() {
    let mut child = start(&["repl"]);
    let script =
        b"(unwind-protect (progn (print 'going) (loop (par (dotimes (i 100000) i)))) (print 'clean))\n(print 'after)\n";
    child.stdin.take().expect("the input is piped").write_all(script).expect("it reads");
    let (rest, found) = signalled_at_first_line(child, "-INT");
    assert_eq!(found.status.code(), Some(130), "{}", stderr(&found));
    assert!(rest.ends_with("clean\n") && !rest.contains("after"), "{rest}");
}
