//! Runs that are seen: `--report`, `rpl view`, `--live`. How the page looks is tested in a browser (`page/tests`).

use crate::folder::{folder, put, text_in};
use crate::rpl::{rpl, run_in};
use rpl_page::report::run_in as run_of_report;
use serde_json::Value;
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};

const DRIVE: &str = "(def-valve tray)\n(def-fluent done nil)\n\
    (par (with-valve tray (go-to 'corner))\n     (seq (wait-time 1) (with-valve tray (setf (value done) t))))\n\
    (print 'there)\n";

const SITE: [&str; 6] = ["--world", "test-room", "--grid", "coarse", "--seed", "7"];

/// What is seen in a report: the head, then each line.
fn seen(folder: &Path, name: &str) -> (Value, Vec<(u64, Value)>) {
    let run = run_of_report(&text_in(folder, name)).expect("there is a run in it");
    let lines = String::from_utf8(run.lines().to_vec()).expect("lines are text");
    let parsed = lines.lines().map(|line| serde_json::from_str(line).expect("a line is JSON"));
    (serde_json::from_str(run.head()).expect("the head is JSON"), parsed.collect())
}

/// All that was seen of a kind, with its time.
fn of_kind<'s>(lines: &'s [(u64, Value)], kind: &str) -> Vec<(u64, &'s Value)> {
    lines.iter().filter_map(|(time_us, seen)| Some((*time_us, seen.get(kind)?))).collect()
}

#[test]
fn a_run_that_is_seen_prints_and_traces_what_it_does_unseen() {
    let folder = folder("view-same");
    put(&folder, "drive.rpl", DRIVE);
    let run = |more: &[&str]| run_in(&folder, &[&["run", "drive.rpl", "--json"], more, &SITE[..]].concat());
    let unseen = run(&["--trace", "unseen.jsonl", "--trace-poses", "5"]);
    let seen = run(&["--trace", "seen.jsonl", "--trace-poses", "5", "--report", "run.html", "--truth"]);
    assert_eq!(unseen.status, 0, "{}", unseen.errors);
    assert_eq!(text_in(&folder, "unseen.jsonl"), text_in(&folder, "seen.jsonl"));
    // The last line also tells how long was computed.
    let told = |errors: &str| errors.split(" (").next().map(str::to_string);
    assert_eq!(told(&unseen.errors), told(&seen.errors));
    let printed = |out: &str| out.lines().next().map(str::to_string);
    assert_eq!(printed(&unseen.out), printed(&seen.out));
    let answer =
        followed(&folder, &["run", "drive.rpl", "--live", ":0", "--trace", "live.jsonl", "--trace-poses", "5"]);
    assert!(answer.starts_with("HTTP/1.1 200") && answer.contains("drive.rpl"), "{answer}");
    assert_eq!(text_in(&folder, "unseen.jsonl"), text_in(&folder, "live.jsonl"));
}

