//! `rpl lsp` as an editor starts it: bytes on its streams, and how it ends. What it answers is tested in the crate of the
//! editor.

use crate::folder::{folder, put};
use crate::rpl::{Ended, feed, rpl, run};
use crate::wire::{messages, written};
use serde_json::{Value, json};

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
