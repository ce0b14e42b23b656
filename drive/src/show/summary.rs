//! How a run went, at its end: for a person, as JSON, and as an exit status.

use crate::observed::{Observed, RunEnd};
use crate::show::failure_report::{FailureRecord, PLAN_FAILED, Reporter, SCENARIO_FAILED};
use anyhow::{Context, Result};
use rpl_mission::robot::Robot;
use rpl_mission::sight::Account;
use rpl_protocol::remote_host::HostRecord;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use serde::Serialize;
use serde_json::{Map, Value};
use std::time::Instant;

/// Characters of the plan's value that are shown.
const LONGEST_VALUE: usize = 500;

/// What `--json` writes.
#[derive(Clone, Debug, Serialize)]
pub struct RunSummary {
    outcome: &'static str,
    value: Option<String>,
    time_s: f64,
    failure: Option<FailureRecord>,
    scenario_failure: Option<FailureRecord>,
    #[serde(flatten)]
    account: Account,
    relocalizations: u64,
    measures: Map<String, Value>,
    wall_s: f64,
    seed: u64,
}

/// The exit status an ending means. What a plan did beside a scenario that failed is not what it was
/// to show.
pub fn status(system: &System<Robot>, ending: RunEnd) -> Status {
    match ending {
        RunEnd::Outcome(Outcome::Succeeded(_)) if system.outside.failed_scenario().is_some() => Status::Failed,
        RunEnd::Outcome(Outcome::Succeeded(_)) => Status::Succeeded,
        RunEnd::Outcome(Outcome::Failed(_) | Outcome::Evaporated) => Status::Failed,
        RunEnd::TimeUp => Status::TimeUp,
        RunEnd::Interrupted | RunEnd::GivenUp => Status::Interrupted,
    }
}

fn reporter<'a>(system: &'a System<Robot>, console: &Console) -> Reporter<'a> {
    Reporter { machine: &system.machine, program: &system.program, colour: console.colour }
}

impl RunSummary {
    /// The summary as one JSON object.
    ///
    /// # Errors
    /// A fault of the program.
    pub fn as_json(&self) -> Result<String> {
        serde_json::to_string(self).context("the summary cannot be written as JSON")
    }
}

/// What came of a run.
pub fn summarize(system: &System<Robot>, ending: RunEnd, observed: &Observed, seed: u64, began: Instant) -> RunSummary {
    let value = match ending {
        RunEnd::Outcome(Outcome::Succeeded(value)) => Some(system.machine.write(&system.program, value)),
        _ => None,
    };
    let failure = match ending {
        RunEnd::Outcome(Outcome::Failed(failure)) => {
            Reporter { machine: &system.machine, program: &system.program, colour: false }.record(failure)
        }
        _ => None,
    };
    RunSummary {
        outcome: match ending {
            RunEnd::Outcome(Outcome::Succeeded(_)) => "succeeded",
            RunEnd::Outcome(Outcome::Failed(_) | Outcome::Evaporated) => "failed",
            RunEnd::TimeUp => "timeout",
            RunEnd::Interrupted | RunEnd::GivenUp => "interrupted",
        },
        value,
        scenario_failure: system.outside.failed_scenario().and_then(|(scenario, failure)| {
            Reporter { machine: &scenario.machine, program: &scenario.program, colour: false }.record(failure)
        }),
        time_s: system.machine.now_s(),
        failure,
        account: system.outside.account().unwrap_or(Account::NOTHING),
        relocalizations: observed.relocalizations,
        measures: measures(&system.machine),
        wall_s: (began.elapsed().as_secs_f64() * 1e3).round() / 1e3,
        seed,
    }
}

/// What a plan has measured of its run, by name.
fn measures(machine: &Machine) -> Map<String, Value> {
    machine.measures.iter().map(|(name, number)| (machine.symbols.name(name).to_string(), number.into())).collect()
}

