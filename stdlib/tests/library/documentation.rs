//! Every name is documented, and means one thing.

use crate::evaluate::library;
use rpl_lang::reader;
use rpl_lang::source::SourceId;
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::{NodeKind, Tree};
use std::collections::BTreeMap;

/// Kind, name and documentation of every definition of the prelude.
fn prelude_definitions() -> Vec<(String, String, Option<String>)> {
    let (mut symbols, mut tree) = (Symbols::default(), Tree::default());
    let (forms, diagnostics) = reader::read(rpl_stdlib::PRELUDE, SourceId(0), &mut symbols, &mut tree);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    forms
        .iter()
        .map(|&form| {
            let items = tree.items(form);
            let name = |at: usize| tree.symbol(items[at]).map(|name| symbols.name(name).to_string());
            // A rule says at its end what it is for.
            let is_rule = name(0).is_some_and(|kind| kind == "def-revision");
            let doc = items.get(if is_rule { items.len() - 1 } else { 3 }).and_then(|&doc| match &tree.get(doc).kind {
                NodeKind::Str(text) if items.len() > 4 => Some(text.to_string()),
                _ => None,
            });
            (name(0).expect("a definition"), name(1).expect("a name"), doc)
        })
        .collect()
}

#[test]
fn every_definition_of_the_prelude_is_documented() {
    // A record documents the functions it defines itself.
    for (kind, name, doc) in prelude_definitions().into_iter().filter(|(kind, ..)| kind != "defstruct") {
        assert!(
            matches!(kind.as_str(), "defun" | "defmacro" | "def-revision"),
            "{kind} {name}: the prelude only defines, it does not run"
        );
        let doc = doc.unwrap_or_else(|| panic!("`{name}` has no documentation"));
        assert!(doc.ends_with('.'), "the documentation of `{name}` is no sentence: {doc}");
    }
}

#[test]
fn every_native_is_documented() {
    for native in rpl_stdlib::natives() {
        assert!(
            native.doc.ends_with('.') && native.doc.len() > 10,
            "the documentation of `{}`: {}",
            native.name,
            native.doc
        );
        let (min, max) = native.arity();
        assert!(max.is_none_or(|max| min <= max), "{}", native.name);
    }
}

#[test]
fn no_name_is_defined_twice() {
    let mut seen: BTreeMap<String, &str> = BTreeMap::new();
    let natives = rpl_stdlib::natives().into_iter().map(|native| (native.name.to_string(), "the library"));
    let runtime =
        rpl_runtime::step::natives::natives().into_iter().map(|native| (native.name.to_string(), "the runtime"));
    let prelude = prelude_definitions().into_iter().map(|(_, name, _)| (name, "the prelude"));
    for (name, place) in natives.chain(runtime).chain(prelude) {
        if let Some(before) = seen.insert(name.clone(), place) {
            panic!("`{name}` is defined in {before} and again in {place}");
        }
    }
}

#[test]
fn every_setter_has_an_accessor() {
    let names: Vec<&str> = rpl_stdlib::natives().iter().map(|native| native.name).collect();
    for accessor in names.iter().filter_map(|name| name.strip_prefix("%set-")) {
        assert!(names.contains(&accessor), "`{accessor}` can be set and not read");
    }
}

#[test]
fn the_library_compiles_without_warnings() {
    // A name the prelude uses and nobody defines would be an error here.
    assert!(!library().natives.is_empty());
}
