//! Messages of editors and debuggers as bytes: a header with the length, an empty line, and JSON.
//!
//! What is no message is told, and the next one is looked for. It begins with a line that says its length; no such line
//! stands within JSON, where the end of a line in a text is written as two letters.

use serde::Serialize;
use serde_json::Value;
use std::io::{self, BufRead, Read, Write};

/// Longer messages are passed over: no text that is opened has this many bytes.
const MOST_BYTES: u64 = 64 << 20;

/// Longer headers are none.
const MOST_HEADER_BYTES: u64 = 8 << 10;

/// The field by which a message begins.
const LENGTH: &[u8] = b"content-length:";

/// What stands where a message should, in one sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Malformed(pub String);

/// The messages of a stream.
pub struct Frames<R> {
    from: R,
    /// Read, and to be read again.
    kept: Vec<u8>,
    /// Whether what comes may be in the midst of a message: what is none was told, and is not told line by line.
    is_lost: bool,
}

/// A line of a header.
enum Line {
    /// As it stands, without its end.
    Whole(Vec<u8>),
    /// The header has more bytes than any has.
    TooLong(Vec<u8>),
    /// The stream has ended.
    End,
}

impl<R: BufRead> Frames<R> {
    /// Those of a stream from where it stands.
    pub fn new(from: R) -> Self {
        Self { from, kept: Vec::new(), is_lost: false }
    }

    /// The next message, or what stands in its place; none at the end of the stream. After what is no message, this can
    /// be asked again. Cost: linear in the bytes.
    ///
    /// # Errors
    /// The stream ends within a message, or cannot be read.
    pub fn read(&mut self) -> io::Result<Option<Result<Value, Malformed>>> {
        let Some(header) = self.header()? else { return Ok(None) };
        let length = match header {
            Ok(length) if length <= MOST_BYTES => length,
            Ok(length) => return Ok(Some(self.lost(format!("a message of {length} bytes; it may have {MOST_BYTES}")))),
            Err(why) => return Ok(Some(self.lost(why))),
        };
        let mut bytes = Vec::new();
        let read = self.from.by_ref().take(length).read_to_end(&mut bytes)?;
        if read as u64 != length {
            return Err(broken_off(&format!("after {read} of {length} bytes of a message")));
        }
        mend_halves(&mut bytes);
        match serde_json::from_slice(&bytes) {
            Ok(message) => {
                self.is_lost = false;
                Ok(Some(Ok(message)))
            }
            Err(error) => Ok(Some(self.lost(format!("no JSON in a message of {length} bytes: {error}")))),
        }
    }

    fn lost<T>(&mut self, why: String) -> Result<T, Malformed> {
        self.is_lost = true;
        Err(Malformed(why))
    }

    /// The length that the next header says, or what is wrong with it; none at the end of the stream.
    fn header(&mut self) -> io::Result<Option<Result<u64, String>>> {
        let mut left = MOST_HEADER_BYTES;
        let mut has_begun = false;
        let mut length = None;
        loop {
            let line = match self.line(&mut left)? {
                Line::Whole(line) => line,
                Line::TooLong(piece) => {
                    // The field may stand where the pieces meet.
                    let place = place_of_length(&piece).filter(|&place| place > 0);
                    let from = place.unwrap_or(piece.len().saturating_sub(LENGTH.len()));
                    self.kept.splice(0..0, piece[from..].iter().copied());
                    if !self.is_lost {
                        return Ok(Some(Err(format!("a header of more than {MOST_HEADER_BYTES} bytes"))));
                    }
                    left = MOST_HEADER_BYTES;
                    continue;
                }
                Line::End if has_begun => return Err(broken_off("within the header of a message")),
                Line::End => return Ok(None),
            };
            match (length, place_of_length(&line)) {
                (None, Some(0)) => match length_of(&line) {
                    Ok(said) => (length, has_begun) = (Some(said), true),
                    Err(why) => return Ok(Some(Err(why))),
                },
                (None, Some(place)) => {
                    self.kept = [&line[place..], b"\r\n", &self.kept].concat();
                    if !self.is_lost {
                        return Ok(Some(Err(format!("{place} bytes before the header of a message"))));
                    }
                    left = MOST_HEADER_BYTES;
                }
                (Some(before), Some(0)) if length_of(&line) == Ok(before) => {}
                (Some(_), Some(_)) => return Ok(Some(Err("a header with two lengths".to_string()))),
                (Some(length), None) if line.is_empty() => return Ok(Some(Ok(length))),
                (None, None) if self.is_lost => left = MOST_HEADER_BYTES,
                (None, None) if line.is_empty() && !has_begun => {}
                (None, None) if line.is_empty() => {
                    return Ok(Some(Err("a header without `Content-Length`".to_string())));
                }
                (_, None) if is_field(&line) => has_begun = true,
                (_, None) => return Ok(Some(Err(format!("{} is no line of a header", shown(&line))))),
            }
        }
    }

