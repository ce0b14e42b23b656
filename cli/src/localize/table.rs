//! What the trials showed, as text.

use super::Timed;
use crate::experiment::{Spread, wilson_95};
use rpl_robot::localization::{OdometryError, SensorParameters};
use rpl_robot::recording::{PoseError, Start};
use serde_json::{Value, json};

/// One line for each window, and what they have in common.
pub fn table(trials: &[Timed], start: Start) -> String {
    let mut lines = vec![format!(
        "{:>6} {:>10} {:>8} {:>6} {:>10} {:>10} {:>10} {:>8}",
        "window", "start [m]", "scans", "found", "after [m]", "error [m]", "error [°]", "time [s]"
    )];
    for (index, timed) in trials.iter().enumerate() {
        let last = timed.trial.errors.last();
        lines.push(format!(
            "{:>6} {:>10.1} {:>8} {:>6} {:>10} {:>10} {:>10} {:>8.2}",
            index + 1,
            timed.window.start_m,
            timed.window.scans.len(),
            if timed.trial.succeeded { "yes" } else { "no" },
            timed.trial.found_after_m.map_or("–".to_string(), |found_m| format!("{found_m:.1}")),
            last.map_or("–".to_string(), |error| format!("{:.2}", error.position_m())),
            last.map_or("–".to_string(), |error| format!("{:.1}", error.heading_rad().to_degrees())),
            timed.wall_s
        ));
    }
    let found = trials.iter().filter(|timed| timed.trial.succeeded).count();
    let (low, high) = wilson_95(found, trials.len());
    let what = match start {
        Start::Uniform => "found",
        Start::FromTruth => "kept",
    };
    lines.push(format!(
        "{what} {found} of {}: {:.1} %, 95 % interval {:.1} to {:.1} % (Wilson)",
        trials.len(),
        100.0 * found as f64 / trials.len() as f64,
        100.0 * low,
        100.0 * high
    ));
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
    lines.join("\n")
}

/// The errors while the estimate was right.
struct Errors {
    scans: usize,
    position_m: Spread,
    heading_deg: Spread,
}

fn errors(trials: &[Timed]) -> Option<Errors> {
    let found: Vec<&PoseError> = trials.iter().flat_map(|timed| timed.trial.errors_once_found()).collect();
    let positions_m: Vec<f64> = found.iter().map(|error| error.position_m()).collect();
    let headings_deg: Vec<f64> = found.iter().map(|error| error.heading_rad().to_degrees()).collect();
    let (position_m, heading_deg) = (Spread::of(&positions_m)?, Spread::of(&headings_deg)?);
    Some(Errors { scans: found.len(), position_m, heading_deg })
}

/// The same as JSON.
pub fn json(trials: &[Timed]) -> String {
    let windows: Vec<Value> = trials
        .iter()
        .map(|timed| {
            let last = timed.trial.errors.last();
            json!({
                "start_m": timed.window.start_m,
                "length_m": timed.window.length_m,
                "scans": timed.window.scans.len(),
                "found": timed.trial.succeeded,
                "found_after_m": timed.trial.found_after_m,
                "final_error_m": last.map(PoseError::position_m),
                "final_error_rad": last.map(PoseError::heading_rad),
                "time_s": timed.wall_s,
            })
        })
        .collect();
    let spread = |spread: Spread| json!({ "mean": spread.mean, "median": spread.median, "max": spread.max });
    let while_found = errors(trials).map(|errors| {
        json!({
            "scans": errors.scans,
            "position_m": spread(errors.position_m),
            "heading_deg": spread(errors.heading_deg),
        })
    });
    let found = trials.iter().filter(|timed| timed.trial.succeeded).count();
    json!({ "windows": windows, "found": found, "of": trials.len(), "while_found": while_found }).to_string()
}

/// Fitted parameters.
pub fn fitted(sensor: &SensorParameters, odometry: &OdometryError) -> String {
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
