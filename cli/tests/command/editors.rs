//! The grammar for editors: what it makes of plan text, and that it agrees with the language about
//! what is a comment, a string, a number.

use crate::folder::{folder, put};
use crate::rpl::run_in;
use fancy_regex::Regex;
use rpl_lang::lexer::{Token, lex};
use rpl_lang::source::SourceId;
use rpl_tests::repository::{files_below, root, text_of};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;

/// The part of a TextMate engine that the grammar uses: `match`, `begin` and `end`, `captures`,
/// `include` of the repository.
struct Engine {
    grammar: Value,
    expressions: BTreeMap<String, Regex>,
}

/// A region that is open, by the rule that opened it.
#[derive(Clone)]
struct Region {
    rule: Value,
}

/// A stretch of a line and its scopes, outermost first.
struct Stretch {
    from: usize,
    to: usize,
    scopes: Vec<String>,
}

/// What fits first.
struct Found {
    rule: Value,
    is_end: bool,
    groups: Vec<Option<(usize, usize)>>,
}

impl Engine {
    fn new() -> Self {
        let text = text_of("editors/vscode/syntaxes/rpl.tmLanguage.json");
        let grammar: Value = serde_json::from_str(&text).expect("the grammar is JSON");
        let mut engine = Self { grammar, expressions: BTreeMap::new() };
        let grammar = engine.grammar.clone();
        engine.compile(&grammar);
        engine
    }

    fn compile(&mut self, rule: &Value) {
        match rule {
            Value::Object(fields) => {
                for (name, value) in fields {
                    if let (true, Some(text)) = (["match", "begin", "end"].contains(&name.as_str()), value.as_str()) {
                        let regex = Regex::new(text).unwrap_or_else(|error| panic!("{text}: {error}"));
                        self.expressions.insert(text.to_string(), regex);
                    }
                    self.compile(value);
                }
            }
            Value::Array(items) => items.iter().for_each(|item| self.compile(item)),
            _ => {}
        }
    }

    /// The rules that a list of patterns comes down to, in order.
    fn flat(&self, patterns: &Value, rules: &mut Vec<Value>) {
        for pattern in patterns.as_array().into_iter().flatten() {
            let named = pattern["include"].as_str().map(|name| &self.grammar["repository"][&name[1..]]);
            let rule = named.unwrap_or(pattern);
            assert!(rule.is_object(), "{pattern} is not in the repository");
            if rule["match"].is_null() && rule["begin"].is_null() {
                self.flat(&rule["patterns"], rules);
            } else {
                rules.push(rule.clone());
            }
        }
    }

    /// The first match at or behind a place: the leftmost, and of several the end of the region, then
    /// the first rule.
    fn next(&self, line: &str, at: usize, open: Option<&Region>) -> Option<Found> {
        let mut rules = Vec::new();
        let patterns = open.map_or(&self.grammar["patterns"], |region| &region.rule["patterns"]);
        self.flat(patterns, &mut rules);
        let ends = open.map(|region| (region.rule["end"].clone(), region.rule.clone(), true));
        let begins = rules.into_iter().map(|rule| {
            let text = if rule["match"].is_null() { &rule["begin"] } else { &rule["match"] };
            (text.clone(), rule, false)
        });
        let mut best: Option<Found> = None;
        for (text, rule, is_end) in ends.into_iter().chain(begins) {
            let regex = &self.expressions[text.as_str().expect("an expression is a text")];
            let Some(captures) = regex.captures_from_pos(line, at).expect("it can be searched") else { continue };
            let groups: Vec<_> = (0..captures.len())
                .map(|group| captures.get(group).map(|found| (found.start(), found.end())))
                .collect();
            let start = |groups: &[Option<(usize, usize)>]| groups[0].expect("the whole is a group").0;
            if best.as_ref().is_none_or(|best| start(&groups) < start(&best.groups)) {
                best = Some(Found { rule, is_end, groups });
            }
        }
        best
    }

    /// The scopes of each line's stretches.
    fn highlight(&self, text: &str) -> Vec<Vec<Stretch>> {
        let mut open: Vec<Region> = Vec::new();
        text.lines().map(|line| self.line(line, &mut open)).collect()
    }

