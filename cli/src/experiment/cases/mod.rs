//! The case memory of RUPART without its robot (Fox and Anderson-Sprecher 2006): how good its routes are and how
//! much work, and whether the kind of case comes back that is needed.

mod behaviours;
mod kinds;
mod pictures;
mod routes;

use super::findings::ExperimentResult;
use super::request::ExperimentRequest;
use super::trials::run_all;
use crate::files::{robot_files, world_files};
use crate::status::Status;
use crate::terminal::console::Console;
use crate::terminal::progress;
use anyhow::{Result, bail};
use behaviours::{BehaviourResult, BehaviourRow};
use kinds::{KindResult, KindRow};
use routes::{RouteResult, RouteRow};
use rpl_robot::description::RobotDescription;
use rpl_robot::simulator::{SimulatorModel, SimulatorSettings};
use rpl_robot::world::World;
use rpl_rupart::places::Places;
use rpl_rupart::trial::{Driven, Driver, DrivingGround, KindGround, KindRetrieved, RouteAsked, run_routes};
use serde_json::json;
use std::sync::Arc;

/// Where, unless another world is named.
const WORLD: &str = "olin-rice";

/// Who drives there.
const ROBOT: &str = "pioneer-2dx";

/// The building, its places, and the robot that is to pass between them.
struct Building {
    world: World,
    robot: Arc<RobotDescription>,
    places: Places,
}

impl Building {
    fn of(request: &ExperimentRequest) -> Result<Self> {
        let robot = robot_files::named(Some(ROBOT))?;
        let world = world_files::for_all_seeds(request.world.as_deref().unwrap_or(WORLD), &robot)?;
        let places = Places::new(&world, robot.radius_m)?;
        Ok(Self { world, robot, places })
    }
}

/// Asks for routes, row by row.
///
/// # Errors
/// No row has the name, there is no such world, or the results cannot be written.
pub fn routes(request: &ExperimentRequest, console: &mut Console) -> Result<ExperimentResult> {
    let is_meant = |row: &&RouteRow| request.row.as_deref().is_none_or(|name| name == row.name);
    let chosen: Vec<&RouteRow> = routes::ROWS.iter().filter(is_meant).collect();
    if chosen.is_empty() {
        bail!(request.no_row(request.row.as_deref().unwrap_or_default(), &route_rows()));
    }
    let building = Building::of(request)?;
    let home = building.places.closest(building.world.start_in_map.point());
    let seeds = request.seeds();
    let mut rows: Vec<(&RouteRow, Vec<Vec<RouteAsked>>)> = Vec::new();
    for row in chosen {
        let bar = progress::runs(seeds.len() as u64, row.name, console);
        let one = |seed: u64| run_routes(&building.places, home, &row.trial, seed);
        let asked = run_all(&seeds, request.jobs, one, || bar.inc(1));
        bar.finish_and_clear();
        rows.push((row, asked));
    }
    let results: Vec<RouteResult> = rows.iter().map(|(row, asked)| RouteResult::of(row, asked)).collect();
    let mut files = pictures::files(&building.world, &building.places, &rows);
    files.push(("runs.csv".to_string(), routes::raw_rows(&seeds, &rows)));
    request.write(&files)?;
    Ok(ExperimentResult {
        status: Status::Succeeded,
        blocks: routes::blocks(&results),
        figures: json!({ "rows": results }),
    })
}

/// What can be asked for with `--row`.
pub fn route_rows() -> Vec<&'static str> {
    routes::ROWS.iter().map(|row| row.name).collect()
}

/// Retrieves cases for every reason, row by row.
///
/// # Errors
/// As for [`routes`].
pub fn case_kinds(request: &ExperimentRequest, console: &mut Console) -> Result<ExperimentResult> {
    let is_meant = |row: &&KindRow| request.row.as_deref().is_none_or(|name| name == row.name);
    let chosen: Vec<&KindRow> = kinds::ROWS.iter().filter(is_meant).collect();
    if chosen.is_empty() {
        bail!(request.no_row(request.row.as_deref().unwrap_or_default(), &kind_rows()));
    }
    let building = Building::of(request)?;
    let ground = KindGround::new(&building.world, &building.places, &building.robot);
    let seeds = request.seeds();
    let mut rows: Vec<(&str, Vec<Vec<KindRetrieved>>)> = Vec::new();
    for row in chosen {
        let bar = progress::runs(seeds.len() as u64, row.name, console);
        let one = |seed: u64| ground.retrieve(row.telling, row.phase, kinds::EACH, seed);
        let retrieved = run_all(&seeds, request.jobs, one, || bar.inc(1));
        bar.finish_and_clear();
        rows.push((row.name, retrieved));
    }
    let results: Vec<KindResult> = rows.iter().map(|(name, retrieved)| KindResult::of(name, retrieved)).collect();
    request.write(&[("runs.csv".to_string(), kinds::raw_rows(&seeds, &rows))])?;
    Ok(ExperimentResult {
        status: Status::Succeeded,
        blocks: kinds::blocks(&results),
        figures: json!({ "rows": results }),
    })
}

/// What can be asked for with `--row`.
pub fn kind_rows() -> Vec<&'static str> {
    kinds::ROWS.iter().map(|row| row.name).collect()
}

/// Drives by behaviour cases, row by row; all rows drive the same routes.
///
/// # Errors
/// As for [`routes`].
pub fn behaviours(request: &ExperimentRequest, console: &mut Console) -> Result<ExperimentResult> {
    let is_meant = |row: &&BehaviourRow| request.row.as_deref().is_none_or(|name| name == row.name);
    let chosen: Vec<&BehaviourRow> = behaviours::ROWS.iter().filter(is_meant).collect();
    if chosen.is_empty() {
        bail!(request.no_row(request.row.as_deref().unwrap_or_default(), &behaviour_rows()));
    }
    let building = Building::of(request)?;
    let model = Arc::new(SimulatorModel::new(Arc::new(building.world), SimulatorSettings::of(building.robot)));
    let ground = DrivingGround { model: &model, places: &building.places };
    let seeds = request.seeds();
    let mut rows: Vec<(&BehaviourRow, Vec<Option<Driven>>)> = Vec::new();
    let mut cases = Vec::new();
    for row in chosen {
        let memory = ground.memory(row.driver);
        let bar = progress::runs(seeds.len() as u64, row.name, console);
        let one = |seed: u64| ground.drive(&memory, row.is_braked, row.judges, seed);
        let driven = run_all(&seeds, request.jobs, one, || bar.inc(1));
        bar.finish_and_clear();
        cases.push(memory.len());
        rows.push((row, driven));
    }
    let tuned = rows.iter().find(|(row, _)| row.driver == Driver::Tuned && row.is_braked);
    let tuned = tuned.map(|(_, driven)| driven.as_slice());
    let results: Vec<BehaviourResult> = rows
        .iter()
        .zip(&cases)
        .map(|((row, driven), cases)| BehaviourResult::of(row.name, *cases, driven, tuned))
        .collect();
    request.write(&[("runs.csv".to_string(), behaviours::raw_rows(&seeds, &rows))])?;
    Ok(ExperimentResult {
        status: Status::Succeeded,
        blocks: behaviours::blocks(&results),
        figures: json!({ "rows": results }),
    })
}

/// What can be asked for with `--row`.
pub fn behaviour_rows() -> Vec<&'static str> {
    behaviours::ROWS.iter().map(|row| row.name).collect()
}
