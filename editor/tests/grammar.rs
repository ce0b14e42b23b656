//! The TextMate grammar of the editors, made of the tables of names; the file in `editors` is what
//! this gives.

use rpl_lang::number::unit_names;
use rpl_mission::reference::{NameKind, Reference, TOPICS};
use serde_json::{Value, json};
use std::path::Path;

/// A character of a name.
const NAME: &str = r#"[^\s()'`,";\[\]{}|]"#;

/// Nothing of a name stands before; the `@` may belong to `,@`.
const BEGINS: &str = r#"(?<![^\s()'`,";\[\]{}|@])"#;

/// Nothing of a name comes after.
const ENDS: &str = r#"(?![^\s()'`,";\[\]{}|])"#;

/// Definitions whose name is called afterwards.
const CALLABLE: &[&str] = &["def-plan", "def-interp-proc", "def-resume", "defun", "defmacro", "deftest"];

fn escaped(name: &str) -> String {
    name.chars().flat_map(|c| r"\.*+?()[]{}|^$".contains(c).then_some('\\').into_iter().chain([c])).collect()
}

/// One of these names, the longest first.
fn any_of<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names: Vec<&str> = names.into_iter().collect();
    names.sort_by_key(|name| (std::cmp::Reverse(name.len()), *name));
    format!("(?:{})", names.iter().map(|name| escaped(name)).collect::<Vec<_>>().join("|"))
}

fn word(names: &str, scope: &str) -> Value {
    json!({ "match": format!("{BEGINS}{names}{ENDS}"), "name": scope })
}

fn called(names: &str, scope: &str) -> Value {
    json!({ "match": format!(r"(?<=\(|#'){names}{ENDS}"), "name": scope })
}

fn definitions(names: &str, defined: &str) -> Value {
    json!({
        "match": format!(r"(?<=\()({names})\s+({NAME}+)"),
        "captures": { "1": { "name": "keyword.other.definition.rpl" }, "2": { "name": defined } },
    })
}

fn include(names: &[&str]) -> Value {
    names.iter().map(|name| json!({ "include": format!("#{name}") })).collect()
}

/// Text between a beginning and `)`, whatever lists are in it.
fn list(begin: &str, scope: &str, inside: &[&str]) -> Value {
    json!({ "begin": begin, "end": r"\)", "name": scope, "patterns": include(inside) })
}

