//! Texts by number, and places in them.

use crate::visible::visible;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::{Arc, OnceLock};

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

/// Whether a place is in another.
pub(crate) fn lies_in(inner: Span, outer: Span) -> bool {
    inner.source == outer.source && outer.start <= inner.start && inner.end <= outer.end
}

/// One text with the name errors print for it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// File name, `plan#3`, `<repl>`.
    pub name: Arc<str>,
    /// The text.
    pub text: Arc<str>,
    #[serde(skip)]
    places: Places,
}

/// Where lines start and characters stand in a text, once somebody has asked for a place in it.
#[derive(Clone, Debug, Default)]
struct Places(OnceLock<Arc<Landmarks>>);

/// What places in a text are counted from.
#[derive(Debug)]
struct Landmarks {
    /// The first byte of each line.
    lines: Vec<u32>,
    /// How many characters begin before each stretch of [`STRETCH_BYTES`], and in the whole text.
    characters: Vec<u32>,
}

/// Characters are counted from the start of such a stretch: a text may be one line.
const STRETCH_BYTES: usize = 1024;

/// How many characters begin in these bytes.
fn count_characters(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&byte| byte & 0xc0 != 0x80).count()
}

impl Landmarks {
    fn of(text: &str) -> Self {
        let mut characters = vec![0];
        for stretch in text.as_bytes().chunks(STRETCH_BYTES) {
            characters.push(characters[characters.len() - 1] + count_characters(stretch) as u32);
        }
        Self { lines: line_starts(text).map(|start| start as u32).collect(), characters }
    }
}

impl PartialEq for Places {
    /// Texts are the same whether or not somebody has asked.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Places {}

impl Source {
    fn new(name: &str, text: &str) -> Self {
        Self { name: name.into(), text: text.into(), places: Places::default() }
    }

    fn landmarks(&self) -> &Landmarks {
        self.places.0.get_or_init(|| Arc::new(Landmarks::of(&self.text)))
    }

    /// The number of the line that a byte stands in, from 0, and the line's bytes, its end included. Cost: the first
    /// time O(text), then O(log lines).
    pub fn line(&self, at: usize) -> (usize, Range<usize>) {
        let starts = &self.landmarks().lines;
        let line = starts.partition_point(|&start| start as usize <= at) - 1;
        let end = starts.get(line + 1).map_or(self.text.len(), |&next| next as usize);
        (line, starts[line] as usize..end)
    }

    /// How many characters begin before a byte. Cost: the first time O(text), then O(1).
    pub fn characters_before(&self, at: usize) -> usize {
        let stretch = at / STRETCH_BYTES;
        let behind = count_characters(&self.text.as_bytes()[stretch * STRETCH_BYTES..at]);
        self.landmarks().characters[stretch] as usize + behind
    }
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
        let source = Source::new(name, text);
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
        self.list[id.0 as usize] = Source::new("", "");
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
        let source = self.get(span.source);
        let start = source.text.floor_char_boundary(span.start as usize);
        let (line, bytes) = source.line(start);
        // A mark at the start of the text is no part of it.
        let mark = usize::from(source.text[bytes.start..start].starts_with(BYTE_ORDER_MARK));
        (line + 1, source.characters_before(start) - source.characters_before(bytes.start) - mark + 1)
    }

    /// `file:line:column` of the span's start.
    pub fn place(&self, span: Span) -> String {
        let (line, column) = self.line_column(span);
        format!("{}:{line}:{column}", visible(&self.get(span.source).name))
    }

    /// The text the span covers.
    pub fn text_of(&self, span: Span) -> &str {
        let text = &self.get(span.source).text;
        let start = text.floor_char_boundary(span.start as usize);
        &text[start..text.floor_char_boundary((span.end as usize).max(start))]
    }
}

/// May stand at the start of a text, and says nothing.
pub const BYTE_ORDER_MARK: char = '\u{feff}';

