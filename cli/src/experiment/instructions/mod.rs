//! Finding a room by instructions (Gutierrez-Osuna and Luo, *LOLA*): what is perceived of hallways, whether
//! openings are counted right, and whether the robot arrives.
//!
//! Read in this order: `setting` (what differs from row to row), `course` (drives along single hallways) with
//! `features` and `openings`, `delivery` (whole routes), `topological` (the complete map), `markers` (what the
//! camera finds), `figures`.

mod course;
mod delivery;
mod features;
mod figures;
mod markers;
mod openings;
mod setting;
mod topological;

use super::findings::ExperimentResult;
use super::request::ExperimentRequest;
use super::trials::run_all;
use crate::status::Status;
use crate::terminal::console::Console;
use crate::terminal::progress;
use anyhow::{Result, bail};
use course::{Course, drive};
use delivery::{Delivery, DeliveryRow, Lists, deliver};
use features::FeatureRow;
use markers::{MarkerDrive, MarkerResult, MarkerRow, look_for_markers};
use openings::{Choice, ChoiceRow, choices};
use rpl_lola::LolaSettings;
use rpl_lola::state_set::{Inference, Method};
use serde_json::json;
use setting::{
    CALM, CROWDED, CROWDED_MARKED, EXACT, Ground, MARKED, Setting, THICK, THIN, UNREGISTERED, by, by_dervish,
};
use topological::{MapResult, MapRow, drive_about};

/// The rows of `hallway-features`.
const FEATURES: [Setting; 8] = [CALM, MARKED, THIN, THICK, CROWDED, CROWDED_MARKED, EXACT, UNREGISTERED];

/// A row of `count-openings`: drives, and what is made of their percepts.
struct Counting {
    name: &'static str,
    drives: Setting,
    inference: fn() -> Inference,
}

/// The rows of `count-openings`. Those of the same drives judge the same percepts.
const COUNTINGS: [Counting; 10] = [
    Counting { name: "state set", drives: CALM, inference: || Inference::of_robot(false) },
    Counting { name: "counter with class", drives: CALM, inference: || by(Method::CounterWithClass) },
    Counting { name: "plain counter", drives: CALM, inference: || by(Method::PlainCounter) },
    Counting { name: "literal equations", drives: CALM, inference: || by(Method::LiteralEquations) },
    Counting { name: "DERVISH's matrix", drives: CALM, inference: by_dervish },
    Counting { name: "with markers", drives: MARKED, inference: || Inference::of_robot(true) },
    Counting { name: "crowded", drives: CROWDED, inference: || Inference::of_robot(false) },
    Counting { name: "crowded, counter with class", drives: CROWDED, inference: || by(Method::CounterWithClass) },
    Counting { name: "crowded, with markers", drives: CROWDED_MARKED, inference: || Inference::of_robot(true) },
    Counting { name: "without registration", drives: UNREGISTERED, inference: || Inference::of_robot(false) },
];

/// A row of `office-delivery`.
struct DeliverySetting {
    name: &'static str,
    setting: Setting,
    lists: Lists,
}

/// A row with right lists, called as its setting is.
const fn right(setting: Setting) -> DeliverySetting {
    DeliverySetting { name: setting.name, setting, lists: Lists::Right }
}

/// A row in which openings are counted by something else.
const fn counting(name: &'static str, lola: fn(&mut LolaSettings)) -> DeliverySetting {
    right(Setting { name, lola, ..CALM })
}

/// The rows of `office-delivery`.
const DELIVERIES: [DeliverySetting; 15] = [
    right(CALM),
    right(MARKED),
    right(THIN),
    right(CROWDED),
    right(CROWDED_MARKED),
    right(EXACT),
    counting("plain counter", |settings| settings.inference = Some(by(Method::PlainCounter))),
    counting("counter with class", |settings| settings.inference = Some(by(Method::CounterWithClass))),
    counting("literal equations", |settings| settings.inference = Some(by(Method::LiteralEquations))),
    counting("DERVISH's matrix", |settings| settings.inference = Some(by_dervish())),
    right(UNREGISTERED),
    DeliverySetting { name: "wrong lists", setting: CALM, lists: Lists::Wrong },
    DeliverySetting { name: "wrong lists, crowded", setting: CROWDED, lists: Lists::Wrong },
    DeliverySetting { name: "asked back", setting: CALM, lists: Lists::Answered },
    DeliverySetting { name: "asked back, crowded", setting: CROWDED, lists: Lists::Answered },
];

