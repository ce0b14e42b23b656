//! A run as what can be seen of it: a head, and lines that each say what has changed.
//!
//! Lengths are in millimetres, angles in milliradians, times in microseconds of the plan, all of them whole numbers: they
//! are short to write, and the same on every machine. The frame of all points is the map's.
//!
//! A line is `[time_us, {what: …}]`. Lines are only ever added. Their order is that of happening, and a state is what the
//! lines up to it have left: a task as the last line about it says, and so on.

use crate::place::{Pose, Spot};
use serde::Serialize;

/// The layout of head and lines.
pub const VERSION: u32 = 2;

/// The lines of a series are no longer than this, some hundred hours of a robot. What comes later is not seen, and the page
/// says so.
pub const MOST_BYTES: usize = 512 << 20;

/// What does not change in a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Head {
    /// The layout.
    pub series: u32,
    /// The version of the program.
    pub rpl: String,
    /// The plan, by name.
    pub plan: String,
    /// Of every random stream.
    pub seed: u64,
    /// The scenario, by name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scenario: Option<String>,
    /// Where it runs, if there is a robot.
    pub map: Option<DrawnMap>,
    /// The robot, if there is one.
    pub robot: Option<DrawnRobot>,
    /// The texts of the plan.
    pub texts: Vec<Text>,
    /// Whether lines tell where the robot really is.
    pub truth: bool,
}

/// A text by the name that places have for it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Text {
    /// The name.
    pub name: String,
    /// The text.
    pub text: String,
}

/// A world as it is drawn.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DrawnMap {
    /// Its name.
    pub name: String,
    /// The lower left corner.
    pub corner: Spot,
    /// Width and height.
    pub size: Spot,
    /// Outlines of what stands there.
    pub solids: Vec<DrawnSolid>,
    /// Its doors.
    pub doors: Vec<DrawnDoor>,
    /// Rooms: name, and where the name stands.
    pub rooms: Vec<(String, Spot)>,
    /// Places: name, and where.
    pub places: Vec<(String, Spot)>,
}

/// What stands in a world.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DrawnSolid {
    /// What it is.
    pub kind: SolidKind,
    /// Its outline, closed; a disc is its middle, and its radius as `radius`.
    pub outline: Vec<Spot>,
    /// Of a disc.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<i32>,
    /// Its name, if it is not in the robot's map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
}

/// A door.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DrawnDoor {
    /// The room it belongs to.
    pub room: String,
    /// Its two jambs, between which its leaf stands when it is closed.
    pub jambs: [Spot; 2],
    /// Whether it is open at the start: really, if where the robot really is is seen, else in the robot's map.
    pub open: bool,
}

/// Kinds of what stands in a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SolidKind {
    /// Part of the building.
    Wall,
    /// Furniture.
    Object,
    /// What is there and not in the robot's map.
    Unmapped,
}

/// A robot as it is drawn.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DrawnRobot {
    /// Its name.
    pub name: String,
    /// Of its disc.
    pub radius: i32,
    /// Where each range reading is measured from, and in which direction, in the robot's frame.
    pub rays: Vec<Pose>,
    /// How far they reach.
    pub range: i32,
    /// Fastest translation and rotation, in mm/s and mrad/s.
    pub fastest: [i32; 2],
    /// How much both change within the time that velocities are considered for.
    pub window: [i32; 2],
}

/// Something that has changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Seen {
    /// A task began, or stands otherwise than before.
    Task(Task),
    /// A task is no more.
    Ended(Ended),
    /// Who has a valve.
    Valve(Valve),
    /// A fluent has another value.
    Fluent(Fluent),
    /// Something was told.
    Told(Told),
    /// The robot.
    Robot(Robot),
    /// Distances in centimetres, one for each ray of the head; 0 where there was no echo.
    Ranges(Vec<i32>),
    /// Points it is on its way to, the next first.
    Targets(Vec<Spot>),
    /// Obstacles that it remembers: x and y of one after the other, in centimetres.
    Obstacles(Vec<i32>),
    /// Where it may be.
    Belief(crate::belief::DrawnBelief),
    /// Numbers of the doors that are closed: really, if that is to be seen, else as far as the robot knows.
    Closed(Vec<usize>),
    /// Objects that are not in the robot's map.
    Things(Vec<DrawnSolid>),
    /// People: x and y of one after the other, in centimetres.
    People(Vec<i32>),
    /// The series is full.
    Full(bool),
}

/// How a living task stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum TaskState {
    /// It has not begun.
    Created,
    /// It can run.
    Ready,
    /// It waits.
    Waits,
    /// It is kept from running.
    Suspended,
}

/// A living task.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Task {
    /// Its number; none has it again.
    pub id: usize,
    /// The living task it belongs to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parent: Option<usize>,
    /// The path it began with.
    pub path: String,
    /// The plan calls it is in, the outermost first: the name in the path, and the arguments.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub calls: Vec<[String; 2]>,
    /// How the call has ended that it was in before: `succeeded`, `failed`, `evaporated`, `left`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub returned: Option<String>,
    /// How it stands.
    pub state: TaskState,
    /// What it waits for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// Until when at the latest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until: Option<u64>,
    /// The form it waits in: text, line and column.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<String>,
    /// The tasks that suspended it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub by: Vec<usize>,
    /// The fluents its condition reads, each as it was, and with those it is computed from.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub reads: Vec<Reading>,
}

