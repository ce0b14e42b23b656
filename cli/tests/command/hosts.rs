//! Hosts in other processes, over TCP: served, driven, lost; and their recordings, repeated.

use crate::folder::{folder, put, text_in};
use crate::keys;
use crate::rpl::{Ended, feed, rpl, run, run_in, start};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread;

/// A plan that drives, and ends by itself.
const DRIVE: &str =
    "(print 'begun)\n(unwind-protect (go-to 'corner) (print 'cleaned))\n(print (at-destination? 'corner))\n";

/// A simulated host in a process of its own.
pub struct Served {
    pub child: Child,
    out: BufReader<ChildStdout>,
    pub address: String,
}

impl Served {
    pub fn start(arguments: &[&str]) -> Self {
        let common = ["simulate", "--world", "test-room", "--listen", "127.0.0.1:0", "--json"];
        let mut child = start(&[&common[..], arguments].concat());
        let mut out = BufReader::new(child.stdout.take().expect("the output is piped"));
        let mut line = String::new();
        out.read_line(&mut line).expect("it says where it listens");
        let address = line.trim().strip_prefix("listening at ").expect("it listens").to_string();
        Self { child, out, address }
    }

    /// Ends it by force.
    pub fn end(mut self) {
        self.child.kill().expect("it can be killed");
        self.child.wait().expect("it is dead");
    }

    /// Its summary, when it has ended.
    pub fn summary(mut self) -> (Value, Ended) {
        let mut rest = String::new();
        self.out.read_to_string(&mut rest).expect("the rest is text");
        let last = rest.lines().last().unwrap_or_default();
        (serde_json::from_str(last).expect("a JSON object"), Ended::of(self.child))
    }
}

fn mission<'a>(plan: &'a str, address: &'a str, more: &[&'a str]) -> Ended {
    let common = ["run", plan, "--world", "test-room", "--grid", "coarse", "--host", address];
    run(&[&common[..], more].concat())
}

#[test]
fn a_mission_drives_a_host_and_its_recording_is_the_same_run_again() {
    let folder = folder("host-drive");
    let plan = put(&folder, "plan.rpl", DRIVE);
    let [recording, live, again] = ["run.jsonl", "live.jsonl", "again.jsonl"].map(|name| put(&folder, name, ""));
    let host = Served::start(&["--speed", "8", "--once"]);
    let found = mission(&plan, &host.address, &["--record", &recording, "--trace", &live, "--json"]);
    assert_eq!(found.status, 0, "{}", found.errors);
    let (printed, summary) = found.out.trim_end().rsplit_once('\n').expect("a summary");
    assert_eq!(printed, "begun\ncleaned\nt");
    let summary: Value = serde_json::from_str(summary).expect("one JSON object");
    assert!(summary["contacts"].is_null() && summary["host"]["percepts"].as_u64() > Some(20), "{summary}");

    let (world, ended) = host.summary();
    assert_eq!((ended.status, &world["missions"], &world["speed_mps"]), (0, &1.into(), &0.0.into()), "{world}");
    assert_eq!(keys::found(&world), keys::documented("rpl simulate"));
    let of_host = keys::found(&summary).into_iter().filter(|key| key.starts_with("host."));
    assert_eq!(of_host.collect::<BTreeSet<String>>(), keys::documented("Hosts"));

    let replayed = run(&["replay", &recording, "--trace", &again]);
    assert_eq!((replayed.status, replayed.out.as_str()), (0, "begun\ncleaned\nt\n"), "{}", replayed.errors);
    assert_eq!(text_in(&folder, "live.jsonl"), text_in(&folder, "again.jsonl"));

    changed_plans_go_astray(&folder, &recording);
    wrong_recordings_are_told(&folder, &recording);
}

fn changed_plans_go_astray(folder: &Path, recording: &str) {
    let other = put(folder, "other.rpl", DRIVE.replace("'corner", "'table-side"));
    let found = run(&["replay", recording, "--plan", &other]);
    assert_eq!((found.status, found.out.as_str()), (1, "begun\ncleaned\n"), "{}", found.errors);
    assert!(found.errors.contains("is not the text that was recorded"), "{}", found.errors);
    assert!(found.errors.contains("acts differently from"), "{}", found.errors);
    assert!(found.errors.contains("recorded: {\"number\":") && found.errors.contains("now:      {\"number\":"));
    let same = put(folder, "same.rpl", format!("; a comment\n{DRIVE}"));
    assert_eq!(run(&["replay", recording, "--plan", &same]).status, 0);
}

