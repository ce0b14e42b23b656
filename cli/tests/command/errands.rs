//! Errands in a house of symbols (`examples/errands`): actions in Python that wait, their results, queries, and a world
//! that outlives a run.

use crate::folder::{folder, put, text_in};
use crate::modules::{root, run_in};
use crate::rpl::Ended;
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::{Child, Command};

/// A folder with the errands and another plan.
fn folder_of_errands(name: &str, plan: &str) -> PathBuf {
    let folder = folder(name);
    for file in ["errands.rpl", "errands.toml", "carrying.rpl", "world.py"] {
        put(&folder, file, std::fs::read_to_string(root().join("examples/errands").join(file)).expect("it is there"));
    }
    put(&folder, "plan.rpl", plan);
    folder
}

const RUN: [&str; 4] = ["run", "plan.rpl", "--module", "errands.toml"];

#[test]
fn the_problems_are_solved() {
    let folder = folder_of_errands("errands-tests", "");
    let Ended { out, errors, status } = run_in(&folder, &["test", "errands.rpl", "--module", "errands.toml"]);
    assert!(out.contains("6 tests, all ok") && status == 0, "{out}{errors}");
    let Ended { out, errors, status } = run_in(&folder, &["check", "errands.rpl", "--module", "errands.toml"]);
    assert!(out.contains("errands.rpl: no findings") && status == 0, "{out}{errors}");
}

#[test]
fn actions_that_wait_are_a_function_of_the_seed() {
    let folder = folder_of_errands("errands-seed", "");
    let trace = |seed: &str, name: &str| {
        let run = ["run", "errands.rpl", "--module", "errands.toml", "--set", "problem=3", "--seed", seed, "-q"];
        let Ended { errors, status, .. } = run_in(&folder, &[&run[..], &["--trace", name]].concat());
        assert_eq!(status, 0, "{errors}");
        text_in(&folder, name)
    };
    let first = trace("5", "a.jsonl");
    assert!(first == trace("5", "b.jsonl"), "the same seed gives the same run");
    let rest = |trace: &str| trace.split_once('\n').map(|(_, rest)| rest.to_string());
    assert!(rest(&first) != rest(&trace("6", "c.jsonl")), "another seed gives another one");
}

