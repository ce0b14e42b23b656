//! Places in the text: what is marked, and what a comment there says.

use crate::bars::read_name;
use crate::diagnostic::Diagnostic;
use crate::lexer::Token;
use crate::lexer::lex;
use crate::source::{LINE_ENDS, SourceId, Sources, Span};
use std::collections::BTreeMap;

/// What a comment begins with that takes warnings away.
const ALLOWANCE: &str = "; check: allow ";

/// The words that it has; rules follow.
const ALLOWANCE_WORDS: usize = 3;

/// The span if it stands in one line, else its head: `(loop`.
pub(super) fn brief(sources: &Sources, span: Span) -> Span {
    let text = sources.text_of(span);
    if !text.contains(LINE_ENDS) {
        return span;
    }
    let end = text.char_indices().skip(1).find(|&(_, c)| c.is_whitespace() || matches!(c, '(' | ')'));
    Span { end: span.start + end.map_or(1, |(at, _)| at as u32), ..span }
}

/// The text of the span, shortened to one line.
pub(super) fn one_line(sources: &Sources, span: Span) -> String {
    let text = sources.text_of(span);
    match text.split_once(LINE_ENDS) {
        Some((first, _)) => format!("{} …", first.trim_end()),
        None => text.to_string(),
    }
}

/// The word that a form begins with.
pub(super) fn head(sources: &Sources, form: Span) -> &str {
    let text = sources.text_of(form).strip_prefix('(').unwrap_or_default();
    text.split(|c: char| c.is_whitespace() || matches!(c, '(' | ')')).next().unwrap_or_default()
}

/// Comments that take warnings away: where they stand in the texts that warnings are about.
pub(super) struct Allowances<'a> {
    sources: &'a Sources,
    /// Of each text, in order.
    comments: BTreeMap<SourceId, Vec<usize>>,
}

impl<'a> Allowances<'a> {
    /// Those in the texts of a program.
    pub(super) fn new(sources: &'a Sources) -> Self {
        Self { sources, comments: BTreeMap::new() }
    }

    /// Whether a comment in the line of the warning, or in the line above, names its rule.
    pub(super) fn allow(&mut self, warning: &Diagnostic) -> bool {
        let source = self.sources.get(warning.span.source);
        let text = &source.text;
        let comments = self.comments.entry(warning.span.source);
        let comments = comments.or_insert_with(|| text.match_indices(ALLOWANCE).map(|(at, _)| at).collect());
        let names_rule = |from: usize, end: usize| {
            let first = comments.get(comments.partition_point(|&at| at < from)).filter(|&&at| at < end);
            first.is_some_and(|&at| {
                text[at..end].split_whitespace().skip(ALLOWANCE_WORDS).any(|rule| rule == warning.code)
            })
        };
        let start = text.floor_char_boundary(warning.span.start as usize);
        let own = source.line(start).1;
        let above = source.line(own.start.saturating_sub(1)).1.start..own.start;
        names_rule(start, own.end)
            || text[above.clone()].trim_start().starts_with(';') && names_rule(above.start, above.end)
    }
}

/// The place of a name that is bound at the span, which is the name alone or begins a list with it;
/// none if the span is of something else.
pub(super) fn binding_name(sources: &Sources, span: Span, name: &str) -> Option<Span> {
    let text = sources.text_of(span);
    let inner = text.strip_prefix('(').unwrap_or(text);
    let inner_start = text.len() - inner.trim_start().len();
    let rest = text.get(inner_start..)?;
    let end = rest.find(|c: char| c.is_whitespace() || matches!(c, '(' | ')' | ';')).unwrap_or(rest.len());
    if read_name(&rest[..end]) != name {
        return None;
    }
    let start = span.start + inner_start as u32;
    Some(Span { start, end: start + end as u32, ..span })
}

/// Where a keyword stands: at its own place, or, if a macro has copied it, where the call names it.
pub(super) fn keyword(sources: &Sources, call: Span, own: Span, key: &str) -> Span {
    if own != call {
        return own;
    }
    let (tokens, _) = lex(sources.text_of(call), call.source);
    let named = tokens.into_iter().filter(|(token, _)| *token == Token::Keyword).map(|(_, span)| Span {
        start: call.start + span.start,
        end: call.start + span.end,
        ..call
    });
    let is_key = |span: &Span| read_name(&sources.text_of(*span)[1..]) == key;
    named.into_iter().find(is_key).unwrap_or(own)
}
