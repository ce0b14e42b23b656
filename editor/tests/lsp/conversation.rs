//! How a conversation begins, goes on and ends; and that the server knows the text the editor has.

use crate::client::{Client, FILE, Files, range};
use rpl_editor::lsp::Ending;
use rpl_editor::lsp::messages::{ErrorCode, Heard};
use rpl_editor::lsp::session::Session;
use serde_json::{Value, json};

fn code(client: &mut Client<'_>, method: &str, params: Value) -> Option<ErrorCode> {
    client.respond(method, params).outcome.err().map(|refusal| refusal.code)
}

#[test]
fn nothing_is_answered_before_initialize_and_after_shutdown() {
    let files = Files::default();
    let mut session = Session::new(&files);
    session.hear(Heard::of(json!({ "id": 1, "method": "textDocument/hover", "params": {} })));
    let said = serde_json::to_value(session.take_said()).expect("it can be said");
    assert_eq!((&said[0]["id"], &said[0]["error"]["code"]), (&json!(1), &json!(-32002)));

    let mut client = Client::new(&files);
    assert_eq!(code(&mut client, "initialize", json!({ "capabilities": {} })), Some(ErrorCode::InvalidRequest));
    assert_eq!(code(&mut client, "shutdown", Value::Null), None);
    assert_eq!(code(&mut client, "shutdown", Value::Null), Some(ErrorCode::InvalidRequest));
}

#[test]
fn what_is_not_known_or_not_understood_gets_the_protocols_error() {
    let files = Files::default();
    let mut client = Client::with(&files, "(print 1)\n");
    assert_eq!(code(&mut client, "textDocument/moon", json!({})), Some(ErrorCode::MethodNotFound));
    assert_eq!(code(&mut client, "textDocument/hover", json!({ "no": 1 })), Some(ErrorCode::InvalidParams));
    let elsewhere = json!({ "textDocument": { "uri": "file:///x.rpl" }, "position": { "line": 0, "character": 0 } });
    assert_eq!(code(&mut client, "textDocument/hover", elsewhere), Some(ErrorCode::InvalidParams));
    // Notifications that say nothing sensible have no answer, and are told.
    client.findings(FILE);
    client.notify("textDocument/didChange", json!({ "textDocument": 7 }));
    assert_eq!(client.last_told().method, "window/logMessage");
    client.notify("$/moon", json!({}));
    client.notify("$/cancelRequest", json!({ "id": 99 }));
    assert!(client.findings(FILE).is_empty());
}

#[test]
fn only_a_server_that_was_shut_down_ends_well() {
    let files = Files::default();
    let exit = || Heard::of(json!({ "method": "exit" }));
    let mut client = Client::new(&files);
    assert!(!client.session.hear(Heard::End));
    assert_eq!(client.session.ending(), Ending::Abandoned);
    let mut client = Client::new(&files);
    assert!(!client.session.hear(exit()));
    assert_eq!(client.session.ending(), Ending::ToldToExit);
    let mut client = Client::new(&files);
    client.request("shutdown", Value::Null).expect("it is answered");
    assert!(!client.session.hear(exit()));
    assert_eq!(client.session.ending(), Ending::ShutDown);
}

#[test]
fn changes_are_counted_in_units_of_utf_16() {
    let files = Files::default();
    let mut client = Client::with(&files, "(print \"ä🙂\") (print x)\n");
    let found = client.findings(FILE);
    // `"ä🙂"` is two bytes and four, one unit and two.
    assert_eq!(found[0]["range"], range((0, 21), (0, 22)), "{found:?}");
    client.change(range((0, 21), (0, 22)), "\"🙂\"");
    assert!(client.findings(FILE).is_empty());
    client.change(range((0, 8), (0, 11)), "");
    client.change(range((0, 0), (0, 0)), "y ");
    assert_eq!(client.findings(FILE)[0]["range"], range((0, 0), (0, 1)));
}

#[test]
fn a_burst_of_changes_is_looked_at_once() {
    let files = Files::default();
    let mut client = Client::with(&files, "\n");
    client.findings(FILE);
    let before = client.session.looks;
    for (column, letter) in "(print 1)".chars().enumerate() {
        client.change(range((0, column as u32), (0, column as u32)), &letter.to_string());
    }
    assert!(client.findings(FILE).is_empty());
    assert_eq!(client.session.looks, before + 1);
    // What the editor asks meanwhile needs no further look.
    client.ask("textDocument/foldingRange", json!({})).expect("it is answered");
    client.ask("textDocument/semanticTokens/full", json!({})).expect("it is answered");
    assert_eq!(client.session.looks, before + 1);
}

#[test]
fn a_keystroke_in_a_long_text_waits_for_a_pause() {
    let files = Files::default();
    let long = "(print 1)\n".repeat(12_000);
    let mut client = Client::with(&files, &long);
    client.findings(FILE);
    let before = client.session.looks;
    client.change(range((0, 7), (0, 8)), "2");
    assert_eq!(client.session.waits(), Some(true), "it is long");
    let at = json!({ "position": { "line": 0, "character": 3 } });
    client.ask("textDocument/completion", at.clone()).expect("it is answered");
    client.ask("textDocument/semanticTokens/full", json!({})).expect("it is answered");
    client.ask("textDocument/signatureHelp", at).expect("it is answered");
    assert_eq!(client.session.looks, before, "typing looks at nothing as a whole");
}

#[test]
fn texts_that_cannot_be_read_are_answered_for() {
    let files = Files::default();
    let texts = [
        "(",
        ")",
        "((((",
        "\"",
        "#|",
        "'",
        "(def-plan",
        "(def-plan x",
        "\0",
        "(let ((x",
        "#;",
        ". .",
        "🙂(",
        "(:tag",
        "(load",
        "`,@",
    ];
    for text in texts {
        let mut client = Client::reading(&files, text);
        let end = json!({ "position": { "line": 0, "character": 99 }, "context": { "includeDeclaration": true, "triggerKind": 1, "isRetrigger": false } });
        for method in ["hover", "completion", "signatureHelp", "definition", "references", "documentHighlight"] {
            client
                .ask(&format!("textDocument/{method}"), end.clone())
                .unwrap_or_else(|why| panic!("{method} of {text}: {why}"));
        }
        for method in ["documentSymbol", "foldingRange", "semanticTokens/full"] {
            client
                .ask(&format!("textDocument/{method}"), json!({}))
                .unwrap_or_else(|why| panic!("{method} of {text}: {why}"));
        }
        let all = json!({ "range": range((0, 0), (9, 9)), "context": { "diagnostics": [] } });
        client.ask("textDocument/codeAction", all).expect("it is answered");
        assert!(!client.findings(FILE).is_empty(), "{text}");
    }
}
