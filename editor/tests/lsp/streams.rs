//! Bytes in, bytes out: what is no message is answered as JSON-RPC says, and the conversation goes on.

use crate::client::{FILE, Files};
use rpl_editor::frames::Frames;
use rpl_editor::lsp::{Ending, serve};
use serde_json::{Value, json};
use std::io::{self, Cursor};

fn written(body: &str) -> Vec<u8> {
    format!("Content-Length: {}\r\n\r\n{body}", body.len()).into_bytes()
}

/// A conversation of bytes: how it ends, and what the server has said.
fn said(pieces: &[Vec<u8>]) -> (io::Result<Ending>, Vec<Value>) {
    let mut out = Vec::new();
    let ending = serve(&Files::default(), Cursor::new(pieces.concat()), &mut out);
    let mut frames = Frames::new(out.as_slice());
    let mut said = Vec::new();
    while let Some(message) = frames.read().expect("it is whole") {
        said.push(message.expect("it is a message"));
    }
    (ending, said)
}

fn beginning() -> Vec<u8> {
    written(&json!({ "jsonrpc": "2.0", "id": 1, "method": "initialize", "params": { "capabilities": {} } }).to_string())
}

fn end() -> Vec<u8> {
    [json!({ "jsonrpc": "2.0", "id": 9, "method": "shutdown" }), json!({ "jsonrpc": "2.0", "method": "exit" })]
        .iter()
        .flat_map(|message| written(&message.to_string()))
        .collect()
}

#[test]
fn after_what_is_no_message_the_conversation_goes_on() {
    for (bytes, id, code) in [
        (written("{\"id\":2,\"method\":"), json!(null), -32700),
        (written("\u{0}"), json!(null), -32700),
        (b"Content-Length: 1\r\n\r\n\xff".to_vec(), json!(null), -32700),
        (b"Content-Length: x\r\n\r\n{}".to_vec(), json!(null), -32700),
        (b"Content-Length: 99999999999\r\n\r\n{}".to_vec(), json!(null), -32700),
        (b"hello\r\n\r\n".to_vec(), json!(null), -32700),
        (written("[{\"id\":2,\"method\":\"shutdown\"}]"), json!(null), -32600),
        (written("7"), json!(null), -32600),
        (written("{\"id\":2}"), json!(2), -32600),
        (written("{\"id\":[],\"method\":\"shutdown\"}"), json!(null), -32600),
        (written("{\"id\":2,\"method\":\"textDocument/moon\"}"), json!(2), -32601),
        (written("{\"id\":2,\"method\":\"textDocument/hover\"}"), json!(2), -32602),
        (written("{\"id\":2,\"method\":\"textDocument/hover\",\"params\":[7]}"), json!(2), -32602),
    ] {
        let (ending, said) = said(&[beginning(), bytes.clone(), end()]);
        let shown = String::from_utf8_lossy(&bytes);
        assert_eq!(ending.expect("it is whole"), Ending::ShutDown, "{shown}");
        assert_eq!(said.len(), 3, "{shown}: {said:?}");
        assert_eq!((&said[1]["id"], &said[1]["error"]["code"]), (&id, &json!(code)), "{shown}: {said:?}");
        assert_eq!((&said[2]["id"], &said[2]["result"]), (&json!(9), &Value::Null));
    }
}

#[test]
fn half_a_character_in_a_change_does_not_end_the_conversation() {
    let text = "\"\" (defun fetch () 1)";
    let document = json!({ "uri": FILE, "languageId": "rpl", "version": 1, "text": text });
    let open = json!({ "method": "textDocument/didOpen", "params": { "textDocument": document } });
    let change = |column: u32, half: &str| {
        let at = json!({ "line": 0, "character": column });
        let change = json!({ "range": { "start": at, "end": at }, "text": "HALF" });
        let params = json!({ "textDocument": { "uri": FILE, "version": 2 }, "contentChanges": [change] });
        written(&json!({ "method": "textDocument/didChange", "params": params }).to_string().replace("HALF", half))
    };
    let asked = json!({ "textDocument": { "uri": FILE } });
    let symbols = json!({ "id": 2, "method": "textDocument/documentSymbol", "params": asked });
    let (ending, said) = said(&[
        beginning(),
        written(&open.to_string()),
        change(1, "\\ud83d"),
        change(2, "\\ude42"),
        written(&symbols.to_string()),
        end(),
    ]);
    assert_eq!(ending.expect("it is whole"), Ending::ShutDown);
    assert!(said.iter().all(|message| message["error"].is_null()), "{said:?}");
    // Two halves are two units, as the whole is for the editor.
    let answer = said.iter().find(|message| message["id"] == 2).expect("it is answered");
    assert_eq!(answer["result"][0]["range"]["start"], json!({ "line": 0, "character": 5 }), "{answer}");
}

#[test]
fn a_stream_that_breaks_off_is_a_fault_and_one_that_ends_is_not() {
    let (ending, _) = said(&[beginning(), b"Content-Length: 10\r\n\r\n{}".to_vec()]);
    assert_eq!(ending.expect_err("it breaks off").kind(), io::ErrorKind::UnexpectedEof);
    assert_eq!(said(&[beginning()]).0.expect("it is whole"), Ending::Abandoned);
    let exit = written("{\"method\":\"exit\"}");
    assert_eq!(said(&[beginning(), exit]).0.expect("it is whole"), Ending::ToldToExit);
}

#[test]
fn what_comes_before_initialize_and_is_no_message_is_answered_too() {
    let (ending, said) = said(&[written("{"), beginning(), end()]);
    assert_eq!(ending.expect("it is whole"), Ending::ShutDown);
    assert_eq!(said[0]["error"]["code"], -32700);
    assert!(said[1]["result"].is_object());
}
