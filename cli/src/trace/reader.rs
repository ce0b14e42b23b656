//! Reading a trace file, line by line, as far as it goes.

use super::file::{Header, VERSION};
use crate::files;
use anyhow::{Result, anyhow, bail};
use rpl_runtime::trace::{Event, EventKind};
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::Value;
use std::fmt;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// A longer line is no event.
const MAX_LINE_BYTES: u64 = 64 << 20;

/// Times above this would not be exact to the microsecond.
const MAX_TIME_S: f64 = 9e9;

/// An event, and the line it stands in.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Counts from 1, the header included.
    pub number: usize,
    /// As it stands in the file.
    pub text: String,
    /// The event.
    pub event: Event,
}

/// A trace being read. As an iterator it gives the events up to the first line that is none.
pub struct TraceReader {
    /// What the user called it.
    pub name: String,
    /// Which run it is of; none if the file does not say.
    pub header: Option<Header>,
    /// Why reading ended before the end of the file.
    pub damage: Option<String>,
    input: Box<dyn BufRead>,
    number: usize,
    /// A first line that is an event already.
    first: Option<Line>,
}

impl TraceReader {
    /// Opens a trace; `-` is standard input.
    ///
    /// # Errors
    /// It cannot be read, is empty, or is no trace.
    pub fn open(name: &str) -> Result<Self> {
        let input: Box<dyn BufRead> = match name {
            "-" => Box::new(BufReader::new(io::stdin())),
            _ => Box::new(BufReader::new(
                files::open(Path::new(name)).map_err(|error| anyhow!("cannot read the trace `{name}`: {error}"))?,
            )),
        };
        let mut reader = Self { name: name.to_string(), header: None, damage: None, input, number: 0, first: None };
        let bytes = reader.next_bytes().map_err(|error| anyhow!("cannot read the trace `{name}`: {error}"))?;
        if bytes.is_empty() {
            bail!("the trace `{name}` is empty; `rpl run FILE --trace {name}` writes one");
        }
        let text = String::from_utf8_lossy(&bytes);
        match (serde_json::from_str::<Header>(&text), event_in(text.trim_end())) {
            (Ok(header), _) => reader.header = Some(header),
            (_, Ok(event)) => reader.first = Some(Line { number: 1, text: text.trim_end().to_string(), event }),
            (_, Err(reason)) => {
                bail!("`{name}` is no trace: line 1 {reason}; `rpl run FILE --trace {name}` writes one")
            }
        }
        Ok(reader)
    }

    /// What is to be said before the first event, if the file is not of this version.
    pub fn caution(&self) -> Option<String> {
        let name = &self.name;
        match &self.header {
            None => Some(format!(
                "`{name}` does not begin with the header of a trace: it is of an older rpl, or its beginning is cut off"
            )),
            Some(header) if header.version != VERSION => Some(format!(
                "`{name}` is a trace of version {}, and this rpl knows version {VERSION}; it is read as far as it goes",
                header.version
            )),
            Some(_) => None,
        }
    }

    fn next_bytes(&mut self) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.input.by_ref().take(MAX_LINE_BYTES).read_until(b'\n', &mut bytes)?;
        self.number += 1;
        Ok(bytes)
    }

    fn next_line(&mut self) -> Result<Option<Line>, String> {
        let bytes = self.next_bytes().map_err(|error| format!("cannot be read: {error}"))?;
        if bytes.is_empty() {
            return Ok(None);
        }
        let is_whole = bytes.ends_with(b"\n");
        let text = String::from_utf8(bytes).map_err(|_| "is not text".to_string())?;
        let text = text.trim_end().to_string();
        match event_in(&text) {
            Ok(event) => Ok(Some(Line { number: self.number, text, event })),
            Err(_) if !is_whole => Err("is cut off".to_string()),
            Err(reason) => Err(reason),
        }
    }
}

impl Iterator for TraceReader {
    type Item = Line;

    fn next(&mut self) -> Option<Line> {
        if let Some(first) = self.first.take() {
            return Some(first);
        }
        if self.damage.is_some() {
            return None;
        }
        match self.next_line() {
            Ok(line) => line,
            Err(reason) => {
                self.damage =
                    Some(format!("`{}`: line {} {reason}; what stands before it is used", self.name, self.number));
                None
            }
        }
    }
}

/// The fields of an object in their order.
struct Fields(Vec<(String, Value)>);

impl<'de> Deserialize<'de> for Fields {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = Fields;

            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("an object")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Fields, M::Error> {
                let mut fields = Vec::new();
                while let Some(field) = map.next_entry()? {
                    fields.push(field);
                }
                Ok(Fields(fields))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}

/// The event a line tells of.
///
/// # Errors
/// What is wrong with the line, as said after its number.
fn event_in(text: &str) -> Result<Event, String> {
    let Fields(fields) = serde_json::from_str(text).map_err(|_| "is no JSON object".to_string())?;
    let (mut time_s, mut sequence, mut path, mut kind) = (None, None, None, None);
    let mut details = Vec::new();
    for (name, value) in fields {
        match (name.as_str(), value) {
            ("time_s", value) => time_s = value.as_f64(),
            ("seq", value) => sequence = value.as_u64(),
            ("task", Value::String(task)) => path = Some(task),
            ("kind", value) => {
                let known = serde_json::from_value::<EventKind>(value.clone());
                kind = Some(known.map_err(|_| format!("tells of an event of the kind {value}, which is not known"))?);
            }
            (_, Value::String(value)) => details.push((name, value)),
            (_, value) => details.push((name, value.to_string())),
        }
    }
    let time_s = time_s.filter(|time_s| (0.0..MAX_TIME_S).contains(time_s));
    match (time_s, sequence, path, kind) {
        (Some(time_s), Some(sequence), Some(path), Some(kind)) => {
            Ok(Event { time_us: (time_s * 1e6).round() as u64, sequence, path, kind, details })
        }
        _ => Err("is no event: `time_s`, `seq`, `task` and `kind` are expected".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::file::line;
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let event = Event {
            time_us: 12_345_678,
            sequence: 9,
            path: "main/fetch".into(),
            kind: EventKind::Blocked,
            details: vec![("reads".into(), "level open?".into()), ("level".into(), "\"ü\n\"".into())],
        };
        assert_eq!(event_in(&line(&event)), Ok(event));
    }

    #[test]
    fn a_line_that_is_no_event_says_why() {
        for (text, reason) in [
            ("", "no JSON object"),
            ("[1]", "no JSON object"),
            ("{\"time_s\":1}", "`kind` are expected"),
            ("{\"time_s\":-1,\"seq\":1,\"task\":\"\",\"kind\":\"log\"}", "no event"),
            ("{\"time_s\":1e300,\"seq\":1,\"task\":\"\",\"kind\":\"log\"}", "no event"),
            ("{\"time_s\":1,\"seq\":1,\"task\":\"\",\"kind\":\"fly\"}", "the kind \"fly\", which is not known"),
        ] {
            let error = event_in(text).expect_err(text);
            assert!(error.contains(reason), "{text}: {error}");
        }
        let deep = "[".repeat(100_000);
        assert!(event_in(&format!("{{\"a\":{deep}")).is_err());
    }
}
