//! What reaches beyond the text: the library's own texts, the other plans of the folders, what can be run.

use crate::client::{Client, FILE, Files, range};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// An editor that asks servers for texts.
fn asking(files: &Files) -> (Client<'_>, Value) {
    let can = json!({ "workspace": { "textDocumentContent": { "dynamicRegistration": false } } });
    Client::saying(files, json!({ "capabilities": can }))
}

/// The text that a place is in and begins with.
fn led_to<'t>(text: &'t str, place: &Value) -> &'t str {
    let line = place["range"]["start"]["line"].as_u64().expect("a line") as usize;
    let column = place["range"]["start"]["character"].as_u64().expect("a column") as usize;
    &text.split('\n').nth(line).expect("there is such a line")[column..]
}

#[test]
fn names_of_the_library_lead_into_its_texts() {
    let files = Files::default();
    let (mut client, said) = asking(&files);
    assert_eq!(said["capabilities"]["workspace"]["textDocumentContent"]["schemes"], json!(["rpl"]));
    let text = "(go-to 'mail-slots)\n(dolist (x '(1)) (print x))\n(library:n-times 3 (reduce #'max '(1 2)))\n(let ((go-to 1)) go-to)\n'go-to\n";
    client.open_at(FILE, text);
    let mut to = |line: u32, character: u32| {
        let at = json!({ "position": { "line": line, "character": character } });
        client.ask("textDocument/definition", at).expect("it is answered")
    };
    let (plan, construct, qualified, function) = (to(0, 2), to(1, 3), to(2, 12), to(2, 24));
    assert!(to(1, 18).is_null(), "a native function has no text");
    assert_eq!(to(3, 18)["uri"], FILE, "a variable hides it");
    assert!(to(4, 3).is_null(), "it is a symbol");
    for (place, uri, name) in [
        (plan, "rpl:/robot.rpl", "go-to"),
        (construct, "rpl:/prelude.rpl", "dolist"),
        (qualified, "rpl:/prelude.rpl", "n-times"),
        (function, "rpl:/prelude.rpl", "reduce"),
    ] {
        assert_eq!(place["uri"], uri, "{name}");
        let read = client.request("workspace/textDocumentContent", json!({ "uri": uri })).expect("it is there");
        let text = read["text"].as_str().expect("a text");
        assert!(led_to(text, &place).starts_with(&format!("{name} (")), "{name}: {}", led_to(text, &place));
    }
    let none = client.request("workspace/textDocumentContent", json!({ "uri": "rpl:/moon.rpl" }));
    assert!(none.is_err_and(|why| why.contains("no text `rpl:/moon.rpl`")));
}

#[test]
fn an_editor_that_asks_for_no_texts_is_led_to_files() {
    let files = Files::default();
    let mut client = Client::with(&files, "(|unless nil (print 1))\n");
    let place = client.at_mark("textDocument/definition", json!({})).expect("it is answered");
    assert_eq!(place["uri"], "file:///library/prelude.rpl");
    let (_, said) = Client::saying(&files, json!({ "capabilities": {} }));
    assert_eq!(said["capabilities"]["workspace"]["textDocumentContent"], Value::Null);
}

