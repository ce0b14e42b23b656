//! The trace as JSON Lines: one object per event.

use rpl_runtime::trace::Event;
use serde_json::{Map, Value, json};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// A trace file being written.
pub struct TraceFile {
    out: BufWriter<File>,
}

impl TraceFile {
    /// An empty file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn create(path: &Path) -> io::Result<Self> {
        Ok(Self { out: BufWriter::new(File::create(path)?) })
    }

    /// Adds an event.
    ///
    /// # Errors
    /// The disk is full.
    pub fn write(&mut self, event: &Event) -> io::Result<()> {
        writeln!(self.out, "{}", line(event))
    }

    /// Hands everything to the disk.
    ///
    /// # Errors
    /// The disk is full.
    pub fn finish(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// `{"time_s":…,"seq":…,"task":…,"kind":…,…}` with the details in their order.
fn line(event: &Event) -> String {
    let head = [
        ("time_s", json!(event.time_us as f64 / 1e6)),
        ("seq", json!(event.sequence)),
        ("task", json!(event.path)),
        ("kind", json!(event.kind.name())),
    ];
    // `serde_json` sorts the keys of its maps, and a person reads the time first.
    let mut fields: Vec<String> = head.iter().map(|(name, value)| format!("{}:{value}", json!(name))).collect();
    let taken: Vec<&str> = head.iter().map(|&(name, _)| name).collect();
    let mut details = Map::new();
    for (name, value) in &event.details {
        let free = !taken.contains(&name.as_str()) && !details.contains_key(name);
        let name = if free { name.clone() } else { format!("{name}_") };
        fields.push(format!("{}:{}", json!(name), json!(value)));
        details.insert(name, Value::Null);
    }
    format!("{{{}}}", fields.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_runtime::trace::EventKind;

    #[test]
    fn a_line_is_an_object_that_begins_with_the_time() {
        let event = Event {
            time_us: 1_500_000,
            sequence: 7,
            path: "main/wash".into(),
            kind: EventKind::Blocked,
            details: vec![("on".into(), "a \"quoted\" name".into()), ("kind".into(), "x".into())],
        };
        let line = line(&event);
        assert!(line.starts_with("{\"time_s\":1.5,\"seq\":7,\"task\":\"main/wash\",\"kind\":\"blocked\",\"on\":"));
        let read: Value = serde_json::from_str(&line).expect("the line is JSON");
        assert_eq!(read["on"], "a \"quoted\" name");
        assert_eq!(read["kind_"], "x");
    }
}
