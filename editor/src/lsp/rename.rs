//! Another name for what the texts define: written everywhere at once, or not at all.
//!
//! The renamed texts are looked at before they are handed out: every name in them must mean what it meant.

use super::diagnostics::Places;
use super::library;
use super::messages::Refusal;
use super::session::{Answer, Session};
use crate::analysis::Analysis;
use crate::document::Document;
use lsp_types::{PrepareRenameResponse, RenameParams, TextDocumentPositionParams, TextEdit, Uri, WorkspaceEdit};
use rpl_lang::bars::{only_symbol, read_name};
use rpl_lang::lexer::Token;
use rpl_lang::occurrences::{Occurrence, Target};
use rpl_lang::source::{SourceId, Span};
use rpl_lang::symbol::Qualifier;
use std::collections::{BTreeMap, HashMap};

pub(super) fn prepare(
    session: &mut Session<'_>,
    params: TextDocumentPositionParams,
) -> Answer<Option<PrepareRenameResponse>> {
    let analysis = session.analysis(&params.text_document.uri)?;
    let document = session.document(&params.text_document.uri)?;
    not_of_library(session, document, document.byte(params.position))?;
    let Some(occurrence) = analysis.at(document.byte(params.position)) else { return Ok(None) };
    renamable(&analysis, document, occurrence)?;
    Ok(Some(PrepareRenameResponse::Range(document.range_of(occurrence.span))))
}

pub(super) fn rename(session: &mut Session<'_>, params: RenameParams) -> Answer<Option<WorkspaceEdit>> {
    let at = params.text_document_position;
    let analysis = session.analysis(&at.text_document.uri)?;
    let document = session.document(&at.text_document.uri)?;
    not_of_library(session, document, document.byte(at.position))?;
    let Some(&occurrence) = analysis.at(document.byte(at.position)) else {
        return Err(Refusal::failed("here stands no name that this text or one it loads defines"));
    };
    let spans = renamable(&analysis, document, &occurrence)?;
    let new = params.new_name.as_str();
    if only_symbol(new).is_none() {
        return Err(Refusal::failed(format!("`{new}` is no name; a name is a word such as `fetch-cup`")));
    }
    means_the_same(session, document, &analysis, &spans, new)?;
    let places = Places::of(&analysis);
    let mut changes: HashMap<Uri, Vec<TextEdit>> = HashMap::new();
    for location in spans.iter().filter_map(|&span| places.location_in(span, document)) {
        changes.entry(location.uri).or_default().push(TextEdit::new(location.range, new.to_string()));
    }
    Ok(Some(WorkspaceEdit::new(changes)))
}

/// Refuses a name that stands in the library, or says that it is the library's.
fn not_of_library(session: &Session<'_>, document: &Document, byte: usize) -> Answer<()> {
    if library::is_of_library(session, document) {
        return Err(Refusal::failed("this is a text of the library, and stays what it is"));
    }
    let outline = document.outline();
    let lexeme = outline.at(byte).map(|at| outline.lexemes[at]).filter(|lexeme| lexeme.token == Token::Symbol);
    let Some(lexeme) = lexeme else { return Ok(()) };
    let name = read_name(&document.text[lexeme.start..lexeme.end]);
    match Qualifier::split(&name) {
        Some((Qualifier::Library, base)) => {
            Err(Refusal::failed(format!("`{base}` is a name of the library here, and stays what it is")))
        }
        Some((Qualifier::Global, _)) | None => Ok(()),
    }
}

/// Where a name is written, if it can be changed.
fn renamable(analysis: &Analysis, document: &Document, occurrence: &Occurrence) -> Answer<Vec<Span>> {
    let name = analysis.examined.symbols.name(occurrence.name);
    let all: Vec<&Occurrence> = analysis.of_target(occurrence.target).collect();
    if analysis.definition(occurrence.target).is_none() || !all.iter().any(|one| one.is_binding) {
        return Err(Refusal::failed(format!("`{name}` is not defined in this text or one it loads")));
    }
    if !all.iter().all(|one| one.is_certain) {
        let reason =
            format!("within a macro it cannot be told which `{name}` is meant; give one of them another name by hand");
        return Err(Refusal::failed(reason));
    }
    let is_local = matches!(occurrence.target, Target::Local(_));
    if is_local && all.iter().any(|one| one.is_binding && is_keyword(document, one.span)) {
        let reason =
            format!("`{name}` is a keyword parameter: its callers write `:{name}`, and they would have to change too");
        return Err(Refusal::failed(reason));
    }
    Ok(all.into_iter().map(|one| one.span).collect())
}

/// Whether a parameter stands behind `&key`.
fn is_keyword(document: &Document, span: Span) -> bool {
    let outline = document.outline();
    let Some(at) = outline.at(span.start as usize) else { return false };
    // `(name default)` is a list in the list of parameters.
    let lists = std::iter::successors(outline.around[at], |&opener| outline.around[opener as usize]).take(2);
    let text_of = |at: usize| &document.text[outline.lexemes[at].start..outline.lexemes[at].end];
    let mut items = lists.flat_map(|opener| outline.items(opener as usize));
    items.any(|item| item < at && text_of(item).eq_ignore_ascii_case("&key"))
}

/// Looks at the renamed text, and refuses a name that has a meaning already where it would stand.
fn means_the_same(
    session: &Session<'_>,
    document: &Document,
    analysis: &Analysis,
    spans: &[Span],
    new: &str,
) -> Answer<()> {
    let sources: Vec<SourceId> = analysis.sources().collect();
    let texts: BTreeMap<String, String> = sources
        .iter()
        .map(|&source| {
            let known = analysis.examined.program.sources.get(source);
            let mut text = known.text.to_string();
            for span in spans.iter().rev().filter(|span| span.source == source) {
                text.replace_range(span.start as usize..span.end as usize, new);
            }
            (known.name.to_string(), text)
        })
        .collect();
    let renamed = session.examine_all(document, texts).map_err(Refusal::failed)?;
    let shape = |analysis: &Analysis| {
        let mut numbers = BTreeMap::new();
        let places = analysis.occurrences().iter().map(|one| {
            let next = numbers.len();
            (*numbers.entry(one.target).or_insert(next), one.is_binding)
        });
        (places.collect::<Vec<_>>(), analysis.examined.diagnostics.iter().map(|found| found.code).collect::<Vec<_>>())
    };
    match shape(analysis) == shape(&renamed) {
        true => Ok(()),
        false => Err(Refusal::failed(format!("`{new}` has a meaning already where it would stand; take another name"))),
    }
}