#[test]
fn a_text_of_the_library_is_read_and_nothing_else() {
    let files = Files::default();
    let (mut client, _) = asking(&files);
    let read = |client: &mut Client<'_>| {
        client.request("workspace/textDocumentContent", json!({ "uri": "rpl:/robot.rpl" })).expect("it is there")
    };
    let text = read(&mut client)["text"].as_str().expect("a text").to_string();
    for uri in ["rpl:/robot.rpl", "file:///library/robot.rpl"] {
        client.open_at(uri, &text);
        assert!(client.looked().is_empty(), "it has no findings");
        let of_text = |more: Value| {
            let mut params = json!({ "textDocument": { "uri": uri } });
            params.as_object_mut().expect("it is an object").extend(more.as_object().expect("one as well").clone());
            params
        };
        let symbols = client.request("textDocument/documentSymbol", of_text(json!({}))).expect("it is answered");
        let go_to = symbols.as_array().expect("a list").iter().find(|one| one["name"] == "go-to");
        let place = go_to.expect("it is in the outline")["selectionRange"]["start"].clone();
        let hover =
            client.request("textDocument/hover", of_text(json!({ "position": place }))).expect("it is answered");
        assert!(hover["contents"]["value"].as_str().is_some_and(|said| said.contains("(go-to ")), "{hover}");
        let renamed =
            client.request("textDocument/rename", of_text(json!({ "position": place, "newName": "drive-to" })));
        assert!(renamed.is_err_and(|why| why.contains("a text of the library")));
        let everywhere = json!({ "range": range((0, 0), (999, 0)), "context": { "diagnostics": [] } });
        let actions = client.request("textDocument/codeAction", of_text(everywhere)).expect("it is answered");
        assert!(actions.is_null());
    }
}

const PROJECT: [(&str, &str); 3] = [
    ("inspect.rpl", "(def-plan inspect-if-open (place) (go-to place))\n(def-fluent inspected nil)\n"),
    ("night.rpl", "; ä\n(defmacro twice (form) `(progn ,form ,form))\n(def-goal (achieve (room-is-warm room)) 1)\n"),
    ("typed.rpl", "(def-plan unfinished (x)\n  (print \"\n"),
];

/// An editor with the folder of the project open.
fn in_folder(files: &Files) -> Client<'_> {
    let folders = json!([{ "uri": "file:///plans", "name": "plans" }]);
    Client::saying(files, json!({ "capabilities": {}, "workspaceFolders": folders })).0
}

fn found(client: &mut Client<'_>, query: &str) -> Vec<(String, String, Value)> {
    let all = client.request("workspace/symbol", json!({ "query": query })).expect("it is answered");
    let text = |value: &Value| value.as_str().unwrap_or_default().to_string();
    let one = |one: &Value| (text(&one["name"]), text(&one["containerName"]), one["location"]["range"].clone());
    all.as_array().expect("a list").iter().map(one).collect()
}

fn names(client: &mut Client<'_>, query: &str) -> Vec<String> {
    found(client, query).into_iter().map(|(name, _, _)| name).collect()
}

#[test]
fn the_definitions_of_the_folders_are_found_by_a_part_of_their_names() {
    let files = Files(PROJECT.into());
    let mut client = in_folder(&files);
    assert_eq!(found(&mut client, "TWI"), [("twice".into(), "night.rpl".into(), range((1, 10), (1, 15)))]);
    assert_eq!(names(&mut client, "inspect"), ["inspect-if-open", "inspected"]);
    assert_eq!(names(&mut client, "iifo"), ["inspect-if-open"]);
    assert_eq!(names(&mut client, "warm"), ["(achieve (room-is-warm room))"]);
    assert_eq!(names(&mut client, "unfin"), ["unfinished"], "it cannot be read yet");
    assert_eq!(names(&mut client, "moon"), [""; 0]);
    assert_eq!(names(&mut client, "").len(), 5);
    assert_eq!(client.session.reads, 3, "each file was read once");
}

#[test]
fn an_open_text_is_searched_as_it_is() {
    let files = Files(PROJECT.into());
    let mut client = in_folder(&files);
    let uri = "file:///plans/inspect.rpl";
    client.open_at(uri, "(def-plan look-at (place) (go-to place))\n");
    assert_eq!(names(&mut client, "inspect"), [""; 0]);
    assert_eq!(names(&mut client, "look"), ["look-at"]);
    client.notify("textDocument/didClose", json!({ "textDocument": { "uri": uri } }));
    assert_eq!(names(&mut client, "inspect").len(), 2);
}