    fn line(&self, line: &str, open: &mut Vec<Region>) -> Vec<Stretch> {
        let mut stretches = Vec::new();
        let mut at = 0;
        while at < line.len() {
            let base = scopes_of(open);
            let Some(found) = self.next(line, at, open.last()) else {
                stretches.push(Stretch { from: at, to: line.len(), scopes: base });
                break;
            };
            let (from, to) = found.groups[0].expect("the whole is a group");
            stretches.push(Stretch { from: at, to: from, scopes: base.clone() });
            let own = |mut scopes: Vec<String>| {
                scopes.extend(found.rule["name"].as_str().map(str::to_string));
                scopes
            };
            if found.is_end {
                stretches.push(Stretch { from, to, scopes: base });
                open.pop();
            } else if found.rule["match"].is_null() {
                open.push(Region { rule: found.rule.clone() });
                stretches.push(Stretch { from, to, scopes: scopes_of(open) });
            } else {
                stretches.push(Stretch { from, to, scopes: own(base.clone()) });
                for (group, place) in found.groups.iter().enumerate().skip(1) {
                    let name = found.rule["captures"][group.to_string()]["name"].as_str();
                    if let (&Some((from, to)), Some(name)) = (place, name) {
                        let mut scopes = own(base.clone());
                        scopes.push(name.to_string());
                        stretches.push(Stretch { from, to, scopes });
                    }
                }
            }
            assert!(to > at || found.is_end, "the grammar stands still at {at} of {line}");
            at = to;
        }
        stretches
    }
}

fn scopes_of(open: &[Region]) -> Vec<String> {
    open.iter().filter_map(|region| region.rule["name"].as_str()).map(str::to_string).collect()
}

/// The scopes at a byte of a line: of stretches that lie within one another the last says most.
fn scopes_at(stretches: &[Stretch], at: usize) -> &[String] {
    stretches.iter().rfind(|stretch| stretch.from <= at && at < stretch.to).map_or(&[], |stretch| &stretch.scopes)
}

#[test]
fn the_text_of_the_highlighting_test_has_the_scopes_it_names() {
    let text = text_of("editors/vscode/tests/highlighting.rpl");
    let engine = Engine::new();
    let is_claim = |line: &&str| line.starts_with(';') && line.trim_start_matches([';', ' ']).starts_with('^');
    let code: String = text.split_inclusive('\n').filter(|line| !is_claim(line)).collect();
    let stretches = engine.highlight(&code);
    let (mut row, mut claims) = (0, 0);
    for line in text.lines() {
        if !is_claim(&line) {
            row += 1;
            continue;
        }
        let above = code.lines().nth(row - 1).expect("a claim stands under a line");
        let (marks, scope) = line.rsplit_once("^ ").expect("a claim names a scope");
        let columns = marks.find('^').unwrap_or(marks.len())..marks.len() + 1;
        for column in columns {
            let scopes = scopes_at(&stretches[row - 1], column);
            assert!(
                scopes.iter().any(|known| known == scope.trim()),
                "column {column} of `{above}` is {scopes:?} and not {scope}"
            );
        }
        claims += 1;
    }
    assert!(claims > 40, "{claims} claims");
}

/// What the lexer says of a token, as a part of a scope.
fn expected(token: Token) -> Option<&'static str> {
    match token {
        Token::Str => Some("string."),
        Token::LineComment | Token::BlockComment => Some("comment."),
        Token::Int(_) | Token::Float(_) => Some("constant.numeric."),
        Token::Keyword => Some("constant.keyword."),
        _ => None,
    }
}

