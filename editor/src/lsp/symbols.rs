//! What a text defines, for the outline.

use super::session::{Answer, Session};
use lsp_types::{DocumentSymbol, DocumentSymbolParams, DocumentSymbolResponse, SymbolKind};
use rpl_lang::code::{CodeKind, GlobalKind};
use rpl_lang::compile::DefinedKind;
use rpl_lang::source::Span;

pub(super) fn symbols(
    session: &mut Session<'_>,
    params: DocumentSymbolParams,
) -> Answer<Option<DocumentSymbolResponse>> {
    let analysis = session.analysis(&params.text_document.uri)?;
    let document = session.document(&params.text_document.uri)?;
    let outline = document.outline();
    let source = analysis.examined.source;
    let mut found: Vec<DocumentSymbol> = Vec::new();
    let mut last: Option<Span> = None;
    let defined = analysis.defined().map(|(name, span, kind)| (name.to_string(), span, kind_of(&analysis, name, kind)));
    let tests = analysis.examined.tests.iter().map(|test| (test.name.to_string(), test.span, SymbolKind::EVENT));
    let mut all: Vec<(String, Span, SymbolKind)> = defined.chain(tests).filter(|one| one.1.source == source).collect();
    all.sort_by_key(|one| one.1);
    for (name, span, kind) in all {
        // A form that defines several names, such as a structure, is called by the name it is given.
        if last == Some(span) {
            continue;
        }
        last = Some(span);
        let bytes = span.start as usize..span.end as usize;
        let opener = outline.opener(bytes.start + 1);
        let written = opener
            .and_then(|opener| outline.named(opener))
            .filter(|name| !document.text[name.clone()].starts_with('('));
        let name = written.clone().map_or(name, |written| document.text[written].to_string());
        let selection = written.unwrap_or(bytes.start..bytes.start);
        let head = opener.and_then(|opener| outline.head(&document.text, opener)).map(str::to_string);
        #[allow(deprecated, reason = "the type has a field that is not used any more, and no other way to be made")]
        found.push(DocumentSymbol {
            name,
            detail: head,
            kind,
            tags: None,
            deprecated: None,
            range: document.range(bytes),
            selection_range: document.range(selection),
            children: None,
        });
    }
    Ok(Some(DocumentSymbolResponse::Nested(found)))
}

fn kind_of(analysis: &crate::analysis::Analysis, name: &str, kind: DefinedKind) -> SymbolKind {
    match kind {
        DefinedKind::Function(CodeKind::Plan) => SymbolKind::METHOD,
        DefinedKind::Function(_) | DefinedKind::Macro => SymbolKind::FUNCTION,
        DefinedKind::Failure => SymbolKind::CLASS,
        DefinedKind::Value => match analysis.global(name) {
            Some(GlobalKind::Constant) => SymbolKind::CONSTANT,
            Some(GlobalKind::Fluent) => SymbolKind::PROPERTY,
            Some(GlobalKind::Valve { .. }) => SymbolKind::INTERFACE,
            _ => SymbolKind::VARIABLE,
        },
    }
}
