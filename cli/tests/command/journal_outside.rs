//! Journals of runs whose robot is moved by a host, or whose modules run, in other processes.

use crate::folder::{folder, put, text_in};
use crate::hosts::Served;
use crate::rpl::{Ended, rpl, run_in};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};

/// Goes somewhere, and says the time meanwhile.
const GO: &str = "(def-resume look (print (list 'resumed (assoc 'mail notes))))\n\
    (defvar notes '((mail 7)))\n\
    (pursue (loop (print (list 'at (now))) (wait-time 0.5)) (go-to 'corner))\n\
    (print (list 'there (at-destination? 'corner)))\n";

/// Starts it, and ends it by force after `lines` lines; those lines.
fn killed_after(lines: usize, folder: &Path, arguments: &[&str]) -> Vec<String> {
    let mut child = started(folder, arguments);
    let mut out = BufReader::new(child.stdout.take().expect("the output is piped")).lines();
    let read = out.by_ref().take(lines).collect::<Result<Vec<String>, _>>().expect("it is text");
    child.kill().expect("it can be killed");
    child.wait().expect("it is dead");
    assert_eq!(read.len(), lines, "it ended before");
    read
}

fn started(folder: &Path, arguments: &[&str]) -> Child {
    let mut command = with_python(arguments);
    command.current_dir(folder).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("it starts")
}