fn wrong_recordings_are_told(folder: &Path, recording: &str) {
    let text = fs::read_to_string(recording).expect("it is there");
    let cut = put(folder, "cut.jsonl", &text[..text.len() / 2]);
    let found = run(&["replay", &cut]);
    assert_eq!(found.status, 1, "{}", found.errors);
    assert!(found.errors.contains("the recording of `host` ends after"), "{}", found.errors);
    for (name, text, expected) in [
        ("empty.jsonl", String::new(), "line 1: a recording of rpl is expected"),
        ("trace.jsonl", "{\"trace\":1}\n".to_string(), "line 1: a recording of rpl is expected"),
        (
            "version.jsonl",
            text.replacen("\"recording\":1", "\"recording\":7", 1),
            "line 1: the recording has version 7",
        ),
        ("turn.jsonl", text.replacen("\"turn\":3,", "\"turn\":4,", 1), "line 5: turn 3 of `host` is expected"),
        ("words.jsonl", text.replacen("\"sonars_on\":true", "\"sonars_on\":7", 1), "invalid type: integer `7`"),
        (
            "world.jsonl",
            text.replacen("\"name\":\"test-room\"", "\"name\":\"dept\"", 1),
            "the world `dept` is not what",
        ),
    ] {
        let found = run(&["replay", &put(folder, name, text)]);
        assert_eq!(found.status, 2, "{name}: {}", found.errors);
        assert!(found.errors.contains(expected), "{name}: {}", found.errors);
    }
}

