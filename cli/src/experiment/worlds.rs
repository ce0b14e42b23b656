//! Drives from anywhere to any place, world by world: whether they arrive, and how long the way is
//! beside the shortest.

use super::catalogue::WORLDS;
use super::statistics::{Spread, wilson_95};
use super::trial::{Goal, Trial, one_trial};
use super::trials::{failures, run_all};
use super::{Arguments, jobs, progress, seeds, write_results};
use crate::console::Console;
use crate::mission::{self, Robot, Site};
use crate::status::Status;
use anyhow::{Context, Result, bail};
use rpl_lang::compile::NoFiles;
use rpl_lang::suggest::suggest;
use rpl_random::Stream;
use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::navigation::{PlannerModel, PlannerParameters, path_length_m};
use rpl_robot::office::{OfficeRobot, OfficeSettings};
use rpl_robot::world::{Place, ROBOT_RADIUS_M, World};
use rpl_runtime::system::System;

/// Edge of a cell of the floor that the shortest ways are found on.
const CELL_M: f64 = 0.05;

/// Nobody starts nearer to a wall, so that every start can be left.
const START_CLEARANCE_M: f64 = ROBOT_RADIUS_M + 0.1;

/// What cannot be drawn by then is not there.
pub(super) const DRAWS: u32 = 2000;

/// Start and goal are at least this far apart in a straight line.
const APART_M: f64 = 3.0;

/// A world to drive in, and its floor.
pub(super) struct Ground {
    pub(super) world: World,
    pub(super) site: Site,
    /// What really stands there, at the price of length alone: for the shortest ways there are.
    pub(super) floor: PlannerModel,
}

impl Ground {
    fn new(name: &str) -> Result<Self> {
        let world = mission::world(name)?;
        let parameters = PlannerParameters {
            comfortable_distance_m: ROBOT_RADIUS_M,
            closeness_weight: 0.0,
            ..PlannerParameters::default()
        };
        Ok(Self {
            site: Site::new(Some(world.clone()), None, OfficeSettings::default())?,
            floor: PlannerModel::new(&world.floor(CELL_M, |door| world.doors[door].open), parameters),
            world,
        })
    }
}

/// Where a robot is put down, and told so.
pub(super) struct Start {
    pub(super) at_in_map: Pose,
    /// From there to where it is to go first.
    pub(super) path: Vec<Point>,
}

/// Runs the drives of all worlds, or of the one that is asked for.
///
/// # Errors
/// No row has the name, a run cannot be driven, or the results cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    run_in(arguments, console, &WORLDS, drive)
}

/// The same for any list of worlds, and any run of a seed in one of them.
///
/// # Errors
/// As for [`run`].
pub(super) fn run_in(
    arguments: &Arguments,
    console: &mut Console,
    all_worlds: &[&'static str],
    run: fn(&Ground, &Arguments, u64) -> Result<Trial>,
) -> Result<Status> {
    let worlds: Vec<&str> = match arguments.row.as_deref().or(arguments.world.as_deref()) {
        None => all_worlds.to_vec(),
        Some(name) => match all_worlds.iter().find(|world| **world == name) {
            Some(world) => vec![world],
            None => bail!("{}", unknown(&arguments.name, name, all_worlds)),
        },
    };
    let mut rows = Vec::new();
    for name in worlds {
        let ground = Ground::new(name)?;
        let seeds = seeds(arguments);
        let bar = progress(seeds.len() as u64, console);
        bar.set_message(name.to_string());
        let trials = run_all(&seeds, jobs(arguments), |seed| run(&ground, arguments, seed), || bar.inc(1));
        bar.finish_and_clear();
        rows.push((name, trials.into_iter().collect::<Result<Vec<Trial>>>()?));
    }
    console.print(&table(&rows))?;
    let all_arrived = rows.iter().flat_map(|(_, trials)| trials).all(|trial| trial.succeeded());
    write_results(arguments, &rows, &[])?;
    Ok(if all_arrived { Status::Succeeded } else { Status::Failed })
}

fn unknown(experiment: &str, name: &str, worlds: &[&str]) -> String {
    let meant =
        suggest(name, worlds.iter().copied()).map_or(String::new(), |meant| format!(", did you mean `{meant}`?"));
    format!("the experiment `{experiment}` has no row `{name}`{meant} (it has {})", worlds.join(", "))
}

/// From anywhere to a place that is not near.
fn drive(ground: &Ground, arguments: &Arguments, seed: u64) -> Result<Trial> {
    let mut stream = Stream::new(seed, "errand");
    let drawn = (0..DRAWS).find_map(|_| {
        let destination = draw_place(&ground.world, &mut stream);
        let start = draw_start(ground, destination, &mut stream)?;
        Some((robot_at(&ground.site, seed, &start)?, start, destination))
    });
    let (robot, start, destination) = drawn.with_context(|| no_errand(ground, seed))?;
    let goal = Goal { pose_in_map: destination.pose_in_map, item: None };
    let text = format!("(go-to '{})", destination.name);
    run_errand(ground, robot, &text, arguments, seed, goal, path_length_m(&start.path))
}

pub(super) fn no_errand(ground: &Ground, seed: u64) -> String {
    format!("no start and goal in `{}` for seed {seed}", ground.world.name)
}

/// Runs a plan to its end and measures it; `optimum_m` is the shortest way.
pub(super) fn run_errand(
    ground: &Ground,
    robot: OfficeRobot,
    text: &str,
    arguments: &Arguments,
    seed: u64,
    goal: Goal<'_>,
    optimum_m: f64,
) -> Result<Trial> {
    let library = &ground.site.library;
    let loaded = match library.load("errand.rpl", text, &mut NoFiles) {
        Ok(loaded) => loaded,
        Err(rejected) => bail!("{}", rejected.render(false).trim_end()),
    };
    let system = System::traced(library.clone(), loaded, Robot::Office(Box::new(robot)), seed);
    let mut trial = one_trial(system, seed, arguments.until, Some(goal))?;
    let way_m = trial.measure("distance [m]").filter(|_| trial.succeeded());
    trial.measures.push(("way / optimum", way_m.map(|way_m| way_m / optimum_m)));
    Ok(trial)
}

pub(super) fn draw_place<'w>(world: &'w World, stream: &mut Stream) -> &'w Place {
    &world.places[stream.index(world.places.len().max(1))]
}

