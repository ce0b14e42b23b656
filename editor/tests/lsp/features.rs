//! Each feature: one fact of the language that an editor is told.

use crate::client::{Client, FILE, Files, changed, range};
use rpl_editor::lsp::messages::{Heard, Said};
use serde_json::{Value, json};

/// Two plans that share names of variables, a macro of the text, a class of failure.
const TEXT: &str = "(def-fluent cups 0 \"How many cups are washed.\")
(def-failure slipped (plan-failure) ())
(defmacro twice (form)
  \"Runs a form two times.\"
  `(progn ,form ,form))
(def-plan wash (number)
  \"Washes cups.\"
  (dolist (cup (range 0 number))
    (setf (value cups) (+ (value cups) cup)))
  (twice (log number)))
(let ((number 2))
  (ignore-failures (slipped)
    (wash number)))
";

fn labels(response: &Value) -> Vec<&str> {
    let items = response["items"].as_array().expect("a list of words");
    items.iter().filter_map(|item| item["label"].as_str()).collect()
}

fn starts(locations: &Value) -> Vec<(u64, u64)> {
    let all = locations.as_array().expect("a list of places");
    let start = |one: &Value| one["range"]["start"].clone();
    all.iter()
        .map(|one| (start(one)["line"].as_u64().unwrap_or(99), start(one)["character"].as_u64().unwrap_or(99)))
        .collect()
}

/// The text with the place marked that stands in a line before a word.
fn marked(line: usize, word: &str) -> String {
    let start: usize = TEXT.split_inclusive('\n').take(line).map(str::len).sum();
    let at = start + TEXT[start..].find(word).expect("the word is there");
    format!("{}|{}", &TEXT[..at], &TEXT[at..])
}

#[test]
fn findings_have_rule_place_advice_and_other_places() {
    let files = Files::default();
    let mut client = Client::with(&files, "(defun f (a) a)\n(f 1 2)\n(prnt 1)\n(let ((x 1)) 2)\n");
    let found = client.findings(FILE);
    let codes: Vec<_> = found.iter().map(|one| (one["code"].as_str(), one["severity"].as_u64())).collect();
    assert_eq!(codes, [(Some("arity"), Some(1)), (Some("unbound-name"), Some(1)), (Some("unused-binding"), Some(2))]);
    let related = &found[0]["relatedInformation"][0];
    assert_eq!(
        (&related["location"]["uri"], &related["location"]["range"]["start"]["line"]),
        (&json!(FILE), &json!(0))
    );
    assert_eq!(found[1]["range"], range((2, 1), (2, 5)));
    assert!(found[1]["message"].as_str().is_some_and(|text| text.contains("did you mean `print`?")), "{found:?}");
}

#[test]
fn what_a_loaded_file_lacks_is_told_there_and_taken_back() {
    let files = Files([("part.rpl", "(defun part () (nowhere))\n")].into());
    let mut client = Client::with(&files, "(dolist (x '(1)) (let ((|x 2)) (print x)) (print x))");
    let edits = client.at_mark("textDocument/rename", json!({ "newName": "y" })).expect("it can be done");
    let after = changed("(dolist (x '(1)) (let ((x 2)) (print x)) (print x))", &edits["changes"][FILE]);
    assert_eq!(after, "(dolist (x '(1)) (let ((y 2)) (print y)) (print x))");

    let mut client = Client::with(&files, "(load \"part.rpl\")\n(part)\n");
    assert!(client.findings(FILE).is_empty());
    assert_eq!(client.findings("file:///plans/part.rpl")[0]["code"], "unbound-name");
    client.notify("textDocument/didClose", json!({ "textDocument": { "uri": FILE } }));
    assert!(client.findings("file:///plans/part.rpl").is_empty());
}

#[test]
fn a_plan_that_names_the_robot_is_looked_at_with_one() {
    let files = Files::default();
    let mut client = Client::with(&files, "(go-to 'mail-slots)\n(wait-for (> pos-certainty* 0.5))\n");
    assert!(client.findings(FILE).is_empty());
    // Without one, a plan may give the robot's names meanings of its own.
    let mut client = Client::with(&files, "(defun go-to (place) (print place))\n(go-to 'home)\n");
    assert!(client.findings(FILE).is_empty());
}

#[test]
fn what_a_hint_says_to_type_can_be_typed() {
    let files = Files::default();
    for (before, after) in [
        ("(prnt 1)\n", "(print 1)\n"),
        ("(print (+ 1 pos-certainty*))\n", "(print (+ 1 (value pos-certainty*)))\n"),
        ("(wait-time 3 s)\n", "(wait-time 3s)\n"),
        ("(let ((x\u{200b} 1)) (print x))\n", "(let ((x 1)) (print x))\n"),
    ] {
        let mut client = Client::with(&files, before);
        let all = json!({ "range": range((0, 0), (0, 40)), "context": { "diagnostics": [] } });
        let actions = client.ask("textDocument/codeAction", all).expect("it is answered");
        let preferred = actions.as_array().and_then(|all| all.iter().find(|one| one["isPreferred"] == true));
        let edits = &preferred.unwrap_or_else(|| panic!("{before}: {actions}"))["edit"]["changes"][FILE];
        assert_eq!(changed(before, edits), after);
    }
}

#[test]
fn a_warning_can_be_allowed_and_is_gone() {
    let files = Files::default();
    let before = "(print\n  (let ((x 1)) 2))\n";
    let mut client = Client::with(&files, before);
    let there = json!({ "range": range((1, 9), (1, 9)), "context": { "diagnostics": [] } });
    let actions = client.ask("textDocument/codeAction", there).expect("it is answered");
    let after = changed(before, &actions[0]["edit"]["changes"][FILE]);
    assert_eq!(after, "(print\n  ; check: allow unused-binding\n  (let ((x 1)) 2))\n");
    assert!(Client::with(&files, &after).findings(FILE).is_empty());
}

#[test]
fn the_outline_is_what_the_text_defines() {
    let files = Files::default();
    let mut client = Client::with(&files, TEXT);
    let symbols = client.ask("textDocument/documentSymbol", json!({})).expect("it is answered");
    let found: Vec<_> =
        symbols.as_array().expect("a list").iter().map(|one| (one["name"].as_str(), one["detail"].as_str())).collect();
    let expected = [("cups", "def-fluent"), ("slipped", "def-failure"), ("twice", "defmacro"), ("wash", "def-plan")];
    assert_eq!(found, expected.map(|(name, form)| (Some(name), Some(form))));
    assert_eq!(symbols[3]["range"], range((5, 0), (9, 23)));
    assert_eq!(symbols[3]["selectionRange"], range((5, 10), (5, 14)));
}

#[test]
fn the_pointer_is_told_what_a_name_is() {
    let files = Files::default();
    for (text, said) in [
        ("(pri|nt 1)\n", "(print"),
        ("(wait-|for cups)\n(def-fluent cups 0)\n", "special form"),
        ("(go-to 'mail-sl|ots)\n", "a place in the world `dept`"),
        ("(deftest t :world \"test-room\" (go-to 'table-si|de))\n", "a place in the world `test-room`"),
        ("(defun f (who)\n  \"Greets somebody.\"\n  (print wh|o))\n", "bound in line 1"),
        ("(defun f (who)\n  \"Greets somebody.\"\n  (print who))\n(|f 1)\n", "Greets somebody."),
        ("(let ((print 1)) (+ pri|nt 1))\n", "bound in line 1"),
    ] {
        let mut client = Client::with(&files, text);
        let hover = client.at_mark("textDocument/hover", json!({})).expect("it is answered");
        let value = hover["contents"]["value"].as_str().unwrap_or_else(|| panic!("{text}: {hover}"));
        assert!(value.contains(said), "{text}: {value}");
    }
}

#[test]
fn completion_offers_what_fits() {
    let files = Files::default();
    for (text, word, is_first) in [
        ("(def-plan greet () 1)\n(gre|", "greet", false),
        ("(whene|", "whenever", false),
        ("(go-to 'mail|)", "mail-slots", true),
        ("(activate nav|)", "navigation", true),
        ("(with-valve |)", "wheels", true),
        ("(def-failure slipped (failure) ())\n(fail |)", "slipped", true),
        ("(wait-for x :ti|)", ":timeout", false),
        ("(run-behaviour gripper :gr|)", ":grasp", false),
        ("(let ((kettle 1)) (print ket|))", "kettle", false),
        ("(library:whene|", "library:whenever", false),
        ("(print (library:|", "library:length", false),
        ("(def-plan greet () 1)\n(global:gre|", "global:greet", false),
        ("(global:|", "global:length", false),
        ("(library:activate nav|)", "navigation", true),
    ] {
        let mut client = Client::with(&files, text);
        let offered = client.at_mark("textDocument/completion", json!({})).expect("it is answered");
        assert!(labels(&offered).contains(&word), "{text}");
        let item = offered["items"].as_array().and_then(|all| all.iter().find(|item| item["label"] == word));
        let sort = item.and_then(|item| item["sortText"].as_str()).unwrap_or_default();
        assert_eq!(sort.starts_with('0'), is_first, "{text}");
    }
    let mut client = Client::with(&files, "(def-plan greet () 1)\n(def-failure slipped (failure) ())\n(library:|");
    let offered = client.at_mark("textDocument/completion", json!({})).expect("it is answered");
    assert!(labels(&offered).iter().all(|label| label.starts_with("library:")));
    assert!(!labels(&offered).contains(&"library:greet"), "the text's own is not the library's");
    for nothing in ["(print \"go-|\")", "; go-|"] {
        let mut client = Client::with(&files, nothing);
        let offered = client.at_mark("textDocument/completion", json!({})).expect("it is answered");
        assert!(offered.is_null(), "{nothing}");
    }
    let mut client = Client::with(&files, "(|");
    let item = client
        .request("completionItem/resolve", json!({ "label": "with-policy", "data": FILE }))
        .expect("it is answered");
    assert!(item["documentation"]["value"].as_str().is_some_and(|text| text.contains("(with-policy")), "{item}");
}

#[test]
fn the_part_that_is_typed_is_marked_in_the_signature() {
    let files = Files::default();
    let part = |text: &str| {
        let mut client = Client::with(&files, text);
        let help = client.at_mark("textDocument/signatureHelp", json!({})).expect("it is answered");
        let signature = &help["signatures"][0];
        let active = signature["activeParameter"].as_u64()?;
        let offsets = &signature["parameters"][active as usize]["label"];
        let (start, end) = (offsets[0].as_u64()? as usize, offsets[1].as_u64()? as usize);
        Some(signature["label"].as_str()?[start..end].to_string())
    };
    assert_eq!(part("(def-plan serve (cup guest) 1)\n(serve |)").as_deref(), Some("cup"));
    assert_eq!(part("(def-plan serve (cup guest) 1)\n(serve (list 1 2) |").as_deref(), Some("guest"));
    assert_eq!(part("(if a b |").as_deref(), Some("[ELSE]"));
    assert_eq!(part("(unknown |"), None);
}

#[test]
fn a_name_leads_to_where_it_is_defined() {
    let files = Files([("part.rpl", "; parts\n(defun part () 1)\n")].into());
    let place = |text: &str| {
        let mut client = Client::with(&files, text);
        let found = client.at_mark("textDocument/definition", json!({})).expect("it is answered");
        (found["uri"].as_str().map(str::to_string), found["range"].clone())
    };
    let here = || Some(FILE.to_string());
    assert_eq!(place(&marked(12, "wash")), (here(), range((5, 10), (5, 14))));
    assert_eq!(place(&marked(12, "number")), (here(), range((10, 7), (10, 13))));
    assert_eq!(place(&marked(9, "number")), (here(), range((5, 16), (5, 22))));
    assert_eq!(place(&marked(8, "cup)")), (here(), range((7, 11), (7, 14))));
    assert_eq!(place(&marked(9, "twice")), (here(), range((2, 10), (2, 15))));
    assert_eq!(place(&marked(11, "slipped")), (here(), range((1, 13), (1, 20))));
    let loaded = place("(load \"part.rpl\")\n(|part)\n");
    assert_eq!(loaded, (Some("file:///plans/part.rpl".into()), range((1, 7), (1, 11))));
    assert_eq!(place("(|print 1)").0, None, "the library has no file");
}

#[test]
fn the_uses_of_a_name_are_its_own_and_no_others() {
    let files = Files::default();
    let uses = |line, word, declaration: bool| {
        let mut client = Client::with(&files, &marked(line, word));
        let context = json!({ "context": { "includeDeclaration": declaration } });
        starts(&client.at_mark("textDocument/references", context).expect("it is answered"))
    };
    assert_eq!(uses(5, "number", true), [(5, 16), (7, 24), (9, 14)]);
    assert_eq!(uses(10, "number", true), [(10, 7), (12, 10)]);
    assert_eq!(uses(0, "cups", false), [(8, 17), (8, 33)]);
    assert_eq!(uses(7, "cup ", true), [(7, 11), (8, 39)]);
}

#[test]
fn a_new_name_stands_everywhere_or_nowhere() {
    let files = Files([("part.rpl", "(defun part () (part))\n")].into());
    let mut client = Client::with(&files, &marked(5, "number"));
    let edits = client.at_mark("textDocument/rename", json!({ "newName": "how-many" })).expect("it can be done");
    let after = changed(TEXT, &edits["changes"][FILE]);
    assert!(after.contains("(def-plan wash (how-many)") && after.contains("(range 0 how-many)"), "{after}");
    assert!(after.contains("(twice (log how-many))") && after.contains("(let ((number 2))"), "{after}");

    let mut client = Client::with(&files, "(load \"part.rpl\")\n(|part)\n");
    let edits = client.at_mark("textDocument/rename", json!({ "newName": "piece" })).expect("it can be done");
    assert_eq!(edits["changes"]["file:///plans/part.rpl"].as_array().map(Vec::len), Some(2));
    assert_eq!(edits["changes"][FILE].as_array().map(Vec::len), Some(1));
}

/// A text with a name of its own, which hides one of the library, and is hidden.
const QUALIFIED: &str = "(defun length (l) (library:length l))
(defvar size 3)
(let ((size 1) (length 2))
  (dolist (e (list size global:size))
    (print (global:length (list e length)))))
";

#[test]
fn a_name_with_a_qualifier_is_followed_and_changed_behind_it() {
    let files = Files::default();
    let at = |line: usize, word: &str| {
        let start: usize = QUALIFIED.split_inclusive('\n').take(line).map(str::len).sum();
        let at = start + QUALIFIED[start..].find(word).expect("the word is there");
        Client::with(&files, &format!("{}|{}", &QUALIFIED[..at], &QUALIFIED[at..]))
    };
    for (line, word, defined) in [
        (3, "global:size", range((1, 8), (1, 12))),
        (3, "size))", range((1, 8), (1, 12))),
        (3, "size global", range((2, 7), (2, 11))),
        (4, "global:length", range((0, 7), (0, 13))),
        (4, "length)))", range((2, 16), (2, 22))),
    ] {
        let found = at(line, word).at_mark("textDocument/definition", json!({})).expect("it is answered");
        assert_eq!(found["range"], defined, "{word}");
    }
    let none = at(0, "library:length").at_mark("textDocument/definition", json!({})).expect("it is answered");
    assert!(none.is_null(), "the library has no file: {none}");
    let context = || json!({ "context": { "includeDeclaration": true } });
    let uses = at(1, "size").at_mark("textDocument/references", context()).expect("it is answered");
    assert_eq!(starts(&uses), [(1, 8), (3, 31)]);

    let edits = at(1, "size").at_mark("textDocument/rename", json!({ "newName": "width" })).expect("it can be done");
    let after = changed(QUALIFIED, &edits["changes"][FILE]);
    assert_eq!(after, QUALIFIED.replace("defvar size", "defvar width").replace("global:size", "global:width"));
    let edits = at(3, "global:size").at_mark("textDocument/rename", json!({ "newName": "width" }));
    assert_eq!(changed(QUALIFIED, &edits.expect("it can be done")["changes"][FILE]), after);
    for method in ["textDocument/rename", "textDocument/prepareRename"] {
        let refused = at(0, "library:length").at_mark(method, json!({ "newName": "count-of" }));
        assert!(refused.as_ref().is_err_and(|why| why.contains("a name of the library")), "{method}: {refused:?}");
    }
}

#[test]
fn a_new_name_that_would_mean_another_thing_is_refused() {
    let files = Files::default();
    for (text, name) in [
        ("(let ((a 1) (b 2)) (print (+ |a b)))", "b"),
        ("(defun f (a) a)\n(defun g (b) (|f b))", "b"),
        ("(let ((|a 1)) (print a))", "print 1"),
        ("(let ((|a 1)) (print a))", "print"),
        ("(let ((|a 1)) (print a))", "12"),
        ("(|print 1)", "show"),
        ("(defun f (&key |size) size)\n(f :size 1)", "width"),
    ] {
        let mut client = Client::with(&files, text);
        let renamed = client.at_mark("textDocument/rename", json!({ "newName": name }));
        assert!(renamed.is_err(), "{text} with {name}: {renamed:?}");
    }
}

#[test]
fn a_text_is_laid_out_by_changes_of_lines() {
    let files = Files::default();
    let before = "(print   1)\n\n(def-plan 🙂 ()\n(print 2))\n\n(print   3)\n";
    let mut client = Client::with(&files, before);
    let options = json!({ "options": { "tabSize": 2, "insertSpaces": true } });
    let edits = client.ask("textDocument/formatting", options.clone()).expect("it is answered");
    assert_eq!(changed(before, &edits), "(print 1)\n\n(def-plan 🙂 ()\n  (print 2))\n\n(print 3)\n");
    let mut part = options.clone();
    part["range"] = range((3, 0), (3, 3));
    let edits = client.ask("textDocument/rangeFormatting", part).expect("it is answered");
    assert_eq!(changed(before, &edits), "(print   1)\n\n(def-plan 🙂 ()\n  (print 2))\n\n(print   3)\n");
    let mut client = Client::with(&files, "(print   1");
    assert!(client.ask("textDocument/formatting", options).expect("it is answered").is_null(), "it cannot be read");
}

#[test]
fn lists_and_comments_of_several_lines_fold() {
    let files = Files::default();
    let mut client = Client::reading(&files, "; one\n; two\n(a\n  (b\n    c)\n  d)\n#| e\nf |#\n(g)\n");
    let folds = client.ask("textDocument/foldingRange", json!({})).expect("it is answered");
    let lines: Vec<_> = folds
        .as_array()
        .expect("a list")
        .iter()
        .map(|one| (one["startLine"].as_u64(), one["endLine"].as_u64()))
        .collect();
    assert_eq!(lines, [(0, 1), (2, 5), (3, 4), (6, 7)].map(|(from, to)| (Some(from), Some(to))));
}

#[test]
fn words_are_coloured_by_what_they_mean() {
    let files = Files::default();
    let text = "(def-plan 🙂wash () (print pos-certainty*)) ; ä\n(🙂wash)\n#| a\nb |#\n";
    let mut client = Client::reading(&files, text);
    let legend = {
        let mut other = Client::new(&files);
        other.respond("shutdown", Value::Null);
        let mut session = rpl_editor::lsp::session::Session::new(&files);
        session.hear(Heard::of(json!({ "id": 1, "method": "initialize", "params": { "capabilities": {} } })));
        match session.take_said().remove(0) {
            Said::Response(response) => response.outcome.expect("it is answered"),
            other => panic!("{other:?}"),
        }
    };
    let types = legend["capabilities"]["semanticTokensProvider"]["legend"]["tokenTypes"].clone();
    let tokens = client.ask("textDocument/semanticTokens/full", json!({})).expect("it is answered");
    let numbers: Vec<u64> = tokens["data"].as_array().expect("a list").iter().filter_map(Value::as_u64).collect();
    let (mut line, mut column, mut found) = (0, 0, Vec::new());
    for token in numbers.chunks(5) {
        column = if token[0] == 0 { column + token[1] } else { token[1] };
        line += token[0];
        found.push((
            line,
            column,
            token[2],
            types[token[3] as usize].as_str().unwrap_or_default().to_string(),
            token[4],
        ));
    }
    let expected = [
        (0, 1, 8, "keyword", 2),
        (0, 10, 6, "method", 1),
        (0, 21, 5, "function", 2),
        (0, 27, 14, "property", 2),
        (0, 44, 3, "comment", 0),
        (1, 1, 6, "method", 0),
        (2, 0, 4, "comment", 0),
        (3, 0, 4, "comment", 0),
    ];
    assert_eq!(
        found,
        expected.map(|(line, column, length, kind, bits)| (line, column, length, kind.to_string(), bits))
    );
}
