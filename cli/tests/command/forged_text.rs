//! Texts from elsewhere in what the command says: none of them acts on a terminal, hides, or looks like a line of ours.

use crate::folder::{folder, put};
use crate::hosts::{Served, says};
use crate::rpl::{Ended, run};
use rpl_lang::visible::is_invisible;
use std::io::{Read, Write};
use std::net::TcpStream;

/// Clears the screen in two ways, reorders, hides, and begins a line of its own. Short enough to be shown whole.
const FORGED: &str = "a\nerror: forged\u{1b}[2J\u{9b}2J\r\u{202e}\u{200b}b";

/// The beginning of it, as it is shown.
const SHOWN: &str = "a\\nerror: forged\\u{1b}[2J\\u{9b}2J\\r\\u{202e}\\u{200b}b";

/// What a command has said is all to be seen, and has no line that is another's.
fn assert_clean(what: &str, found: &Ended) {
    for said in [&found.out, &found.errors] {
        let raw = said.chars().find(|&c| c != '\n' && is_invisible(c));
        assert_eq!(raw, None, "{what}: {said:?}");
        assert!(said.lines().all(|line| !line.starts_with("error: forged")), "{what}: {said}");
    }
}

/// The same, and the text is there, as it is shown.
fn assert_shown(what: &str, found: &Ended) {
    assert_clean(what, found);
    // A terminal's width does not matter here: there is none.
    assert!(found.errors.contains(SHOWN), "{what}: {}", found.errors);
}

fn json(text: &str) -> String {
    serde_json::to_string(text).expect("a text")
}

#[test]
fn what_a_host_says_is_told_on_one_line() {
    let plan = put(&folder("forged-host"), "plan.rpl", "(wait-time 1)");
    let hello = |robot: &str| {
        format!(
            r#"{{"type":"hello","protocol":2,"robot":{},"period_us":50000,"factor":1.0,"start_known":true}}"#,
            json(robot)
        )
    };
    let bye = || format!(r#"{{"type":"bye","reason":{}}}"#, json(FORGED));
    let percept = format!(r#"{{"type":"percept",{}:1}}"#, json(FORGED));
    for (what, lines) in [
        ("a refusal", vec![bye()]),
        ("another robot", vec![hello(FORGED)]),
        ("a goodbye", vec![hello("b21"), bye()]),
        ("an unknown key", vec![hello("b21"), percept]),
    ] {
        let address = says(lines);
        let found = run(&["run", &plan, "--world", "test-room", "--grid", "coarse", "--host", &address]);
        assert_shown(what, &found);
    }
}

#[test]
fn what_a_mission_says_is_told_on_one_line() {
    let host = Served::start(&["--until", "60s", "--speed", "1000"]);
    let hello = |robot: &str| {
        format!(
            "{{\"type\":\"hello\",\"protocol\":2,\"rpl\":\"0\",\"robot\":{},\"mission\":{}}}\n",
            json(robot),
            json(FORGED)
        )
    };
    let bye = format!("{{\"type\":\"bye\",\"reason\":{}}}\n", json(FORGED));
    let commands =
        "{\"type\":\"commands\",\"number\":0,\"translation_mps\":0,\"rotation_radps\":0,\"sonars_on\":true}\n";
    for lines in [hello(FORGED), hello("b21") + commands + &bye] {
        let mut stream = TcpStream::connect(&host.address).expect("it listens");
        stream.write_all(lines.as_bytes()).expect("it reads");
        stream.read_to_end(&mut Vec::new()).expect("it closes the line");
    }
    // The world goes on by itself to its end.
    let (_, ended) = host.summary();
    assert_shown("a service", &ended);
    assert!(ended.errors.contains(&format!("it says goodbye: {SHOWN}")), "{}", ended.errors);
    assert!(ended.errors.contains(&format!("`{SHOWN}` from 127.0.0.1")), "{}", ended.errors);
}

#[test]
fn names_on_the_command_line_and_of_files_are_told_on_one_line() {
    let folder = folder("forged-names");
    // A name of a file has no other bound than its folder and its end.
    let file = put(&folder, &format!("{FORGED}.rpl"), "(print 'hm");
    let plan = put(&folder, "plan.rpl", "(print 1)");
    for (what, arguments) in [
        ("a plan that is wrong", vec!["run", &file]),
        ("a plan that is not there", vec!["run", FORGED]),
        ("a world", vec!["run", &plan, "--world", FORGED]),
        ("a robot", vec!["run", &plan, "--world", "test-room", "--robot", FORGED]),
        ("a trace", vec!["trace", FORGED]),
        ("a journal", vec!["resume", FORGED]),
        ("a recording", vec!["replay", FORGED]),
        ("an output", vec!["run", &plan, "--trace", &format!("{FORGED}/no/such")]),
    ] {
        assert_shown(what, &run(&arguments));
    }
    assert_clean("an option", &run(&["run", &plan, "--seed", FORGED]));
    assert_clean("a checked text", &run(&["check", &file]));
}

#[test]
fn what_files_and_plans_say_is_told_within_its_message() {
    let folder = folder("forged-texts");
    let plan = put(&folder, "plan.rpl", "(print 1)");
    let robot = put(&folder, "robot.toml", format!("name = {}\n{} = 1\n", json(FORGED), json(FORGED)));
    assert_clean("a robot's file", &run(&["run", &plan, "--world", "test-room", "--robot", &robot]));
    let failing = put(&folder, "failing.rpl", "(fail \"a\\nerror: forged\\u{1b}[31m\\u{9b}\\u{202e}\")");
    let found = run(&["run", &failing]);
    assert_clean("a failure", &found);
    assert!(found.errors.contains("a\n    error: forged\\u{1b}[31m\\u{9b}\\u{202e}"), "{}", found.errors);
}
