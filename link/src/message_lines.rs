//! Lines of bounded length read from a stream: whoever sends one without an end fills no memory.

use rpl_protocol::host::LONGEST_LINE;
use std::io::{BufRead, ErrorKind};

/// What was read.
#[derive(Debug, PartialEq, Eq)]
pub enum ReadLine {
    /// A line, without its end.
    Text(String),
    /// There is nothing more; half a line is nothing.
    End,
    /// One clause that says why it is no line.
    Fault(String),
}

/// Reads the next line.
pub fn read_line(from: &mut impl BufRead) -> ReadLine {
    let mut line = Vec::new();
    loop {
        let available = match from.fill_buf() {
            Ok(available) => available,
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            // The other end was killed: what the system says of it does not matter.
            Err(_) => return ReadLine::End,
        };
        if available.is_empty() {
            return ReadLine::End;
        }
        let end = available.iter().position(|&byte| byte == b'\n');
        let taken = end.unwrap_or(available.len());
        line.extend_from_slice(&available[..taken]);
        from.consume(end.map_or(taken, |end| end + 1));
        if line.len() > LONGEST_LINE {
            return ReadLine::Fault(format!("a line of more than {LONGEST_LINE} bytes"));
        }
        if end.is_some() {
            return match String::from_utf8(line) {
                Ok(text) => ReadLine::Text(text),
                Err(_) => ReadLine::Fault("a line that is not UTF-8".to_string()),
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufReader, repeat};

    #[test]
    fn lines_have_an_end_and_a_bound() {
        let mut text = "one\ntwo\nthr".as_bytes();
        assert_eq!(read_line(&mut text), ReadLine::Text("one".to_string()));
        assert_eq!(read_line(&mut text), ReadLine::Text("two".to_string()));
        assert_eq!(read_line(&mut text), ReadLine::End);
        let ReadLine::Fault(why) = read_line(&mut BufReader::new(repeat(b'x'))) else { panic!("it has no end") };
        assert!(why.contains("1048576 bytes"), "{why}");
        assert!(matches!(read_line(&mut &b"\xff\n"[..]), ReadLine::Fault(_)));
    }
}
