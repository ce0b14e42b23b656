//! Messages as bytes: a header with their length, an empty line, and JSON.

use serde::Serialize;
use serde_json::Value;
use std::io::{self, BufRead, Read, Write};

/// A message of more bytes is none that a debugger sends.
const MOST_BYTES: u64 = 64 << 20;

/// Longer lines stand in no header.
const MOST_HEADER_BYTES: u64 = 8 << 10;

/// The next message; none at the end of the stream.
///
/// # Errors
/// The stream breaks off, or what stands there is no message.
pub fn read(from: &mut impl BufRead) -> io::Result<Option<Value>> {
    let wrong = |what: String| io::Error::new(io::ErrorKind::InvalidData, what);
    let mut length = None;
    loop {
        let mut line = String::new();
        if from.by_ref().take(MOST_HEADER_BYTES).read_line(&mut line)? == 0 {
            return Ok(None);
        }
        let Some(line) = line.strip_suffix('\n') else { return Err(wrong("a header without an end".into())) };
        let line = line.trim_end_matches('\r');
        if line.is_empty() {
            break;
        }
        let (name, value) = line.split_once(':').ok_or_else(|| wrong(format!("`{line}` is no header")))?;
        if name.eq_ignore_ascii_case("content-length") {
            length = Some(value.trim().parse::<u64>().map_err(|error| wrong(format!("`{line}`: {error}")))?);
        }
    }
    let length = length.ok_or_else(|| wrong("a message without `Content-Length`".into()))?;
    if length > MOST_BYTES {
        return Err(wrong(format!("a message of {length} bytes, more than {MOST_BYTES}")));
    }
    let mut bytes = Vec::new();
    if from.take(length).read_to_end(&mut bytes)? as u64 != length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    serde_json::from_slice(&bytes).map(Some).map_err(|error| wrong(error.to_string()))
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

    #[test]
    fn what_is_written_is_read_again() {
        let messages = [json!({ "seq": 1, "command": "🙂" }), json!({})];
        let mut bytes = Vec::new();
        messages.iter().for_each(|message| write(message, &mut bytes).expect("memory takes it"));
        let mut from = bytes.as_slice();
        for message in messages {
            assert_eq!(read(&mut from).expect("it is whole"), Some(message));
        }
        assert_eq!(read(&mut from).expect("it is the end"), None);
    }

    #[test]
    fn what_is_no_message_is_told() {
        for bytes in [
            "x\r\n\r\n",
            "Content-Length: 5\r\n\r\n{}",
            "\r\n",
            "Content-Length: 99999999999\r\n\r\n",
            "Content-Length: 1\r\n\r\n{",
        ] {
            assert!(read(&mut bytes.as_bytes()).is_err(), "{bytes}");
        }
    }
}
