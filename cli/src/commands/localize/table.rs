//! What the trials showed, as text.

use super::findings::{Certainty, Errors, Findings, Phase, Spread};
use super::windows::Timed;
use rpl_experiments::reliability::{self, SURE};
use rpl_experiments::statistics::Proportion;
use rpl_robot::geometry::Pose;
use rpl_robot::localization::{BeamParameters, OdometryError};
use rpl_robot::recording::{PoseError, TrialStart};
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde_json::{Value, json};

/// The table of windows, without its rows.
pub fn table() -> Table {
    Table::new(&["window", "start [m]", "found", "after [m]", "error [m]", "error [°]", "sure, wrong", "time [s]"])
}

/// The row of a window.
pub fn row(index: usize, timed: &Timed) -> [String; 8] {
    let last = timed.trial.errors.last();
    let one = |number: f64| format!("{number:.1}");
    let (_, wrong) = timed.trial.sure_and_wrong();
    [
        (index + 1).to_string(),
        one(timed.window.start_m),
        if timed.trial.succeeded { "yes" } else { "no" }.to_string(),
        timed.trial.found_after_m.map_or(NOTHING.to_string(), one),
        last.map_or(NOTHING.to_string(), |error| format!("{:.2}", error.position_m())),
        last.map_or(NOTHING.to_string(), |error| one(error.heading_rad().to_degrees())),
        wrong.to_string(),
        format!("{:.2}", timed.wall_s),
    ]
}

/// What the windows have in common.
pub fn summary(findings: &Findings, start: TrialStart) -> Vec<Block> {
    let mut blocks = vec![Block::Lines(found(findings, start).join("\n"))];
    blocks.extend(findings.while_found.as_ref().map(|errors| Block::Table(errors_table(errors))));
    blocks.push(Block::Lines(sure(findings)));
    let certainty = &findings.certainty;
    if !certainty.bins.is_empty() {
        blocks.push(Block::Table(reliability::table(&certainty.bins)));
    }
    blocks.push(Block::Lines(worth(certainty)));
    blocks
}

fn found(findings: &Findings, start: TrialStart) -> Vec<String> {
    let what = match start {
        TrialStart::Uniform => "found",
        TrialStart::FromTruth => "kept",
    };
    let Proportion { count, of, rate, .. } = findings.found;
    let rate = rate.map_or(String::new(), |rate| format!("{:.1} %, ", 100.0 * rate));
    let interval = findings.found.interval();
    let mut lines = vec![format!("{what} {count} of {of}: {rate}95 % interval {interval} by stretches of the drive")];
    if let [_, _, ..] = findings.phases[..] {
        let phase = |Phase { phase, found, of }: &Phase| format!("{phase}: {found} of {of}");
        let phases: Vec<String> = findings.phases.iter().map(phase).collect();
        lines.push(format!("by phases: {}", phases.join(", ")));
    }
    lines
}

fn errors_table(errors: &Errors) -> Table {
    let mut table = Table::new(&["while found", "scans", "mean", "median", "95 %", "most"]);
    for (name, Spread { mean, median, percentile_95, max }, decimals) in
        [("position [m]", errors.position_m, 3), ("heading [°]", errors.heading_deg, 2)]
    {
        let numbers = [mean, median, percentile_95, max].map(|number| format!("{number:.decimals$}"));
        table.row([name.to_string(), errors.scans.to_string()].into_iter().chain(numbers));
    }
    table
}

fn sure(findings: &Findings) -> String {
    let wrong = &findings.wrong_while_sure;
    match wrong.rate {
        Some(rate) => format!(
            "certainty of 0.9 and above: {} of {} scans, wrong after {} of them: {:.2} %, 95 % interval {} by stretches \
             of the drive",
            wrong.of,
            findings.scans,
            wrong.count,
            100.0 * rate,
            wrong.interval()
        ),
        None => "certainty of 0.9 and above: never".to_string(),
    }
}

fn worth(certainty: &Certainty) -> String {
    let right = &certainty.right_at_099;
    let rate = right.rate.map_or(String::new(), |rate| format!(", right after {:.2} % of them", 100.0 * rate));
    let mut lines = vec![format!("at {SURE} and above: {} scans{rate}", right.of)];
    if !certainty.bins.is_empty() {
        lines.push(format!("largest error of a bin {:.3}", certainty.largest_error));
    }
    lines.push("share of the belief and how often it is right, fitted to these scans:".to_string());
    lines.push(reliability::knots_text(&certainty.fitted));
    lines.join("\n")
}

/// The same as JSON.
pub fn json(trials: &[Timed], findings: &Findings) -> String {
    let windows: Vec<Value> = trials
        .iter()
        .map(|timed| {
            let last = timed.trial.errors.last();
            let (sure, wrong) = timed.trial.sure_and_wrong();
            json!({
                "phase": timed.phase,
                "start_m": timed.window.start_m,
                "length_m": timed.window.length_m,
                "scans": timed.window.scans.len(),
                "ends_s": timed.ends_s,
                "ends_at": last.map(|error| {
                    let Pose { x_m, y_m, heading_rad } = error.true_in_map;
                    [x_m, y_m, heading_rad]
                }),
                "found": timed.trial.succeeded,
                "found_after_m": timed.trial.found_after_m,
                "final_error_m": last.map(PoseError::position_m),
                "final_error_rad": last.map(PoseError::heading_rad),
                "final_certainty": last.map(|error| error.certainty),
                "sure": sure,
                "sure_and_wrong": wrong,
                "time_s": timed.wall_s,
            })
        })
        .collect();
    let mut whole = json!(findings);
    whole["windows"] = windows.into();
    whole.to_string()
}

/// Fitted parameters.
pub fn fitted(sensor: &BeamParameters, odometry: &OdometryError) -> String {
    let row = |name: &str, value: f64, unit: &str| format!("{name:28} {value:>8.4} {unit}");
    [
        row("Gaussian", sensor.hit, ""),
        row("uniform", sensor.uniform, ""),
        row("unmapped before the surface", sensor.short, ""),
        row("no echo", sensor.missed, ""),
        row("depth of walls", sensor.wall_depth_m, "m"),
        row("deviation at 0 m", sensor.sigma_m, "m"),
        row("deviation per metre", sensor.sigma_per_m, "m"),
        row("mean distance of unmapped", sensor.short_mean_m, "m"),
        row("odometry, forward", odometry.forward_m, "m after 1 m"),
        row("odometry, sideward", odometry.sideward_m, "m after 1 m"),
        row("odometry, turn", odometry.turn_per_metre_rad.to_degrees(), "° after 1 m"),
        row("odometry, turn", odometry.turn_per_radian_rad.to_degrees(), "° after turning by 1 rad"),
    ]
    .join("\n")
}
