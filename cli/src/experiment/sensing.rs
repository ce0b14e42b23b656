//! Active sensing (Fox, Burgard, Thrun, *Active Markov Localization for Mobile Robots*, §5.3): a
//! robot is moved up and down a corridor that looks the same from both ends, but for a box that only
//! the sonars see, and reads one sensor at a time.

mod course;
mod picture;
mod shuttle;
mod table;

use super::trials::run_all;
use super::{Arguments, Findings, jobs, no_row, progress, seeds, write_files};
use crate::console::Console;
use crate::mission;
use crate::status::Status;
use anyhow::{Result, bail};
use course::{Course, Hall, NEVER_LONGER_US};
use serde_json::json;

/// Which sensors can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensors {
    /// The 24 sonars.
    Sonars,
    /// The 181 directions of the laser.
    Laser,
    /// All of them.
    Both,
}

/// How the next direction is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// By the entropy expected after reading it.
    Active,
    /// Each as likely as the other.
    Random,
}

/// A row of the table.
#[derive(Debug)]
pub struct Setting {
    pub name: &'static str,
    pub sensors: Sensors,
    pub policy: Policy,
}

const SETTINGS: [Setting; 6] = [
    Setting { name: "both, active", sensors: Sensors::Both, policy: Policy::Active },
    Setting { name: "both, random", sensors: Sensors::Both, policy: Policy::Random },
    Setting { name: "sonars, active", sensors: Sensors::Sonars, policy: Policy::Active },
    Setting { name: "sonars, random", sensors: Sensors::Sonars, policy: Policy::Random },
    Setting { name: "laser, active", sensors: Sensors::Laser, policy: Policy::Active },
    Setting { name: "laser, random", sensors: Sensors::Laser, policy: Policy::Random },
];

/// The runs of one row, in the order of the seeds.
pub type Rows = Vec<(&'static Setting, Vec<Course>)>;

/// Runs the experiment; the status is about its first row.
///
/// # Errors
/// There is no such row or world, or the results cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Findings> {
    let chosen: Vec<&Setting> =
        SETTINGS.iter().filter(|setting| arguments.row.as_deref().is_none_or(|row| row == setting.name)).collect();
    if chosen.is_empty() {
        bail!(no_row("sensing", arguments.row.as_deref().unwrap_or_default(), &row_names()));
    }
    let hall = Hall::new(mission::world(arguments.world.as_deref().unwrap_or("sensing"))?)?;
    let until_us = arguments.until.min(NEVER_LONGER_US);
    let seeds = seeds(arguments);
    let mut rows = Rows::new();
    for setting in chosen {
        let bar = progress(seeds.len() as u64, console);
        bar.set_message(setting.name);
        rows.push((setting, run_all(&seeds, jobs(arguments), |seed| hall.run(setting, seed, until_us), || bar.inc(1))));
        bar.finish_and_clear();
    }
    if arguments.results.is_some() {
        let mut files = picture::pictures(&hall, &rows);
        files.push(("runs.csv".to_string(), table::raw_rows(&rows)));
        write_files(arguments, &files)?;
    }
    let succeeded = rows.first().is_some_and(|(_, courses)| courses.iter().all(Course::succeeded));
    let results = table::results(&rows);
    let status = if succeeded { Status::Succeeded } else { Status::Failed };
    Ok(Findings { status, blocks: table::blocks(&results), figures: json!({ "rows": results }) })
}

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    SETTINGS.iter().map(|setting| setting.name).collect()
}
