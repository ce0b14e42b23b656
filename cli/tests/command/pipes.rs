//! Output that nobody reads, or that cannot be written.

use crate::folder::{folder, put};
use crate::rpl::{Ended, rpl, start};
use serde_json::Value;
use std::fs;
use std::io::Read;
use std::process::Child;

/// Reads the output of a command up to the end of a line.
pub fn wait_for_line(child: &mut Child) {
    let mut byte = [0];
    let out = child.stdout.as_mut().expect("the output is piped");
    while out.read(&mut byte).expect("the output can be read") == 1 && byte[0] != b'\n' {}
}

#[test]
fn a_closed_pipe_ends_quietly_and_runs_clean_ups() {
    let folder = folder("pipe");
    let trace = folder.join("pipe.jsonl").to_string_lossy().into_owned();
    let plan = put(&folder, "pipe.rpl", "(unwind-protect (loop (print 1) (wait-time 1)) (print 2))");
    let mut child = start(&["run", &plan, "--trace", &trace]);
    wait_for_line(&mut child);
    drop(child.stdout.take());
    let found = Ended::of(child);
    assert_eq!((found.errors.as_str(), found.status), ("", 0));
    let trace = fs::read_to_string(trace).expect("the trace is there");
    let last: Value = serde_json::from_str(trace.lines().last().unwrap_or_default()).expect("a whole object");
    assert_eq!((&last["task"], &last["kind"], &last["state"]), (&"main".into(), &"end".into(), &"evaporated".into()));
}

#[test]
fn an_endless_loop_that_prints_is_seen_and_ends_with_its_reader() {
    let folder = folder("printing");
    for text in ["(loop (print 1))", "(wait-time 1) (loop (print 1))"] {
        let plan = put(&folder, "endless.rpl", text);
        let mut child = start(&["run", &plan]);
        wait_for_line(&mut child);
        drop(child.stdout.take());
        let found = Ended::of(child);
        assert_eq!((found.errors.as_str(), found.status), ("", 0));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_written_is_told() {
    let folder = folder("full");
    let plan = put(&folder, "plan.rpl", "(print 1)");
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
        let found = Ended::from(rpl(line).stdout(full()).output().expect("it starts"));
        assert_eq!(found.status, 2, "{line:?}");
        let told = "error: cannot write to standard output: No space left";
        assert!(found.errors.starts_with(told), "{line:?}: {}", found.errors);
    }
}

#[test]
fn whoever_closes_the_pipe_has_read_enough() {
    for line in [&["--help"][..], &["doc"], &["worlds"], &["examples", "delivery"], &["completions", "bash"]] {
        let mut child = start(line);
        drop(child.stdout.take());
        let found = Ended::of(child);
        assert_eq!((found.errors.as_str(), found.status), ("", 0), "{line:?}");
    }
}
