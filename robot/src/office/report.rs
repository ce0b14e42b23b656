//! Reports: what the robot and the scenario have to tell, and how it stands in the trace.

use crate::geometry::Point;
use rpl_runtime::robot::RobotEvent;
use rpl_runtime::state::trace::{Event, EventKind};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Makes of a list of reports, each with its name in traces, the reports and their kinds.
macro_rules! reports {
    ($($(#[$doc:meta])* $name:ident $({ $($fields:tt)* })? => $in_traces:literal,)+) => {
        /// Something that happened.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub enum Report {
            $($(#[$doc])* $name $({ $($fields)* })?,)+
        }

        /// What kind of thing happened, by which traces are read.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum ReportKind {
            $(#[doc = concat!("[`Report::", stringify!($name), "`]")] $name,)+
        }

        impl ReportKind {
            /// All kinds.
            pub const ALL: [Self; [$($in_traces),+].len()] = [$(Self::$name),+];

            /// The name in traces.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$name => $in_traces,)+
                }
            }
        }

        impl Report {
            /// Of what kind it is.
            pub fn kind(&self) -> ReportKind {
                match self {
                    $(Self::$name { .. } => ReportKind::$name,)+
                }
            }
        }
    };
}

reports! {
    /// The run goes on in another process than before, and the world has not waited.
    Resumed => "resumed",
    /// A plan has given the estimate up.
    PositionDoubted => "position doubted",
    /// The position does not count as known any more.
    PositionLost {
        /// Of the estimate.
        certainty: f64,
    } => "position lost",
    /// The position counts as known again.
    PositionFound {
        /// Of the estimate.
        certainty: f64,
    } => "position found",
    /// Odometry errs much farther than the description of the robot says.
    OdometrySlips {
        /// How many times as far.
        times: f64,
    } => "odometry slips",
    /// Much of what the robot has seen of late is not as in the map.
    MapDoesNotFit {
        /// The share of it.
        share: f64,
        /// In which room most of that is.
        room: Option<String>,
    } => "map does not fit",
    /// The robot was to drive, and has not moved for a while.
    Immobile {
        /// From 0 to 1.
        battery: f64,
    } => "immobile",
    /// Active localization has chosen where to go.
    LocalizationAction {
        /// Seen from where the robot was then.
        target_in_base: Point,
    } => "localization action",
    /// The host is gone.
    HostLost {
        /// One sentence.
        why: String,
    } => "host lost",
    /// What the robot perceived came late.
    PerceptLate {
        /// By how much.
        late_s: f64,
    } => "percept late",
    /// The host says something of time that cannot be: it goes back, stands still or leaps.
    TimeAstray {
        /// By how much between two percepts that should have been a period apart, or as many as are missing.
        by_s: f64,
    } => "time astray",
    /// The odometry of the host has changed by more than the robot can have moved: it counts as no motion.
    OdometryLeapt {
        /// By how far.
        distance_m: f64,
        /// By which angle, counter-clockwise.
        angle_rad: f64,
    } => "odometry leapt",
    /// The wheels are said to be faster than the robot can drive: they count as no faster than it can.
    WheelsTooFast {
        /// Speed ahead.
        translation_mps: f64,
        /// Turning speed.
        rotation_radps: f64,
    } => "wheels too fast",
    /// The host says that a sensor has failed.
    SensorFailed {
        /// Which.
        sensor: String,
    } => "sensor failed",
    /// The host says that a sensor works again.
    SensorWorks {
        /// Which.
        sensor: String,
    } => "sensor works again",
    /// What the robot perceived never came.
    PerceptsMissing {
        /// Missing steps of the host.
        count: u64,
    } => "percepts missing",
    /// To take a percept in and to decide took longer than the period of the host.
    DecisionLong {
        /// How long it took.
        took_s: f64,
    } => "decision long",
    /// The scenario turned the robot.
    RotatedByHand {
        /// Counter-clockwise.
        angle_rad: f64,
    } => "rotated by hand",
    /// The scenario put the robot down somewhere else.
    CarriedByHand {
        /// There.
        point_in_map: Point,
    } => "carried by hand",
    /// The scenario opened a door.
    DoorOpened {
        /// Of this room.
        room: String,
    } => "door opened",
    /// The scenario closed a door.
    DoorClosed {
        /// Of this room.
        room: String,
    } => "door closed",
    /// The scenario put a thing into the world.
    ObjectAdded {
        /// Its name.
        object: String,
    } => "object added",
    /// The scenario took a thing out of the world.
    ObjectRemoved {
        /// Its name.
        object: String,
    } => "object removed",
    /// The scenario made people gather about the robot.
    PeopleGathered {
        /// How many.
        people: usize,
    } => "people gathered",
    /// The scenario made the sonars fail.
    SonarsFailed {
        /// For how long.
        seconds: f64,
    } => "sonars failed",
    /// The scenario held the wheels.
    WheelsHeld {
        /// For how long.
        seconds: f64,
    } => "wheels held",
    /// The scenario put a thing that can be carried somewhere.
    ItemPlaced {
        /// Its name.
        item: String,
    } => "item placed",
    /// The scenario charged or drained the battery.
    BatterySet {
        /// From 0 to 1.
        charge: f64,
    } => "battery set",
    /// The scenario sent the robot a message.
    MessageSent {
        /// Its words.
        text: String,
    } => "message sent",
    /// The scenario printed or logged a line.
    Scenario {
        /// The line.
        text: String,
    } => "scenario",
    /// The scenario ended with a failure.
    ScenarioFailed {
        /// As it is shown.
        failure: String,
        /// Where in its text.
        at: Option<String>,
    } => "scenario failed",
}

impl ReportKind {
    /// What an event of a trace reports, if it is a report.
    pub fn of(event: &Event) -> Option<Self> {
        if event.kind != EventKind::Robot {
            return None;
        }
        let (_, what) = event.details.iter().find(|(name, _)| name == "what")?;
        Self::ALL.into_iter().find(|kind| kind.name() == what)
    }

    /// Whether it is about the pace of a host in another process.
    pub fn is_of_pace(self) -> bool {
        matches!(self, Self::PerceptLate | Self::PerceptsMissing | Self::DecisionLong)
    }

    /// Whether somebody has moved the robot.
    pub fn is_by_hand(self) -> bool {
        matches!(self, Self::RotatedByHand | Self::CarriedByHand)
    }
}

impl Report {
    fn details(self) -> Vec<(&'static str, String)> {
        match self {
            Self::PositionDoubted | Self::Resumed => vec![],
            Self::PositionLost { certainty } | Self::PositionFound { certainty } => {
                vec![("certainty", format!("{certainty:.2}"))]
            }
            Self::OdometrySlips { times } => vec![("factor", format!("{times:.1}"))],
            Self::MapDoesNotFit { share, room } => {
                let room = room.map(|room| ("mostly-in", room));
                [("percent", format!("{:.0}", 100.0 * share))].into_iter().chain(room).collect()
            }
            Self::LocalizationAction { target_in_base } => {
                vec![("ahead", format!("{:.1}", target_in_base.x)), ("left", format!("{:.1}", target_in_base.y))]
            }
            Self::HostLost { why } => vec![("why", why)],
            Self::PerceptLate { late_s } => vec![("seconds", format!("{late_s:.3}"))],
            Self::TimeAstray { by_s } => vec![("seconds", format!("{by_s:.3}"))],
            Self::OdometryLeapt { distance_m, angle_rad } => {
                vec![("metres", format!("{distance_m:.2}")), ("degrees", format!("{:.0}", angle_rad.to_degrees()))]
            }
            Self::WheelsTooFast { translation_mps, rotation_radps } => vec![
                ("metres-per-second", format!("{translation_mps:.2}")),
                ("degrees-per-second", format!("{:.0}", rotation_radps.to_degrees())),
            ],
            Self::SensorFailed { sensor } | Self::SensorWorks { sensor } => vec![("sensor", sensor)],
            Self::PerceptsMissing { count } => vec![("count", format!("{count}"))],
            Self::DecisionLong { took_s } => vec![("seconds", format!("{took_s:.3}"))],
            Self::RotatedByHand { angle_rad } => vec![("degrees", format!("{:.0}", angle_rad.to_degrees()))],
            Self::CarriedByHand { point_in_map } => {
                vec![("x", format!("{:.2}", point_in_map.x)), ("y", format!("{:.2}", point_in_map.y))]
            }
            Self::DoorOpened { room } | Self::DoorClosed { room } => vec![("room", room)],
            Self::ObjectAdded { object } | Self::ObjectRemoved { object } => vec![("object", object)],
            Self::PeopleGathered { people } => vec![("people", format!("{people}"))],
            Self::Immobile { battery } => vec![("battery", format!("{battery:.2}"))],
            Self::WheelsHeld { seconds } | Self::SonarsFailed { seconds } => vec![("seconds", format!("{seconds}"))],
            Self::ItemPlaced { item } => vec![("item", item)],
            Self::BatterySet { charge } => vec![("charge", format!("{charge:.2}"))],
            Self::MessageSent { text } | Self::Scenario { text } => vec![("text", text)],
            Self::ScenarioFailed { failure, at } => {
                let at = at.map(|at| ("at", at));
                [("failure", failure)].into_iter().chain(at).collect()
            }
        }
    }
}

impl From<Report> for RobotEvent {
    fn from(report: Report) -> Self {
        let what = report.kind().name();
        let details = report.details().into_iter().map(|(name, value)| (Cow::Borrowed(name), value));
        Self { what: Cow::Borrowed(what), details: details.collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_found_again_in_the_trace() {
        for kind in ReportKind::ALL {
            let details = vec![("what".to_string(), kind.name().to_string())];
            let event = Event { time_us: 0, sequence: 0, path: String::new(), kind: EventKind::Robot, details };
            assert_eq!(ReportKind::of(&event), Some(kind));
            assert_eq!(ReportKind::of(&Event { kind: EventKind::Valve, ..event }), None);
        }
    }
}
