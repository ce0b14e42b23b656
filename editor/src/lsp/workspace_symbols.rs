//! The definitions in the plans of the open folders, by a part of their names.

use super::library;
use super::session::{Answer, Session};
use crate::definitions::{Definition, definitions};
use crate::document::{Document, uri_of};
use lsp_types::{Location, SymbolInformation, Uri, WorkspaceSymbolParams, WorkspaceSymbolResponse};
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::path::Path;

/// Names that are told at once; an editor that is told so shows the best, and asks again when more is typed.
const MOST_SYMBOLS: usize = 400;

pub(super) fn symbols(
    session: &mut Session<'_>,
    params: WorkspaceSymbolParams,
) -> Answer<Option<WorkspaceSymbolResponse>> {
    let folders = session.folders();
    session.files.update(session.surroundings, &folders);
    session.reads += session.files.read_first(session.surroundings);
    let open: BTreeMap<&Path, &Document> =
        session.open.all().filter(|one| one.path.is_absolute()).map(|one| (one.path.as_path(), one)).collect();
    let closed = session.files.known().filter(|(path, _)| !open.contains_key(path));
    let closed = closed.flat_map(|(path, defined)| defined.iter().map(move |one| (path, one.clone())));
    let opened = open.iter().filter(|(_, document)| !library::is_of_library(session, document));
    let opened = opened.flat_map(|(&path, document)| {
        let defined = definitions(&document.text, &document.outline(), &document.lines);
        defined.into_iter().map(move |one| (path, one))
    });
    let query: Vec<char> = params.query.to_lowercase().chars().filter(|c| !c.is_whitespace()).collect();
    let ranked = closed.chain(opened).filter_map(|(path, one)| Some((Reverse(rank(&one.name, &query)?), path, one)));
    let mut found: Vec<(Reverse<u32>, &Path, Definition)> = ranked.collect();
    found.sort_by(|a, b| (a.0, &a.2.name, a.1).cmp(&(b.0, &b.2.name, b.1)));
    let told = found.into_iter().take(MOST_SYMBOLS).filter_map(|(_, path, one)| {
        let uri: Uri =
            open.get(path).map(|document| document.uri.clone()).or_else(|| uri_of(&path.to_string_lossy()))?;
        let beside = folders.iter().find_map(|folder| path.strip_prefix(folder).ok()).unwrap_or(path);
        #[allow(deprecated, reason = "the type has a field that is not used any more, and no other way to be made")]
        Some(SymbolInformation {
            name: one.name,
            kind: one.kind,
            tags: None,
            deprecated: None,
            location: Location::new(uri, one.name_range),
            container_name: Some(beside.to_string_lossy().into_owned()),
        })
    });
    Ok(Some(WorkspaceSymbolResponse::Flat(told.collect())))
}

/// How well a name fits what is typed of it, the better the greater; none if its letters are not in the name, in their
/// order. Letters that begin a word of the name, or stand behind the one before, fit best.
fn rank(name: &str, query: &[char]) -> Option<u32> {
    let mut left = query.iter().peekable();
    let (mut rank, mut before, mut is_running) = (0, '-', false);
    for c in name.chars().flat_map(char::to_lowercase) {
        let fits = left.next_if(|&&wanted| wanted == c).is_some();
        if fits {
            rank += if is_running || !before.is_alphanumeric() { 3 } else { 1 };
        }
        (before, is_running) = (c, fits);
    }
    let is_whole = name.chars().count() == query.len();
    left.peek().is_none().then_some(2 * rank + u32::from(is_whole))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_fit_better_have_a_higher_rank() {
        let of = |name: &str, query: &str| rank(name, &query.chars().collect::<Vec<_>>());
        assert!(of("inspect", "inspect") > of("inspect-if-open", "inspect"));
        assert!(of("inspect-if-open", "iio") > of("initialisation-of", "iio"));
        assert!(of("keep-charged", "charg") > of("coherent-age", "charg"));
        assert_eq!(of("dock", "dc"), Some(4 + 4));
        assert_eq!(of("dock", "cd"), None);
        assert_eq!(of("dock", "docks"), None);
        assert!(of("Größe", "größe").is_some() && of("x", "").is_some());
    }
}
