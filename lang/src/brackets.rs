//! Square brackets and braces, as other languages write lists, elements and tables with them: what stands between a
//! pair is one part that cannot be read, and is told of once.

use crate::diagnostic::Diagnostic;
use crate::lexer::{Token, lex};
use crate::source::{LINE_ENDS, SourceId, Span, lies_in};

/// What an element is called in a longer list than this is not shown.
const MOST_SHOWN_BYTES: usize = 40;

/// The tokens of a text as [`lex`] gives them, but for brackets that have a partner: each pair, with what is between and
/// with the name or list directly before it, is one token that is told of. Cost: linear.
pub(crate) fn lex_in_pairs(text: &str, source: SourceId) -> (Vec<(Token, Span)>, Vec<Diagnostic>) {
    let (tokens, mut found) = lex(text, source);
    if !tokens.iter().any(|&(token, span)| bracket(text, token, span).is_some()) {
        return (tokens, found);
    }
    let partners = partners(text, &tokens);
    let mut kept: Vec<(Token, Span)> = Vec::with_capacity(tokens.len());
    let (mut told, mut at) = (Vec::new(), 0);
    while let Some(&(token, span)) = tokens.get(at) {
        let Some(end) = partners[at].filter(|&end| end > at && token == Token::Error) else {
            kept.push((token, span));
            at += 1;
            continue;
        };
        let before = at.checked_sub(1).filter(|&before| tokens[before].1.end == span.start);
        let owner = before.and_then(|before| match tokens[before].0 {
            Token::Symbol => Some(before),
            Token::Close => partners[before],
            _ => None,
        });
        let start = owner.map_or(span.start, |owner| tokens[owner].1.start);
        let part = Span { start, end: tokens[end].1.end, source };
        kept.truncate(kept.partition_point(|(_, kept)| kept.start < start));
        kept.push((Token::Error, part));
        let between = &tokens[at + 1..end];
        told.push(explain(text, Span { end: tokens[end].1.end, ..span }, owner.map(|_| part), between));
        at = end + 1;
    }
    found.retain(|old| !told.iter().any(|new: &Diagnostic| lies_in(old.span, new.span)));
    found.extend(told);
    found.sort_by_key(|diagnostic| diagnostic.span.start);
    (kept, found)
}

fn bracket(text: &str, token: Token, span: Span) -> Option<u8> {
    let written = &text.as_bytes()[span.start as usize..span.end as usize];
    match written {
        &[byte @ (b'[' | b']' | b'{' | b'}')] if token == Token::Error => Some(byte),
        _ => None,
    }
}

/// The partner of each parenthesis and bracket that has one. A `(` in the first column begins a new form: what is open
/// there has none.
fn partners(text: &str, tokens: &[(Token, Span)]) -> Vec<Option<usize>> {
    let mut partners = vec![None; tokens.len()];
    let mut open: Vec<(u8, usize)> = Vec::new();
    for (at, &(token, span)) in tokens.iter().enumerate() {
        let byte = match token {
            Token::Open => b'(',
            Token::Close => b')',
            _ => bracket(text, token, span).unwrap_or_default(),
        };
        let opener = match byte {
            b'(' | b'[' | b'{' => {
                if byte == b'(' && text[..span.start as usize].ends_with(LINE_ENDS) {
                    open.clear();
                }
                open.push((byte, at));
                continue;
            }
            b')' => {
                // A bracket that is still open in the list that ends has no partner.
                while open.last().is_some_and(|&(opener, _)| opener != b'(') {
                    open.pop();
                }
                b'('
            }
            b']' => b'[',
            b'}' => b'{',
            _ => continue,
        };
        if let Some(&(_, partner)) = open.last().filter(|&&(last, _)| last == opener) {
            open.pop();
            (partners[at], partners[partner]) = (Some(partner), Some(at));
        }
    }
    partners
}

/// What a pair was meant for, by what stands before it and between.
fn explain(text: &str, pair: Span, with_owner: Option<Span>, between: &[(Token, Span)]) -> Diagnostic {
    let written = |span: Span| &text[span.start as usize..span.end as usize];
    let (open, close) = if written(pair).starts_with('[') { ('[', ']') } else { ('{', '}') };
    let owner = with_owner.map(|whole| written(Span { end: pair.start, ..whole }));
    let is_word = |token| matches!(token, Token::Symbol | Token::Int(_) | Token::Str);
    let help = match (owner.filter(|owner| owner.len() <= MOST_SHOWN_BYTES), between) {
        (Some(owner), &[(Token::Str, key)]) if key.end - key.start <= MOST_SHOWN_BYTES as u32 => {
            let key = written(key);
            format!("a value is `(gethash {key} {owner})` in a table, `(assoc-value {key} {owner})` in a list of pairs")
        }
        (Some(owner), &[(token, index)]) if is_word(token) && index.end - index.start <= MOST_SHOWN_BYTES as u32 => {
            format!("an element is `(nth {} {owner})`, counted from 0", written(index))
        }
        (Some(owner), _) => format!("an element is `(nth INDEX {owner})`, counted from 0"),
        (None, [(Token::Open, _), ..]) if open == '{' => {
            "forms that are done one after the other are one form by `(seq FORM...)`".to_string()
        }
        (None, _) if open == '{' => {
            "a table is a list of pairs, `'((\"anna\" . a-desk) (\"bert\" . b-desk))`, read by `(assoc-value KEY LIST)`"
                .to_string()
        }
        (None, _) => {
            "lists are written with `(` and `)`: `'(a b)` holds names as they stand, `(list A B)` values".to_string()
        }
    };
    let message = format!("`{open}` and `{close}` have no meaning here");
    let place = with_owner.unwrap_or(pair);
    Diagnostic::error("invalid-character", place, message, "not part of the language").help(help)
}