    /// The next line, of `left` bytes at most, which are then fewer.
    fn line(&mut self, left: &mut u64) -> io::Result<Line> {
        let mut line = Vec::new();
        let most = *left;
        let kept = std::mem::take(&mut self.kept);
        let mut all = kept.as_slice().chain(&mut self.from);
        let read = all.by_ref().take(most).read_until(b'\n', &mut line)? as u64;
        self.kept = all.into_inner().0.to_vec();
        *left -= read;
        Ok(match line.last() {
            None if most > 0 => Line::End,
            Some(b'\n') => {
                line.truncate(line.len() - 1 - usize::from(line.ends_with(b"\r\n")));
                Line::Whole(line)
            }
            Some(_) if read < most && self.is_lost => Line::End,
            Some(_) if read < most => return Err(broken_off("within the header of a message")),
            None | Some(_) => Line::TooLong(line),
        })
    }
}

fn broken_off(place: &str) -> io::Error {
    io::Error::new(io::ErrorKind::UnexpectedEof, format!("the stream ends {place}"))
}

/// Where in a line the field with the length begins.
fn place_of_length(line: &[u8]) -> Option<usize> {
    line.windows(LENGTH.len()).position(|stretch| stretch.eq_ignore_ascii_case(LENGTH))
}

/// The length in a line that begins with its name.
fn length_of(line: &[u8]) -> Result<u64, String> {
    let value = std::str::from_utf8(&line[LENGTH.len()..]).ok().map(str::trim);
    let digits = value.filter(|value| value.bytes().all(|byte| byte.is_ascii_digit()));
    digits.and_then(|digits| digits.parse().ok()).ok_or_else(|| format!("{}: it is a number of bytes", shown(line)))
}

/// Whether a line is a field of a header: a word, a colon, and what it says.
fn is_field(line: &[u8]) -> bool {
    let is_of_word = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_');
    line.iter().position(|&byte| byte == b':').is_some_and(|colon| colon > 0 && line[..colon].iter().all(is_of_word))
}

/// The beginning of a line, as a message can have it.
fn shown(line: &[u8]) -> String {
    format!("`{}`", line[..line.len().min(60)].escape_ascii())
}

/// Replaces each half of a character that stands alone in a text of JSON, `"\ud83d"`, by U+FFFD. Editors that count in
/// UTF-16 cut characters in two; no text here can hold that, and U+FFFD has one unit as well, so that all that follows
/// stays where the editor has it.
fn mend_halves(json: &mut [u8]) {
    let mut at = 0;
    while let Some(ahead) = json[at..].iter().position(|&byte| byte == b'\\') {
        at += ahead;
        at += match (unit(json, at), unit(json, at + 6)) {
            (None, _) => 2.min(json.len() - at),
            (Some(0xd800..0xdc00), Some(0xdc00..0xe000)) => 12,
            (Some(0xd800..0xe000), _) => {
                json[at..at + 6].copy_from_slice(b"\\ufffd");
                6
            }
            (Some(_), _) => 6,
        };
    }
}

/// The unit of UTF-16 that is written as `\u` and four digits at a place.
fn unit(json: &[u8], at: usize) -> Option<u16> {
    let digits = json.get(at..at + 6)?.strip_prefix(b"\\u")?;
    u16::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()
}

