//! The tables of the book that repeat what the code says of itself are written from it.
//!
//! A table stands between `<!-- NAME -->` and `<!-- end -->`. `WRITE_BOOK=1 cargo test -p rpl-tests book`
//! writes all of them anew.

use rpl_lang::reader::read;
use rpl_lang::source::SourceId;
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::{NodeId, NodeKind, Tree};
use rpl_mission::modules;
use rpl_mission::reference::Reference;
use rpl_robot::office::{self, PLANS, RULES};
use rpl_runtime::robot::FluentSpec;
use rpl_runtime::step::native::Native;
use rpl_tests::repository::{root, text_of};
use std::fs;

const PAGE: &str = "docs/behaviours.md";

/// A table of a page: its name there, and its lines.
struct Table {
    name: &'static str,
    lines: Vec<String>,
}

impl Table {
    fn new(name: &'static str, columns: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Self {
        let line = |cells: Vec<String>| format!("| {} |", cells.join(" | "));
        let head = columns.iter().map(|column| (*column).to_string()).collect();
        let rule = columns.iter().map(|_| "---".to_string()).collect();
        Self { name, lines: [head, rule].into_iter().chain(rows).map(line).collect() }
    }

    /// The page with this table in its place.
    fn put_into(&self, page: &str) -> String {
        let begin = format!("<!-- {} -->\n", self.name);
        let (before, rest) = page.split_once(&begin).unwrap_or_else(|| panic!("{PAGE} has no `{begin}`"));
        let (_, after) = rest.split_once("<!-- end -->").unwrap_or_else(|| panic!("`{begin}` has no end"));
        format!("{before}{begin}{}\n<!-- end -->{after}", self.lines.join("\n"))
    }
}

fn behaviours() -> Table {
    let rows = modules::tables().behaviours.iter().map(|behaviour| {
        let valve = behaviour.valve.as_deref().map_or("–".to_string(), |valve| format!("`{valve}`"));
        vec![format!("`{}`", behaviour.name), valve, behaviour.doc.to_string()]
    });
    Table::new("behaviours", &["behaviour", "valve", "what it does"], rows)
}

fn fluents(name: &'static str, fluents: &[FluentSpec]) -> Table {
    let rows = fluents.iter().map(|fluent| vec![format!("`{}`", fluent.name), fluent.doc.to_string()]);
    Table::new(name, &["fluent", "what it holds"], rows)
}

fn functions(name: &'static str, natives: &[Native]) -> Table {
    let shown = natives.iter().filter(|native| !native.name.starts_with('%'));
    let rows = shown.map(|native| {
        let call = format!("{} {}", native.name, native.parameters);
        vec![format!("`({})`", call.trim_end()), native.doc.to_string()]
    });
    Table::new(name, &["function", "what it does"], rows)
}

/// The definitions of the robot's libraries.
fn plans() -> Table {
    let rows = [PLANS, RULES, rpl_lola::PLANS, rpl_rupart::PLANS].into_iter().flat_map(definitions);
    Table::new("plans", &["plan", "what it does"], rows)
}

/// The definitions of a library, each with how it is called and its documentation.
fn definitions(library: &str) -> Vec<Vec<String>> {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (forms, faults) = read(library, SourceId(0), &mut symbols, &mut tree);
    assert!(faults.is_empty(), "{faults:?}");
    let word = |node: NodeId| tree.symbol(node).map_or("", |name| symbols.name(name));
    let rows = forms.iter().filter_map(|&form| {
        let items = tree.items(form);
        let [head, name, parameters, doc, ..] = items else { return None };
        let NodeKind::Str(doc) = &tree.get(*doc).kind else { return None };
        let is_called = ["def-plan", "defun", "defmacro"].contains(&word(*head));
        let written = |node: &NodeId| &library[tree.span(*node).start as usize..tree.span(*node).end as usize];
        let words = std::iter::once(name).chain(tree.items(*parameters)).map(written).collect::<Vec<_>>();
        let is_called = is_called && !word(*name).starts_with('%');
        is_called.then(|| vec![format!("`({})`", words.join(" ")), doc.to_string()])
    });
    rows.collect()
}

/// Definitions in the midst of their files, with and without defaults.
#[test]
fn names_are_shown_as_they_are_called() {
    let reference = Reference::new().expect("the library compiles");
    for called in
        ["(go-to destination &key patience)", "(charge place level)", "(find-opening instruction &optional (from 0.0))"]
    {
        let name = called.trim_start_matches('(').split(' ').next().expect("a name");
        assert_eq!(reference.find(name).expect(name).signature, called);
    }
}

#[test]
fn the_tables_of_the_book_are_those_of_the_code() {
    let tables = [
        behaviours(),
        fluents("fluents", &modules::tables().fluents),
        functions("functions", &modules::natives()),
        plans(),
        fluents("fluents of scenarios", &office::oracle_tables().fluents),
        functions("functions of scenarios", &office::oracle_natives()),
    ];
    let page = text_of(PAGE);
    let wanted = tables.iter().fold(page.clone(), |page, table| table.put_into(&page));
    if std::env::var_os("WRITE_BOOK").is_some() {
        fs::write(root().join(PAGE), &wanted).expect("the page can be written");
    }
    let stale = wanted.lines().find(|line| !page.lines().any(|there| there == *line));
    assert!(
        text_of(PAGE) == wanted,
        "a table of {PAGE} is not that of the code, at `{}`: `WRITE_BOOK=1 cargo test -p rpl-tests book` writes it anew",
        stale.unwrap_or_default()
    );
}
