//! Whatever a module does wrong: what was under way fails with what it did, and so does what is started
//! later; nothing hangs.

use crate::module::{Played, play, reason};
use rpl_protocol::module::process_module::News;
use rpl_runtime::robot::{Ending, StopReason};

/// Patience for what never comes; everything else comes at once, and is waited for longer.
const SOON: &str = "answer_within = \"80ms\"\nstart_within = \"80ms\"";

/// What it does instead of greeting, and what is said of it.
const REFUSED: &[(&str, &str)] = &[
    (
        "death-before-hello",
        "ended with exit status 3; the last it wrote to standard error:\n  faulty: death-before-hello",
    ),
    (
        "child-before-hello",
        "ended with exit status 3, while a process that it had started still has its standard output; the last it wrote to standard error:\n  faulty: child-before-hello",
    ),
    (
        "background-before-hello",
        "ended with exit status 0, while a process that it had started still has its standard output",
    ),
    ("no-hello", "did not answer `hello` within 80ms; the last it wrote to standard error:\n  loading a large model"),
    ("not-hello-first", "did not say `hello` first"),
    ("text-before-hello", "said something that is no JSON: expected value at line 1 column 1: Loading weights..."),
    (
        "wrong-version",
        "speaks version 1 of the protocol, and rpl speaks version 2; a module in Python needs `rpl_module` of this rpl, and any other one says `\"protocol\":2` and answers `query`, if its manifest has a [[query]]",
    ),
    ("wrong-name", "calls itself `lamp`, which is not its name in the manifest"),
    ("floods-before-hello", "said a wrong message: missing field `type` at line 1 column 2: {}"),
];

/// What it does while `sweep` is at work, and the reason of the failure.
const LOST: &[(&str, &str)] = &[
    (
        "death-after-hello",
        "ended with exit status 3; the last it wrote to standard error:\n  faulty: death-after-hello",
    ),
    ("hello-twice", "said `hello` again"),
    ("done-without-tick", "said `done` for the tick at 0 us, and was asked at 50000 us"),
    ("closes-output", "closed its standard output"),
    ("closes-input", "did not answer the tick at 50000 us within 80ms"),
    ("death-at-start", "ended with exit status 3; the last it wrote to standard error:\n  faulty: death-at-start"),
    ("death-at-tick", "ended with exit status 3; the last it wrote to standard error:\n  faulty: death-at-tick"),
    ("death-while-idle", "ended with exit status 3; the last it wrote to standard error:\n  faulty: death-while-idle"),
    ("killed", "was ended by signal 9"),
    (
        "child-at-tick",
        "ended with exit status 3, while a process that it had started still has its standard output; the last it wrote to standard error:\n  faulty: child-at-tick",
    ),
    ("child-and-killed", "was ended by signal 9, while a process that it had started still has its standard output"),
    (
        "child-and-half-a-line",
        "ended with exit status 3, while a process that it had started still has its standard output in the middle of a line: {\"type\":\"flue",
    ),
    (
        "half-a-line",
        "ended with exit status 3 in the middle of a line: {\"type\":\"flue; the last it wrote to standard error:\n  faulty: half-a-line",
    ),
    ("half-a-line-and-alive", "did not answer the tick at 100000 us within 80ms"),
    ("long-line", "said a line of more than 1 MiB"),
    ("not-utf-8", "said something that is not UTF-8 (at byte 9)"),
    (
        "not-json",
        "said something that is no JSON: expected value at line 1 column 1: Traceback (most recent call last):",
    ),
    ("empty-line", "said something that is no JSON: EOF while parsing a value at line 1 column 0: "),
    ("not-an-object", "said something that is no message, which is an object with a `type`: [1,2]"),
    (
        "unknown-type",
        "said a wrong message: unknown variant `succes`, expected one of `hello`, `fluents`, `success`, `failure`, `event`, `done` at line 1 column 16: {\"type\":\"succes\",\"id\":1}",
    ),
    ("no-type", "said a wrong message: missing field `type` at line 1 column 8: {\"id\":1}"),
    ("missing-field", "said a wrong message: missing field `id`: {\"type\":\"success\"}"),
    (
        "unknown-field",
        "said a wrong message: unknown field `result`, expected `id` or `value`: {\"type\":\"success\",\"id\":1,\"result\":2}",
    ),
    (
        "wrong-type",
        "said a wrong message: invalid type: string \"one\", expected u64: {\"type\":\"success\",\"id\":\"one\"}",
    ),
    (
        "negative-id",
        "said a wrong message: invalid value: integer `-1`, expected u64: {\"type\":\"success\",\"id\":-1}",
    ),
    ("unknown-fluent", "set the fluent `lihgt*`, which its manifest does not have; did it mean `light*`?"),
    ("wrong-value", "set `light*` to \"bright\", and its manifest says: number"),
    (
        "object-value",
        "said a wrong message: an object is a value only as {\"symbol\": \"name\"}: {\"type\":\"fluents\",\"values\":{\"light*\":{\"lux\":3}}}",
    ),
    ("fraction", "set `cups*` to 1.5, and its manifest says: integer"),
    ("beyond-64-bits", "set `cups*` to 9.223372036854776e+18, and its manifest says: integer"),
    (
        "nan",
        "said something that is no JSON: expected value at line 1 column 38: {\"type\":\"fluents\",\"values\":{\"light*\":NaN}}",
    ),
    ("infinite", "said something that is no JSON: "),
    ("huge-number", "said something that is no JSON: number out of range at line 1 column 42: "),
    ("deep-list", "said a wrong message: lists of a robot are nested at most 64 deep, and this one is nested deeper: "),
    ("deeper-list", "said something that is no JSON: recursion limit exceeded at line 1 column 162: "),
    ("odd-symbol", "said a wrong message: \"two words\" is no name of a symbol: "),
    ("unknown-id", "ended the activation 7, which there is not"),
    ("success-twice", "ended the activation 1 of `sweep` twice"),
    ("failure-after-success", "ended the activation 1 of `sweep` twice"),
    ("odd-class", "said a failure with \"no cup\", which is no name"),
    ("done-twice", "said `done` for the tick at 100000 us, which it had answered"),
    ("done-for-later", "said `done` for the tick at 999999999 us, and it is 100000 us"),
    ("never-done", "did not answer the tick at 100000 us within 80ms"),
    ("floods", "said more than 1000 messages or 8 MiB in one turn"),
    (
        "floods-errors",
        "did not answer the tick at 100000 us within 80ms; the last it wrote to standard error:\n  warning: something is wrong",
    ),
    ("hello-again", "said `hello` again"),
];

