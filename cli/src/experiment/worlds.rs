//! Drives from anywhere to any place, world by world: whether they arrive, and how long the way is
//! beside the shortest.

use super::catalogue::WORLDS;
use super::row_result::RowResult;
use super::trial::{Trial, one_trial};
use super::trials::run_all;
use super::{Arguments, Findings, jobs, no_row, progress, results, seeds, write_results};
use crate::console::Console;
use crate::mission::{self, Robot, Site};
use crate::page::Block;
use crate::status::Status;
use crate::table::Table;
use anyhow::{Context, Result, bail};
use rpl_lang::compile::NoFiles;
use rpl_random::Stream;
use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::navigation::{PlannerModel, PlannerParameters, path_length_m};
use rpl_robot::office::{OfficeRobot, OfficeSettings};
use rpl_robot::world::{Place, ROBOT_RADIUS_M, World};
use rpl_runtime::system::System;
use serde_json::json;

/// Edge of a cell of the floor that the shortest ways are found on.
const CELL_M: f64 = 0.05;

/// Nobody starts nearer to a wall, so that every start can be left.
const START_CLEARANCE_M: f64 = ROBOT_RADIUS_M + 0.1;

/// Start and goal are at least this far apart in a straight line.
const APART_M: f64 = 3.0;

/// What the way driven is measured by.
const WAY_BY_OPTIMUM: &str = "way / optimum";

/// One drive of a seed.
struct Errand<'w> {
    /// At its start, and told so.
    robot: OfficeRobot,
    destination: &'w Place,
    optimum_m: f64,
}

/// Runs the drives of all worlds, or of the one that is asked for.
///
/// # Errors
/// No row has the name, a run cannot be driven, or the results cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Findings> {
    let wanted = arguments.row.as_deref().or(arguments.world.as_deref());
    let worlds: Vec<&str> = match wanted {
        None => WORLDS.to_vec(),
        Some(name) => match WORLDS.iter().find(|world| **world == name) {
            Some(world) => vec![world],
            None => bail!(no_row("worlds", name, &WORLDS)),
        },
    };
    let mut rows = Vec::new();
    for name in worlds {
        rows.push((name, drives(arguments, console, name)?));
    }
    write_results(arguments, &rows, &[])?;
    let results = results(&rows);
    let all_arrived = results.iter().all(|row| row.failures.is_empty());
    let status = if all_arrived { Status::Succeeded } else { Status::Failed };
    Ok(Findings { status, blocks: blocks(&results), figures: json!({ "rows": results }) })
}

fn drives(arguments: &Arguments, console: &Console, name: &str) -> Result<Vec<Trial>> {
    let world = mission::world(name)?;
    let site = Site::new(Some(world.clone()), None, OfficeSettings::default())?;
    let parameters = PlannerParameters {
        comfortable_distance_m: ROBOT_RADIUS_M,
        closeness_weight: 0.0,
        ..PlannerParameters::default()
    };
    let floor = PlannerModel::new(&world.floor(CELL_M, |door| world.doors[door].open), parameters);
    let seeds = seeds(arguments);
    let bar = progress(seeds.len() as u64, console);
    bar.set_message(name.to_string());
    let one = |seed: u64| -> Result<Trial> {
        let Robot::Office(robot) = site.robot(seed) else { bail!("there is no robot in `{name}`") };
        let errand = draw(&world, &floor, &robot, seed)
            .with_context(|| format!("no start and goal in `{name}` for seed {seed}"))?;
        let text = format!("(go-to '{})", errand.destination.name);
        let loaded = match site.library.load("go-to.rpl", &text, &mut NoFiles) {
            Ok(loaded) => loaded,
            Err(rejected) => bail!("{}", rejected.render(false).trim_end()),
        };
        let system = System::traced(site.library.clone(), loaded, Robot::Office(Box::new(errand.robot)), seed);
        let mut trial = one_trial(system, seed, arguments.until, Some(errand.destination.pose_in_map))?;
        let way_m = trial.measure("distance [m]").filter(|_| trial.succeeded());
        trial.measures.push((WAY_BY_OPTIMUM, way_m.map(|way_m| way_m / errand.optimum_m)));
        Ok(trial)
    };
    let trials = run_all(&seeds, jobs(arguments), one, || bar.inc(1));
    bar.finish_and_clear();
    trials.into_iter().collect()
}

/// A start with some room around it where nobody stands, and a place that is not near, drawn from
/// the seed; none if two thousand draws find nothing.
fn draw<'w>(world: &'w World, floor: &PlannerModel, robot: &OfficeRobot, seed: u64) -> Option<Errand<'w>> {
    let mut stream = Stream::new(seed, "errand");
    let bounds = world.bounds();
    for _ in 0..2000 {
        let destination = &world.places[stream.index(world.places.len().max(1))];
        let goal = destination.pose_in_map.point();
        let start =
            Point::new(stream.uniform_in(bounds.min.x, bounds.max.x), stream.uniform_in(bounds.min.y, bounds.max.y));
        let heading_rad = stream.uniform_in(-std::f64::consts::PI, std::f64::consts::PI);
        if distance_m(start, goal) < APART_M || floor.obstacle_distance_m(start) < START_CLEARANCE_M {
            continue;
        }
        let start_in_map = Pose::new(start.x, start.y, heading_rad);
        if let Some(path) = floor.value_field(goal).path(start)
            && let Ok(robot) = robot.clone().starting_at(start_in_map)
        {
            return Some(Errand { robot, destination, optimum_m: path_length_m(&path) });
        }
    }
    None
}

fn blocks(rows: &[RowResult]) -> Vec<Block> {
    let mut table =
        Table::new(&["", "arrived", "95 % interval", "contacts", "way [m]", "way / opt.", "90 %", "time [s]", "lost"]);
    for row in rows {
        table.row([
            row.name.clone(),
            row.succeeded.fraction(),
            row.succeeded.interval(),
            row.total("contacts caused"),
            row.median("distance [m]"),
            row.median(WAY_BY_OPTIMUM),
            row.nine_in_ten(WAY_BY_OPTIMUM),
            row.median("time [s]"),
            row.total("relocalizations"),
        ]);
    }
    let mut blocks = vec![Block::Table(table)];
    blocks.extend(rows.iter().filter_map(|row| {
        let seeds = row.failed_seeds()?;
        Some(Block::Lines(format!("{}: not with seed {seeds}", row.name)))
    }));
    blocks.push(Block::Lines(
        "contacts: caused by the robot, total; way, way / optimum and time: medians; lost: relocalizations, total.\n\
         The optimum is the straightened way of the value field for the robot's radius on the real floor, at 5 cm."
            .into(),
    ));
    blocks
}