/// Drives, and compares plans again and again meanwhile.
const THINK: &str = "(def-plan again () (seq (go-to 'corner) (go-to 'table-side)))
(pursue (go-to 'corner)
  (loop (let ((c (compare-plans '(go-to 'table-side) '(again) :runs 20 :errors 9 :horizon 20min)))
          (print (list (now) (comparison-thinking c) (comparison-stale c)
                       (projection-horizon (comparison-first c)))))))
(print 'there)
";

// r[project.live]
#[test]
fn what_was_thought_about_on_the_way_is_replayed_as_it_came() {
    let folder = folder("host-thinking");
    let plan = put(&folder, "plan.rpl", THINK);
    let [recording, live, again] = ["run.jsonl", "live.jsonl", "again.jsonl"].map(|name| put(&folder, name, ""));
    let host = Served::start(&["--speed", "4", "--once"]);
    let found = mission(&plan, &host.address, &["--record", &recording, "--trace", &live]);
    assert_eq!(found.status, 0, "{}", found.errors);
    host.summary();
    let replayed = run(&["replay", &recording, "--trace", &again]);
    assert_eq!((replayed.status, &replayed.out), (0, &found.out), "{}", replayed.errors);
    assert_eq!(text_in(&folder, "live.jsonl"), text_in(&folder, "again.jsonl"));
    let seen = feed(&mut rpl(&["replay", &recording, "--prompt"]), ":continue\n:back 1\n:continue\n");
    assert!(seen.out.contains(&found.out) && !seen.errors.contains("projection-failure"), "{}", seen.errors);

    // Another question is answered at the same moments, and by what is so in the recording.
    let other = put(&folder, "other.rpl", THINK.replace("20min", "30min"));
    let changed = run(&["replay", &recording, "--plan", &other]);
    assert_eq!(changed.status, 0, "{}", changed.errors);
    assert!(found.out.contains(" 1200.0)\n"), "{}", found.out);
    assert_eq!(changed.out, found.out.replace(" 1200.0)\n", " 1800.0)\n"));
}

#[test]
fn the_prompt_stands_in_a_recording() {
    let folder = folder("host-prompt");
    let plan = put(&folder, "plan.rpl", DRIVE);
    let recording = put(&folder, "run.jsonl", "");
    let host = Served::start(&["--speed", "8", "--once"]);
    assert_eq!(mission(&plan, &host.address, &["--record", &recording]).status, 0);
    host.summary();
    let typed = ":time 1s\n:back 1\n:continue\n";
    let found = feed(&mut rpl(&["replay", &recording, "--prompt"]), typed);
    assert!(found.out.contains("cleaned") && !found.errors.contains("host-failure"), "{} {}", found.out, found.errors);
}

#[cfg(unix)]
#[test]
fn a_second_mission_goes_on_from_where_the_robot_stands() {
    let folder = folder("host-second");
    let plan = put(&folder, "plan.rpl", "(wait-time 1)");
    let host = Served::start(&["--speed", "20"]);
    for _ in 0..2 {
        let found = mission(&plan, &host.address, &[]);
        assert_eq!(found.status, 0, "{}", found.errors);
    }
    let id = host.child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    let (world, _) = host.summary();
    assert_eq!((&world["missions"], &world["halts"]["closed_lines"]), (&2.into(), &2.into()), "{world}");
}

/// A host that greets, says these lines, and is gone.
pub fn says(lines: impl IntoIterator<Item: AsRef<str>, IntoIter: Send + 'static>) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("it has one").to_string();
    let lines = lines.into_iter();
    thread::spawn(move || {
        let Ok((mut stream, _)) = listener.accept() else { return };
        let mut heard = BufReader::new(stream.try_clone().expect("a second handle"));
        heard.read_line(&mut String::new()).ok();
        for line in lines {
            stream.write_all(format!("{}\n", line.as_ref()).as_bytes()).ok();
        }
        // What it is told is read, so that the line is closed and not broken off.
        stream.shutdown(std::net::Shutdown::Write).ok();
        heard.read_to_string(&mut String::new()).ok();
    });
    address
}

const HELLO: &str = r#"{"type":"hello","protocol":2,"robot":"b21","period_us":50000,"factor":1.0,"start_known":true}"#;
const PERCEPT: &str = r#"{"type":"percept","number":0,"time_us":50000,"odometry_in_odom":{"x_m":0,"y_m":0,"heading_rad":0},"translation_mps":0,"rotation_radps":0,"bumped":false,"gripper":"open","battery":1}"#;

#[test]
fn a_host_that_is_lost_fails_the_mission_and_is_named() {
    let plan = put(&folder("host-lost"), "plan.rpl", DRIVE);
    for (lines, why) in [
        (&[HELLO][..], "is gone: it has closed the line"),
        (&[HELLO, PERCEPT], "is gone: it has closed the line"),
        (&[HELLO, "{\"type\":\"bye\",\"reason\":\"the battery is empty\"}"], "says goodbye: the battery is empty"),
        (&[HELLO, "no json"], "has sent what is no message: expected ident"),
        (&[HELLO, HELLO], "greets a second time"),
    ] {
        let address = says(lines);
        let found = mission(&plan, &address, &[]);
        assert_eq!(found.status, 1, "{why}: {}", found.errors);
        let named = format!("the host `{address}` {why}");
        assert!(found.errors.contains("host-failure") && found.errors.contains(&named), "{named}: {}", found.errors);
    }
}

#[test]
fn a_host_that_says_what_cannot_be_is_lost() {
    let plan = put(&folder("host-nonsense"), "plan.rpl", "(wait-time 1)");
    const SONARS: &str = r#"{"type":"percept","number":0,"time_us":50000,"odometry_in_odom":{"x_m":0,"y_m":0,"heading_rad":0},"translation_mps":0,"rotation_radps":0,"sonar_m":[1,2],"bumped":false,"gripper":"open","battery":1}"#;
    const FAR: &str = r#"{"type":"percept","number":0,"time_us":50000,"odometry_in_odom":{"x_m":1e300,"y_m":0,"heading_rad":0},"translation_mps":0,"rotation_radps":0,"bumped":false,"gripper":"open","battery":1}"#;
    for (lines, why) in [
        (&[HELLO, SONARS][..], "percept 0: `sonar_m` has 2 readings, and 24 are expected"),
        (&[HELLO, FAR], "percept 0: `odometry_in_odom.x_m` is 1e300"),
    ] {
        let found = mission(&plan, &says(lines), &[]);
        assert!(found.status == 1 && found.errors.contains("host-failure"), "{}", found.errors);
        let errors: String = found.errors.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(errors.contains(&why.replace("1e300", "")[..30]), "{why}: {errors}");
    }
}

#[test]
fn who_does_not_fit_is_refused_before_anything_is_built() {
    let plan = put(&folder("host-unfit"), "plan.rpl", "(wait-time 1)");
    let hello = |from: &str, to: &str| -> &'static [&'static str] {
        Box::leak(Box::new([&*Box::leak(HELLO.replace(from, to).into_boxed_str())]))
    };
    for (lines, why) in [
        (hello("\"protocol\":2", "\"protocol\":1"), "speaks version 1 of the messages, and this rpl 2"),
        (hello("b21", "roomba"), "moves the robot `roomba`, and the mission is for `b21`"),
        (hello("50000", "0"), "greets with a period of 0 us"),
        (hello("50000", "40000"), "has a period of 40000 us, and the robot of the mission one of 50000 us"),
        (hello("\"factor\":1.0", "\"factor\":-1.0"), "a factor of -1"),
        (hello("\"robot\"", "\"robbot\""), "unknown field `robbot`"),
        (&[], "gives no greeting"),
    ] {
        let found = mission(&plan, &says(lines), &[]);
        assert_eq!((found.status, found.out.as_str()), (2, ""), "{why}: {}", found.errors);
        assert!(found.errors.contains(why), "{why}: {}", found.errors);
    }
    let found = mission(&plan, "127.0.0.1:1", &[]);
    assert!(found.status == 2 && found.errors.contains("the host `127.0.0.1:1` cannot be reached"), "{}", found.errors);
    let found = mission(&plan, "nowhere", &[]);
    assert!(found.status == 2 && found.errors.contains("an address is `HOST:PORT`"), "{}", found.errors);
    let found = mission(&plan, "127.0.0.1:1", &["--scenario", "rotated.rpl"]);
    assert!(found.status == 2 && found.errors.contains("cannot be used with"), "{}", found.errors);
}

/// What a served host answers to somebody who is no mission.
fn answer(address: &str, line: &str) -> String {
    let mut stream = TcpStream::connect(address).expect("it listens");
    stream.write_all(line.as_bytes()).expect("it reads");
    let mut heard = String::new();
    stream.read_to_string(&mut heard).expect("it closes the line");
    heard
}

#[cfg(target_os = "linux")]
#[test]
fn it_is_told_that_nobody_can_be_let_in_and_a_mission_gets_the_robot_when_there_is_room() {
    let program = rpl(&["simulate", "--world", "test-room", "--listen", "127.0.0.1:0", "--speed", "20", "--once"]);
    let mut limited = Command::new("sh");
    limited.args(["-c", "ulimit -n 24; exec \"$0\" \"$@\""]).arg(program.get_program()).args(program.get_args());
    let mut child = limited.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
    let mut out = BufReader::new(child.stdout.take().expect("it is piped")).lines().map_while(Result::ok);
    let address = out.find_map(|line| Some(line.strip_prefix("listening at ")?.to_string())).expect("it listens");
    let crowd: Vec<TcpStream> = (0..40).map(|_| TcpStream::connect(&address).expect("there is a line")).collect();
    let mut told = BufReader::new(child.stderr.take().expect("it is piped")).lines().map_while(Result::ok);
    assert!(told.any(|line| line.contains("Too many open files")), "it is not told");
    drop(crowd);
    let plan = put(&folder("host-full"), "plan.rpl", "(wait-time 1)");
    let found = mission(&plan, &address, &[]);
    assert_eq!(found.status, 0, "{}", found.errors);
    assert!(told.filter(|line| line.contains("nobody can be let in")).count() <= 1, "it is told once");
    child.wait().expect("it ends");
}

#[test]
fn a_served_host_outlives_what_is_no_mission() {
    let host = Served::start(&["--speed", "20", "--once"]);
    for (line, why) in [
        ("nonsense\n", "what is no message"),
        ("{\"type\":\"hello\",\"protocol\":9,\"rpl\":\"9\",\"robot\":\"b21\"}\n", "speaks version 9"),
        ("{\"type\":\"hello\",\"protocol\":2,\"rpl\":\"0\",\"robot\":\"roomba\"}\n", "for the robot `roomba`"),
        (
            "{\"type\":\"commands\",\"number\":0,\"translation_mps\":1,\"rotation_radps\":0,\"sonars_on\":true}\n",
            "commands before it greets",
        ),
        ("{\"type\":\"commands\",\"number\":0,\"translation_mps\":1e999,\"rotation_radps\":0}\n", "out of range"),
        ("{\"type\":\"bye\"}\n", "it says goodbye"),
    ] {
        let heard = answer(&host.address, line);
        assert!(heard.contains("\"bye\"") && heard.contains(why), "{line}: {heard}");
    }
    let plan = put(&folder("host-outlives"), "plan.rpl", "(wait-time 1)");
    let found = mission(&plan, &host.address, &[]);
    assert_eq!(found.status, 0, "{}", found.errors);
    let (world, _) = host.summary();
    assert_eq!(world["missions"], 1, "{world}");
}

#[test]
fn a_run_in_the_simulator_is_recorded_by_what_it_is_made_of() {
    let folder = folder("host-simulated");
    put(&folder, "plan.rpl", "(print (list (random 1000) 'go))");
    let found = run_in(&folder, &["run", "plan.rpl", "--world", "test-room", "--seed", "9", "--record", "r.jsonl"]);
    assert_eq!(found.status, 0, "{}", found.errors);
    let again = run_in(&folder, &["replay", "r.jsonl"]);
    assert_eq!((again.status, again.out), (0, found.out));
}

#[test]
fn a_session_is_repeated_with_what_was_typed() {
    let folder = folder("host-session");
    let recording = put(&folder, "session.jsonl", "");
    let typed = "(defvar n (random 1000))\nn\n(go-to 'corner)\n(* n\n   2)\n(fail \"no\")\n(+ n 1)\n";
    let world = ["--world", "test-room", "--grid", "coarse", "--seed", "4"];
    let found = feed(&mut rpl(&[&["repl", "--record", &recording][..], &world].concat()), typed);
    assert!(found.out.lines().count() > 2, "{} {}", found.out, found.errors);
    let again = run(&["replay", &recording]);
    assert_eq!((again.out, again.status), (found.out, found.status), "{}", again.errors);
}

/// r[cleanup.stop]
#[cfg(unix)]
#[test]
fn a_run_that_was_stopped_stops_again_at_the_same_time() {
    let folder = folder("host-stopped");
    let plan = put(&folder, "plan.rpl", "(unwind-protect (seq (print 'going) (wait-time 1000)) (print 'clean))");
    let [recording, live, again] = ["run.jsonl", "live.jsonl", "again.jsonl"].map(|name| put(&folder, name, ""));
    let common = ["run", &plan, "--world", "test-room", "--grid", "coarse", "--realtime"];
    let mut child = start(&[&common[..], &["--record", &recording, "--trace", &live]].concat());
    let mut out = BufReader::new(child.stdout.take().expect("the output is piped"));
    out.read_line(&mut String::new()).expect("it goes");
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    assert_eq!(Ended::of(child).status, 130);
    let found = run(&["replay", &recording, "--trace", &again]);
    assert_eq!((found.out.as_str(), found.status), ("going\nclean\n", 130), "{}", found.errors);
    assert_eq!(text_in(&folder, "live.jsonl"), text_in(&folder, "again.jsonl"));
}

// r[project.live]
#[cfg(unix)]
#[test]
fn a_run_that_is_stopped_while_it_thinks_does_not_think_to_the_end() {
    let folder = folder("host-thinking-stopped");
    // It would take minutes.
    let plan = "(print 'going) (unwind-protect (project '(dotimes (n 100000) (wait-time (random 0.002))) :runs 10000) (print 'clean))";
    let plan = put(&folder, "plan.rpl", plan);
    let [recording, live, again] = ["run.jsonl", "live.jsonl", "again.jsonl"].map(|name| put(&folder, name, ""));
    let host = Served::start(&["--speed", "8", "--once"]);
    let common = ["run", &plan, "--world", "test-room", "--grid", "coarse", "--host", &host.address];
    let mut child = start(&[&common[..], &["--record", &recording, "--trace", &live]].concat());
    let mut out = BufReader::new(child.stdout.take().expect("the output is piped"));
    out.read_line(&mut String::new()).expect("it goes");
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    assert_eq!(Ended::of(child).status, 130);
    host.summary();
    let found = run(&["replay", &recording, "--trace", &again]);
    assert_eq!((found.out.as_str(), found.status), ("going\nclean\n", 130), "{}", found.errors);
    assert_eq!(text_in(&folder, "live.jsonl"), text_in(&folder, "again.jsonl"));
}
