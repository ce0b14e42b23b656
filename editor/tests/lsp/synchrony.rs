//! The server has the text that the editor has, whatever is said of it.

use crate::client::{Client, FILE, Files, range};
use serde_json::{Value, json};

/// Where `nowhere`, which nothing defines, stands for the server.
fn place(client: &mut Client<'_>) -> Value {
    client.findings(FILE)[0]["range"]["start"].clone()
}

#[test]
fn half_a_character_is_one_unit_whichever_half_it_is_and_where_it_is_cut() {
    let files = Files::default();
    let at = |character: u32| json!({ "line": 0, "character": character });
    // Half a character, then the other half, each by itself.
    let mut client = Client::reading(&files, "\"\" nowhere\n");
    assert_eq!(place(&mut client), at(3));
    client.change(range((0, 1), (0, 1)), "\u{fffd}");
    assert_eq!(place(&mut client), at(4));
    client.change(range((0, 2), (0, 2)), "\u{fffd}");
    assert_eq!(place(&mut client), at(5));
    client.change(range((0, 1), (0, 3)), "");
    assert_eq!(place(&mut client), at(3));
    // A character of two units: its first half taken away, its second, both; something between them; and over its end.
    for (start, end, text, after) in
        [(1, 2, "", 4), (2, 3, "", 4), (1, 3, "", 3), (2, 2, "xy", 7), (2, 4, "\" ", 5), (0, 2, "\"", 4)]
    {
        let mut client = Client::reading(&files, "\"🙂\" nowhere\n");
        assert_eq!(place(&mut client), at(5));
        client.change(range((0, start), (0, end)), text);
        assert_eq!(place(&mut client), at(after), "{start}..{end} {text}");
    }
}

#[test]
fn a_line_with_half_a_character_is_not_laid_out() {
    let files = Files::default();
    let mut client = Client::reading(&files, "(print  1)\n(print  \"🙂\")\n(print  2)\n");
    client.change(range((1, 10), (1, 10)), "");
    let edits = client.ask("textDocument/formatting", json!({ "options": { "tabSize": 2, "insertSpaces": true } }));
    let edits = edits.expect("it is answered");
    let lines: Vec<_> =
        edits.as_array().into_iter().flatten().map(|edit| edit["range"]["start"]["line"].clone()).collect();
    assert!(!lines.contains(&json!(1)), "{edits}");
}

#[test]
fn places_that_are_none_are_taken_as_the_specification_says() {
    let files = Files::default();
    let most = u32::MAX;
    for (changed, text, after) in [
        (range((0, 6), (0, 7)), "22", "(list 22 nowhere)"),
        // Behind a line is its end; behind the text its end.
        (range((0, 0), (0, most)), "nowhere", "nowhere"),
        (range((0, 0), (most, most)), "nowhere", "nowhere"),
        (range((most, most), (most, 0)), "\n", "(list 1 nowhere)\n\n"),
        (range((0, 7), (0, 6)), "22", "(list 22 nowhere)"),
    ] {
        let mut client = Client::reading(&files, "(list 1 nowhere)\n");
        client.change(changed.clone(), text);
        let column = after.find("nowhere").expect("it is there");
        assert_eq!(place(&mut client)["character"], json!(column), "{changed} {text}");
    }
}

#[test]
fn changes_of_one_message_follow_each_other() {
    let files = Files::default();
    let mut client = Client::reading(&files, "(print 1 nowhere)\n");
    // The second is said of what the first has made, as is the third, which stands before both.
    client.changes(json!([
        { "range": range((0, 7), (0, 8)), "text": "12345" },
        { "range": range((0, 12), (0, 12)), "text": " 6" },
        { "range": range((0, 0), (0, 0)), "text": "\n" },
        { "range": range((1, 1), (1, 6)), "text": "list" },
    ]));
    assert_eq!(place(&mut client), json!({ "line": 1, "character": 14 }));
    client.changes(json!([{ "text": "x" }, { "range": range((0, 0), (0, 1)), "text": "  nowhere" }]));
    assert_eq!(place(&mut client), json!({ "line": 0, "character": 2 }));
}

#[test]
fn a_change_that_is_not_understood_closes_the_text() {
    let files = Files::default();
    for change in [json!({ "range": { "start": { "line": -1, "character": 0 } }, "text": "" }), json!({}), json!(7)] {
        let mut client = Client::reading(&files, "(print 1)\n");
        client.findings(FILE);
        client.changes(json!([change]));
        let told = client.last_told();
        assert_eq!(told.method, "window/showMessage", "{change}");
        assert!(told.params["message"].as_str().is_some_and(|text| text.contains("open it again")), "{told:?}");
        // Nothing is said of what nobody knows, and nothing is changed in it.
        let formatted =
            client.ask("textDocument/formatting", json!({ "options": { "tabSize": 2, "insertSpaces": true } }));
        assert!(formatted.is_err_and(|why| why.contains("is not open")));
        client.open_at(FILE, "(nowhere)\n");
        assert_eq!(client.findings(FILE).len(), 1);
    }
}

#[test]
fn a_version_that_goes_back_is_the_editors_business() {
    let files = Files::default();
    let mut client = Client::reading(&files, "(print 1)\n");
    for version in [7, 3, -1] {
        let document = json!({ "uri": FILE, "version": version });
        let change = json!({ "range": range((0, 0), (0, 0)), "text": "x " });
        client.notify("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [change] }));
        assert_eq!(client.last_told().params["version"], json!(version));
    }
    assert_eq!(client.findings(FILE)[0]["range"], range((0, 0), (0, 1)), "all of them were made");
}

#[test]
fn what_is_not_open_is_neither_changed_nor_closed() {
    let files = Files::default();
    let mut client = Client::new(&files);
    client.change(range((0, 0), (0, 0)), "x");
    assert_eq!(client.last_told().method, "window/logMessage");
    client.open_at(FILE, "(print 1)\n");
    let close = json!({ "textDocument": { "uri": FILE } });
    client.notify("textDocument/didClose", close.clone());
    assert_eq!(client.last_told().method, "textDocument/publishDiagnostics");
    client.notify("textDocument/didClose", close);
    assert_eq!(client.last_told().method, "window/logMessage");
}

#[test]
fn a_text_may_have_no_file() {
    let files = Files::default();
    for uri in
        ["untitled:Untitled-1", "http://example.org/a.rpl", "file://host/a.rpl", "file:", "x", "vscode-vfs:/a%00"]
    {
        let mut client = Client::new(&files);
        client.open_at(uri, "(nowhere) (load \"part.rpl\")\n");
        assert_eq!(client.findings(uri).len(), 2, "{uri}");
    }
}

#[test]
fn many_changes_of_a_long_text_are_taken_in_one_go() {
    let files = Files::default();
    let many = 5_000;
    let mut client = Client::reading(&files, &"(print 1)\n".repeat(many));
    let changes: Vec<Value> = (0..many as u32)
        .rev()
        .map(|line| json!({ "range": range((line, 7), (line, 8)), "text": if line == 5 { "nowhere" } else { "22" } }))
        .collect();
    client.changes(json!(changes));
    assert_eq!(place(&mut client), json!({ "line": 5, "character": 7 }));
}
