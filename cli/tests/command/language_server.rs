//! `rpl lsp` as an editor starts it: bytes on its streams, and how it ends. What it answers is tested in the crate of the
//! editor.

use crate::folder::{folder, put};
use crate::rpl::{Ended, feed, rpl, run};
use crate::wire::{messages, written};
use serde_json::{Value, json};
use std::fs;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

fn request(id: i32, method: &str, params: Value) -> Value {
    json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params })
}

fn notification(method: &str, params: Value) -> Value {
    json!({ "jsonrpc": "2.0", "method": method, "params": params })
}

/// A conversation, and what the server has said.
fn said(to_say: &[Value]) -> (Ended, Vec<Value>) {
    let ended = feed(&mut rpl(&["lsp", "--stdio"]), written(to_say));
    let messages = messages(ended.out.as_bytes());
    (ended, messages)
}

fn beginning() -> Vec<Value> {
    vec![request(1, "initialize", json!({ "capabilities": {} })), notification("initialized", json!({}))]
}

#[test]
fn it_ends_well_if_it_was_shut_down_first() {
    let mut whole = beginning();
    whole.extend([request(2, "shutdown", Value::Null), notification("exit", Value::Null)]);
    let (ended, messages) = said(&whole);
    assert_eq!(ended.status, 0, "{}", ended.errors);
    assert_eq!(messages[0]["result"]["capabilities"]["positionEncoding"], "utf-16");
    assert_eq!((&messages[1]["id"], &messages[1]["result"]), (&json!(2), &Value::Null));

    let mut hasty = beginning();
    hasty.push(notification("exit", Value::Null));
    let ended = said(&hasty).0;
    assert_eq!((ended.status, &*ended.errors), (1, "error: the editor said `exit` without `shutdown`\n"));
    let ended = said(&beginning()).0;
    assert_eq!(ended.status, 1);
    assert!(ended.errors.starts_with("error: the editor is gone"), "{}", ended.errors);
    assert_eq!(run(&["lsp", "--port", "1"]).status, 2);
}

#[test]
fn the_project_says_which_world_and_files_are_meant() {
    let folder = folder("language-server");
    put(&folder, "rpl.toml", "world = \"test-room\"\n");
    put(&folder, "part.rpl", "(defun part (place) (go-to place))\n");
    let plan = put(&folder, "plan.rpl", "");
    let uri = format!("file://{plan}");
    let text = "(load \"part.rpl\")\n(part 'table-side)\n(go-to 'mail-slots)\n";
    let mut whole = beginning();
    let at = |line: u32, character: u32| json!({ "textDocument": { "uri": uri }, "position": { "line": line, "character": character } });
    whole.extend([
        notification("textDocument/didOpen", json!({ "textDocument": { "uri": uri, "languageId": "rpl", "version": 1, "text": text } })),
        request(2, "textDocument/definition", at(1, 2)),
        request(3, "textDocument/completion", at(2, 9)),
        request(4, "textDocument/codeAction", json!({ "textDocument": { "uri": uri }, "range": { "start": at(2, 9)["position"], "end": at(2, 9)["position"] }, "context": { "diagnostics": [] } })),
        request(5, "shutdown", Value::Null),
        notification("exit", Value::Null),
    ]);
    let (ended, messages) = said(&whole);
    assert_eq!(ended.status, 0, "{}", ended.errors);
    let answer =
        |id: i32| messages.iter().find(|one| one["id"] == id).map(|one| one["result"].clone()).unwrap_or_default();
    assert!(answer(2)["uri"].as_str().is_some_and(|uri| uri.ends_with("/part.rpl")), "{messages:?}");
    let items = answer(3)["items"].clone();
    let offered: Vec<&str> = items.as_array().into_iter().flatten().filter_map(|item| item["label"].as_str()).collect();
    assert!(offered.contains(&"table-side") && !offered.contains(&"wolframs-shelf"), "{offered:?}");
    // The world of the project has no such place, and that is told.
    let actions = answer(4);
    let code = &actions[0]["diagnostics"][0]["code"];
    assert_eq!(code, "unknown-place", "{actions}");
}

/// A conversation in which files change.
struct Editor(Child);

