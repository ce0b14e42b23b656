//! `--once`: scans of the drive, each alone against the whole map.

use super::arguments::Arguments;
use anyhow::Result;
use rpl_experiments::one_scan::{Answer, RowResult, answer, bins, table};
use rpl_experiments::reliability;
use rpl_robot::localization::LocalizationParameters;
use rpl_robot::localization::once::trial::Verdict;
use rpl_robot::localization::once::{RangeBeam, ScanLocator};
use rpl_robot::occupancy::OccupancyGrid;
use rpl_robot::recording::{Recording, Scan};
use rpl_shell::interrupt;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use rpl_shell::terminal::page::Block;
use serde_json::json;
use std::time::Instant;

/// Compares `count` scans, evenly spread over the drive, with the map.
///
/// # Errors
/// The map has no free cell, or the result cannot be written.
pub fn run(
    arguments: &Arguments,
    count: u32,
    map: &OccupancyGrid,
    recording: &Recording,
    parameters: &LocalizationParameters,
    console: &mut Console,
) -> Result<Status> {
    let _ends_with_this = interrupt::ends_experiment();
    let locator = ScanLocator::new(map, &parameters.sensors[0].beam, parameters.clearance_m)?;
    let of = recording.scans.len();
    let count = (count as usize).min(of);
    let scans = (0..count).map(|number| &recording.scans[(2 * number + 1) * of / (2 * count)]);
    let mut answers: Vec<Answer> = Vec::with_capacity(count);
    for scan in scans {
        if interrupt::is_asked() {
            break;
        }
        answers.push(one(&locator, recording, scan));
    }
    let done = answers.len();
    // Each scan is a stretch of its own.
    let runs: Vec<Vec<Answer>> = answers.into_iter().map(|answer| vec![answer]).collect();
    let (result, bins) = (RowResult::of("each alone", &runs), bins(&runs));
    if arguments.json {
        console.print(&(serde_json::to_string(&json!({ "once": result, "bins": bins }))? + "\n"))?;
    } else {
        console.block(&Block::Table(table(std::slice::from_ref(&result))))?;
        if !bins.is_empty() {
            console.block(&Block::Table(reliability::table(&bins)))?;
        }
    }
    if done < count {
        console.note(&format!("interrupted: {done} of {count} scans are done"));
        return Ok(Status::Interrupted);
    }
    Ok(Status::Succeeded)
}

fn one(locator: &ScanLocator, recording: &Recording, scan: &Scan) -> Answer {
    let beam = |(reading, &range_m): (usize, &f32)| RangeBeam {
        bearing_rad: recording.geometry.bearing_rad(reading),
        range_m: f64::from(range_m),
    };
    let beams: Vec<RangeBeam> = scan.ranges_m.iter().enumerate().map(beam).collect();
    let began = Instant::now();
    let located = locator.locate(&beams);
    answer(Verdict::of(&located, scan.laser_in_map), began.elapsed().as_secs_f64() * 1e3)
}
