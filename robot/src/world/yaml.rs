//! The flat part of YAML that map files are written in: `key: value`, and lists of numbers.
//!
//! A whole YAML reader is thousands of lines for seven keys; this one refuses what it does not know.

use crate::file_text::{FileFaults, Finding};
use std::ops::Range;

/// Some text of the file, and where it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct YamlPart {
    pub text: String,
    pub span: Range<usize>,
}

/// What stands behind a key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum YamlValue {
    One(YamlPart),
    List(Vec<YamlPart>, Range<usize>),
}

impl YamlValue {
    pub fn span(&self) -> Range<usize> {
        match self {
            Self::One(part) => part.span.clone(),
            Self::List(_, span) => span.clone(),
        }
    }
}

/// Keys with their values, in the order of the file.
pub(super) fn read(file: &str, text: &str) -> Result<Vec<(YamlPart, YamlValue)>, FileFaults> {
    let fault = |span: Range<usize>, message: &str| {
        let help = "map files are flat: write each key as `key: value`, and lists as `[1.0, 2.0, 0.0]`";
        FileFaults { findings: vec![Finding::new(file, text, span, "", message, help)], more: 0 }
    };
    let mut entries: Vec<(YamlPart, YamlValue)> = Vec::new();
    let mut lines = text.split_inclusive('\n').scan(0, |at, line| {
        let start = *at;
        *at += line.len();
        Some((start, without_comment(line)))
    });
    while let Some((start, line)) = lines.next() {
        if line.trim().is_empty() || line.starts_with("---") || line.starts_with("...") || line.starts_with('%') {
            continue;
        }
        if let Some(item) = line.trim_start().strip_prefix("- ") {
            let part = part_at(start + line.len() - item.len(), item);
            match entries.last_mut() {
                Some((_, YamlValue::List(parts, span))) => {
                    span.end = part.span.end;
                    parts.push(part);
                }
                _ => return Err(fault(part.span, "an item of a list without a key before it")),
            }
            continue;
        }
        let here = part_at(start, line);
        let Some((key, rest)) = line.split_once(':') else {
            return Err(fault(here.span, "no `key: value` in this line"));
        };
        if line.starts_with([' ', '\t']) {
            return Err(fault(here.span, "keys stand at the beginning of their line"));
        }
        let key = part_at(start, key);
        let value_at = start + line.len() - rest.len();
        let mut rest = rest.to_owned();
        if rest.trim_start().starts_with('[') {
            while !rest.contains(']') {
                let Some((_, more)) = lines.next() else {
                    return Err(fault(key.span, "a list that is not closed by `]`"));
                };
                rest.push_str(more);
            }
        }
        let value = part_at(value_at, &rest);
        let value = match value.text.strip_prefix('[').map(|inner| inner.split_once(']')) {
            Some(Some((inner, ""))) => YamlValue::List(list_parts(value.span.start + 1, inner), value.span),
            Some(_) => return Err(fault(value.span, "something behind the `]` of a list")),
            None if value.text.is_empty() => YamlValue::List(Vec::new(), key.span.clone()),
            None => YamlValue::One(value),
        };
        entries.push((key, value));
    }
    Ok(entries)
}

/// The line without a comment: `#` at its start or after white space, outside quotes.
fn without_comment(line: &str) -> &str {
    let mut quote = None;
    let mut before = ' ';
    for (at, character) in line.char_indices() {
        match (quote, character) {
            (None, '#') if before.is_whitespace() => return &line[..at],
            (None, '"' | '\'') => quote = Some(character),
            (Some(open), _) if open == character => quote = None,
            _ => {}
        }
        before = character;
    }
    line
}

/// The text without white space and quotes around it.
fn part_at(start: usize, text: &str) -> YamlPart {
    let trimmed = text.trim();
    let start = start + text.len() - text.trim_start().len();
    let span = start..start + trimmed.len();
    for quote in ['"', '\''] {
        if let Some(inner) = trimmed.strip_prefix(quote).and_then(|rest| rest.strip_suffix(quote)) {
            return YamlPart { text: inner.to_owned(), span };
        }
    }
    YamlPart { text: trimmed.to_owned(), span }
}

fn list_parts(start: usize, inner: &str) -> Vec<YamlPart> {
    let mut at = start;
    let parts = inner.split(',').map(|item| {
        let part = part_at(at, item);
        at += item.len() + 1;
        part
    });
    parts.filter(|part| !part.text.is_empty()).collect()
}