impl Editor {
    fn begin(command: &mut Command) -> Self {
        let child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("it starts");
        let mut editor = Self(child);
        editor.say(&beginning());
        editor.hear(|message| message["id"] == 1);
        editor
    }

    fn say(&mut self, messages: &[Value]) {
        let to = self.0.stdin.as_mut().expect("it hears");
        to.write_all(&written(messages)).and_then(|()| to.flush()).expect("it hears");
    }

    /// The next message of a kind.
    fn hear(&mut self, is_wanted: impl Fn(&Value) -> bool) -> Value {
        let from = self.0.stdout.as_mut().expect("it speaks");
        loop {
            let mut bytes = Vec::new();
            while !bytes.ends_with(b"\r\n\r\n") {
                let mut byte = [0];
                from.read_exact(&mut byte).expect("it speaks");
                bytes.extend(byte);
            }
            let header = String::from_utf8(bytes.clone()).expect("the header is text");
            let length = header.trim().strip_prefix("Content-Length: ").and_then(|length| length.parse().ok());
            let mut body = vec![0; length.expect("it has a length")];
            from.read_exact(&mut body).expect("it speaks");
            let message = messages(&[bytes, body].concat()).remove(0);
            if is_wanted(&message) {
                return message;
            }
        }
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        self.say(&[request(7, method, params)]);
        self.hear(|message| message["id"] == 7)["result"].clone()
    }

    fn open(&mut self, uri: &str, text: &str) {
        let document = json!({ "uri": uri, "languageId": "rpl", "version": 1, "text": text });
        self.say(&[notification("textDocument/didOpen", json!({ "textDocument": document }))]);
    }

    /// How many findings the next message about a text has.
    fn findings(&mut self, uri: &str) -> usize {
        let told = self
            .hear(|message| message["method"] == "textDocument/publishDiagnostics" && message["params"]["uri"] == uri);
        told["params"]["diagnostics"].as_array().map_or(0, Vec::len)
    }

    fn end(mut self) {
        self.say(&[request(8, "shutdown", Value::Null), notification("exit", Value::Null)]);
        assert!(self.0.wait().expect("it ends").success());
    }
}

#[test]
fn a_plan_that_is_saved_says_anew_which_texts_are_scenarios() {
    let folder = folder("language-server-roles");
    put(&folder, "rpl.toml", "world = \"test-room\"\n");
    let tests = put(&folder, "tests.rpl", "(deftest a (print 1))\n");
    let text = "(rotate-robot! 90deg)\n";
    let scenario = format!("file://{}", put(&folder, "turn.rpl", text));
    let changed = |file: &str| {
        let changes = json!([{ "uri": format!("file://{file}"), "type": 2 }]);
        [notification("workspace/didChangeWatchedFiles", json!({ "changes": changes }))]
    };
    let mut editor = Editor::begin(&mut rpl(&["lsp"]));
    editor.open(&scenario, text);
    assert_eq!(editor.findings(&scenario), 1, "plans cannot turn the robot");
    put(&folder, "tests.rpl", "(deftest a :scenario \"turn.rpl\" (print 1))\n");
    editor.say(&changed(&tests));
    assert_eq!(editor.findings(&scenario), 0);
    put(&folder, "tests.rpl", "(deftest a (print 1))\n");
    editor.say(&changed(&tests));
    assert_eq!(editor.findings(&scenario), 1);
    let project = put(&folder, "rpl.toml", "scenarios = [\"turn.rpl\"]\n");
    editor.say(&changed(&project));
    assert_eq!(editor.findings(&scenario), 0);
    // What is hidden is none of the project's.
    fs::create_dir(folder.join(".old")).expect("it can be made");
    put(&folder, "rpl.toml", "");
    editor.say(&changed(&project));
    assert_eq!(editor.findings(&scenario), 1);
    let hidden = put(&folder, ".old/tests.rpl", "(deftest a :scenario \"../turn.rpl\" (print 1))\n");
    editor.say(&changed(&hidden));
    let lenses = editor.ask("textDocument/codeLens", json!({ "textDocument": { "uri": scenario } }));
    assert_eq!(lenses, json!([]), "it is a plan still, and the editor has no commands");
    editor.end();
}

