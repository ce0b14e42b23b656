//! Active sensing (Fox, Burgard, Thrun, *Active Markov Localization for Mobile Robots*, §5.3): a
//! robot is moved up and down a corridor that looks the same from both ends, but for a box that only
//! the sonars see, and reads one sensor at a time.

mod course;
mod picture;
mod settings;
mod shuttle;
mod table;

use super::findings::ExperimentResult;
use super::request::ExperimentRequest;
use super::trials::run_all;
use crate::files::world_files;
use crate::status::Status;
use crate::terminal::console::Console;
use crate::terminal::progress;
use anyhow::{Result, bail};
use course::{Hall, NEVER_LONGER_US, SensingRun};
use serde_json::json;
use settings::{SETTINGS, SensingSetting};

/// The runs of one row, in the order of the seeds.
pub type SensingRuns = Vec<(&'static SensingSetting, Vec<SensingRun>)>;

/// Runs the experiment; the status is about its first row.
///
/// # Errors
/// There is no such row or world, or the results cannot be written.
pub fn run(request: &ExperimentRequest, console: &mut Console) -> Result<ExperimentResult> {
    let chosen: Vec<&SensingSetting> =
        SETTINGS.iter().filter(|setting| request.row.as_deref().is_none_or(|row| row == setting.name)).collect();
    if chosen.is_empty() {
        bail!(request.no_row(request.row.as_deref().unwrap_or_default(), &row_names()));
    }
    let hall = Hall::new(world_files::for_all_seeds(request.world.as_deref().unwrap_or("sensing"), &request.robot)?)?;
    let until_us = request.until_us.min(NEVER_LONGER_US);
    let seeds = request.seeds();
    let mut rows = SensingRuns::new();
    for setting in chosen {
        let bar = progress::runs(seeds.len() as u64, setting.name, console);
        rows.push((setting, run_all(&seeds, request.jobs, |seed| hall.run(setting, seed, until_us), || bar.inc(1))));
        bar.finish_and_clear();
    }
    if request.results.is_some() {
        let mut files = picture::pictures(&hall, &rows);
        files.push(("runs.csv".to_string(), table::raw_rows(&rows)));
        request.write(&files)?;
    }
    let succeeded = rows.first().is_some_and(|(_, courses)| courses.iter().all(SensingRun::succeeded));
    let results = table::results(&rows);
    let status = if succeeded { Status::Succeeded } else { Status::Failed };
    Ok(ExperimentResult { status, blocks: table::blocks(&results), figures: json!({ "rows": results }) })
}

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    SETTINGS.iter().map(|setting| setting.name).collect()
}
