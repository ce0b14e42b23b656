//! Names that are defined twice, or that were the library's.

use super::known::Check;
use crate::compile::resolved::Defined;
use crate::diagnostic::Diagnostic;
use crate::name_places::NamePlaces;
use crate::source::{SourceId, Span};
use crate::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let library = library_names(check);
    // A file may replace what it loads; within one file the first definition is lost.
    let mut first: BTreeMap<(SourceId, bool, Symbol), Span> = BTreeMap::new();
    let mut places = NamePlaces::default();
    for definition in &check.subject.text.definitions {
        let is_class = matches!(definition.defined, Defined::Failure);
        let name = check.name(definition.name);
        let place = places.find(&check.subject.program.sources, definition.span, name).unwrap_or(definition.span);
        match first.get(&(definition.span.source, is_class, definition.name)) {
            Some(&before) => {
                let message = format!("`{name}` is defined twice, and this one takes the place of the first");
                let warning = check.warning("duplicate-definition", place, message, "defined again here");
                found.push(warning.related(before, "first defined here"));
            }
            None => {
                first.insert((definition.span.source, is_class, definition.name), place);
                if !is_class && library.contains(&definition.name) {
                    let message = format!("`{name}` is a name of the library, and means something else in this text");
                    let warning = check.warning("redefines-library", place, message, "defined again here");
                    found.push(warning.help(format!(
                        "`rpl doc {name}` says what the library's does; take another name, or write `; check: allow redefines-library` above"
                    )));
                }
            }
        }
    }
}

/// Names of the library's functions, macros and variables.
fn library_names(check: &Check<'_>) -> BTreeSet<Symbol> {
    let program = check.subject.program;
    let globals = program.globals[..program.library_globals as usize].iter().map(|global| global.name);
    let natives = check.natives.keys().filter_map(|native| check.subject.symbols.find(native));
    let macros = check.subject.library.iter().flat_map(|text| &text.definitions).map(|definition| definition.name);
    globals.chain(natives).chain(macros).collect()
}