/// What ends a line: line feed, carriage return, or both in this order. Nothing else does, in the
/// reader, in what errors show, in breakpoints and in what is laid out anew alike.
pub const LINE_ENDS: [char; 2] = ['\n', '\r'];

/// The first byte of each line; a text has one more line than it has line ends.
pub fn line_starts(text: &str) -> impl Iterator<Item = usize> {
    let bytes = text.as_bytes();
    let is_end = |at: usize| match bytes[at] {
        b'\n' => true,
        b'\r' => bytes.get(at + 1) != Some(&b'\n'),
        _ => false,
    };
    std::iter::once(0).chain((0..bytes.len()).filter(move |&at| is_end(at)).map(|at| at + 1))
}

/// The first byte of the line a byte stands in.
pub fn line_start(text: &str, at: usize) -> usize {
    // A line feed belongs to the carriage return before it.
    let from =
        if text.as_bytes()[..at].ends_with(b"\r") && text.as_bytes().get(at) == Some(&b'\n') { at - 1 } else { at };
    text[..from].rfind(LINE_ENDS).map_or(0, |end| end + 1)
}

/// The byte behind the last one of the line a byte stands in, its line end not counted.
pub fn line_end(text: &str, at: usize) -> usize {
    text[at..].find(LINE_ENDS).map_or(text.len(), |end| at + end)
}

/// The lines of a text, each with its first byte and without its line end. The end of the last line
/// begins no further one.
pub fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    line_starts(text).filter(|&start| start < text.len()).map(|start| (start, &text[start..line_end(text, start)]))
}

/// Whether a line of a string but its first begins with `(`: it may have swallowed code.
pub(crate) fn holds_code(string: &str) -> bool {
    line_starts(string).skip(1).any(|start| string[start..].starts_with('('))
}

/// How many line ends a text has.
pub fn count_line_ends(text: &str) -> usize {
    line_starts(text).count() - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_line_feed_or_carriage_return_or_both() {
        let text = "a\nb\r\nc\rd\u{b}\u{c}\u{85}\u{2028}e\n\r";
        let found: Vec<&str> = lines(text).map(|(_, line)| line).collect();
        assert_eq!(found, ["a", "b", "c", "d\u{b}\u{c}\u{85}\u{2028}e", ""]);
        assert_eq!(count_line_ends(text), 5);
        for (start, line) in lines(text) {
            for at in (start..=start + line.len()).filter(|&at| text.is_char_boundary(at)) {
                assert_eq!((line_start(text, at), line_end(text, at)), (start, start + line.len()), "{at}");
            }
        }
        // Between the two characters of one end the line has not ended.
        assert_eq!(line_start(text, 4), 2);
        assert_eq!(lines("").count(), 0);
    }

    #[test]
    fn columns_of_a_long_line_count_characters() {
        let text = format!("{}\n{}", "aß€🙂".repeat(700), "b🙂".repeat(700));
        let mut sources = Sources::default();
        let source = sources.add("t", &text);
        let (mut line, mut column) = (1, 1);
        for (at, character) in text.char_indices() {
            let start = at as u32;
            assert_eq!(sources.line_column(Span { source, start, end: start }), (line, column), "{at}");
            assert_eq!(sources.get(source).characters_before(at), text[..at].chars().count());
            (line, column) = if character == '\n' { (line + 1, 1) } else { (line, column + 1) };
        }
        assert_eq!(sources.get(source).characters_before(text.len()), text.chars().count());
        let whole = sources.add("t", &"x".repeat(2 * STRETCH_BYTES));
        assert_eq!(sources.get(whole).characters_before(2 * STRETCH_BYTES), 2 * STRETCH_BYTES);
    }

    #[test]
    fn columns_count_characters() {
        let mut sources = Sources::default();
        let source = sources.add("t", "\u{feff}aß(\r\n\té(");
        let at = |start| sources.line_column(Span { source, start, end: start });
        assert_eq!((at(0), at(3), at(6)), ((1, 1), (1, 1), (1, 3)));
        assert_eq!(at(12), (2, 3));
    }
}