/// Asks a run with a page for its lines, and interrupts it when it is over; what was answered.
fn followed(folder: &Path, arguments: &[&str]) -> String {
    let mut command = rpl(&[arguments, &SITE[..]].concat());
    let piped = command.current_dir(folder).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = piped.spawn().expect("it starts");
    let mut told = BufReader::new(child.stderr.take().expect("it is piped")).lines().map_while(Result::ok);
    let link = told.find_map(|line| Some(line.split_once("shown at http://")?.1.to_string())).expect("a link");
    let host = link.trim_end_matches('/');
    let mut line = TcpStream::connect(host).expect("it is served");
    let asked = format!("GET /lines?from=0 HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    line.write_all(asked.as_bytes()).expect("it can be asked");
    let mut answer = String::new();
    line.read_to_string(&mut answer).expect("it answers");
    assert!(told.any(|line| line.contains("the page stays until Ctrl-C")), "the run ends and is shown");
    let ended = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(ended.success() && child.wait().is_ok());
    answer
}

#[test]
fn a_report_has_the_map_the_plan_the_tasks_and_the_robot() {
    let folder = folder("view-report");
    put(&folder, "drive.rpl", DRIVE);
    let found = run_in(&folder, &[&["run", "drive.rpl", "-q", "--report", "run.html"], &SITE[..]].concat());
    assert_eq!(found.status, 0, "{}", found.errors);
    let (head, lines) = seen(&folder, "run.html");
    assert_eq!((&head["plan"], &head["texts"][0]["text"]), (&"drive.rpl".into(), &DRIVE.into()));
    assert_eq!(head["map"]["name"], "test-room");
    assert!(lines.is_sorted_by_key(|(time_us, _)| *time_us), "lines stand in the order of happening");
    // The truth is not in it: nobody asked for it.
    let robots = of_kind(&lines, "robot");
    assert!(robots.len() > 5 && robots.iter().all(|(_, robot)| robot.get("truth").is_none()));
    for kind in ["belief", "ranges", "targets", "valve", "fluent"] {
        assert!(!of_kind(&lines, kind).is_empty(), "{kind}");
    }
    // Whoever has begun has ended, and the second waited for the valve of the first.
    let tasks = of_kind(&lines, "task");
    let waits = tasks.iter().any(|(_, task)| task["state"] == "waits" && task["on"] == "valve tray");
    assert!(waits);
    let numbers = |of: &[(u64, &Value)]| of.iter().map(|(_, task)| task["id"].as_u64()).collect::<BTreeSet<_>>();
    let (living, ended) = (numbers(&tasks), numbers(&of_kind(&lines, "ended")));
    assert_eq!(living, ended);
}

#[test]
fn the_truth_is_seen_if_it_is_asked_for() {
    let folder = folder("view-truth");
    put(&folder, "drive.rpl", DRIVE);
    run_in(&folder, &[&["run", "drive.rpl", "-q", "--report", "run.html", "--truth"], &SITE[..]].concat());
    let (head, lines) = seen(&folder, "run.html");
    assert_eq!(head["truth"], true);
    assert!(of_kind(&lines, "robot").iter().all(|(_, robot)| robot["truth"].is_array()));
}

#[test]
fn people_and_what_no_map_has_are_seen_with_the_truth_alone() {
    let folder = folder("view-people");
    put(&folder, "stay.rpl", "(wait-time 3)\n");
    put(&folder, "closes.rpl", "(wait-time 1) (close-door! 'b) (add-object! 'crate 13.0 9.5 13.6 10.1)\n");
    let run = |name: &str, more: &[&str]| {
        let arguments = ["run", "stay.rpl", "-q", "--world", "dept-furnished", "--scenario", "closes.rpl"];
        let found = run_in(&folder, &[&arguments[..], &["--report", name], more].concat());
        assert_eq!(found.status, 0, "{}", found.errors);
        seen(&folder, name)
    };
    let (head, lines) = run("truth.html", &["--truth"]);
    assert!(
        of_kind(&lines, "people").iter().all(|(_, people)| people.as_array().map(Vec::len) == Some(8)),
        "four people"
    );
    let names = |things: &Value| {
        let things = things.as_array().into_iter().flatten();
        things.filter_map(|thing| Some(thing["name"].as_str()?.to_string())).collect::<Vec<_>>()
    };
    let things = of_kind(&lines, "things");
    assert!(!names(things[0].1).contains(&"crate".into()) && names(things[1].1).contains(&"crate".into()));
    let closed = of_kind(&lines, "closed");
    let rooms = |closed: &Value| {
        let numbers = closed.as_array().into_iter().flatten().filter_map(Value::as_u64);
        numbers.map(|number| head["map"]["doors"][number as usize]["room"].to_string()).collect::<Vec<_>>()
    };
    assert!(!rooms(closed[0].1).contains(&"\"B\"".into()) && rooms(closed[1].1).contains(&"\"B\"".into()));
    let (head, lines) = run("map.html", &[]);
    assert!(of_kind(&lines, "people").is_empty() && of_kind(&lines, "things").is_empty());
    assert_eq!(of_kind(&lines, "closed").len(), 1, "the robot has not seen the door close");
    let solids = head["map"]["solids"].as_array().expect("there are walls");
    assert!(solids.iter().all(|solid| solid["kind"] != "unmapped"));
}

#[test]
fn battery_and_speed_are_seen_in_a_trace_with_poses() {
    let folder = folder("view-battery");
    put(&folder, "drive.rpl", DRIVE);
    run_in(&folder, &[&["run", "drive.rpl", "-q", "--trace", "t.jsonl", "--trace-poses", "5"], &SITE[..]].concat());
    run_in(&folder, &["view", "t.jsonl", "--report", "t.html"]);
    let (_, lines) = seen(&folder, "t.html");
    let robots = of_kind(&lines, "robot");
    assert!(robots.iter().skip(1).all(|(_, robot)| robot["battery"].is_u64() && robot["speed"].is_array()));
    assert!(robots.iter().any(|(_, robot)| robot["speed"][0].as_i64() > Some(50)), "it drove");
}

#[test]
fn a_trace_a_report_and_a_journal_are_seen_alike() {
    let folder = folder("view-past");
    put(&folder, "drive.rpl", DRIVE);
    let traced = ["run", "drive.rpl", "-q", "--trace", "t.jsonl", "--trace-poses", "5", "--report", "run.html"];
    run_in(&folder, &[&traced[..], &SITE[..]].concat());
    run_in(&folder, &[&["run", "drive.rpl", "-q", "--journal", "j"], &SITE[..]].concat());
    let (_, live) = seen(&folder, "run.html");
    for (file, page) in [("t.jsonl", "of-trace.html"), ("j", "of-journal.html"), ("run.html", "of-report.html")] {
        let found = run_in(&folder, &["view", file, "--report", page]);
        assert_eq!((found.status, found.errors.as_str()), (0, ""), "{file}");
        let (_, past) = seen(&folder, page);
        for kind in ["task", "ended", "valve", "fluent"] {
            assert_eq!(of_kind(&past, kind), of_kind(&live, kind), "{kind} of {file}");
        }
    }
    let (_, computed) = seen(&folder, "of-journal.html");
    assert_eq!(of_kind(&computed, "belief"), of_kind(&live, "belief"));
}

#[test]
fn what_cannot_be_shown_is_told() {
    let folder = folder("view-wrong");
    put(&folder, "plan.rpl", "(print 1)\n");
    put(&folder, "page.html", "<!DOCTYPE html><p>nothing</p>");
    for (arguments, said) in [
        (&["view", "none.jsonl"][..], "cannot read `none.jsonl`"),
        (&["view", "page.html"], "it has no run in it"),
        (&["view", "."], "no journal"),
        (&["view", "page.html", "--report", "x.html", "--open"], "cannot be used with"),
        (&["run", "plan.rpl", "--control"], "--live"),
        (&["run", "plan.rpl", "--live", "no such host.invalid"], "error: `no such host.invalid` is no address"),
        (&["run", "plan.rpl", "--live", ":0", "--control", "--journal", "j"], "leave `--control` away"),
        (&["run", "plan.rpl", "--report", "none/x.html"], "there is no folder `none`"),
    ] {
        let found = run_in(&folder, arguments);
        assert_eq!(found.status, 2, "{arguments:?}: {}", found.errors);
        assert!(found.errors.contains(said), "{arguments:?}: {}", found.errors);
    }
}