fn grammar(reference: &Reference) -> Value {
    let of = |kinds: &[NameKind]| {
        any_of(reference.names().filter(|entry| kinds.contains(&entry.kind)).map(|entry| entry.name.as_str()))
    };
    let topic = TOPICS.iter().find(|topic| topic.word == "definitions").expect("the topic of the definitions");
    let is_definition = |name: &&str| name.starts_with("def") || *name == "global-fluent";
    let (callable, others): (Vec<&str>, Vec<&str>) =
        topic.names().filter(is_definition).partition(|name| CALLABLE.contains(name));
    let units = any_of(unit_names());
    json!({
        "$schema": "https://raw.githubusercontent.com/martinring/tmlanguage/master/tmlanguage.json",
        "name": "RPL",
        "scopeName": "source.rpl",
        "fileTypes": ["rpl"],
        "patterns": include(&["comments", "strings", "bars", "quoted", "prefixes", "atoms", "forms", "names"]),
        "repository": {
            "comments": { "patterns": [
                { "match": ";.*$", "name": "comment.line.semicolon.rpl" },
                { "include": "#block-comment" },
                list(r"#;\s*\(", "comment.block.datum.rpl", &["comments", "strings", "bars", "commented-list"]),
                { "match": format!("#;\\s*{NAME}+"), "name": "comment.block.datum.rpl" },
            ] },
            "block-comment": {
                "begin": r"#\|", "end": r"\|#", "name": "comment.block.rpl",
                "patterns": include(&["block-comment"]),
            },
            "commented-list": list(r"\(", "comment.block.datum.rpl", &["comments", "strings", "bars", "commented-list"]),
            "strings": {
                "begin": "\"", "end": "\"", "name": "string.quoted.double.rpl",
                "patterns": [
                    { "match": r#"\\(?:[ntr0\\"]|u\{[0-9a-fA-F]{1,6}\})"#, "name": "constant.character.escape.rpl" },
                    { "match": r"\\.", "name": "invalid.illegal.escape.rpl" },
                    { "match": r"~[0-9,]*[a-zA-Z%~]", "name": "constant.other.placeholder.rpl" },
                ],
            },
            "bars": { "match": r":?\|(?:[^|\\]|\\.)*\|", "name": "variable.other.bars.rpl" },
            "quoted": { "patterns": [
                list(r"(?<!#)'\(", "meta.quoted.rpl", &["comments", "strings", "bars", "prefixes", "atoms", "quoted-list", "symbols"]),
                {
                    "match": format!(r"(?<!#)(')({NAME}+)"),
                    "captures": {
                        "1": { "name": "keyword.operator.quote.rpl" },
                        "2": { "name": "constant.other.symbol.rpl" },
                    },
                },
            ] },
            "quoted-list":
                list(r"\(", "meta.quoted.rpl", &["comments", "strings", "bars", "prefixes", "atoms", "quoted-list", "symbols"]),
            "symbols": { "match": format!("{NAME}+"), "name": "constant.other.symbol.rpl" },
            "prefixes": { "match": "#'|#(?=\\()|,@|['`,]", "name": "keyword.operator.quote.rpl" },
            "atoms": { "patterns": [
                {
                    "match": format!(r"{BEGINS}[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?({units})?{ENDS}"),
                    "name": "constant.numeric.rpl",
                    "captures": { "1": { "name": "keyword.other.unit.rpl" } },
                },
                word("(?:nil|t)", "constant.language.rpl"),
                word("&(?:optional|rest|key|body)", "storage.modifier.rpl"),
                {
                    "match": format!(r"(?<=\()(:tag)(?=[\s()])(?:\s+({NAME}+))?"),
                    "captures": {
                        "1": { "name": "keyword.control.rpl" },
                        "2": { "name": "entity.name.tag.rpl" },
                    },
                },
                word(&format!(":{NAME}+"), "constant.keyword.rpl"),
            ] },
            "forms": { "patterns": [
                definitions(&any_of(callable), "entity.name.function.rpl"),
                definitions(&any_of(others), "entity.name.type.rpl"),
                called(&of(&[NameKind::SpecialForm, NameKind::Macro]), "keyword.control.rpl"),
                called(&of(&[NameKind::Plan]), "support.function.plan.rpl"),
                called(&of(&[NameKind::Function]), "support.function.rpl"),
            ] },
            "names": { "patterns": [
                word(&of(&[NameKind::Fluent]), "support.variable.fluent.rpl"),
                word(&format!(r"[a-zA-Z]{NAME}*\*"), "variable.other.fluent.rpl"),
                word(&of(&[NameKind::Behaviour, NameKind::Valve]), "support.constant.robot.rpl"),
                word(&of(&[NameKind::FailureClass]), "support.class.failure.rpl"),
            ] },
        },
    })
}

#[test]
fn the_grammar_of_the_editors_is_that_of_the_tables() {
    let reference = Reference::new().expect("the library compiles");
    let text = serde_json::to_string_pretty(&grammar(&reference)).expect("it is data") + "\n";
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../editors/vscode/syntaxes/rpl.tmLanguage.json");
    if std::env::var_os("WRITE_GRAMMAR").is_some() {
        std::fs::write(&file, &text).expect("the file can be written");
    }
    let there = std::fs::read_to_string(&file).unwrap_or_default();
    assert!(
        there == text,
        "the names of the language have changed: `WRITE_GRAMMAR=1 cargo test -p rpl-editor grammar` writes the grammar anew"
    );
}
