//! What the trials showed, as text.

use super::Timed;
use crate::experiment::statistics::{Dispersion, Proportion};
use crate::terminal::table::{NOTHING, Table};
use rpl_robot::localization::{BeamParameters, OdometryError};
use rpl_robot::recording::{PoseError, TrialStart};
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
pub fn summary(trials: &[Timed], start: TrialStart) -> String {
    let found = trials.iter().filter(|timed| timed.trial.succeeded).count();
    let what = match start {
        TrialStart::Uniform => "found",
        TrialStart::FromTruth => "kept",
    };
    let mut lines = vec![format!("{what} {}", Proportion::new(found, trials.len()).sentence())];
    lines.extend(errors(trials).map(|errors| {
        format!(
            "while found: position mean {:.3} m, median {:.3} m; heading mean {:.2}°, median {:.2}° ({} scans)",
            errors.position_m.mean,
            errors.position_m.median,
            errors.heading_deg.mean,
            errors.heading_deg.median,
            errors.scans
        )
    }));
    let wrong = wrong_while_sure(trials);
    let interval = wrong.interval();
    lines.push(match wrong.rate {
        Some(rate) => format!(
            "certainty of 0.9 and above: {} of {} scans, wrong after {} of them: {:.2} %, 95 % interval {interval} by \
             windows",
            wrong.of,
            scans(trials),
            wrong.count,
            100.0 * rate
        ),
        None => "certainty of 0.9 and above: never".to_string(),
    });
    lines.join("\n")
}

fn scans(trials: &[Timed]) -> usize {
    trials.iter().map(|timed| timed.trial.errors.len()).sum()
}

/// How often the filter was wrong when it was sure; scans of a window are wrong together.
fn wrong_while_sure(trials: &[Timed]) -> Proportion {
    let windows = trials.iter().map(|timed| timed.trial.sure_and_wrong()).filter(|(sure, _)| *sure > 0);
    Proportion::in_groups(&windows.map(|(sure, wrong)| (wrong, sure)).collect::<Vec<_>>())
}

/// The errors while the estimate was right.
struct Errors {
    scans: usize,
    position_m: Dispersion,
    heading_deg: Dispersion,
}

fn errors(trials: &[Timed]) -> Option<Errors> {
    let found: Vec<&PoseError> = trials.iter().flat_map(|timed| timed.trial.errors_once_found()).collect();
    let positions_m: Vec<f64> = found.iter().map(|error| error.position_m()).collect();
    let headings_deg: Vec<f64> = found.iter().map(|error| error.heading_rad().to_degrees()).collect();
    let (position_m, heading_deg) = (Dispersion::of(&positions_m)?, Dispersion::of(&headings_deg)?);
    Some(Errors { scans: found.len(), position_m, heading_deg })
}

/// The same as JSON.
pub fn json(trials: &[Timed]) -> String {
    let windows: Vec<Value> = trials
        .iter()
        .map(|timed| {
            let last = timed.trial.errors.last();
            let (sure, wrong) = timed.trial.sure_and_wrong();
            json!({
                "start_m": timed.window.start_m,
                "length_m": timed.window.length_m,
                "scans": timed.window.scans.len(),
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
    let spread = |spread: Dispersion| json!({ "mean": spread.mean, "median": spread.median, "max": spread.max });
    let while_found = errors(trials).map(|errors| {
        json!({
            "scans": errors.scans,
            "position_m": spread(errors.position_m),
            "heading_deg": spread(errors.heading_deg),
        })
    });
    let found = trials.iter().filter(|timed| timed.trial.succeeded).count();
    json!({
        "windows": windows,
        "found": found,
        "of": trials.len(),
        "while_found": while_found,
        "wrong_while_sure": wrong_while_sure(trials),
    })
    .to_string()
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