/// Tells a person how it went.
pub(crate) fn report(system: &System<Robot>, ending: RunEnd, summary: &RunSummary, console: &mut Console) {
    if let RunEnd::Outcome(Outcome::Failed(failure)) = ending {
        let text = reporter(system, console).text(PLAN_FAILED, failure);
        console.note(text.trim_end());
    }
    tell_failed_scenario(system, console);
    if console.quiet {
        return;
    }
    if let (RunEnd::Outcome(Outcome::Succeeded(value)), Some(text)) = (ending, &summary.value)
        && value != value::Value::Nil
    {
        console.note(&format!("value: {}", beginning(text)));
    }
    // A plan without a robot that succeeded has nothing else to say.
    let is_plain_success =
        matches!(ending, RunEnd::Outcome(Outcome::Succeeded(_))) && system.outside.account().is_none();
    if is_plain_success {
        return;
    }
    let how = match ending {
        RunEnd::Outcome(Outcome::Succeeded(_)) => format!("succeeded after {:.1} s", summary.time_s),
        RunEnd::Outcome(Outcome::Failed(_)) => format!("failed after {:.1} s", summary.time_s),
        RunEnd::Outcome(Outcome::Evaporated) => format!("ended itself after {:.1} s", summary.time_s),
        RunEnd::TimeUp => format!("cut off by --until, the last instant at {:.1} s", summary.time_s),
        RunEnd::Interrupted => format!("interrupted at {:.1} s, clean-ups done", summary.time_s),
        RunEnd::GivenUp => {
            format!("interrupted at {:.1} s, a clean-up that computed without end given up", summary.time_s)
        }
    };
    let robot = system.outside.account().map_or(String::new(), |account| describe(account, summary.relocalizations));
    let scenario = if summary.scenario_failure.is_some() { ", beside a scenario that failed" } else { "" };
    console.note(&format!("{how}{scenario}{robot} ({:.1} s of computing)", summary.wall_s));
}

/// Tells of the failure of the scenario, if it has failed.
pub fn tell_failed_scenario(system: &System<Robot>, console: &mut Console) {
    if let Some((scenario, failure)) = system.outside.failed_scenario() {
        let reporter = Reporter { machine: &scenario.machine, program: &scenario.program, colour: console.colour };
        console.note(reporter.text(SCENARIO_FAILED, failure).trim_end());
    }
}

/// As much of a value as a person wants to see; `--json` has all of it.
fn beginning(text: &str) -> String {
    match text.char_indices().nth(LONGEST_VALUE) {
        Some((end, _)) => format!("{}… ({} characters; `--json` has them all)", &text[..end], text.chars().count()),
        None => text.to_string(),
    }
}

fn describe(account: Account, relocalizations: u64) -> String {
    let plural = |count: u64, noun: &str| match count {
        0 => format!("no {noun}"),
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    };
    let touched = match (account.contacts, account.host) {
        (Some(contacts), _) => plural(u64::from(contacts), "contact"),
        (None, host) => plural(host.map_or(0, |host| host.bumps), "bump"),
    };
    let host = account.host.map_or(String::new(), |host| {
        let HostRecord { percepts_late, percepts_missing, times_astray, motions_astray, .. } = host;
        let HostRecord { decisions_long, longest_decision_s, .. } = host;
        let longest = if decisions_long > 0 { format!(" (at most {longest_decision_s:.2} s)") } else { String::new() };
        let astray = match times_astray + motions_astray {
            0 => String::new(),
            _ => format!(", {times_astray} with a time and {motions_astray} with a motion that cannot be"),
        };
        let percepts = plural(percepts_late, "late percept");
        format!(
            ", {percepts}, {percepts_missing} missing{astray}, {}{longest}",
            plural(decisions_long, "long decision")
        )
    });
    let relocalizations = plural(relocalizations, "relocalization");
    format!(", {:.1} m driven, {touched}, {relocalizations}{host}", account.distance_m)
}