#[test]
fn plans_of_a_module_are_looked_at_as_that() {
    let folder = folder("language-server-module");
    put(&folder, "rpl.toml", "modules = [\"nose.toml\"]\n");
    let manifest = "name = \"nose\"\ndoc = \"It smells.\"\ncommand = [\"true\"]\nplans = \"nose.rpl\"\n\
                    [[fluent]]\nname = \"gas*\"\ndoc = \"Gas.\"\ntype = \"number\"\n";
    put(&folder, "nose.toml", manifest);
    let text = "(def-plan sniff-room (seconds) (wait-time seconds))\n";
    let plans = format!("file://{}", put(&folder, "nose.rpl", text));
    let plan = format!("file://{}", put(&folder, "plan.rpl", ""));
    let mut editor = Editor::begin(&mut rpl(&["lsp"]));
    editor.open(&plans, text);
    assert_eq!(editor.findings(&plans), 0);
    editor.open(&plan, "(sniff-room 3)\n");
    assert_eq!(editor.findings(&plan), 0);
    let at = json!({ "textDocument": { "uri": plan }, "position": { "line": 0, "character": 2 } });
    let defined = editor.ask("textDocument/definition", at);
    assert_eq!(defined["uri"], plans, "its plans have a file");
    assert_eq!(defined["range"]["start"], json!({ "line": 0, "character": 10 }));
    editor.end();
}

#[test]
fn a_name_of_the_library_leads_to_a_file_that_is_never_written_over() {
    let folder = folder("language-server-library");
    let uri = format!("file://{}", put(&folder, "plan.rpl", ""));
    let definition = || {
        let mut editor = Editor::begin(rpl(&["lsp"]).env("XDG_CACHE_HOME", &folder));
        editor.open(&uri, "(dolist (x '(1)) (print x))\n");
        let at = json!({ "textDocument": { "uri": uri }, "position": { "line": 0, "character": 2 } });
        let place = editor.ask("textDocument/definition", at);
        editor.end();
        let file = place["uri"].as_str().and_then(|uri| uri.strip_prefix("file://")).expect("it is a file").to_string();
        (PathBuf::from(file), place["range"]["start"]["line"].as_u64().expect("a line") as usize)
    };
    let (file, line) = definition();
    assert!(file.starts_with(folder.join("rpl")) && file.ends_with("prelude.rpl"), "{}", file.to_string_lossy());
    let text = fs::read_to_string(&file).expect("it is there");
    assert!(text.split('\n').nth(line).is_some_and(|line| line.starts_with("(defmacro dolist ")), "{line}");
    assert!(file.metadata().expect("it is there").permissions().readonly());
    assert_eq!(definition(), (file.clone(), line), "the same file");
    // One that somebody has changed stays as it is.
    fs::remove_file(&file).expect("it can be removed");
    fs::write(&file, "mine\n").expect("it can be written");
    let (other, _) = definition();
    assert!(other.ends_with("prelude-2.rpl"), "{}", other.to_string_lossy());
    assert_eq!(fs::read_to_string(&other).expect("it is there"), text);
    assert_eq!(fs::read_to_string(&file).expect("it is there"), "mine\n");
}

#[test]
fn bytes_that_are_no_message_are_answered_and_a_message_that_breaks_off_is_told() {
    let mut bytes = written(&beginning());
    bytes.extend(b"Content-Length: 9\r\n\r\n{\"id\":2,}");
    bytes.extend(written(&[request(3, "shutdown", Value::Null), notification("exit", Value::Null)]));
    let ended = feed(&mut rpl(&["lsp"]), bytes);
    assert_eq!((ended.status, &*ended.errors), (0, ""));
    let messages = messages(ended.out.as_bytes());
    assert_eq!((&messages[1]["id"], &messages[1]["error"]["code"]), (&Value::Null, &json!(-32700)));
    assert_eq!(messages[2]["id"], 3);

    let ended = feed(&mut rpl(&["lsp"]), "Content-Length: 10\r\n\r\n{}");
    assert_eq!(ended.status, 1);
    assert!(ended.errors.contains("after 2 of 10 bytes of a message"), "{}", ended.errors);
}