/// A start with some room around it, from where a place that is not near can be reached.
pub(super) fn draw_start(ground: &Ground, destination: &Place, stream: &mut Stream) -> Option<Start> {
    let (bounds, floor) = (ground.world.bounds(), &ground.floor);
    let goal = destination.pose_in_map.point();
    let start =
        Point::new(stream.uniform_in(bounds.min.x, bounds.max.x), stream.uniform_in(bounds.min.y, bounds.max.y));
    let heading_rad = stream.uniform_in(-std::f64::consts::PI, std::f64::consts::PI);
    if distance_m(start, goal) < APART_M || floor.obstacle_distance_m(start) < START_CLEARANCE_M {
        return None;
    }
    let path = floor.value_field(goal).path(start)?;
    Some(Start { at_in_map: Pose::new(start.x, start.y, heading_rad), path })
}

/// The robot at a start; none if somebody stands there.
pub(super) fn robot_at(site: &Site, seed: u64, start: &Start) -> Option<OfficeRobot> {
    let Robot::Office(robot) = site.robot(seed) else { return None };
    robot.starting_at(start.at_in_map).ok()
}

fn table(rows: &[(&str, Vec<Trial>)]) -> String {
    let mut lines = vec![format!(
        "{:18} {:>9} {:>15} {:>8} {:>8} {:>10} {:>8} {:>9} {:>6}",
        "", "arrived", "95 % interval", "contacts", "way [m]", "way / opt.", "90 %", "time [s]", "lost"
    )];
    for (name, trials) in rows {
        let numbers =
            |measure: &str| -> Vec<f64> { trials.iter().filter_map(|trial| trial.measure(measure)).collect() };
        let median = |measure: &str| {
            Spread::of(&numbers(measure)).map_or("–".to_string(), |spread| format!("{:.2}", spread.median))
        };
        let mut ratios = numbers("way / optimum");
        ratios.sort_by(f64::total_cmp);
        let nine_in_ten = ratios.get(ratios.len() * 9 / 10).map_or("–".to_string(), |ratio| format!("{ratio:.2}"));
        let arrived = trials.iter().filter(|trial| trial.succeeded()).count();
        let (low, high) = wilson_95(arrived, trials.len());
        lines.push(format!(
            "{name:18} {:>9} {:>15} {:>8} {:>8} {:>10} {nine_in_ten:>8} {:>9} {:>6}",
            format!("{arrived}/{}", trials.len()),
            format!("{:.1}–{:.1} %", 100.0 * low, 100.0 * high),
            numbers("contacts caused").iter().sum::<f64>(),
            median("distance [m]"),
            median("way / optimum"),
            median("time [s]"),
            numbers("relocalizations").iter().sum::<f64>(),
        ));
        lines.extend(failures(trials).map(|failures| format!("{:18} not with seed {failures}", "")));
    }
    lines.push(
        "contacts: caused by the robot, total; way, way / optimum and time: medians; lost: relocalizations, total."
            .into(),
    );
    lines.push(
        "The optimum is the straightened way of the value field for the robot's radius on the real floor, at 5 cm."
            .into(),
    );
    lines.join("\n")
}
