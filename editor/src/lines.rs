//! Places as editors count them: lines from 0, and columns in units of UTF-16.

use lsp_types::{Position, Range};
use rpl_lang::source::line_starts;

/// Where the lines of a text begin.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    starts: Vec<u32>,
    /// How many units begin before each stretch of [`STRETCH_BYTES`], and in the whole text.
    units: Vec<u32>,
}

/// A byte of a text, before which something stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// The first of a character, or the end of a line.
    pub byte: usize,
    /// Whether half of the character stands before it.
    pub is_within: bool,
}

/// Units are counted from the start of such a stretch: a text may be one line.
const STRETCH_BYTES: usize = 1024;

/// How many units begin in these bytes.
fn count_units(bytes: &[u8]) -> u32 {
    let units = |byte: u8| match byte {
        0x80..0xc0 => 0,
        0xf0.. => 2,
        _ => 1,
    };
    bytes.iter().map(|&byte| units(byte)).sum()
}

impl Lines {
    /// Of a text. Cost: linear.
    pub fn of(text: &str) -> Self {
        let mut units = vec![0];
        for stretch in text.as_bytes().chunks(STRETCH_BYTES) {
            units.push(units[units.len() - 1] + count_units(stretch));
        }
        Self { starts: line_starts(text).map(|start| start as u32).collect(), units }
    }

    /// How many lines there are; an empty text has one.
    pub fn count(&self) -> usize {
        self.starts.len()
    }

    /// The line a byte stands in.
    pub fn line(&self, byte: usize) -> usize {
        self.starts.partition_point(|&start| start as usize <= byte).saturating_sub(1)
    }

    /// The bytes of a line, its end included.
    fn bytes(&self, line: usize, text: &str) -> std::ops::Range<usize> {
        let start = self.starts.get(line).map_or(text.len(), |&start| start as usize);
        let end = self.starts.get(line + 1).map_or(text.len(), |&start| start as usize);
        start..end
    }

    /// Where a byte of the text stands; one within a character stands before it.
    pub fn position(&self, text: &str, byte: usize) -> Position {
        let byte = text.floor_char_boundary(byte);
        let line = self.line(byte);
        let start = self.bytes(line, text).start.min(byte);
        Position::new(line as u32, self.units_before(text, byte) - self.units_before(text, start))
    }

    /// How many units begin before a byte. O(1).
    fn units_before(&self, text: &str, byte: usize) -> u32 {
        let stretch = byte / STRETCH_BYTES;
        let behind = count_units(&text.as_bytes()[stretch * STRETCH_BYTES..byte]);
        self.units.get(stretch).map_or(0, |before| before + behind)
    }

    /// Where a stretch of bytes stands.
    pub fn range(&self, text: &str, bytes: std::ops::Range<usize>) -> Range {
        Range::new(self.position(text, bytes.start), self.position(text, bytes.end))
    }

    /// The byte at a position. What lies behind a line is its end, what lies behind the text the text's; a position
    /// within a character is before it.
    pub fn byte(&self, text: &str, position: Position) -> usize {
        self.place(text, position).byte
    }

    /// The same, and whether it is within a character. Cost: logarithmic in the text.
    pub fn place(&self, text: &str, position: Position) -> Place {
        let bytes = self.bytes(position.line as usize, text);
        let end = bytes.start + text[bytes.clone()].trim_end_matches(['\n', '\r']).len();
        let wanted = self.units_before(text, bytes.start).saturating_add(position.character);
        // In the last stretch before which no more units begin.
        let stretch = self.units.partition_point(|&before| before <= wanted).saturating_sub(1);
        let start = text.floor_char_boundary((stretch * STRETCH_BYTES).clamp(bytes.start, end));
        let mut units = self.units_before(text, start);
        for (at, character) in text[start..end].char_indices() {
            let after = units + character.len_utf16() as u32;
            if after > wanted {
                return Place { byte: start + at, is_within: units < wanted };
            }
            units = after;
        }
        Place { byte: end, is_within: false }
    }

    /// The bytes of a range, in order whatever the range says.
    pub fn bytes_of(&self, text: &str, range: Range) -> std::ops::Range<usize> {
        let (start, end) = (self.byte(text, range.start), self.byte(text, range.end));
        start.min(end)..start.max(end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_units_of_utf_16() {
        // ä is two bytes and one unit, 🙂 four bytes and two units.
        let text = "(ä 🙂 x)\r\n🙂\r\ry";
        let lines = Lines::of(text);
        assert_eq!(lines.count(), 4);
        let x = text.find('x').expect("it is there");
        assert_eq!((x, lines.position(text, x)), (9, Position::new(0, 6)));
        assert_eq!(lines.byte(text, Position::new(0, 6)), x);
        let y = text.find('y').expect("it is there");
        assert_eq!(lines.position(text, y), Position::new(3, 0));
        // Every character is found again where it stands.
        for (at, character) in text.char_indices().filter(|(_, character)| !matches!(character, '\r' | '\n')) {
            assert_eq!(lines.byte(text, lines.position(text, at)), at, "{character}");
        }
    }

    #[test]
    fn columns_of_a_long_line_are_counted_from_its_start() {
        let text = "aä🙂".repeat(1_000);
        let lines = Lines::of(&text);
        let mut units = 0;
        for (at, character) in text.char_indices() {
            assert_eq!(lines.position(&text, at), Position::new(0, units));
            units += character.len_utf16() as u32;
        }
        assert_eq!(lines.position(&text, text.len()), Position::new(0, units));
    }

    #[test]
    fn positions_that_are_none_are_the_nearest_before() {
        let text = "🙂b\nc";
        let lines = Lines::of(text);
        assert_eq!(lines.byte(text, Position::new(0, 1)), 0, "within a character");
        assert_eq!(lines.byte(text, Position::new(0, 99)), 5, "behind the line, before its end");
        assert_eq!(lines.byte(text, Position::new(9, 0)), text.len());
        assert_eq!(lines.position(text, 2), Position::new(0, 0));
        assert_eq!(lines.bytes_of(text, Range::new(Position::new(1, 1), Position::new(0, 0))), 0..7);
    }
}