#[test]
fn folders_come_and_go_and_without_any_those_of_the_texts_count() {
    let files = Files(PROJECT.into());
    let mut client = in_folder(&files);
    let folder = |uri: &str| json!([{ "uri": uri, "name": "x" }]);
    let event = json!({ "added": folder("file:///elsewhere"), "removed": folder("file:///plans") });
    client.notify("workspace/didChangeWorkspaceFolders", json!({ "event": event }));
    assert_eq!(names(&mut client, ""), [""; 0]);

    let mut client = Client::new(&files);
    assert_eq!(names(&mut client, ""), [""; 0]);
    client.open_at("untitled:Untitled-1", "(defun nowhere () 1)\n");
    client.open_at("file:///plans/new.rpl", "(defun fresh () 1)\n");
    assert_eq!(names(&mut client, "").len(), 6);
    client.open_at("file:///library/robot.rpl", "(def-plan go-to (place) 1)\n");
    assert_eq!(names(&mut client, "go-to"), [""; 0], "the library is no part of the project");
    let (mut client, _) = Client::saying(&files, json!({ "capabilities": {}, "rootUri": "file:///plans" }));
    assert_eq!(names(&mut client, "").len(), 5);
}

#[test]
fn no_more_names_are_told_than_somebody_reads() {
    let text: &'static str = (0..2_000).map(|at| format!("(defvar v{at} 1)\n")).collect::<String>().leak();
    let files = Files([("many.rpl", text)].into());
    let mut client = in_folder(&files);
    assert_eq!(names(&mut client, "v").len(), 400);
    assert_eq!(names(&mut client, "v1999"), ["v1999"]);
}

#[test]
fn of_very_many_files_the_last_are_read_when_nobody_waits() {
    let files: BTreeMap<&'static str, &'static str> =
        (0..2_500).map(|at| (&*format!("p{at:04}.rpl").leak(), &*format!("(defvar v{at} 1)\n").leak())).collect();
    let files = Files(files);
    let mut client = in_folder(&files);
    assert_eq!(names(&mut client, "v999"), ["v999"]);
    assert_eq!(names(&mut client, "v1999"), ["v1999"], "the second time others are read");
    assert_eq!((names(&mut client, "v2499").len(), client.session.reads), (1, 2_500));
    let mut client = in_folder(&files);
    names(&mut client, "v");
    assert_eq!(client.session.reads, 1_000);
    assert_eq!(client.session.waits(), Some(false));
    client.looked();
    assert_eq!((client.session.waits(), client.session.reads), (None, 2_500));
}

const RUN: &str = "(def-plan go () 1)\n(go)\n\n(deftest it-goes\n  (assert (= 1 (go))))\n(deftest it-goes-on (go))\n";

fn lenses(files: &Files, commands: Value, uri: &str, text: &str) -> Value {
    let options = json!({ "commands": commands });
    let (mut client, said) = Client::saying(files, json!({ "capabilities": {}, "initializationOptions": options }));
    let has_some = commands.as_array().is_some_and(|all| !all.is_empty());
    assert_eq!(!said["capabilities"]["codeLensProvider"].is_null(), has_some);
    client.open_at(uri, text);
    client.request("textDocument/codeLens", json!({ "textDocument": { "uri": uri } })).expect("it is answered")
}

#[test]
fn a_plan_and_its_tests_can_be_run_by_an_editor_that_can() {
    let files = Files::default();
    let told = |lenses: Value| -> Vec<(u64, String, Value)> {
        let one = |one: &Value| {
            let command = &one["command"];
            let line = one["range"]["start"]["line"].as_u64().expect("a line");
            (line, command["command"].as_str().expect("a name").to_string(), command["arguments"].clone())
        };
        lenses.as_array().expect("a list").iter().map(one).collect()
    };
    let file = "/plans/plan.rpl";
    let run = (0, "rpl.run".to_string(), json!([file]));
    let tests = [
        (3, "rpl.test".to_string(), json!([file, "it-goes"])),
        (5, "rpl.test".to_string(), json!([file, "it-goes-on"])),
    ];
    let both = json!(["rpl.run", "rpl.test"]);
    assert_eq!(told(lenses(&files, both.clone(), FILE, RUN)), [&[run.clone()][..], &tests].concat());
    assert_eq!(told(lenses(&files, json!(["rpl.run"]), FILE, RUN)), [run]);
    assert_eq!(told(lenses(&files, json!(["rpl.test"]), FILE, RUN)), tests);
    assert_eq!(told(lenses(&files, both.clone(), FILE, "(def-plan go () 1)\n")), [], "nothing in it runs");
    assert!(lenses(&files, both.clone(), "untitled:Untitled-1", RUN).is_null(), "it has no file");
    assert!(lenses(&files, both, "file:///library/robot.rpl", RUN).is_null(), "it is of the library");
    assert_eq!(told(lenses(&files, json!([]), FILE, RUN)), []);
}