#[test]
fn the_value_of_a_behaviour_and_of_a_query_is_that_of_the_call() {
    let plan = "
(print (run-behaviour begin :problem 1))
(print (place-of 'banana))
(print (place-of 'cup))
(go-to 'desk)
(print (run-behaviour look))
(print (run-behaviour pick-up :thing 'banana))
(with-failure-handling ((not-here (f) (print (failure-slot f 'what))))
  (run-behaviour pick-up :thing 'banana))
(with-failure-handling ((module-failure (f) (print (failure-slot f 'module))))
  (closed? '(no name)))
(def-fluent spot (fluent (place-of (or holding* 'banana))))
(print (value spot))
(run-behaviour put-down)
(print (value spot))";
    let folder = folder_of_errands("errands-values", plan);
    let Ended { out, errors, status } = run_in(&folder, &RUN);
    assert_eq!((out.as_str(), status), ("t\ndesk\nnil\n(banana)\nbanana\nbanana\nerrands\nnil\ndesk\n", 0), "{errors}");
}

#[test]
fn plans_are_projected_by_what_the_manifest_says_of_times_failures_and_effects() {
    let plan = "
(let ((once (project '(run-behaviour pick-up :thing 'banana) :runs 1000 :horizon 1min)))
  (print (map second (projection-failures once)))
  (print (< 0.16 (first (first (projection-failures once))) 0.24)))
(let ((again (project '(progn
                         (persist (eq (value holding*) 'banana) (slipped) (run-behaviour pick-up :thing 'banana))
                         (run-behaviour put-down)
                         (assert (not (value holding*))))
                      :runs 1000 :horizon 10min)))
  (print (< 0.16 (first (first (projection-failures again))) 0.24))
  (print (< 3.9 (first (projection-time again)) 4.1)))
(print (value holding*))
(with-failure-handling ((projection-failure (f) (print (failure-message f))))
  (project '(run-behaviour move :to 'desk) :runs 2))
(with-failure-handling ((projection-failure (f) (print (failure-message f))))
  (print (projection-failures (project '(closed? 'fridge) :runs 2))))";
    let folder = folder_of_errands("errands-projected", plan);
    let Ended { out, errors, status } = run_in(&folder, &RUN);
    assert_eq!(status, 0, "{out}{errors}");
    let (before, after) = out.split_once("there is no model of what the behaviour `move` does").expect(&out);
    assert_eq!(before, "(slipped)\nt\nt\nt\nnil\n", "{errors}");
    assert!(
        after.contains("projection-failure") || after.contains("no model of what the query `closed?` answers"),
        "{out}"
    );
    for (set, told) in [
        ("\"held*\" = \":thing\"", "`sets` names `held*`, and the module has no such fluent"),
        ("\"holding*\" = \":this\"", "`sets` must be a truth, a number, a text or a parameter of the behaviour"),
        ("\"charge*\" = \"much\"", "`sets` gives `charge*` another value than a number"),
    ] {
        let manifest = text_in(&folder, "errands.toml").replace("\"holding*\" = \":thing\"", set);
        put(&folder, "other.toml", manifest);
        let Ended { errors, status, .. } = run_in(&folder, &["run", "plan.rpl", "--module", "other.toml"]);
        assert!(errors.contains(told) && status == 2, "{told}\n{errors}");
    }
}

#[test]
fn a_module_of_the_old_version_is_told_what_to_change() {
    let folder = folder_of_errands("errands-old", "");
    put(
        &folder,
        "world.py",
        "print('{\"type\":\"hello\",\"protocol\":1,\"module\":\"errands\"}', flush=True); input()",
    );
    let Ended { errors, status, .. } = run_in(&folder, &RUN);
    let told =
        "speaks version 1 of the protocol, and rpl speaks version 2; a module in Python needs `rpl_module` of this";
    assert!(errors.contains(told) && status == 2, "{errors}");
}

#[test]
fn a_lost_module_is_started_again_as_often_as_it_says() {
    let plan = "
(n-times 3
  (with-failure-handling ((module-failure (f) (print (failure-slot f 'reason))))
    (print (closed? 'fridge))
    (run-behaviour charge))
  (wait-time 0.2))";
    let folder = folder_of_errands("errands-restart", plan);
    let world = text_in(&folder, "world.py").replace("world.charge = 1.0", "import os; os._exit(3)");
    put(&folder, "world.py", world.replace("CHARGE_S = 4.0, 2.0, 10.0", "CHARGE_S = 4.0, 2.0, 0.1"));
    put(&folder, "errands.toml", format!("restart = 1\n{}", text_in(&folder, "errands.toml")));
    let Ended { out, errors, status } = run_in(&folder, &[&RUN[..], &["--trace", "t.jsonl"]].concat());
    let lost = "ended with exit status 3\n";
    assert_eq!((out, status), (format!("nil\n{lost}nil\n{lost}{lost}"), 0), "{errors}");
    assert_eq!(text_in(&folder, "t.jsonl").matches("module started again").count(), 1);
    put(&folder, "errands.toml", text_in(&folder, "errands.toml").replace("restart = 1", "restart = \"often\""));
    let Ended { errors, status, .. } = run_in(&folder, &RUN);
    assert!(errors.contains("`restart` must be a whole number up to 1000") && status == 2, "{errors}");
}

/// A world that waits for runs; it ends with the test.
struct Waiting(Child);

impl Drop for Waiting {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

#[test]
fn a_run_that_is_gone_on_with_meets_the_world_that_it_left() {
    let folder = folder_of_errands("errands-connect", "");
    let address = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port is free");
    let address = address.to_string();
    let manifest = text_in(&folder, "errands.toml")
        .replace("command = [\"python3\", \"world.py\"]", &format!("connect = \"{address}\""));
    put(&folder, "errands.toml", manifest);
    let run = ["run", "errands.rpl", "--module", "errands.toml", "--set", "problem=3"];
    let Ended { errors, status, .. } = run_in(&folder, &run);
    assert!(errors.contains(&format!("cannot be connected to at `{address}`")) && status == 2, "{errors}");
    let mut world = Command::new("python3");
    world.args(["world.py", &address]).current_dir(&folder);
    world.env("PYTHONPATH", root().join("python").canonicalize().expect("it is there"));
    let _world = Waiting(world.env("PYTHONDONTWRITEBYTECODE", "1").spawn().expect("it starts"));
    while TcpStream::connect(&address).is_err() {
        std::thread::yield_now();
    }
    let Ended { errors, .. } = run_in(&folder, &[&run[..], &["--until", "30s", "--journal", "journal"]].concat());
    assert!(errors.contains("cut off by --until"), "{errors}");
    // It was begun before: what is done is not done again, and the house is as it was.
    let Ended { errors, status, .. } = run_in(&folder, &["resume", "journal"]);
    assert_eq!(status, 0, "{errors}");
}
