//! How a host was served: what is told on the way, and at the end.

use crate::events::report;
use anyhow::{Context, Result};
use rpl_link::tcp_server::{Notice, ServiceRecord};
use rpl_protocol::guard::{Halt, HaltCounts};
use rpl_robot::office::Report;
use rpl_robot::simulator::SimulatorState;
use rpl_runtime::robot::RobotEvent;
use rpl_runtime::state::trace::{Event, EventKind};
use serde::Serialize;

/// What `--json` writes of a simulated host.
#[derive(Clone, Debug, Serialize)]
pub struct ServiceSummary {
    missions: u32,
    time_s: f64,
    distance_m: f64,
    contacts: u32,
    contacts_unseen: u32,
    contacts_by_people: u32,
    /// Where the robot really stands: x, y in metres, heading in radians.
    pose_in_map: [f64; 3],
    speed_mps: f64,
    halts: HaltCounts,
    percepts: u64,
    delays: u32,
    commands: u64,
    latency_max_s: Option<f32>,
    latency_p99_s: Option<f32>,
}

impl ServiceSummary {
    /// What came of a simulated host.
    pub fn new(state: &SimulatorState, record: &ServiceRecord) -> Self {
        let pose = state.true_pose();
        let contacts = state.contacts();
        let mut latencies_s = record.latencies_s.clone();
        latencies_s.sort_by(f32::total_cmp);
        let p99 = (latencies_s.len() * 99).div_ceil(100).checked_sub(1);
        Self {
            missions: record.missions,
            time_s: state.time_us as f64 / 1e6,
            distance_m: state.distance_driven_m(),
            contacts: contacts.caused,
            contacts_unseen: contacts.unseen,
            contacts_by_people: contacts.run_into,
            pose_in_map: [pose.x_m, pose.y_m, pose.heading_rad],
            speed_mps: state.translation_mps,
            halts: record.halts,
            percepts: record.percepts,
            delays: record.delays,
            commands: latencies_s.len() as u64,
            latency_max_s: latencies_s.last().copied(),
            latency_p99_s: p99.and_then(|at| latencies_s.get(at).copied()),
        }
    }

    /// The summary as one JSON object.
    ///
    /// # Errors
    /// A fault of the program.
    pub fn as_json(&self) -> Result<String> {
        serde_json::to_string(self).context("the summary cannot be written as JSON")
    }

    /// The summary for a person.
    pub fn told(&self) -> String {
        let Self { missions, time_s, distance_m, contacts, halts, delays, .. } = self;
        let [x_m, y_m, heading_rad] = self.pose_in_map;
        let latency = match (self.latency_max_s, self.latency_p99_s) {
            (Some(max_s), Some(p99_s)) => {
                format!("commands after at most {:.1} ms, 99 % within {:.1} ms", max_s * 1e3, p99_s * 1e3)
            }
            _ => "no commands".to_string(),
        };
        format!(
            "{missions} mission(s), {time_s:.1} s, {distance_m:.1} m driven, {contacts} contact(s), at {x_m:.2} {y_m:.2} \
             {:.0}°\n{latency}; motors cut {} time(s) for silence, {} for a closed line, {} for a bump; {delays} delay(s) \
             of the host itself",
            heading_rad.to_degrees(),
            halts.silences,
            halts.closed_lines,
            halts.bumps
        )
    }
}

/// A line for a person.
pub fn notice_line(notice: &Notice) -> String {
    match notice {
        Notice::Came(who) => format!("{who} has the robot"),
        Notice::Went(why) => format!("the mission is gone: {why}"),
        Notice::Refused(why) => format!("refused: {why}"),
        Notice::RefusedMore(count) => format!("refused: {count} more"),
        Notice::Halted(Halt::Silence) => "motors off: no commands for 0.3 s".to_string(),
        Notice::Halted(Halt::Bumper) => "motors off: something presses against the bumper".to_string(),
        Notice::Halted(Halt::Unused | Halt::LineClosed) => "motors off".to_string(),
        Notice::Happened(happened) => happened_line(happened),
    }
}

/// As a trace would tell it.
fn happened_line(happened: &Report) -> String {
    let RobotEvent { what, details } = RobotEvent::from(happened.clone());
    let what = std::iter::once(("what".to_string(), what.to_string()));
    let details = what.chain(details.into_iter().map(|(name, value)| (name.to_string(), value))).collect();
    report(&Event { time_us: 0, sequence: 0, path: String::new(), kind: EventKind::Robot, details })
}
