//! Operators that stand between their operands, as other languages write them: `(battery < 20)`.

use crate::bars::read_name;
use crate::lexer::{Token, lex};
use crate::source::{Sources, Span};

/// What is written between operands elsewhere.
const OPERATORS: &[&str] = &["<", "<=", ">", ">=", "=", "/=", "+", "-", "*", "/", "eq", "equal", "mod", "and", "or"];

/// The part of a form that is looked at, so that forms inside one another cost no more than they are long.
const LOOKED_AT_BYTES: usize = 200;

/// An operator between two operands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Infix {
    pub(crate) operator: String,
    /// The operands as they stand there; `…` for a list.
    left: String,
    right: String,
    pub(crate) span: Span,
}

impl Infix {
    /// How it is to be written.
    pub(crate) fn advice(&self) -> String {
        let Self { operator, left, right, .. } = self;
        if matches!(operator.as_str(), "and" | "or") {
            // What stands beside it may be half of a comparison.
            return format!("the operator stands first: `({operator} TEST TEST)`");
        }
        format!("the operator stands first: `({operator} {left} {right})`")
    }
}

/// Whether a function is written between its operands in other languages.
pub(crate) fn is_operator(name: &str) -> bool {
    OPERATORS.contains(&name)
}

/// The beginning of a form, as far as it is looked at.
pub(crate) fn beginning(sources: &Sources, form: Span) -> &str {
    let text = sources.text_of(form);
    &text[..text.floor_char_boundary(LOOKED_AT_BYTES)]
}

/// The first operator that stands in a form itself between two operands, behind `behind_items` items.
pub(crate) fn infix_in(sources: &Sources, form: Span, behind_items: u32) -> Option<Infix> {
    let (tokens, _) = lex(beginning(sources, form), form.source);
    let words = tokens.into_iter().filter(|(token, _)| !token.is_comment());
    let tokens: Vec<(Token, Span)> = words.map(|(token, span)| (token, within(form, span))).collect();
    let (mut depth, mut items) = (0_u32, 0_u32);
    for (at, (token, _)) in tokens.iter().enumerate() {
        match token {
            Token::Close => depth = depth.saturating_sub(1),
            Token::Open => {
                items += u32::from(depth == 1);
                depth += 1;
            }
            Token::Symbol if depth == 1 => {
                items += 1;
                if items > behind_items
                    && let Some(infix) = infix_at(sources, &tokens, at)
                {
                    return Some(infix);
                }
            }
            Token::Keyword | Token::Int(_) | Token::Float(_) | Token::Str => items += u32::from(depth == 1),
            Token::Symbol
            | Token::Prefix(_)
            | Token::DatumComment
            | Token::Dot
            | Token::LineComment
            | Token::BlockComment
            | Token::Unterminated
            | Token::Error => {}
        }
    }
    None
}

/// Where the list begins that a place lies in, if that is near.
pub(crate) fn enclosing_list(sources: &Sources, place: Span) -> Option<u32> {
    let text = &sources.get(place.source).text;
    let before = text.as_bytes().get(..place.start as usize)?;
    let (mut depth, mut at) = (0_u32, before.len());
    for byte in before.iter().rev().take(LOOKED_AT_BYTES) {
        at -= 1;
        match byte {
            b')' => depth += 1,
            b'(' if depth == 0 => return Some(at as u32),
            b'(' => depth -= 1,
            _ => {}
        }
    }
    None
}

/// The operator that a place names, if it stands between two operands of a list.
pub(crate) fn infix_of_name(sources: &Sources, name: Span) -> Option<Infix> {
    let start = enclosing_list(sources, name)?;
    let text = &sources.get(name.source).text;
    let end = text.floor_char_boundary(name.end as usize + LOOKED_AT_BYTES);
    let around = Span { start, end: end as u32, ..name };
    let (tokens, _) = lex(sources.text_of(around), name.source);
    let words = tokens.into_iter().filter(|(token, _)| !token.is_comment());
    let tokens: Vec<(Token, Span)> = words.map(|(token, span)| (token, within(around, span))).collect();
    let at = tokens.iter().position(|(_, span)| span.start == name.start)?;
    infix_at(sources, &tokens, at)
}

/// The operator at a place among the tokens, if it stands between two operands.
pub(crate) fn infix_at(sources: &Sources, tokens: &[(Token, Span)], at: usize) -> Option<Infix> {
    let span = tokens[at].1;
    let operator = read_name(sources.text_of(span)).into_owned();
    if tokens[at].0 != Token::Symbol || !is_operator(&operator) {
        return None;
    }
    let left = operand(sources, tokens.get(at.checked_sub(1)?)?, &Token::Close)?;
    let right = operand(sources, tokens.get(at + 1)?, &Token::Open)?;
    Some(Infix { operator, left, right, span })
}

fn operand(sources: &Sources, (token, span): &(Token, Span), list: &Token) -> Option<String> {
    match token {
        Token::Symbol | Token::Keyword | Token::Int(_) | Token::Float(_) | Token::Str => {
            Some(sources.text_of(*span).to_string())
        }
        token => (token == list).then(|| "…".to_string()),
    }
}

fn within(form: Span, span: Span) -> Span {
    Span { start: form.start + span.start, end: form.start + span.end, ..form }
}
