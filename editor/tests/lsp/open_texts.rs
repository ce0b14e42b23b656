//! Many texts that are open, and texts that load others.

use crate::client::{Client, FILE, Files, range};
use serde_json::json;

const PART: &str = "file:///plans/part.rpl";

#[test]
fn opening_a_text_looks_at_no_other() {
    let files = Files::default();
    let mut client = Client::new(&files);
    let many = 100;
    for number in 0..many {
        let uri = format!("file:///plans/{number}.rpl");
        client.open_at(&uri, "(nowhere)\n");
        assert_eq!(client.looked(), [uri]);
    }
    assert_eq!(client.session.looks, many);
    // One that was looked at long ago is looked at again for who asks, and is known as it is.
    let at = json!({ "textDocument": { "uri": "file:///plans/0.rpl" } });
    client.request("textDocument/documentSymbol", at).expect("it is answered");
    assert_eq!(client.session.looks, many + 1);
}

#[test]
fn texts_that_are_opened_at_once_are_looked_at_one_by_one_the_last_first() {
    let files = Files::default();
    let mut client = Client::new(&files);
    let uris: Vec<String> = (0..5).map(|number| format!("file:///plans/{number}.rpl")).collect();
    uris.iter().for_each(|uri| client.open_at(uri, "(nowhere)\n"));
    client.session.look();
    assert_eq!(client.session.looks, 1);
    let told = client.looked();
    assert!(told.iter().eq(uris.iter().rev()), "{told:?}");
}

#[test]
fn who_loads_a_text_is_looked_at_when_it_is_opened_saved_or_closed_and_nobody_else() {
    let files = Files([("part.rpl", "(defun part () 1)\n")].into());
    let mut client = Client::reading(&files, "(load \"part.rpl\")\n(part)\n");
    client.open_at("file:///plans/other.rpl", "(print 1)\n");
    assert!(client.findings(FILE).is_empty());
    client.open_at(PART, "(defun piece () 1)\n");
    assert_eq!(client.looked(), [FILE, PART]);
    assert_eq!(client.findings(FILE)[0]["code"], "unbound-name");

    let document = json!({ "uri": PART, "version": 2 });
    let change = json!({ "range": range((0, 7), (0, 12)), "text": "part" });
    client.notify("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [change] }));
    assert_eq!(client.looked(), [PART], "the findings of others come when it is saved");
    // Who asks meanwhile is answered for the texts as they are.
    let renamed =
        client.ask("textDocument/rename", json!({ "position": { "line": 1, "character": 2 }, "newName": "cup" }));
    assert_eq!(renamed.expect("it can be done")["changes"][PART][0]["range"], range((0, 7), (0, 11)));
    client.notify("textDocument/didSave", json!({ "textDocument": { "uri": PART } }));
    assert_eq!(client.looked(), [FILE]);
    assert!(client.findings(FILE).is_empty());

    let change = json!({ "range": range((0, 7), (0, 11)), "text": "piece" });
    let document = json!({ "uri": PART, "version": 3 });
    client.notify("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [change] }));
    client.notify("textDocument/didSave", json!({ "textDocument": { "uri": PART } }));
    assert_eq!(client.findings(FILE).len(), 1);
    client.notify("textDocument/didClose", json!({ "textDocument": { "uri": PART } }));
    assert!(client.findings(FILE).is_empty(), "its file defines it");
}

#[test]
fn findings_of_a_text_that_was_opened_meanwhile_stay() {
    let files = Files([("part.rpl", "(defun part () (nowhere))\n")].into());
    let mut client = Client::reading(&files, "(load \"part.rpl\")\n(part)\n");
    assert_eq!(client.findings(PART).len(), 1, "told by who loads it");
    client.open_at(PART, "(defun part () (nowhere))\n");
    assert_eq!(client.findings(PART).len(), 1, "its own");
    client.notify("textDocument/didClose", json!({ "textDocument": { "uri": FILE } }));
    assert_eq!(client.findings(PART).len(), 1, "its own, still");
}

#[test]
fn who_lacks_a_file_is_looked_at_when_a_plan_comes() {
    let files = Files::default();
    let mut client = Client::reading(&files, "(load \"part.rpl\")\n");
    client.open_at("file:///plans/other.rpl", "(print 1)\n");
    assert_eq!(client.findings(FILE).len(), 1);
    let come = |uri: &str| json!({ "changes": [{ "uri": uri, "type": 1 }] });
    client.notify("workspace/didChangeWatchedFiles", come(PART));
    assert_eq!(client.looked(), [FILE]);
    // A project may be for another world now.
    client.notify("workspace/didChangeWatchedFiles", come("file:///plans/rpl.toml"));
    assert_eq!(client.looked().len(), 2);
}
