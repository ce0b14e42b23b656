//! Reports: what the robot and the scenario have to tell, and how it stands in the trace.

use crate::geometry::Point;
use rpl_runtime::robot::RobotEvent;
use rpl_runtime::state::trace::{Event, EventKind};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Report {
    /// A plan has given the estimate up.
    PositionDoubted,
    /// The position does not count as known any more.
    PositionLost {
        /// Of the estimate.
        certainty: f64,
    },
    /// The position counts as known again.
    PositionFound {
        /// Of the estimate.
        certainty: f64,
    },
    /// Active localization has chosen where to go.
    LocalizationAction {
        /// Seen from where the robot was then.
        target_in_base: Point,
    },
    /// The scenario turned the robot.
    RotatedByHand {
        /// Counter-clockwise.
        angle_rad: f64,
    },
    /// The scenario put the robot down somewhere else.
    CarriedByHand {
        /// There.
        point_in_map: Point,
    },
    /// The scenario opened a door.
    DoorOpened {
        /// Of this room.
        room: String,
    },
    /// The scenario closed a door.
    DoorClosed {
        /// Of this room.
        room: String,
    },
    /// The scenario put a thing into the world.
    ObjectAdded {
        /// Its name.
        object: String,
    },
    /// The scenario took a thing out of the world.
    ObjectRemoved {
        /// Its name.
        object: String,
    },
    /// The scenario made the sonars fail.
    SonarsFailed {
        /// For so long.
        seconds: f64,
    },
    /// The scenario put a thing that can be carried somewhere.
    ItemPlaced {
        /// Its name.
        item: String,
    },
    /// The scenario charged or drained the battery.
    BatterySet {
        /// From 0 to 1.
        charge: f64,
    },
    /// The scenario sent the robot a message.
    MessageSent {
        /// Its words.
        text: String,
    },
    /// The scenario printed or logged a line.
    Scenario {
        /// The line.
        text: String,
    },
    /// The scenario ended with a failure.
    ScenarioFailed {
        /// As it is shown.
        failure: String,
        /// Where in its text.
        at: Option<String>,
    },
}

/// What kind of thing happened, by which traces are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReportKind {
    /// [`Report::PositionDoubted`]
    PositionDoubted,
    /// [`Report::PositionLost`]
    PositionLost,
    /// [`Report::PositionFound`]
    PositionFound,
    /// [`Report::LocalizationAction`]
    LocalizationAction,
    /// [`Report::RotatedByHand`]
    RotatedByHand,
    /// [`Report::CarriedByHand`]
    CarriedByHand,
    /// [`Report::DoorOpened`]
    DoorOpened,
    /// [`Report::DoorClosed`]
    DoorClosed,
    /// [`Report::ObjectAdded`]
    ObjectAdded,
    /// [`Report::ObjectRemoved`]
    ObjectRemoved,
    /// [`Report::SonarsFailed`]
    SonarsFailed,
    /// [`Report::ItemPlaced`]
    ItemPlaced,
    /// [`Report::BatterySet`]
    BatterySet,
    /// [`Report::MessageSent`]
    MessageSent,
    /// [`Report::Scenario`]
    Scenario,
    /// [`Report::ScenarioFailed`]
    ScenarioFailed,
}

impl ReportKind {
    /// All kinds.
    pub const ALL: [Self; 16] = [
        Self::PositionDoubted,
        Self::PositionLost,
        Self::PositionFound,
        Self::LocalizationAction,
        Self::RotatedByHand,
        Self::CarriedByHand,
        Self::DoorOpened,
        Self::DoorClosed,
        Self::ObjectAdded,
        Self::ObjectRemoved,
        Self::SonarsFailed,
        Self::ItemPlaced,
        Self::BatterySet,
        Self::MessageSent,
        Self::Scenario,
        Self::ScenarioFailed,
    ];

    /// The name in traces.
    pub fn name(self) -> &'static str {
        match self {
            Self::PositionDoubted => "position doubted",
            Self::PositionLost => "position lost",
            Self::PositionFound => "position found",
            Self::LocalizationAction => "localization action",
            Self::RotatedByHand => "rotated by hand",
            Self::CarriedByHand => "carried by hand",
            Self::DoorOpened => "door opened",
            Self::DoorClosed => "door closed",
            Self::ObjectAdded => "object added",
            Self::ObjectRemoved => "object removed",
            Self::SonarsFailed => "sonars failed",
            Self::ItemPlaced => "item placed",
            Self::BatterySet => "battery set",
            Self::MessageSent => "message sent",
            Self::Scenario => "scenario",
            Self::ScenarioFailed => "scenario failed",
        }
    }

    /// What an event of a trace reports, if it is a report.
    pub fn of(event: &Event) -> Option<Self> {
        if event.kind != EventKind::Robot {
            return None;
        }
        let (_, what) = event.details.iter().find(|(name, _)| name == "what")?;
        Self::ALL.into_iter().find(|kind| kind.name() == what)
    }

    /// Whether somebody has moved the robot.
    pub fn is_by_hand(self) -> bool {
        matches!(self, Self::RotatedByHand | Self::CarriedByHand)
    }
}

impl Report {
    /// Of what kind it is.
    pub fn kind(&self) -> ReportKind {
        match self {
            Self::PositionDoubted => ReportKind::PositionDoubted,
            Self::PositionLost { .. } => ReportKind::PositionLost,
            Self::PositionFound { .. } => ReportKind::PositionFound,
            Self::LocalizationAction { .. } => ReportKind::LocalizationAction,
            Self::RotatedByHand { .. } => ReportKind::RotatedByHand,
            Self::CarriedByHand { .. } => ReportKind::CarriedByHand,
            Self::DoorOpened { .. } => ReportKind::DoorOpened,
            Self::DoorClosed { .. } => ReportKind::DoorClosed,
            Self::ObjectAdded { .. } => ReportKind::ObjectAdded,
            Self::ObjectRemoved { .. } => ReportKind::ObjectRemoved,
            Self::SonarsFailed { .. } => ReportKind::SonarsFailed,
            Self::ItemPlaced { .. } => ReportKind::ItemPlaced,
            Self::BatterySet { .. } => ReportKind::BatterySet,
            Self::MessageSent { .. } => ReportKind::MessageSent,
            Self::Scenario { .. } => ReportKind::Scenario,
            Self::ScenarioFailed { .. } => ReportKind::ScenarioFailed,
        }
    }

    fn details(self) -> Vec<(&'static str, String)> {
        match self {
            Self::PositionDoubted => vec![],
            Self::PositionLost { certainty } | Self::PositionFound { certainty } => {
                vec![("certainty", format!("{certainty:.2}"))]
            }
            Self::LocalizationAction { target_in_base } => {
                vec![("ahead", format!("{:.1}", target_in_base.x)), ("left", format!("{:.1}", target_in_base.y))]
            }
            Self::RotatedByHand { angle_rad } => vec![("degrees", format!("{:.0}", angle_rad.to_degrees()))],
            Self::CarriedByHand { point_in_map } => {
                vec![("x", format!("{:.2}", point_in_map.x)), ("y", format!("{:.2}", point_in_map.y))]
            }
            Self::DoorOpened { room } | Self::DoorClosed { room } => vec![("room", room)],
            Self::ObjectAdded { object } | Self::ObjectRemoved { object } => vec![("object", object)],
            Self::SonarsFailed { seconds } => vec![("seconds", format!("{seconds}"))],
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
