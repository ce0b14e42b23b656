//! The trace as JSON Lines: a header that says of which run, then one object for each event, and, if
//! asked for, for where the robot was now and then.

use rpl_link::journal::ledger::Ledger;
use rpl_mission::sight::Sight;
use rpl_robot::geometry::Pose;
use rpl_runtime::state::trace::Event;
use serde::ser::SerializeMap;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::json;
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufWriter, Write};

/// The version of the lines that are written.
pub const VERSION: u64 = 1;

/// The first line: which run this is.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// The version of the lines.
    #[serde(rename = "trace")]
    pub version: u64,
    /// The version of the program that wrote it.
    #[serde(default)]
    pub rpl: Option<String>,
    /// The plan's file.
    #[serde(default)]
    pub plan: String,
    /// The world, if there is one.
    #[serde(default)]
    pub world: Option<String>,
    /// The robot, if it is not that of the papers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// What the robot knows of the world, if there is one: `world` or `none`.
    #[serde(default)]
    pub map: Option<String>,
    /// The scenario's file, if there is one.
    #[serde(default)]
    pub scenario: Option<String>,
    /// Seed of every random stream.
    #[serde(default)]
    pub seed: u64,
}

/// A trace file being written.
pub struct TraceFile {
    out: TraceOut,
}

/// Where a trace goes.
enum TraceOut {
    /// Into a file, a pipe or a device.
    File(BufWriter<File>),
    /// Into a file of which a journal knows how far it was written.
    Ledger(Ledger),
}

impl TraceFile {
    /// A file with its header.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn begin(file: File, header: &Header) -> io::Result<Self> {
        let mut trace = Self { out: TraceOut::File(BufWriter::new(file)) };
        trace.line(&serde_json::to_string(header)?)?;
        Ok(trace)
    }

    /// That of a run with a journal, with its header if the run is at its start.
    ///
    /// # Errors
    /// A fault of the program.
    pub fn with_ledger(ledger: Ledger, header: Option<&Header>) -> io::Result<Self> {
        let mut trace = Self { out: TraceOut::Ledger(ledger) };
        if let Some(header) = header {
            trace.line(&serde_json::to_string(header)?)?;
        }
        Ok(trace)
    }

    /// The ledger of a run with a journal.
    pub fn ledger(&mut self) -> Option<&mut Ledger> {
        match &mut self.out {
            TraceOut::Ledger(ledger) => Some(ledger),
            TraceOut::File(_) => None,
        }
    }

    fn line(&mut self, line: &str) -> io::Result<()> {
        match &mut self.out {
            TraceOut::File(out) => {
                out.write_all(line.as_bytes())?;
                out.write_all(b"\n")
            }
            TraceOut::Ledger(ledger) => {
                ledger.push(format!("{line}\n").as_bytes());
                Ok(())
            }
        }
    }

    /// Adds an event.
    ///
    /// # Errors
    /// The disk is full.
    pub fn write(&mut self, event: &Event) -> io::Result<()> {
        self.line(&line(event))
    }

    /// Adds where the robot is.
    ///
    /// # Errors
    /// The disk is full.
    pub fn write_pose(&mut self, seen: &TracedPose) -> io::Result<()> {
        self.line(&pose_line(seen))
    }

    /// Hands everything to the disk; what a ledger has is handed over by its journal.
    ///
    /// # Errors
    /// The disk is full.
    pub fn finish(&mut self) -> io::Result<()> {
        match &mut self.out {
            TraceOut::File(out) => out.flush(),
            TraceOut::Ledger(_) => Ok(()),
        }
    }
}

/// Where the robot was seen at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracedPose {
    /// When, in virtual time.
    pub time_us: u64,
    /// What was seen.
    pub sight: Sight,
}

/// The kind of a line that tells of a pose.
pub(super) const POSE: &str = "pose";

/// `{"time_s":…,"kind":"pose","true":[x, y, heading],"estimated":[x, y, heading],"certainty":…,"velocity":[translation,
/// rotation],"battery":…}` in metres, radians and seconds; `true` is null if it is unknown, velocity and battery before
/// the first step. To the millimetre and less than a hundredth of a degree.
pub(super) fn pose_line(seen: &TracedPose) -> String {
    let Sight { robot_in_map, estimate_in_map, certainty, velocity, battery } = seen.sight;
    let rounded = |value: f64, steps: f64| (value * steps).round() / steps;
    let numbers = |pose: Pose| json!([rounded(pose.x_m, 1e3), rounded(pose.y_m, 1e3), rounded(pose.heading_rad, 1e4)]);
    let velocity =
        velocity.map(|velocity| json!([rounded(velocity.translation_mps, 1e3), rounded(velocity.rotation_radps, 1e4)]));
    format!(
        "{{\"time_s\":{},\"kind\":\"{POSE}\",\"true\":{},\"estimated\":{},\"certainty\":{},\"velocity\":{},\"battery\":{}}}",
        json!(seen.time_us as f64 / 1e6),
        json!(robot_in_map.map(numbers)),
        numbers(estimate_in_map),
        json!(rounded(certainty, 1e4)),
        json!(velocity),
        json!(battery.map(|battery| rounded(battery, 1e4)))
    )
}

/// `{"time_s":…,"seq":…,"task":…,"kind":…,…}` with the details in their order.
pub fn line(event: &Event) -> String {
    // A map of texts and numbers can always be written.
    serde_json::to_string(&Line(event)).unwrap_or_default()
}

/// An event as it is written.
struct Line<'a>(&'a Event);

/// The keys of every line.
const HEAD: [&str; 4] = ["time_s", "seq", "task", "kind"];

impl Serialize for Line<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Line(event) = self;
        let mut map = serializer.serialize_map(None)?;
        let [time, sequence, task, kind] = HEAD;
        map.serialize_entry(time, &(event.time_us as f64 / 1e6))?;
        map.serialize_entry(sequence, &event.sequence)?;
        map.serialize_entry(task, &event.path)?;
        map.serialize_entry(kind, event.kind.name())?;
        let mut taken = BTreeSet::new();
        for (name, value) in &event.details {
            let mut name = Cow::from(name.as_str());
            while HEAD.contains(&&*name) || taken.contains(&name) {
                name.to_mut().push('_');
            }
            map.serialize_entry(&name, value)?;
            taken.insert(name);
        }
        map.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_runtime::state::trace::EventKind;
    use serde_json::Value;

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
