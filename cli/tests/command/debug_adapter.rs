//! `rpl dap` as a debugger starts it: a script of requests, each said when the run stands still, and what it is told.

use crate::folder::{folder, put};
use crate::rpl::{feed, rpl, start};
use crate::wire::{messages, written};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout};

const PLAN: &str = "(def-fluent cups 0)
(def-plan wash (number)
  (dotimes (i number)
    (wait-time 1)
    (setf (value cups) (+ i 1))))
(par (wash 3)
     (:tag watch
       (wait-for (= cups 2))
       (print \"two\")))
(print \"done\")
";

/// A debugger and what it debugs.
struct Debugger {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    requests: i64,
    /// Events that nobody has waited for.
    events: Vec<Value>,
}

impl Debugger {
    fn new() -> Self {
        let mut child = start(&["dap"]);
        let to = child.stdin.take().expect("its input is a pipe");
        let from = BufReader::new(child.stdout.take().expect("its output is a pipe"));
        let mut debugger = Self { child, to, from, requests: 0, events: Vec::new() };
        let can = debugger.ask("initialize", json!({ "adapterID": "rpl" }));
        assert_eq!((&can["supportsStepBack"], &can["supportsConditionalBreakpoints"]), (&json!(true), &json!(true)));
        debugger
    }

    /// One that has launched the plan, before its first form.
    fn at_plan(name: &str) -> (Self, String) {
        let folder = folder(name);
        let plan = put(&folder, "plan.rpl", PLAN);
        let mut debugger = Self::new();
        debugger.ask("launch", json!({ "program": plan, "stopOnEntry": true }));
        debugger.event("initialized");
        (debugger, plan)
    }

    fn next(&mut self) -> Value {
        let mut length = 0;
        loop {
            let mut line = String::new();
            assert!(self.from.read_line(&mut line).expect("it can be read") > 0, "the adapter is gone");
            match line.trim_end().strip_prefix("Content-Length: ") {
                Some(number) => length = number.parse().expect("the length is a number"),
                None => break,
            }
        }
        let mut bytes = vec![0; length];
        self.from.read_exact(&mut bytes).expect("the message is whole");
        serde_json::from_slice(&bytes).expect("the message is JSON")
    }

    fn respond(&mut self, command: &str, arguments: Value) -> Value {
        self.requests += 1;
        let request = json!({ "seq": self.requests, "type": "request", "command": command, "arguments": arguments });
        let text = request.to_string();
        write!(self.to, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("it listens");
        self.to.flush().expect("it listens");
        loop {
            let message = self.next();
            match message["type"].as_str() {
                Some("response") => {
                    assert_eq!(
                        (&message["request_seq"], &message["command"]),
                        (&json!(self.requests), &json!(command))
                    );
                    return message;
                }
                Some("event") => self.events.push(message),
                _ => panic!("{message}"),
            }
        }
    }

    fn ask(&mut self, command: &str, arguments: Value) -> Value {
        let response = self.respond(command, arguments);
        assert_eq!(response["success"], true, "{response}");
        response["body"].clone()
    }

    /// The next event of a kind; those before it are passed over.
    fn event(&mut self, kind: &str) -> Value {
        loop {
            let message = if self.events.is_empty() { self.next() } else { self.events.remove(0) };
            if message["event"] == kind {
                return message["body"].clone();
            }
            assert_ne!(message["event"], "terminated", "the run has ended before `{kind}`");
        }
    }

    /// Goes on by a request; gives the reason to stop and the line.
    fn goes(&mut self, command: &str) -> (String, u64) {
        self.ask(command, json!({ "threadId": 1 }));
        self.stopped()
    }

    fn stopped(&mut self) -> (String, u64) {
        let stopped = self.event("stopped");
        let frames = self.ask("stackTrace", json!({ "threadId": stopped["threadId"] }));
        let line = frames["stackFrames"][0]["line"].as_u64().unwrap_or(0);
        (stopped["reason"].as_str().unwrap_or_default().to_string(), line)
    }

    fn evaluated(&mut self, form: &str) -> String {
        let body = self.ask("evaluate", json!({ "expression": form }));
        body["result"].as_str().unwrap_or_default().to_string()
    }

    fn end(mut self) {
        self.ask("disconnect", json!({}));
        drop(self.to);
        assert_eq!(self.child.wait().expect("it ends").code(), Some(0));
    }
}

fn at(plan: &str, line: u32) -> Value {
    json!({ "source": { "path": plan }, "breakpoints": [{ "line": line }] })
}

#[test]
fn a_run_stops_at_lines_and_steps_in_both_directions() {
    let (mut debugger, plan) = Debugger::at_plan("dap-steps");
    let set = debugger.ask("setBreakpoints", at(&plan, 5));
    assert_eq!((&set["breakpoints"][0]["verified"], &set["breakpoints"][0]["line"]), (&json!(true), &json!(5)));
    debugger.ask("configurationDone", json!({}));
    assert_eq!(debugger.stopped().0, "entry");
    assert_eq!(debugger.goes("continue"), ("breakpoint".into(), 5));
    assert_eq!((debugger.evaluated("i"), debugger.evaluated("(value cups)")), ("0".into(), "0".into()));
    assert_eq!(debugger.goes("continue"), ("breakpoint".into(), 5));
    assert_eq!((debugger.evaluated("i"), debugger.evaluated("(now)")), ("1".into(), "2.0".into()));
    let before = debugger.goes("stepBack");
    assert_eq!(before.0, "step");
    // Back over the line of this round, to that of the round before.
    assert_eq!(debugger.goes("reverseContinue").1, 5);
    assert_eq!(debugger.evaluated("(now)"), "1.0");
    assert_eq!(debugger.goes("reverseContinue").0, "entry");
    // What is gone over again is as it was.
    assert_eq!(debugger.goes("continue"), ("breakpoint".into(), 5));
    assert_eq!(debugger.evaluated("(now)"), "1.0");
    debugger.end();
}

#[test]
fn tasks_are_threads_with_calls_variables_fluents_and_valves() {
    let (mut debugger, plan) = Debugger::at_plan("dap-threads");
    debugger.ask("setBreakpoints", at(&plan, 5));
    debugger.ask("configurationDone", json!({}));
    debugger.event("stopped");
    debugger.ask("continue", json!({ "threadId": 1 }));
    let stopped = debugger.event("stopped");
    let threads = debugger.ask("threads", json!({}));
    let names: Vec<&str> =
        threads["threads"].as_array().into_iter().flatten().filter_map(|one| one["name"].as_str()).collect();
    assert_eq!(names.len(), 3, "{names:?}");
    assert!(names.iter().any(|name| name.contains("watch")), "{names:?}");
    let frames = debugger.ask("stackTrace", json!({ "threadId": stopped["threadId"] }));
    let frame = &frames["stackFrames"][0];
    assert_eq!((&frame["name"], &frame["source"]["name"]), (&json!("wash"), &json!("plan.rpl")));
    let scopes = debugger.ask("scopes", json!({ "frameId": frame["id"] }));
    let mut found = Vec::new();
    for scope in scopes["scopes"].as_array().into_iter().flatten() {
        let held = debugger.ask("variables", json!({ "variablesReference": scope["variablesReference"] }));
        for one in held["variables"].as_array().into_iter().flatten() {
            found.push(format!(
                "{}: {} = {}",
                scope["name"].as_str().unwrap_or(""),
                one["name"].as_str().unwrap_or(""),
                one["value"].as_str().unwrap_or("")
            ));
        }
    }
    for expected in ["Variables: number = 3", "Variables: i = 0", "Fluents: cups = 0"] {
        assert!(found.iter().any(|one| one == expected), "{expected}: {found:?}");
    }
    debugger.end();
}

#[test]
fn conditions_and_names_stop_a_run_too() {
    let (mut debugger, plan) = Debugger::at_plan("dap-conditions");
    let line = json!({ "source": { "path": plan }, "breakpoints": [{ "line": 5, "condition": "(= i 2)" }] });
    debugger.ask("setBreakpoints", line);
    let named = json!({ "breakpoints": [{ "name": "watch" }, { "name": "(= cups 1)" }, { "name": "wahs" }] });
    let set = debugger.ask("setFunctionBreakpoints", named);
    assert!(
        set["breakpoints"][2]["message"].as_str().is_some_and(|text| text.contains("did you mean `wash`?")),
        "{set}"
    );
    debugger.ask("configurationDone", json!({}));
    debugger.event("stopped");
    assert_eq!(debugger.goes("continue").0, "breakpoint", "the tag");
    assert_eq!(debugger.evaluated("(now)"), "0.0");
    assert_eq!(debugger.goes("continue").0, "breakpoint", "the condition over fluents");
    assert_eq!(debugger.evaluated("(value cups)"), "1");
    assert_eq!(debugger.goes("continue"), ("breakpoint".into(), 5));
    assert_eq!((debugger.evaluated("i"), debugger.evaluated("(now)")), ("2".into(), "3.0".into()));
    debugger.ask("setBreakpoints", json!({ "source": { "path": plan }, "breakpoints": [] }));
    debugger.ask("continue", json!({ "threadId": 1 }));
    assert_eq!(debugger.event("exited")["exitCode"], 0);
    debugger.end();
}

#[test]
fn a_failure_is_stopped_at_where_it_is_raised() {
    let folder = folder("dap-failure");
    let plan = put(
        &folder,
        "plan.rpl",
        "(def-plan pour (cup)\n  (wait-time 1)\n  (fail \"~a is broken\" cup))\n(pour 'cup-1)\n",
    );
    let mut debugger = Debugger::new();
    debugger.ask("launch", json!({ "program": plan }));
    debugger.ask("setExceptionBreakpoints", json!({ "filters": ["failure"] }));
    debugger.ask("configurationDone", json!({}));
    assert_eq!(debugger.stopped(), ("exception".into(), 3));
    assert_eq!(debugger.evaluated("cup"), "cup-1");
    debugger.end();
}

#[test]
fn what_a_plan_prints_is_told_and_how_it_ends() {
    let (mut debugger, _) = Debugger::at_plan("dap-output");
    debugger.ask("configurationDone", json!({}));
    debugger.event("stopped");
    debugger.ask("continue", json!({ "threadId": 1 }));
    assert_eq!(debugger.event("output")["output"], "two\n");
    assert_eq!(debugger.event("output")["output"], "done\n");
    assert_eq!(debugger.event("exited")["exitCode"], 0);
    debugger.event("terminated");
    debugger.end();
}

#[test]
fn what_cannot_be_done_is_answered_with_the_reason() {
    let mut debugger = Debugger::new();
    for (command, arguments, reason) in [
        ("threads", json!({}), "`launch` comes first"),
        ("launch", json!({ "program": "no-such.rpl" }), "there is no plan"),
        ("launch", json!({ "program": "delivery.rpl", "args": ["--wordl", "dept"] }), "--wordl"),
        ("launch", json!({}), "program"),
        ("moon", json!({}), "launch"),
    ] {
        let response = debugger.respond(command, arguments);
        let message = response["message"].as_str().unwrap_or_default();
        assert!(response["success"] == false && message.contains(reason), "{response}");
    }
    assert!(!Path::new("no-such.rpl").exists());
    debugger.end();
}

#[test]
fn a_run_without_an_end_can_be_paused() {
    let folder = folder("dap-pause");
    let plan =
        put(&folder, "plan.rpl", "(def-fluent n 0)\n(loop\n  (wait-time 1)\n  (setf (value n) (+ 1 (value n))))\n");
    let mut debugger = Debugger::new();
    debugger.ask("launch", json!({ "program": plan }));
    debugger.ask("configurationDone", json!({}));
    debugger.ask("pause", json!({ "threadId": 1 }));
    assert_eq!(debugger.stopped().0, "pause");
    debugger.ask("setBreakpoints", at(&plan, 4));
    assert_eq!(debugger.goes("continue"), ("breakpoint".into(), 4));
    debugger.end();
}

#[test]
fn what_is_no_request_is_told_and_the_conversation_goes_on() {
    let request = |seq: i64, command: &str| json!({ "seq": seq, "type": "request", "command": command });
    let mut bytes = b"hello\r\n\r\nContent-Length: 3\r\n\r\n{x}Content-Length: 99999999999\r\n\r\n".to_vec();
    bytes.extend(written(&[
        json!([]),
        json!({ "seq": 1, "type": "request" }),
        json!({ "seq": 1.5, "type": "request", "command": "initialize" }),
        // An answer asks nothing.
        json!({ "seq": 2, "type": "response", "command": "disconnect" }),
        request(3, "initialize"),
        request(4, "disconnect"),
    ]));
    let ended = feed(&mut rpl(&["dap"]), bytes);
    assert_eq!((ended.status, &*ended.errors), (0, ""));
    let messages = messages(ended.out.as_bytes());
    let kind = |message: &Value| (message["type"].clone(), message["request_seq"].clone(), message["success"].clone());
    let told = (json!("event"), Value::Null, Value::Null);
    let answered = |seq: i64, success: bool| (json!("response"), json!(seq), json!(success));
    let expected = [
        told.clone(),
        told.clone(),
        told.clone(),
        told.clone(),
        answered(1, false),
        told,
        answered(3, true),
        answered(4, true),
    ];
    assert_eq!(messages.iter().map(kind).collect::<Vec<_>>(), expected, "{messages:?}");
    assert!(messages[1]["body"]["output"].as_str().is_some_and(|text| text.contains("no JSON")), "{messages:?}");
}

#[test]
fn a_debugger_that_is_gone_or_breaks_off_is_told() {
    for (bytes, why) in [("", "the debugger is gone"), ("Content-Length: 10\r\n\r\n{}", "after 2 of 10 bytes")] {
        let ended = feed(&mut rpl(&["dap"]), bytes);
        assert_eq!(ended.status, 1);
        assert!(ended.errors.contains(why), "{}", ended.errors);
    }
}

#[test]
fn lines_frames_and_scopes_that_cannot_be_are_none() {
    let (mut debugger, plan) = Debugger::at_plan("dap-extremes");
    debugger.goes("configurationDone");
    for extreme in [i64::MIN, i64::MAX] {
        let asked = json!({ "source": { "path": plan }, "breakpoints": [{ "line": extreme }] });
        let set = debugger.ask("setBreakpoints", asked);
        assert_eq!(set["breakpoints"][0]["verified"], extreme == i64::MIN, "{set}");
        debugger.ask("scopes", json!({ "frameId": extreme }));
        assert_eq!(debugger.ask("variables", json!({ "variablesReference": extreme }))["variables"], json!([]));
        assert_eq!(debugger.ask("stackTrace", json!({ "threadId": extreme }))["totalFrames"], 0);
    }
    debugger.end();
}
