//! Ctrl-C and SIGTERM, whatever the command is doing when they come.
#![cfg(unix)]

use crate::folder::{folder, put};
use crate::pipes::wait_for_line;
use crate::rpl::{Ended, start};
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command};

/// More steps than any machine takes in the time of a test.
const ENDLESS: &[&str] = &["--max-steps", "4294967295"];

fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    assert!(Command::new("kill").args([name, &id]).status().expect("kill runs").success());
}

/// The signal at the first line of its output, and what it had written from then on at its end.
fn signalled_at_first_line(mut child: Child, name: &str) -> (String, Ended) {
    let mut lines = BufReader::new(child.stdout.take().expect("the output is piped"));
    let mut first = String::new();
    lines.read_line(&mut first).expect("there is a line");
    signal(&child, name);
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut lines, &mut rest).expect("the rest is text");
    (rest, Ended::of(child))
}

/// r[cleanup.stop]
#[test]
fn one_signal_stops_a_run_in_the_middle_of_an_instant() {
    let folder = folder("signal-instant");
    let sorting = "(let ((l (range 0 300000))) (loop (sort #'> l)))";
    let choosing = "(loop (sort (lambda (a b) (> a b)) (range 0 1000)))";
    for busy in ["(loop)", "(loop (par (dotimes (i 1000000) i)))", sorting, choosing] {
        let plan = put(&folder, "plan.rpl", format!("(unwind-protect (seq (print 'going) {busy}) (print 'clean))"));
        for name in ["-INT", "-TERM"] {
            let (rest, found) = signalled_at_first_line(start(&[&["run", &plan, "--json"], ENDLESS].concat()), name);
            assert_eq!(found.status, 130, "{busy}: {}", found.errors);
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
        let plan = put(&folder, "plan.rpl", format!("(unwind-protect (seq (print 'going) (loop)) {clean_up})"));
        let (_, found) = signalled_at_first_line(start(&[&["run", &plan], ENDLESS].concat()), "-INT");
        assert_eq!(found.status, 130, "{clean_up}: {}", found.errors);
        assert!(found.errors.contains("given up"), "{clean_up}: {}", found.errors);
    }
}

#[test]
fn one_signal_ends_a_run_whose_output_nobody_takes() {
    let folder = folder("signal-output");
    let plan = put(&folder, "plan.rpl", "(loop (print 'going))");
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
    let name = pipe.to_string_lossy().into_owned();
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
        let found = Ended::of(child);
        assert_eq!(found.status, 130, "{arguments:?}: {}", found.errors);
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
        let found = Ended::of(child);
        assert_eq!(found.status, 130, "{arguments:?}: {}", found.errors);
        drop(input);
    }
}

#[test]
fn a_signal_ends_the_tests_with_their_summary() {
    let folder = folder("signal-test");
    let tests =
        put(&folder, "plan.rpl", "(deftest quick 1) (deftest endless (loop (wait-time 0.0001))) (deftest last 1)");
    let (rest, found) = signalled_at_first_line(start(&["test", &tests, "--until", "100000h"]), "-INT");
    assert_eq!(found.status, 130, "{}", found.errors);
    assert!(rest.starts_with("1 test, then interrupted, in "), "{rest}");
}

#[test]
fn a_signal_gives_up_what_a_script_runs_at_the_prompt() {
    let mut child = start(&["repl"]);
    let script =
        b"(unwind-protect (progn (print 'going) (loop (par (dotimes (i 100000) i)))) (print 'clean))\n(print 'after)\n";
    child.stdin.take().expect("the input is piped").write_all(script).expect("it reads");
    let (rest, found) = signalled_at_first_line(child, "-INT");
    assert_eq!(found.status, 130, "{}", found.errors);
    assert!(rest.ends_with("clean\n") && !rest.contains("after"), "{rest}");
}

/// r[cleanup.stop]
#[test]
fn an_interrupt_runs_the_clean_ups_and_says_130() {
    let folder = folder("interrupt");
    let text = "(unwind-protect (loop (print 'going) (wait-time 1)) (seq (wait-time 1) (print 'clean)))";
    let plan = put(&folder, "endless.rpl", text);
    for name in ["-INT", "-TERM"] {
        let mut child = start(&["run", &plan, "--realtime", "20"]);
        // By the first line the signals are caught.
        wait_for_line(&mut child);
        signal(&child, name);
        let found = Ended::of(child);
        assert_eq!(found.status, 130, "{}", found.errors);
        assert!(found.out.ends_with("clean\n"), "{}", found.out);
    }
}

/// r[cleanup.stop]
#[test]
fn a_second_interrupt_ends_the_program_at_once() {
    let folder = folder("interrupt-twice");
    let text = "(unwind-protect (seq (print 'going) (wait-time 1000)) (seq (print 'cleaning) (wait-time 1000) (print 'clean)))";
    let plan = put(&folder, "patient.rpl", text);
    let mut child = start(&["run", &plan, "--realtime", "1"]);
    for _ in ["going", "cleaning"] {
        wait_for_line(&mut child);
        signal(&child, "-INT");
    }
    let found = Ended::of(child);
    assert_eq!((found.out.as_str(), found.status), ("", 130), "{}", found.errors);
}
