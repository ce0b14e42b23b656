//! Names as they are written: bare, or between bars where the bare name would be read as something else.

use crate::lexer::{BAR, Token, is_of_word, lex, unescape};
use crate::number::begins_like_number;
use crate::source::SourceId;
use crate::symbol::{base_name, fold_name, is_uninterned};
use crate::visible::{delimited, visible};
use std::borrow::Cow;

/// The name of a symbol as it is written; one made by `gensym`, which cannot be read, as it is shown.
pub fn written_name(name: &str) -> Cow<'_, str> {
    if is_bare(name) {
        Cow::Borrowed(name)
    } else if is_uninterned(name) {
        visible(name)
    } else {
        Cow::Owned(delimited(name, BAR))
    }
}

/// A keyword as it is written, by its name without the colon.
pub fn written_keyword(name: &str) -> String {
    if is_word(name) { format!(":{name}") } else { format!(":{}", delimited(name, BAR)) }
}

/// The name that the text of a [`Token::Symbol`] stands for, or that of a [`Token::Keyword`] behind the colon.
pub fn read_name(text: &str) -> Cow<'_, str> {
    match text.strip_prefix(BAR).and_then(|rest| rest.strip_suffix(BAR)) {
        Some(body) => Cow::Owned(unescape(body, BAR).0),
        None => fold_name(text),
    }
}

/// The name of the symbol that a text is, if it is one and nothing else.
pub fn only_symbol(text: &str) -> Option<Cow<'_, str>> {
    let (tokens, found) = lex(text, SourceId(0));
    match tokens.as_slice() {
        [(Token::Symbol, span)] if found.is_empty() && (span.end - span.start) as usize == text.len() => {
            Some(read_name(text))
        }
        _ => None,
    }
}

/// Whether the text of a [`Token::Symbol`] at the head of a list says that the list defines something.
pub fn begins_definition(head: &str) -> bool {
    base_name(&read_name(head)).starts_with("def")
}

/// Whether the name, as it is, is read as the symbol of this name.
fn is_bare(name: &str) -> bool {
    is_word(name) && !name.starts_with([':', '#']) && name != "." && !begins_like_number(name)
}

/// Whether the name is one word in lower case.
fn is_word(name: &str) -> bool {
    !name.is_empty() && name.chars().all(is_of_word) && fold_name(name) == name
}
