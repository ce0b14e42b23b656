//! Experiments: a plan over many seeds, in parallel, as a table.

mod barn;
mod calibration;
mod cases;
mod catalogue;
mod chart;
mod choices;
mod day;
mod doors;
mod findings;
mod instructions;
mod missions;
mod request;
mod row_result;
mod sensing;
pub mod statistics;
mod trial;
mod trials;
mod worlds;

pub use request::ExperimentRequest;

use crate::terminal::console::Console;
use crate::terminal::page::Block;
use anyhow::{Result, bail};
use catalogue::{EXPERIMENTS, Experiment, ExperimentSubject, Row};
use findings::ExperimentResult;
use missions::{missions, over_time, own_plan, results, status, whether_measured, write_results};
use row_result::comparison;
use rpl_robot::description::RobotDescription;
use rpl_robot::localization::{Calibration, LocalizationParameters};
use serde_json::json;
use trial::MissionTrial;
use trials::sample_rows;

/// Runs an experiment, or a plan of the user's own.
///
/// # Errors
/// No experiment or plan has the name, the plan's text is wrong, or the results cannot be written.
pub fn run(request: &ExperimentRequest, console: &mut Console) -> Result<ExperimentResult> {
    let experiment = EXPERIMENTS.iter().find(|known| known.name == request.name);
    let Some(experiment) = experiment else { return own_plan(request, console) };
    let has_own_robot = matches!(
        experiment.subject,
        ExperimentSubject::Barn
            | ExperimentSubject::Sensing
            | ExperimentSubject::Routes
            | ExperimentSubject::CaseKinds
            | ExperimentSubject::Behaviours
    ) || experiment.rows.iter().any(Row::chooses_robot);
    if has_own_robot && request.robot.name != RobotDescription::PAPERS {
        bail!("the experiment `{}` has a robot of its own; leave `--robot` away", experiment.name);
    }
    let chosen = || rows(experiment, request);
    match experiment.subject {
        ExperimentSubject::Barn => barn::run(request, console),
        ExperimentSubject::Worlds => worlds::run(request, console),
        ExperimentSubject::Doors => doors::run(request, console),
        ExperimentSubject::Sensing => sensing::run(request, console),
        ExperimentSubject::HallwayFeatures => instructions::hallway_features(request, console),
        ExperimentSubject::CountOpenings => instructions::count_openings(request, console),
        ExperimentSubject::OfficeDelivery => instructions::office_delivery(request, console),
        ExperimentSubject::TopologicalGlobal => instructions::topological_global(request, console),
        ExperimentSubject::MarkerDetection => instructions::marker_detection(request, console),
        ExperimentSubject::Routes => cases::routes(request, console),
        ExperimentSubject::CaseKinds => cases::case_kinds(request, console),
        ExperimentSubject::Behaviours => cases::behaviours(request, console),
        ExperimentSubject::Choices => choices::run(request, &chosen()?, console),
        ExperimentSubject::Success => {
            let rows = missions(request, &chosen()?, console)?;
            let results = results(&rows);
            write_results(request, &rows, &over_time(&rows))?;
            let mut blocks = results[0].blocks();
            blocks.push(Block::Lines(String::new()));
            blocks.extend(comparison(&results));
            Ok(ExperimentResult { status: status(&rows[0].1), blocks, figures: json!({ "rows": results }) })
        }
        ExperimentSubject::Comparison => {
            let rows = missions(request, &chosen()?, console)?;
            let results = results(&rows);
            write_results(request, &rows, &[])?;
            let blocks = comparison(&results);
            Ok(ExperimentResult { status: whether_measured(&rows), blocks, figures: json!({ "rows": results }) })
        }
        ExperimentSubject::Calibration => {
            let rows = missions(request, &chosen()?, console)?;
            let results = results(&rows);
            let all: Vec<&MissionTrial> =
                rows.iter().flat_map(|(_, trials)| trials).filter(|trial| trial.is_measured()).collect();
            let used = LocalizationParameters::of(&request.robot).calibration.unwrap_or_else(|| Calibration::new(&[]));
            let reliability = calibration::Reliability::of(&all, &used);
            let diagram = chart::reliability(&reliability.bins);
            write_results(request, &rows, &[("reliability.svg", diagram), ("samples.csv", sample_rows(&rows))])?;
            let mut blocks = reliability.blocks();
            blocks.push(Block::Lines(String::new()));
            blocks.extend(comparison(&results));
            let figures = json!({ "reliability": reliability, "rows": results });
            Ok(ExperimentResult { status: whether_measured(&rows), blocks, figures })
        }
    }
}

/// All rows of an experiment, or the one that is asked for.
fn rows(experiment: &Experiment, request: &ExperimentRequest) -> Result<Vec<&'static Row>> {
    let Some(name) = request.row.as_deref() else { return Ok(experiment.rows.iter().collect()) };
    let found: Vec<&Row> = experiment.rows.iter().filter(|row| row.name == name).collect();
    if found.is_empty() {
        bail!(request.no_row(name, &row_names(experiment)));
    }
    Ok(found)
}

/// What can be asked for with `--row`.
fn row_names(experiment: &Experiment) -> Vec<&'static str> {
    match experiment.subject {
        ExperimentSubject::Barn => barn::row_names(),
        ExperimentSubject::Worlds => catalogue::WORLDS.to_vec(),
        ExperimentSubject::Doors => doors::WORLDS.to_vec(),
        ExperimentSubject::Sensing => sensing::row_names(),
        ExperimentSubject::HallwayFeatures => instructions::feature_rows(),
        ExperimentSubject::CountOpenings => instructions::counting_rows(),
        ExperimentSubject::OfficeDelivery => instructions::delivery_rows(),
        ExperimentSubject::TopologicalGlobal => instructions::map_rows(),
        ExperimentSubject::MarkerDetection => instructions::marker_rows(),
        ExperimentSubject::Routes => cases::route_rows(),
        ExperimentSubject::CaseKinds => cases::kind_rows(),
        ExperimentSubject::Behaviours => cases::behaviour_rows(),
        ExperimentSubject::Success
        | ExperimentSubject::Comparison
        | ExperimentSubject::Calibration
        | ExperimentSubject::Choices => experiment.rows.iter().map(|row| row.name).collect(),
    }
}

/// The experiments with a name, each with its rows.
pub fn names() -> impl Iterator<Item = (&'static str, Vec<&'static str>)> {
    EXPERIMENTS.iter().map(|experiment| (experiment.name, row_names(experiment)))
}
