//! Reading a trace file, line by line, as far as it goes.

use super::file::{Header, POSE, TracedPose, VERSION};
use anyhow::{Result, anyhow, bail};
use rpl_lang::visible::visible;
use rpl_mission::sight::Sight;
use rpl_robot::geometry::{Pose, Velocity};
use rpl_runtime::state::time::LAST_INSTANT_US;
use rpl_runtime::state::trace::{Event, EventKind};
use rpl_shell::files::inputs;
use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::Value;
use std::fmt;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

/// A longer line is no event.
const MAX_LINE_BYTES: u64 = 8 << 20;

/// The end of the clock.
const MAX_TIME_S: f64 = LAST_INSTANT_US as f64 / 1e6;

/// An event, and the line it stands in.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceLine {
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
    /// Where the robot was, as far as the file has been read.
    pub poses: Vec<TracedPose>,
    input: Box<dyn BufRead>,
    number: usize,
    /// A first line that is an event already.
    first: Option<TraceLine>,
}

impl TraceReader {
    /// Opens a trace; `-` is standard input.
    ///
    /// # Errors
    /// It cannot be read, is empty, or is no trace.
    pub fn open(name: &str) -> Result<Self> {
        let input: Box<dyn BufRead> = match name {
            "-" => Box::new(BufReader::new(io::stdin())),
            _ => {
                let unread = |reason| anyhow!("cannot read the trace `{}`: {reason}", visible(name));
                Box::new(BufReader::new(inputs::open(Path::new(name)).map_err(unread)?))
            }
        };
        let name = visible(name);
        let mut reader = Self {
            name: name.to_string(),
            header: None,
            damage: None,
            poses: Vec::new(),
            input,
            number: 0,
            first: None,
        };
        let bytes = reader.next_bytes().map_err(|error| anyhow!("cannot read the trace `{name}`: {error}"))?;
        if bytes.is_empty() {
            bail!("the trace `{name}` is empty; `rpl run FILE --trace run.jsonl` writes one");
        }
        let text = String::from_utf8_lossy(&bytes);
        match (serde_json::from_str::<Header>(&text), told_in(text.trim_end())) {
            (Ok(header), _) => reader.header = Some(header),
            (_, Ok(Told::Event(event))) => {
                reader.first = Some(TraceLine { number: 1, text: text.trim_end().to_string(), event });
            }
            (_, Ok(Told::Pose(seen))) => reader.poses.push(seen),
            (_, Err(reason)) => {
                bail!("`{name}` is no trace: line 1 {reason}; `rpl run FILE --trace run.jsonl` writes one")
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

    fn next_line(&mut self) -> Result<Option<TraceLine>, String> {
        loop {
            let bytes = self.next_bytes().map_err(|error| format!("cannot be read: {error}"))?;
            if bytes.is_empty() {
                return Ok(None);
            }
            if bytes.len() as u64 == MAX_LINE_BYTES {
                return Err(format!("is longer than {} MiB", MAX_LINE_BYTES >> 20));
            }
            let is_whole = bytes.ends_with(b"\n");
            let text = String::from_utf8(bytes).map_err(|_| "is not text".to_string())?;
            let text = text.trim_end().to_string();
            match told_in(&text) {
                Ok(Told::Event(event)) => return Ok(Some(TraceLine { number: self.number, text, event })),
                Ok(Told::Pose(seen)) => self.poses.push(seen),
                Err(_) if !is_whole => return Err("is cut off".to_string()),
                Err(reason) => return Err(reason),
            }
        }
    }
}

impl Iterator for TraceReader {
    type Item = TraceLine;

    fn next(&mut self) -> Option<TraceLine> {
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
struct JsonFields(Vec<(String, Value)>);

impl<'de> Deserialize<'de> for JsonFields {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = JsonFields;

            fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                out.write_str("an object")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<JsonFields, M::Error> {
                let mut fields = Vec::new();
                while let Some(field) = map.next_entry()? {
                    fields.push(field);
                }
                Ok(JsonFields(fields))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}

/// What a line tells of.
#[derive(Clone, Debug, PartialEq)]
enum Told {
    Event(Event),
    Pose(TracedPose),
}

/// What a line tells of.
///
/// # Errors
/// What is wrong with the line, as said after its number.
fn told_in(text: &str) -> Result<Told, String> {
    let JsonFields(fields) = serde_json::from_str(text).map_err(|_| "is no JSON object".to_string())?;
    match fields.iter().any(|(name, value)| name == "kind" && value == POSE) {
        true => pose_of(&fields).map(Told::Pose),
        false => event_of(fields).map(Told::Event),
    }
}

fn time_us_of(time_s: f64) -> Option<u64> {
    (0.0..=MAX_TIME_S).contains(&time_s).then_some((time_s * 1e6).round() as u64)
}

fn pose_of(fields: &[(String, Value)]) -> Result<TracedPose, String> {
    let field = |wanted: &str| fields.iter().find(|(name, _)| name == wanted).map(|(_, value)| value);
    let number = |wanted: &str| field(wanted).and_then(Value::as_f64).filter(|number| number.is_finite());
    let pose = |wanted: &str| {
        let numbers: Vec<f64> = field(wanted)?.as_array()?.iter().filter_map(Value::as_f64).collect();
        let &[x_m, y_m, heading_rad] = numbers.as_slice() else { return None };
        Some(Pose { x_m, y_m, heading_rad })
    };
    // A trace of an older rpl has neither.
    let velocity = field("velocity").and_then(Value::as_array).and_then(|numbers| {
        let numbers: Vec<f64> = numbers.iter().filter_map(Value::as_f64).collect();
        let &[translation_mps, rotation_radps] = numbers.as_slice() else { return None };
        Some(Velocity { translation_mps, rotation_radps })
    });
    let time_us = number("time_s").and_then(time_us_of);
    let truth = match field("true") {
        Some(Value::Null) => Some(None),
        _ => pose("true").map(Some),
    };
    match (time_us, truth, pose("estimated"), number("certainty")) {
        (Some(time_us), Some(robot_in_map), Some(estimate_in_map), Some(certainty)) => {
            let battery = number("battery");
            Ok(TracedPose { time_us, sight: Sight { robot_in_map, estimate_in_map, certainty, velocity, battery } })
        }
        _ => Err("is no pose: `time_s`, `true`, `estimated` and `certainty` are expected".to_string()),
    }
}

fn event_of(fields: Vec<(String, Value)>) -> Result<Event, String> {
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
    match (time_s.and_then(time_us_of), sequence, path, kind) {
        (Some(time_us), Some(sequence), Some(path), Some(kind)) => Ok(Event { time_us, sequence, path, kind, details }),
        _ => Err("is no event: `time_s`, `seq`, `task` and `kind` are expected".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::file::{line, pose_line};
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
        assert_eq!(told_in(&line(&event)), Ok(Told::Event(event)));
        let pose = |x_m| Pose { x_m, y_m: -2.5, heading_rad: 1.2345 };
        for robot_in_map in [Some(pose(1.125)), None] {
            let velocity = robot_in_map.map(|_| Velocity { translation_mps: 0.25, rotation_radps: -0.125 });
            let battery = robot_in_map.map(|_| 0.75);
            let sight = Sight { robot_in_map, estimate_in_map: pose(-0.001), certainty: 0.875, velocity, battery };
            let seen = TracedPose { time_us: 1_250_000, sight };
            assert_eq!(told_in(&pose_line(&seen)), Ok(Told::Pose(seen)));
        }
        let older = "{\"time_s\":1.25,\"kind\":\"pose\",\"true\":null,\"estimated\":[0,0,0],\"certainty\":1}";
        assert!(matches!(told_in(older), Ok(Told::Pose(seen)) if seen.sight.battery.is_none()));
    }

    #[test]
    fn a_line_that_is_no_event_says_why() {
        for (text, reason) in [
            ("", "no JSON object"),
            ("[1]", "no JSON object"),
            ("{\"time_s\":1}", "`kind` are expected"),
            ("{\"time_s\":1,\"kind\":\"pose\",\"true\":[1,2],\"estimated\":[1,2,3],\"certainty\":1}", "is no pose"),
            ("{\"time_s\":-1,\"seq\":1,\"task\":\"\",\"kind\":\"log\"}", "no event"),
            ("{\"time_s\":1e300,\"seq\":1,\"task\":\"\",\"kind\":\"log\"}", "no event"),
            ("{\"time_s\":1,\"seq\":1,\"task\":\"\",\"kind\":\"fly\"}", "the kind \"fly\", which is not known"),
        ] {
            let error = told_in(text).expect_err(text);
            assert!(error.contains(reason), "{text}: {error}");
        }
        let deep = "[".repeat(100_000);
        assert!(told_in(&format!("{{\"a\":{deep}")).is_err());
    }
}