/// `rpl`, that finds the package for modules in Python.
fn with_python(arguments: &[&str]) -> std::process::Command {
    let python = root().join("python").canonicalize().expect("it is there");
    let mut command = rpl(arguments);
    command.env("PYTHONPATH", python).env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn resume(folder: &Path, more: &[&str]) -> Ended {
    let arguments = [&["resume", "j"][..], more].concat();
    with_python(&arguments).current_dir(folder).output().expect("it starts").into()
}

/// How often a text stands in another one.
fn count(text: &str, word: &str) -> usize {
    text.matches(word).count()
}

#[test]
fn a_mission_on_a_host_goes_on_after_each_kill_from_where_the_robot_stands() {
    let folder = folder("journal-host");
    put(&folder, "plan.rpl", GO);
    let host = Served::start(&["--speed", "8"]);
    let begun = [
        ["run", "plan.rpl", "--world", "test-room", "--grid", "coarse", "--host", &host.address],
        ["--journal", "j", "--trace", "j.jsonl", "--sync", "never", "--seed", "3"],
    ]
    .concat();
    let first = killed_after(4, &folder, &begun);
    assert_eq!(first[3], "(at 1.5)");
    let told = run_in(&folder, &["journal", "j"]).out;
    assert!(told.contains(&format!("--host {}", host.address)) && told.contains("it was killed"), "{told}");

    let second = killed_after(3, &folder, &["resume", "j"]);
    // The line of the very instant of the kill may come again.
    assert!(second[..2].contains(&"(resumed (mail 7))".to_string()), "{second:?}");
    let mut third = started(&folder, &["resume", "j"]);
    // The robot has made a step by then.
    let mut lines = BufReader::new(third.stdout.as_mut().expect("the output is piped")).lines().map_while(Result::ok);
    assert!(lines.any(|line| line.starts_with("(resumed")) && lines.next().is_some());
    drop(lines);
    let refused = resume(&folder, &[]);
    assert!(refused.status == 2 && refused.errors.contains(&format!("process {} has it", third.id())));
    third.kill().expect("it can be killed");
    third.wait().expect("it is dead");

    // The host is gone; another one moves the robot now.
    host.end();
    let refused = resume(&folder, &[]);
    assert!(refused.status == 2 && refused.errors.contains("cannot be reached"), "{}", refused.errors);
    let other = Served::start(&["--speed", "8", "--once"]);
    let ended = resume(&folder, &["--host", &other.address]);
    assert_eq!(ended.status, 0, "{}{}", ended.out, ended.errors);
    assert!(ended.out.ends_with("(there t)\n"), "{}", ended.out);
    other.summary();

    let (printed, log, trace) =
        (text_in(&folder, "j/output.txt"), text_in(&folder, "j/log.txt"), text_in(&folder, "j.jsonl"));
    assert_eq!(count(&printed, "(resumed (mail 7))\n"), 3, "{printed}");
    let times: Vec<f64> =
        printed.lines().filter_map(|line| line.strip_prefix("(at ")?.strip_suffix(')')?.parse().ok()).collect();
    assert!(times.len() > 8 && times.windows(2).all(|pair| pair[1] == pair[0] + 0.5), "{printed}");
    assert_eq!(count(&log, "position doubted"), 3, "{log}");
    assert_eq!(count(&log, "s  resumed"), 3, "{log}");
    assert!(count(&log, " is interrupted") >= 3, "{log}");
    assert_eq!(trace.lines().filter(|line| line.contains("\"what\":\"resumed\"")).count(), 3);
    let over = resume(&folder, &[]);
    assert!(over.status == 0 && over.errors.contains("the run is over: it succeeded"), "{}", over.errors);
}

#[test]
fn what_was_heard_can_be_looked_at_afterwards() {
    let folder = folder("journal-host-prompt");
    put(&folder, "plan.rpl", GO);
    let host = Served::start(&["--speed", "8"]);
    let site = ["--world", "test-room", "--grid", "coarse", "--host", &host.address, "--journal", "j"];
    let stood = run_in(&folder, &[&["run", "plan.rpl", "--until", "2s"][..], &site].concat());
    assert_eq!(stood.status, 3, "{}", stood.errors);
    let seen = run_in(&folder, &["view", "j", "--report", "stood.html"]);
    assert_eq!(seen.status, 3, "{}", seen.errors);
    assert!(text_in(&folder, "stood.html").contains("<title>plan.rpl"), "{}", seen.errors);
    let resumed = killed_after(4, &folder, &["resume", "j"]);
    assert_eq!(resumed[0], "(resumed (mail 7))");
    host.end();
    let refused = run_in(&folder, &["view", "j", "--report", "resumed.html"]);
    assert!(refused.status == 2 && refused.errors.contains("rpl repl j"), "{}", refused.errors);
    let printed = text_in(&folder, "j/output.txt");
    let found = crate::rpl::feed(rpl(&["repl", "j"]).current_dir(&folder), "(value x*)\n");
    assert_eq!(found.status, 0, "{}{}", found.out, found.errors);
    let shown: String = found.out.lines().take(printed.lines().count()).map(|line| format!("{line}\n")).collect();
    assert_eq!(shown, printed, "{}", found.errors);
    // Resumed after its last instant, it stands where it stood.
    let stopped = run_in(&folder, &["journal", "j"]).out;
    assert!(stopped.contains("it was killed"), "{stopped}");
}

// r[project.live]
#[test]
fn a_question_that_was_under_way_is_asked_again() {
    let folder = folder("journal-thinking");
    // No run comes to the end of it before the robot has come to the corner.
    let plan = "(def-resume look (print 'resumed))
(pursue (loop (print (list 'at (now))) (wait-time 0.5))
        (seq (wait-time 0.2) (project '(dotimes (n 100000) (wait-time (random 0.002))) :runs 10000) (print 'answered))
        (go-to 'corner))
(print 'there)";
    put(&folder, "plan.rpl", plan);
    let host = Served::start(&["--speed", "4"]);
    let site = ["--world", "test-room", "--grid", "coarse", "--host", &host.address, "--sync", "never"];
    let begun = [&["run", "plan.rpl", "--journal", "j"][..], &site].concat();
    killed_after(4, &folder, &begun);
    // From a checkpoint that was made meanwhile, and then to the end.
    let stood = resume(&folder, &["--until", "3s"]);
    assert_eq!(stood.status, 3, "{}{}", stood.out, stood.errors);
    let ended = resume(&folder, &["--until", "10min"]);
    assert_eq!(ended.status, 0, "{}{}", ended.out, ended.errors);
    assert!(ended.out.starts_with("resumed\n") && ended.out.ends_with("there\n"), "{}", ended.out);
    assert_eq!(count(&text_in(&folder, "j/output.txt"), "answered"), 0);
    host.end();
}

/// A folder with the module of the lamp.
fn with_lamp(name: &str, plan: &str) -> PathBuf {
    let folder = folder(name);
    for file in ["lamp.toml", "lamp.rpl", "lamp.py"] {
        put(&folder, file, fs::read_to_string(root().join("examples/modules").join(file)).expect("it is there"));
    }
    put(&folder, "plan.rpl", plan);
    folder
}

#[test]
fn a_module_is_started_anew_and_its_behaviours_are_interrupted_alone() {
    let plan = "
(def-resume again (print 'again))
(defvar times 100000)
(pursue
  (loop (print (list 'at (now))) (wait-time 1))
  (with-valve lamp
    (with-failure-handling ((interrupted (f) (print 'dark) (setq times 2) (retry)))
      (run-behaviour blink :times times))))
(print (list 'blinked times))
(go-to 'corner)
(print (at-destination? 'corner))";
    let folder = with_lamp("journal-module", plan);
    let begun = [
        ["run", "plan.rpl", "--world", "test-room", "--grid", "coarse", "--module", "lamp.toml"],
        ["--journal", "j", "--trace", "j.jsonl", "--realtime", "20", "--sync", "never"],
    ]
    .concat();
    let first = killed_after(4, &folder, &begun);
    assert_eq!(first[3], "(at 3.0)");
    let ended = resume(&folder, &["--realtime", "1000"]);
    assert_eq!(ended.status, 0, "{}{}", ended.out, ended.errors);
    let printed = text_in(&folder, "j/output.txt");
    assert_eq!(count(&printed, "again\ndark\n"), 1, "{printed}");
    assert!(printed.ends_with("(blinked 2)\nt\n") && printed.contains("(at 3.0)\n"), "{printed}");
    // The world is simulated, and all of it is in the journal.
    let log = text_in(&folder, "j/log.txt");
    assert!(log.contains("s  resumed") && !log.contains("position doubted"), "{log}");

    // From a checkpoint, in which the lamp blinks.
    fs::remove_dir_all(folder.join("j")).expect("it is there");
    let stood = with_python(&[&begun[..10], &["--until", "2500ms"]].concat()).current_dir(&folder).output();
    assert_eq!(stood.expect("it starts").status.code(), Some(3));
    let ended = resume(&folder, &[]);
    assert!(ended.errors.contains("from the checkpoint at 2.5 s") && ended.status == 0, "{}", ended.errors);
    assert_eq!(ended.out, "again\ndark\n(blinked 2)\nt\n");
    assert!(ended.errors.contains("the module `lamp` is started: `python3 lamp.py`"), "{}", ended.errors);

    put(&folder, "lamp.toml", format!("# changed\n{}", text_in(&folder, "lamp.toml")));
    fs::remove_file(folder.join("j/end")).expect("it has ended");
    let refused = resume(&folder, &[]);
    assert!(refused.status == 2 && refused.errors.contains("lamp.toml` changed"), "{}", refused.errors);
}

#[test]
fn a_simulated_run_goes_on_as_if_nothing_had_been() {
    let folder = folder("journal-hook");
    put(&folder, "plan.rpl", "(def-resume look (print 'never))\n(wait-time 2) (print 'one) (wait-time 2) (print 'two)");
    let found = run_in(&folder, &["run", "plan.rpl", "--journal", "j", "--until", "3s"]);
    assert_eq!((found.out.as_str(), found.status), ("one\n", 3), "{}", found.errors);
    let found = run_in(&folder, &["resume", "j", "--host", "127.0.0.1:1"]);
    assert!(found.status == 2 && found.errors.contains("is simulated"), "{}", found.errors);
    let found = run_in(&folder, &["resume", "j"]);
    assert_eq!((found.out.as_str(), found.status), ("two\n", 0), "{}", found.errors);
}
