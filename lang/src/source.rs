//! Texts by number, and places in them.

use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Number of a text in [`Sources`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct SourceId(pub u32);

/// A stretch of one text, in bytes, `start..end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Span {
    /// The text.
    pub source: SourceId,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// The stretch from the start of `self` to the end of `last`; both lie in one text.
    pub fn to(self, last: Span) -> Span {
        Span { source: self.source, start: self.start, end: last.end }
    }
}

/// One text with the name errors print for it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// File name, `plan#3`, `<repl>`.
    pub name: Arc<str>,
    /// The text.
    pub text: Arc<str>,
}

/// All texts of a program. One is given back only when no span leads into it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sources {
    list: Vec<Source>,
    /// Places that were given back, and are used again.
    free: Vec<u32>,
    /// How many texts there have ever been.
    made: u32,
}

impl Sources {
    /// Adds a text.
    pub fn add(&mut self, name: &str, text: &str) -> SourceId {
        let source = Source { name: name.into(), text: text.into() };
        let id = self.next();
        self.made += 1;
        match self.free.pop() {
            Some(place) => self.list[place as usize] = source,
            None => self.list.push(source),
        }
        id
    }

    /// The number the next text gets.
    pub fn next(&self) -> SourceId {
        SourceId(self.free.last().copied().unwrap_or(self.list.len() as u32))
    }

    /// Places that were given back.
    pub fn free_places(&self) -> &[u32] {
        &self.free
    }

    /// Takes over which places were given back, and how many texts there have ever been.
    pub fn restore(&mut self, free: Vec<u32>, made: u32) {
        (self.free, self.made) = (free, made);
    }

    /// How many texts there have ever been.
    pub fn made(&self) -> u32 {
        self.made
    }

    /// Gives the place of a text back that no span leads into.
    pub fn free(&mut self, id: SourceId) {
        self.list[id.0 as usize] = Source { name: "".into(), text: "".into() };
        self.free.push(id.0);
    }

    /// The text of a number this table gave out.
    pub fn get(&self, id: SourceId) -> &Source {
        &self.list[id.0 as usize]
    }

    /// How many texts there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there is no text.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Line and column of the span's start, both from 1, the column in characters.
    pub fn line_column(&self, span: Span) -> (usize, usize) {
        let text = &self.get(span.source).text;
        let before = &text[..text.floor_char_boundary(span.start as usize)];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }

    /// `file:line:column` of the span's start.
    pub fn place(&self, span: Span) -> String {
        let (line, column) = self.line_column(span);
        format!("{}:{line}:{column}", self.get(span.source).name)
    }

    /// The text the span covers.
    pub fn text_of(&self, span: Span) -> &str {
        let text = &self.get(span.source).text;
        let start = text.floor_char_boundary(span.start as usize);
        &text[start..text.floor_char_boundary((span.end as usize).max(start))]
    }
}