/// Writes a message.
///
/// # Errors
/// The stream is closed.
pub fn write(message: &impl Serialize, to: &mut impl Write) -> io::Result<()> {
    let text = serde_json::to_string(message)?;
    write!(to, "Content-Length: {}\r\n\r\n{text}", text.len())?;
    to.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// All that is read of some bytes, to their end or to where they break off: messages, and what stands in the place
    /// of one.
    fn read(bytes: &[u8]) -> (Vec<Result<Value, String>>, bool) {
        let mut frames = Frames::new(bytes);
        let mut read = Vec::new();
        loop {
            match frames.read() {
                Ok(Some(one)) => read.push(one.map_err(|Malformed(why)| why)),
                Ok(None) => return (read, true),
                Err(_) => return (read, false),
            }
        }
    }

    fn written(message: &Value) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(message, &mut bytes).expect("memory takes it");
        bytes
    }

    #[test]
    fn what_is_written_is_read_again() {
        let messages = [json!({ "seq": 1, "command": "🙂" }), json!({})];
        let bytes: Vec<u8> = messages.iter().flat_map(written).collect();
        assert_eq!(read(&bytes), (messages.map(Ok).to_vec(), true));
    }

    #[test]
    fn after_what_is_no_message_the_next_one_is_read() {
        let next = json!({ "id": 7 });
        for (bytes, why) in [
            ("Content-Length: 3\r\n\r\n{x}", "no JSON"),
            ("Content-Length: 6\r\n\r\n{\"a\":1}", "no JSON"),
            ("Content-Length: 9\r\n\r\n{\"a\":1}", "no JSON"),
            ("Content-Length: 0\r\n\r\n", "no JSON"),
            ("Content-Length: -4\r\n\r\n{\"a\":1}", "a number of bytes"),
            ("Content-Length: +7\r\n\r\n{\"a\":1}", "a number of bytes"),
            ("Content-Length:\r\n\r\n{\"a\":1}", "a number of bytes"),
            ("Content-Length: 99999999999999999999\r\n\r\n{\"a\":1}", "a number of bytes"),
            ("Content-Length: 99999999999\r\n\r\n{\"a\":1}", "it may have 67108864"),
            ("Content-Length: 7\r\nContent-Length: 8\r\n\r\n{\"a\":1}", "two lengths"),
            ("Content-Type: x\r\n\r\n{\"a\":1}", "without `Content-Length`"),
            ("{\"a\":1}\r\n", "is no line of a header"),
            ("{\"a\":1}", "7 bytes before"),
            ("Content-Length: 7\r\nnonsense\r\n\r\n{\"a\":1}", "is no line of a header"),
        ] {
            let all = [bytes.as_bytes(), &written(&next)].concat();
            let (found, is_whole) = match read(&all) {
                // A length that is too great takes a part of the next message with it.
                (found, _) if found.len() == 1 => read(&[all, written(&next)].concat()),
                whole => whole,
            };
            assert!(found[0].as_ref().is_err_and(|said| said.contains(why)), "{bytes}: {found:?}");
            assert_eq!((&found[1..], is_whole), (&[Ok(next.clone())][..], true), "{bytes}");
        }
        let long = [b"x: ".as_slice(), &[b'a'; 20_000], b"\r\n", &written(&next)].concat();
        assert_eq!(read(&long).0, [Err("a header of more than 8192 bytes".to_string()), Ok(next.clone())]);
        let many = ["a: b\r\n".repeat(2_000).as_bytes(), b"\r\n", &written(&next)].concat();
        assert_eq!(read(&many).0, [Err("a header of more than 8192 bytes".to_string()), Ok(next)]);
    }

    #[test]
    fn the_next_header_is_found_wherever_the_pieces_of_a_long_line_meet() {
        for length in 8_100..8_300 {
            let garbage = [b"{\r\n".as_slice(), &vec![b'x'; length], &written(&json!(1))].concat();
            assert_eq!(read(&garbage).0.last(), Some(&Ok(json!(1))), "{length}");
        }
    }

    #[test]
    fn fields_that_are_not_known_names_in_other_letters_and_empty_lines_are_no_faults() {
        let bytes = b"\r\nContent-Type: application/vscode-jsonrpc; charset=utf-8\r\ncontent-length:2\n\r\n{}\n";
        assert_eq!(read(bytes), (vec![Ok(json!({}))], true));
    }

    #[test]
    fn a_stream_that_ends_within_a_message_has_broken_off() {
        for bytes in ["Content-Length: 5\r\n\r\n{}", "Content-Length: 5\r\n", "Content-Le", "Content-Type: x\r\n"] {
            assert_eq!(read(bytes.as_bytes()), (vec![], false), "{bytes}");
        }
    }

    #[test]
    fn halves_of_characters_that_stand_alone_become_one_unit_each() {
        for (text, meant) in [
            (r#""\ud83d""#, "\u{fffd}"),
            (r#""\uDE42 \ud83d\ude42 \ud83d\ud83d\ude42""#, "\u{fffd} 🙂 \u{fffd}🙂"),
            (r#""\\ud83d \u005cud83d \\\ud83dx""#, "\\ud83d \\ud83d \\\u{fffd}x"),
            (r#""ä\u00e4""#, "ää"),
        ] {
            let bytes = format!("Content-Length: {}\r\n\r\n{text}", text.len());
            assert_eq!(read(bytes.as_bytes()), (vec![Ok(json!(meant))], true), "{text}");
        }
        // What is cut off is no JSON, and nothing worse.
        for text in [r#""\"#, r#""\u"#, r#""\ud83d\u"#, "\"\\u\u{fffd}"] {
            let bytes = format!("Content-Length: {}\r\n\r\n{text}", text.len());
            assert!(read(bytes.as_bytes()).0[0].is_err(), "{text}");
        }
    }
}