/// Those that are recognised because nothing comes.
fn is_silent(mode: &str) -> bool {
    ["no-hello", "closes-input", "half-a-line-and-alive", "never-done", "floods-errors"].contains(&mode)
}

fn patience(mode: &str) -> &'static str {
    if is_silent(mode) { SOON } else { "answer_within = \"60s\"\nstart_within = \"60s\"" }
}

#[test]
fn a_module_that_does_not_greet_is_refused_with_what_it_did() {
    for (mode, why) in REFUSED {
        let Err(error) = play(mode, patience(mode)) else { panic!("{mode} was greeted") };
        let told = error.to_string();
        assert_eq!(told.strip_prefix("the module `faulty` (faulty.toml) "), Some(*why), "{mode}");
    }
}

/// Steps with `sweep` at work until it fails.
fn failing(played: &mut Played, mode: &str) -> String {
    if let Some(ending) = played.start() {
        return reason(&ending).to_string();
    }
    for _ in 0..3 {
        let news = played.step();
        if let Some((behaviour, ending)) = news.endings.last() {
            assert_eq!(*behaviour, 0, "{mode}");
            if matches!(ending, Ending::Success(_)) {
                let lost = news.events.last().unwrap_or_else(|| panic!("{mode}: it has ended once, and is lost"));
                return lost.details[1].1.clone();
            }
            return reason(ending).to_string();
        }
    }
    panic!("{mode}: nothing failed")
}

#[test]
fn whatever_a_module_does_wrong_fails_what_it_was_doing() {
    let starts_before = ["death-after-hello", "hello-twice", "done-without-tick", "closes-output", "closes-input"];
    let mut faults = Vec::new();
    for (mode, why) in LOST {
        let mut played = play(mode, patience(mode)).unwrap_or_else(|error| panic!("{mode}: {error}"));
        if !starts_before.contains(mode) {
            assert_eq!(played.step(), News::default(), "{mode}");
        }
        let found = failing(&mut played, mode);
        if !found.starts_with(why) {
            faults.push(format!("{mode}: {found}"));
        }
        let again = played.start().unwrap_or_else(|| panic!("{mode}: it is lost"));
        assert_eq!(reason(&again), found, "{mode}");
        assert_eq!(played.step().endings, [], "{mode}");
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn one_that_dies_while_it_stops_is_lost_at_the_next_step() {
    let mut played = play("death-at-stop", patience("death-at-stop")).expect("it greets");
    assert_eq!(played.start(), None);
    played.step();
    played.module.stop(0, StopReason::Deactivated);
    let news = played.step();
    assert_eq!((news.endings, news.events.len()), (vec![], 1), "nothing of it was at work any more");
    assert_eq!(news.events[0].what, "module lost");
    let why = reason(&played.start().expect("it is lost")).to_string();
    assert!(why.contains("exit status 3") && why.contains("faulty: death-at-stop"), "{why}");
}