/// A fluent that a condition reads.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reading {
    /// Its name.
    pub fluent: String,
    /// Its value when the wait began.
    pub value: String,
    /// What it is computed from.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub from: Vec<Reading>,
}

/// A task that is no more.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Ended {
    /// Its number.
    pub id: usize,
    /// How: `succeeded`, `failed`, `evaporated`.
    pub state: String,
    /// Its value or failure.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub result: String,
}

/// A valve.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Valve {
    /// Its name.
    pub name: String,
    /// Tasks that have it now, one for each place that is not free.
    pub holders: Vec<usize>,
    /// Tasks it was taken away from.
    pub taken: Vec<usize>,
}

/// A fluent.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fluent {
    /// Its name.
    pub name: String,
    /// Its value; none if it was only pulsed.
    pub value: Option<String>,
    /// Who changed it.
    pub by: String,
}

/// What kind of thing is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ToldKind {
    /// The plan printed it.
    Print,
    /// The plan logged it.
    Log,
    /// The robot or the world reports.
    Robot,
    /// A failure was raised.
    Failure,
    /// A failure of the task, or of one below it, was handled.
    Handled,
    /// Something about the plan that a person should know.
    Notice,
}

/// Something that was told.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Told {
    /// What it is.
    pub kind: ToldKind,
    /// The text.
    pub text: String,
    /// The path of the task, if it is one's.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub task: String,
}

/// Where the robot is and believes to be.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Robot {
    /// Where it believes itself to be.
    pub estimate: Pose,
    /// How certain it is of that, in thousandths.
    pub certainty: i32,
    /// Translation in mm/s, rotation in mrad/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<[i32; 2]>,
    /// Charge of its battery, in thousandths.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub battery: Option<i32>,
    /// Where it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub truth: Option<Pose>,
}

/// A run as what is seen of it, as far as it has come.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// The head, as JSON.
    head: String,
    /// The lines, each ended.
    lines: Vec<u8>,
}

impl Series {
    /// A run at its start.
    pub fn new(head: &Head) -> Self {
        Self { head: json(head), lines: Vec::new() }
    }

    /// One that was written before.
    pub fn written(head: String, lines: Vec<u8>) -> Self {
        Self { head, lines }
    }

    /// The head, as JSON.
    pub fn head(&self) -> &str {
        &self.head
    }

    /// The lines so far.
    pub fn lines(&self) -> &[u8] {
        &self.lines
    }

    /// Adds lines, each ended.
    pub fn add(&mut self, lines: &str) {
        self.lines.extend_from_slice(lines.as_bytes());
    }
}

/// Writes lines of a series, as long as there is room.
#[derive(Clone, Debug, Default)]
pub struct SeriesWriter {
    bytes: usize,
}

impl SeriesWriter {
    /// The lines that say what has changed, each ended; none when the series is full, and the last one says that it is.
    pub fn lines(&mut self, time_us: u64, seen: impl IntoIterator<Item = Seen>) -> String {
        let mut lines = String::new();
        if self.bytes >= MOST_BYTES {
            return lines;
        }
        seen.into_iter().for_each(|seen| push_line(&mut lines, time_us, &seen));
        self.bytes += lines.len();
        if self.bytes >= MOST_BYTES {
            push_line(&mut lines, time_us, &Seen::Full(true));
        }
        lines
    }
}

fn push_line(lines: &mut String, time_us: u64, seen: &Seen) {
    lines.push_str(&json(&(time_us, seen)));
    lines.push('\n');
}

/// Structures of names, numbers and lists can always be written.
fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_a_time_and_what_has_changed() {
        let mut writer = SeriesWriter::default();
        let robot = Robot { estimate: [1, -2, 3], certainty: 990, speed: None, battery: Some(500), truth: None };
        let cups = Fluent { name: "cups".into(), value: Some("1".into()), by: "main".into() };
        assert_eq!(
            writer.lines(200_000, [Seen::Robot(robot), Seen::Fluent(cups)]),
            "[200000,{\"robot\":{\"estimate\":[1,-2,3],\"certainty\":990,\"battery\":500}}]\n\
             [200000,{\"fluent\":{\"name\":\"cups\",\"value\":\"1\",\"by\":\"main\"}}]\n"
        );
    }

    #[test]
    fn a_series_that_is_full_says_so_once() {
        let mut writer = SeriesWriter { bytes: MOST_BYTES - 1 };
        let last = writer.lines(1, [Seen::Targets(Vec::new())]);
        assert_eq!(last, "[1,{\"targets\":[]}]\n[1,{\"full\":true}]\n");
        assert_eq!(writer.lines(2, [Seen::Targets(Vec::new())]), "");
    }
}