fn hints(text: &str) -> Vec<(u64, u64, String)> {
    let files = Files::default();
    let mut client = Client::reading(&files, text);
    let hints = client.ask("textDocument/inlayHint", json!({ "range": range((0, 0), (99, 0)) })).expect("an answer");
    let one = |one: &Value| {
        let place = &one["position"];
        let (line, column) = (place["line"].as_u64().unwrap_or(99), place["character"].as_u64().unwrap_or(99));
        (line, column, one["label"].as_str().unwrap_or_default().to_string())
    };
    hints.as_array().expect("a list").iter().map(one).collect()
}

#[test]
fn literals_in_calls_have_the_names_of_their_parameters() {
    let text = "(def-plan wait-at (place seconds &optional (times 1) &key loud) (list place seconds times loud))
(wait-at 'dock 5 :loud t)
(wait-at \"place\" 2min 3)
(wait-at (first '(1)) (+ 1 2) nil)
(wait-at 'x 'y)
";
    let expected = [(1, 15, "seconds:"), (2, 17, "seconds:"), (2, 22, "times:"), (3, 30, "times:")];
    assert_eq!(hints(text), expected.map(|(line, column, name)| (line, column, name.to_string())));
    // Plans of the library and behaviours, too.
    assert_eq!(hints("(charge 'dock 0.9)\n"), [(0, 14, "level:".to_string())]);
}

#[test]
fn what_is_no_call_of_a_plan_has_no_hints() {
    for text in [
        "(+ 1 2)",
        "(list 1 2 3)",
        "(max 1 2)",
        "(if t 1 2)",
        "(wait-time 3)",
        "(defun f (a) a)\n'(f 1)",
        "(defun f (a) a)\n(let ((f 1)) f)",
        "(defun f (a) a)\n(case 1 (f 2))",
        "(defun f (&rest all) all)\n(f 1 2)",
        "(defun f (&key a) a)\n(f :a 1)",
        "(defun f (a) a)\n(f",
        "(nowhere 1)",
        "(def-plan f (a) 1)\n(def-plan g (x) (flet ((f (b) b)) (f 1)))",
    ] {
        assert_eq!(hints(text), [], "{text}");
    }
}

#[test]
fn only_the_lines_that_are_seen_have_hints() {
    let files = Files::default();
    let mut client = Client::reading(&files, &format!("(defun f (a) a)\n{}", "(f 1)\n".repeat(50)));
    let seen = json!({ "range": range((10, 0), (19, 5)) });
    let hints = client.ask("textDocument/inlayHint", seen).expect("it is answered");
    assert_eq!(hints.as_array().map(Vec::len), Some(10));
}

#[test]
fn an_editor_that_can_is_asked_to_watch_the_files() {
    let files = Files::default();
    assert!(Client::new(&files).asked.is_empty());
    let can = json!({ "workspace": { "didChangeWatchedFiles": { "dynamicRegistration": true } } });
    let (client, _) = Client::saying(&files, json!({ "capabilities": can }));
    let [asked] = client.asked.as_slice() else { panic!("{:?}", client.asked) };
    assert_eq!(asked.method, "client/registerCapability");
    let registration = &asked.params["registrations"][0];
    assert_eq!(registration["method"], "workspace/didChangeWatchedFiles");
    assert_eq!(registration["registerOptions"]["watchers"][0]["globPattern"], "**/*.{rpl,toml}");
}