/// Drives along hallways, row by row.
///
/// # Errors
/// No row has the name, a drive cannot be simulated, or the results cannot be written.
pub fn hallway_features(request: &ExperimentRequest, console: &mut Console) -> Result<ExperimentResult> {
    let is_meant = |setting: &&Setting| request.row.as_deref().is_none_or(|row| row == setting.name);
    let chosen: Vec<&Setting> = FEATURES.iter().filter(is_meant).collect();
    if chosen.is_empty() {
        bail!(request.no_row(request.row.as_deref().unwrap_or_default(), &feature_rows()));
    }
    let mut rows = Vec::new();
    for setting in chosen {
        rows.push((setting.name, courses(request, console, setting)?));
    }
    let results: Vec<FeatureRow> = rows.iter().map(|(name, courses)| FeatureRow::of(name, courses)).collect();
    let mut files = figures::contours(&rows);
    files.push(("runs.csv".to_string(), features::raw_rows(&rows)));
    request.write(&files)?;
    let status = if results.iter().all(|row| row.failures.is_empty()) { Status::Succeeded } else { Status::Failed };
    Ok(ExperimentResult { status, blocks: features::blocks(&results), figures: json!({ "rows": results }) })
}

/// What can be asked for with `--row`.
pub fn feature_rows() -> Vec<&'static str> {
    FEATURES.iter().map(|setting| setting.name).collect()
}

/// Counts openings along hallways, row by row.
///
/// # Errors
/// As for [`hallway_features`].
pub fn count_openings(request: &ExperimentRequest, console: &mut Console) -> Result<ExperimentResult> {
    let is_meant = |counting: &&Counting| request.row.as_deref().is_none_or(|row| row == counting.name);
    let chosen: Vec<&Counting> = COUNTINGS.iter().filter(is_meant).collect();
    if chosen.is_empty() {
        bail!(request.no_row(request.row.as_deref().unwrap_or_default(), &counting_rows()));
    }
    let mut driven: Vec<(&str, Vec<Course>)> = Vec::new();
    let mut rows: Vec<(&str, usize, Vec<Choice>)> = Vec::new();
    for counting in &chosen {
        let drives = &counting.drives;
        if !driven.iter().any(|(name, _)| *name == drives.name) {
            driven.push((drives.name, courses(request, console, drives)?));
        }
        let courses = driven.iter().find(|(name, _)| *name == drives.name).map_or(&[][..], |(_, courses)| courses);
        let inference = (counting.inference)();
        let made = courses.iter().flat_map(|course| choices(course, &inference)).collect();
        rows.push((counting.name, courses.len(), made));
    }
    let results: Vec<ChoiceRow> = rows.iter().map(|(name, runs, made)| ChoiceRow::of(name, *runs, made)).collect();
    let mut files = figures::state_sets(&driven);
    files.push(("runs.csv".to_string(), openings::raw_rows(&rows)));
    request.write(&files)?;
    Ok(ExperimentResult {
        status: Status::Succeeded,
        blocks: openings::blocks(&results),
        figures: json!({ "rows": results }),
    })
}

/// What can be asked for with `--row`.
pub fn counting_rows() -> Vec<&'static str> {
    COUNTINGS.iter().map(|counting| counting.name).collect()
}

/// The drives of a setting, in the order of the seeds.
fn courses(request: &ExperimentRequest, console: &mut Console, setting: &Setting) -> Result<Vec<Course>> {
    let ground = Ground::new(setting, &request.robot)?;
    let seeds = request.seeds();
    let bar = progress::runs(seeds.len() as u64, setting.name, console);
    let one = |seed: u64| drive(&ground, &setting.arena, seed, request.until_us);
    let courses = run_all(&seeds, request.jobs, one, || bar.inc(1));
    bar.finish_and_clear();
    courses.into_iter().collect()
}

