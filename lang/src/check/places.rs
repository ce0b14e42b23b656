//! Places in the text: what is marked, and what a comment there says.

use crate::bars::read_name;
use crate::diagnostic::Diagnostic;
use crate::lexer::Token;
use crate::lexer::lex;
use crate::source::{LINE_ENDS, Sources, Span, line_end, line_start};

/// What a comment begins with that takes warnings away.
const ALLOWANCE: &str = "; check: allow ";

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

/// Whether a comment in the line of the warning, or in the line above, names its rule.
pub(super) fn is_allowed(sources: &Sources, warning: &Diagnostic) -> bool {
    let text = &sources.get(warning.span.source).text;
    let start = text.floor_char_boundary(warning.span.start as usize);
    let own_start = line_start(text, start);
    let above = text[line_start(text, own_start.saturating_sub(1))..own_start].trim();
    let beside = &text[start..line_end(text, start)];
    let names_rule = |line: &str| {
        line.split_once(ALLOWANCE).is_some_and(|(_, rules)| rules.split_whitespace().any(|rule| rule == warning.code))
    };
    names_rule(beside) || (above.starts_with(';') && names_rule(above))
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

/// Whether a place is in another.
pub(super) fn lies_in(inner: Span, outer: Span) -> bool {
    inner.source == outer.source && outer.start <= inner.start && inner.end <= outer.end
}
