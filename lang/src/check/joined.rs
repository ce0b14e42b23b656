//! Texts that touch: `"""three"""` are three texts, the first and the last of them empty, and `"a"b` is a text and a
//! name.

use super::known::Check;
use crate::diagnostic::Diagnostic;
use crate::lexer::Token;
use crate::source::{SourceId, Span};
use std::collections::BTreeSet;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let text = check.subject.text;
    let definitions = text.definitions.iter().map(|definition| definition.span);
    let forms = text.forms.iter().chain(&text.tests).map(|form| form.span);
    let sources: BTreeSet<SourceId> = definitions.chain(forms).map(|span| span.source).collect();
    for source in sources.into_iter().filter(|&source| source.0 >= check.subject.program.library_sources) {
        let tokens = check.tokens(source);
        for run in tokens.chunk_by(|&(left, before), &(right, behind)| {
            before.end == behind.start
                && (left == Token::Str && is_datum(right) || right == Token::Str && is_datum(left))
        }) {
            found.extend(joined(check, run));
        }
    }
}

fn is_datum(token: Token) -> bool {
    matches!(token, Token::Str | Token::Symbol | Token::Keyword | Token::Int(_) | Token::Float(_))
}

fn joined(check: &Check<'_>, run: &[(Token, Span)]) -> Option<Diagnostic> {
    let [(_, first), .., (_, last)] = *run else { return None };
    let written = |span: Span| check.subject.program.sources.text_of(span);
    let message = format!("these are {} values, with no space between them", run.len());
    let warning = check.warning("joined-text", first.to(last), message, "not one text");
    Some(match run {
        [(Token::Str, before), (Token::Str, text), (Token::Str, behind)]
            if written(*before) == "\"\"" && written(*behind) == "\"\"" && !written(*text).contains('\n') =>
        {
            warning.help(format!("a text has one quotation mark on each side: `{}`", written(*text)))
        }
        _ => warning.help("a text stands between `\"` and `\"`; in a text a quotation mark is written `\\\"`"),
    })
}

/// Whether a text, or what stands beside one, touches its neighbour.
pub(super) fn touches(check: &Check<'_>, form: Span) -> bool {
    let tokens = check.tokens(form.source);
    let at = tokens.partition_point(|(_, span)| span.start < form.start);
    let Some(&(token, span)) = tokens.get(at).filter(|(_, span)| *span == form) else { return false };
    let neighbours = [at.checked_sub(1), Some(at + 1)].into_iter().flatten().filter_map(|at| tokens.get(at));
    neighbours.into_iter().any(|&(other, place)| {
        (place.end == span.start || span.end == place.start)
            && (other == Token::Str && is_datum(token) || token == Token::Str && is_datum(other))
    })
}