#[test]
fn the_grammar_agrees_with_the_lexer_about_every_plan_of_the_repository() {
    let engine = Engine::new();
    let libraries = [
        "stdlib/src/prelude/constructs.rpl",
        "stdlib/src/prelude/functions.rpl",
        "stdlib/src/prelude/revision.rpl",
        "stdlib/src/prelude/rules.rpl",
        "stdlib/src/prelude/foresight.rpl",
        "robot/src/office/plans.rpl",
    ];
    let mut texts = libraries.map(text_of).to_vec();
    for path in files_below(&root().join("examples"), &["rpl"]) {
        texts.push(fs::read_to_string(path).expect("an example can be read"));
    }
    let mut compared = 0;
    for text in &texts {
        let lines = engine.highlight(text);
        let starts: Vec<usize> = text
            .split_inclusive('\n')
            .scan(0, |offset, line| Some(std::mem::replace(offset, *offset + line.len())))
            .collect();
        for (token, span) in lex(text, SourceId(0)).0 {
            let start = span.start as usize;
            let row = starts.partition_point(|&offset| offset <= start) - 1;
            let scopes = scopes_at(&lines[row], start - starts[row]);
            // What a datum comment takes away is a comment whatever it is.
            if scopes.iter().any(|scope| scope.starts_with("comment.block.datum")) {
                continue;
            }
            let written = &text[start..span.end as usize];
            let is = |beginning: &str| scopes.iter().any(|scope| scope.starts_with(beginning));
            match expected(token) {
                Some("constant.keyword.") if written == ":tag" => assert!(is("keyword.control."), "{scopes:?}"),
                Some(beginning) => assert!(is(beginning), "`{written}` is {scopes:?}"),
                None => {
                    let wrong = ["string.", "comment.", "constant.numeric.", "constant.keyword.", "invalid."];
                    assert!(!wrong.iter().any(|wrong| is(wrong)), "`{written}` is {scopes:?}");
                }
            }
            compared += 1;
        }
    }
    assert!(compared > 5_000, "{compared} tokens");
}

#[test]
fn every_file_that_the_extension_names_is_there() {
    let manifest: Value = serde_json::from_str(&text_of("editors/vscode/package.json")).expect("it is JSON");
    let contributes = &manifest["contributes"];
    for path in [&contributes["languages"][0]["configuration"], &contributes["grammars"][0]["path"]] {
        let path = path.as_str().expect("it is a path");
        let text = text_of(&format!("editors/vscode/{path}"));
        serde_json::from_str::<Value>(&text).unwrap_or_else(|error| panic!("{path}: {error}"));
    }
    assert_eq!(contributes["grammars"][0]["scopeName"], Engine::new().grammar["scopeName"]);
}

#[test]
fn findings_of_the_check_are_understood_by_the_extension() {
    let manifest: Value = serde_json::from_str(&text_of("editors/vscode/package.json")).expect("it is JSON");
    let patterns = manifest["contributes"]["problemMatchers"][0]["pattern"].as_array().expect("there are patterns");
    let regexes: Vec<Regex> = patterns
        .iter()
        .map(|pattern| Regex::new(pattern["regexp"].as_str().expect("it has one")).expect("it can be read"))
        .collect();
    let folder = folder("editors");
    put(&folder, "faulty.rpl", "(print 1)\n(no-such-thing)\n");
    let shown = run_in(&folder, &["check", "faulty.rpl"]).errors;
    let lines: Vec<&str> = shown.lines().collect();
    let found = lines.windows(2).find_map(|pair| {
        let heading = regexes[0].captures(pair[0]).ok()??;
        let place = regexes[1].captures(pair[1]).ok()??;
        let group = |captures: &fancy_regex::Captures<'_, str>, pattern: &Value, name: &str| {
            let index = pattern[name].as_u64().expect("it names a group") as usize;
            captures.get(index).map_or(String::new(), |found| found.as_str().to_string())
        };
        Some((
            group(&heading, &patterns[0], "severity"),
            group(&heading, &patterns[0], "code"),
            group(&place, &patterns[1], "file"),
            group(&place, &patterns[1], "line"),
            group(&place, &patterns[1], "column"),
        ))
    });
    let (severity, code, file, line, column) = found.unwrap_or_else(|| panic!("nothing is found in\n{shown}"));
    assert_eq!([severity, code, line, column], ["error", "unbound-name", "2", "2"].map(str::to_string));
    assert!(file.ends_with("faulty.rpl"), "{file}");
}