/// Whole routes, row by row.
///
/// # Errors
/// As for [`hallway_features`].
pub fn office_delivery(request: &ExperimentRequest, console: &mut Console) -> Result<ExperimentResult> {
    let is_meant = |row: &&DeliverySetting| request.row.as_deref().is_none_or(|name| name == row.name);
    let chosen: Vec<&DeliverySetting> = DELIVERIES.iter().filter(is_meant).collect();
    if chosen.is_empty() {
        bail!(request.no_row(request.row.as_deref().unwrap_or_default(), &delivery_rows()));
    }
    let seeds = request.seeds();
    let mut rows: Vec<(&str, Vec<Delivery>)> = Vec::new();
    let mut results = Vec::new();
    let mut files = Vec::new();
    for DeliverySetting { name, setting, lists } in chosen {
        let ground = Ground::new(setting, &request.robot)?;
        let bar = progress::runs(seeds.len() as u64, name, console);
        let one = |seed: u64| deliver(&ground, setting, *lists, seed, request.until_us);
        let deliveries: Result<Vec<Delivery>> = run_all(&seeds, request.jobs, one, || bar.inc(1)).into_iter().collect();
        bar.finish_and_clear();
        let deliveries = deliveries?;
        results.push(DeliveryRow::of(name, &deliveries));
        files.extend(deliveries.first().map(|delivery| delivery::route(name, *lists, setting, delivery)));
        rows.push((name, deliveries));
    }
    files.push(("runs.csv".to_string(), delivery::raw_rows(&rows)));
    request.write(&files)?;
    let first = results.first().is_some_and(|row| row.others.is_empty() && row.contacts == 0);
    Ok(ExperimentResult {
        status: if first { Status::Succeeded } else { Status::Failed },
        blocks: delivery::blocks(&results),
        figures: json!({ "rows": results }),
    })
}

/// What can be asked for with `--row`.
pub fn delivery_rows() -> Vec<&'static str> {
    DELIVERIES.iter().map(|row| row.name).collect()
}

/// Drives about complete maps, row by row.
///
/// # Errors
/// No row has the name, or the results cannot be written.
pub fn topological_global(request: &ExperimentRequest, console: &mut Console) -> Result<ExperimentResult> {
    let is_meant = |row: &&MapRow| request.row.as_deref().is_none_or(|name| name == row.name);
    let chosen: Vec<&MapRow> = topological::ROWS.iter().filter(is_meant).collect();
    if chosen.is_empty() {
        bail!(request.no_row(request.row.as_deref().unwrap_or_default(), &map_rows()));
    }
    let seeds = request.seeds();
    let mut rows = Vec::new();
    for row in chosen {
        let bar = progress::runs(seeds.len() as u64, row.name, console);
        let drives = run_all(&seeds, request.jobs, |seed| (seed, drive_about(row, seed)), || bar.inc(1));
        bar.finish_and_clear();
        rows.push((row.name, drives));
    }
    let result = |(name, drives): &(&str, Vec<(u64, Vec<_>)>)| {
        let steps: Vec<Vec<_>> = drives.iter().map(|(_, steps)| steps.clone()).collect();
        MapResult::of(name, &steps)
    };
    let results: Vec<MapResult> = rows.iter().map(result).collect();
    request.write(&[("runs.csv".to_string(), topological::raw_rows(&rows))])?;
    Ok(ExperimentResult {
        status: Status::Succeeded,
        blocks: topological::blocks(&results),
        figures: json!({ "rows": results }),
    })
}

/// What can be asked for with `--row`.
pub fn map_rows() -> Vec<&'static str> {
    topological::ROWS.iter().map(|row| row.name).collect()
}

/// Drives along hallways with markers, row by row.
///
/// # Errors
/// No row has the name, there is no camera for the robot, or the results cannot be written.
pub fn marker_detection(request: &ExperimentRequest, console: &mut Console) -> Result<ExperimentResult> {
    let is_meant = |row: &&MarkerRow| request.row.as_deref().is_none_or(|name| name == row.name);
    let chosen: Vec<&MarkerRow> = markers::ROWS.iter().filter(is_meant).collect();
    if chosen.is_empty() {
        bail!(request.no_row(request.row.as_deref().unwrap_or_default(), &marker_rows()));
    }
    let seeds = request.seeds();
    let mut rows: Vec<(&str, Vec<MarkerDrive>)> = Vec::new();
    for row in chosen {
        let bar = progress::runs(seeds.len() as u64, row.name, console);
        let drives = run_all(&seeds, request.jobs, |seed| look_for_markers(row, &request.robot, seed), || bar.inc(1));
        bar.finish_and_clear();
        rows.push((row.name, drives.into_iter().collect::<Result<_>>()?));
    }
    let results: Vec<MarkerResult> = rows.iter().map(|(name, drives)| MarkerResult::of(name, drives)).collect();
    request.write(&[("runs.csv".to_string(), markers::raw_rows(&rows))])?;
    Ok(ExperimentResult {
        status: Status::Succeeded,
        blocks: markers::blocks(&results),
        figures: json!({ "rows": results }),
    })
}

/// What can be asked for with `--row`.
pub fn marker_rows() -> Vec<&'static str> {
    markers::ROWS.iter().map(|row| row.name).collect()
}
