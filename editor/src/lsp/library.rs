//! The texts of the library, which no project has: an editor that asks servers for texts gets them by a scheme of their
//! own, and any other as files that are only to be read.

use super::messages::{ErrorCode, Refusal};
use super::session::{Answer, Session};
use crate::analysis::Analysis;
use crate::document::{Document, uri_of};
use crate::lines::Lines;
use crate::outline::Outline;
use lsp_types::request::Request;
use lsp_types::{Location, Uri};
use rpl_lang::bars::read_name;
use rpl_lang::lexer::{Prefix, Token};
use rpl_lang::source::{SourceId, Span};
use rpl_lang::symbol::base_name;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The scheme of the texts: `rpl:/prelude.rpl`.
pub(super) const SCHEME: &str = "rpl";

/// The request for a text by its URI, of version 3.18 of the protocol.
pub(super) enum TextDocumentContent {}

/// Which text.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct TextDocumentContentParams {
    uri: Uri,
}

/// The text.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct TextDocumentContentResult {
    text: String,
}

impl Request for TextDocumentContent {
    type Params = TextDocumentContentParams;
    type Result = TextDocumentContentResult;
    const METHOD: &'static str = "workspace/textDocumentContent";
}

/// A text of the library that every plan without a project is looked at with.
pub(super) fn content(
    session: &mut Session<'_>,
    params: TextDocumentContentParams,
) -> Answer<TextDocumentContentResult> {
    let setting = session.surroundings().setting(Path::new("")).map_err(Refusal::failed)?;
    let sources = setting
        .libraries
        .iter()
        .rev()
        .map(|library| library.names().0)
        .flat_map(|program| (0..program.library_sources).map(|number| program.sources.get(SourceId(number))));
    let mut named = sources.filter(|source| content_uri(&source.name) == params.uri.as_str());
    match named.next() {
        Some(source) => Ok(TextDocumentContentResult { text: source.text.to_string() }),
        None => {
            let reason = format!("there is no text `{}`", params.uri.as_str());
            Err(Refusal::new(ErrorCode::InvalidParams, reason))
        }
    }
}

/// Where the library defines the name at a place, if a text of it does that and not a native function.
pub(super) fn definition(
    session: &Session<'_>,
    document: &Document,
    analysis: &Analysis,
    byte: usize,
) -> Option<Location> {
    let outline = document.outline();
    let at = outline.at(byte).filter(|&at| outline.lexemes[at].token == Token::Symbol)?;
    if at > 0 && outline.lexemes[at - 1].token == Token::Prefix(Prefix::Quote) {
        return None;
    }
    let name = read_name(&document.text[outline.lexemes[at].start..outline.lexemes[at].end]);
    let span = analysis.library_definition(base_name(&name))?;
    let source = analysis.examined.program.sources.get(span.source);
    let uri = uri(session, &source.name, &source.text)?;
    Some(Location::new(uri, Lines::of(&source.text).range(&source.text, name_in(&source.text, span))))
}

/// The bytes of the name in a definition, or of its first parenthesis.
fn name_in(text: &str, span: Span) -> std::ops::Range<usize> {
    let form = &text[span.start as usize..span.end as usize];
    let outline = Outline::of(form);
    let name = outline.forms().next().and_then(|opener| outline.named(opener)).unwrap_or(0..0);
    span.start as usize + name.start..span.start as usize + name.end
}

/// How an editor calls a text of the library. The plans of a module have a file already.
fn uri(session: &Session<'_>, name: &str, text: &str) -> Option<Uri> {
    if Path::new(name).is_absolute() {
        return uri_of(name);
    }
    if session.editor.asks_for_texts {
        return content_uri(name).parse().ok();
    }
    let file = session.surroundings().library_file(&format!("{name}.rpl"), text)?;
    uri_of(&file.to_string_lossy())
}

fn content_uri(name: &str) -> String {
    format!("{SCHEME}:/{name}.rpl")
}

/// Whether an open text is one of the library, where nothing is found and nothing changed.
pub(super) fn is_of_library(session: &Session<'_>, document: &Document) -> bool {
    match document.path.as_os_str().is_empty() {
        true => document.uri.as_str().starts_with(&format!("{SCHEME}:/")),
        false => session.surroundings().is_library_file(&document.path),
    }
}
