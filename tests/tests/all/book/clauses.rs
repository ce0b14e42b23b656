//! Every clause of the reference is shown by a test, and no test cites a clause that is not there.
//!
//! A test cites a clause by writing its label, `r[topic.clause]`, in the comment above it or beside
//! the plan that shows it; a case in `tests/cases` does so in a comment of its text.

use rpl_tests::repository::{files_below, root, text_of};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

/// Folders with tests and cases.
const TESTS: &[&str] = &["tests/tests", "tests/cases", "cli/tests", "lang/tests", "stdlib/tests"];

/// The labels cited in a text, each with its line.
fn citations(text: &str) -> Vec<(String, usize)> {
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        for rest in line.split("r[").skip(1) {
            let Some((label, _)) = rest.split_once(']') else { continue };
            let is_label = label.contains('.')
                && label.starts_with(|first: char| first.is_ascii_lowercase())
                && label.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '.' | '-'));
            if is_label {
                found.push((label.to_string(), number + 1));
            }
        }
    }
    found
}

/// The clauses of the reference.
fn clauses() -> BTreeSet<String> {
    let label = |line: &str| Some(line.strip_prefix("`r[")?.split_once("]`")?.0.to_string());
    text_of("docs/language.md").lines().filter_map(label).collect()
}

/// What is cited, and where first.
fn cited() -> BTreeMap<String, String> {
    let files = TESTS.iter().flat_map(|folder| files_below(&root().join(folder), &["rs", "rpl"]));
    let mut cited = BTreeMap::new();
    for file in files.filter(|file| !file.ends_with("clauses.rs")) {
        let text = fs::read_to_string(&file).unwrap_or_default();
        for (label, line) in citations(&text) {
            cited.entry(label).or_insert_with(|| format!("{}:{line}", file.to_string_lossy()));
        }
    }
    cited
}

#[test]
fn every_clause_is_cited_by_a_test() {
    let (clauses, cited) = (clauses(), cited());
    let missing: Vec<&String> = clauses.iter().filter(|clause| !cited.contains_key(*clause)).collect();
    assert!(missing.is_empty(), "{} clauses of {} have no test:\n{missing:#?}", missing.len(), clauses.len());
}

#[test]
fn every_citation_is_of_a_clause() {
    let clauses = clauses();
    let wrong: Vec<String> = cited()
        .into_iter()
        .filter(|(label, _)| !clauses.contains(label))
        .map(|(label, place)| format!("{place}: there is no clause r[{label}]"))
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_citation_is_a_label_in_brackets() {
    let text = "/// r[read.unit] and r[a-b.c2]\nlet x = bar[0.5]; // r[notalabel] r[Up.per]\nr[x.y]";
    let labels = [("read.unit", 1), ("a-b.c2", 1), ("x.y", 3)].map(|(label, line)| (label.to_string(), line));
    assert_eq!(citations(text), labels);
}
