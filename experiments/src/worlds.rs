//! Drives from anywhere to any place, world by world: whether they arrive, and how long the way is
//! beside the shortest.

use super::catalogue::WORLDS;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::missions::{head, line, results};
use super::quantity::Quantity;
use super::request::ExperimentRequest;
use super::row_result::{RowResult, RowTally};
use super::trial::{Goal, MissionTrial, one_trial};
use anyhow::{Context, Result, bail};
use rpl_lang::compile::NoFiles;
use rpl_mission::modules::SiteRobot;
use rpl_mission::robot::Robot;
use rpl_mission::site::{Setup, Site};
use rpl_random::Stream;
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::office::OfficeSettings;
use rpl_robot::planning::{Inflation, PlannerModel, path_length_m};
use rpl_robot::world::{Place, World};
use rpl_shell::files::world_files;
use rpl_shell::sites;
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::Table;
use serde_json::json;
use std::sync::Arc;

/// Edge of a cell of the floor that the shortest ways are found on.
const CELL_M: f64 = 0.05;

/// Nobody starts nearer to a wall, so that every start can be left.
const START_AIR_M: f64 = 0.1;

/// What cannot be drawn by then is not there.
pub(super) const DRAWS: u32 = 2000;

/// Start and goal are at least this far apart in a straight line.
const APART_M: f64 = 3.0;

/// A world to drive in, and its floor.
pub struct TestGround {
    pub(super) world: World,
    pub(super) site: Site,
    /// What really stands there, at the price of length alone: for the shortest ways there are.
    pub(super) floor: PlannerModel,
}

impl TestGround {
    fn new(name: &str, robot: &Arc<RobotDescription>) -> Result<Self> {
        let world = world_files::for_all_seeds(name, robot)?;
        let inflation = Inflation {
            comfortable_distance_m: robot.radius_m,
            closeness_weight: 0.0,
            ..Inflation::of_robot(robot.radius_m)
        };
        Ok(Self {
            site: sites::build(
                Setup { world: Some(world.clone()), settings: OfficeSettings::of(robot.clone()), ..Setup::default() },
                None,
                Vec::new(),
            )?,
            floor: PlannerModel::new(&world.floor(CELL_M, |door| world.doors[door].open), inflation),
            world,
        })
    }
}

/// Where a robot is put down, and told so.
pub(super) struct StartPoint {
    pub(super) at_in_map: Pose,
    /// From there to where it is to go first.
    pub(super) path: Vec<Point>,
}

/// Drives world by world.
pub struct WorldDrives {
    request: ExperimentRequest,
    worlds: Vec<&'static str>,
    /// A run of a seed in one of them.
    run: fn(&TestGround, &ExperimentRequest, u64) -> Result<MissionTrial>,
}

impl WorldDrives {
    /// From anywhere to any place, in all worlds, or in the one that is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        Self::of(request, &WORLDS, drive)
    }

    /// The same for any list of worlds, and any run of a seed in one of them.
    ///
    /// # Errors
    /// As for [`WorldDrives::new`].
    pub fn of(
        request: ExperimentRequest,
        all: &[&'static str],
        run: fn(&TestGround, &ExperimentRequest, u64) -> Result<MissionTrial>,
    ) -> Result<Self> {
        let worlds = match request.row.as_deref().or(request.world.as_deref()) {
            None => all.to_vec(),
            Some(name) => match all.iter().find(|world| **world == name) {
                Some(world) => vec![*world],
                None => bail!(request.no_row(name, all)),
            },
        };
        Ok(Self { request, worlds, run })
    }
}

impl ExperimentKind for WorldDrives {
    type Ground = TestGround;
    type Record = MissionTrial;
    type Tally = RowTally;

    fn series(&self) -> Vec<String> {
        self.worlds.iter().map(|name| (*name).to_string()).collect()
    }

    fn ground(&self, series: usize) -> Result<TestGround> {
        TestGround::new(self.worlds[series], &self.request.robot)
    }

    fn run(&self, _: usize, ground: &TestGround, run: Run) -> Result<MissionTrial> {
        Ok((self.run)(ground, &self.request, run.seed)?.without_samples())
    }

    fn head(&self, first: &MissionTrial) -> String {
        head(first)
    }

    fn lines(&self, series: &str, _: Run, trial: &MissionTrial) -> String {
        line(series, trial)
    }

    fn findings(&self, tallies: Vec<RowTally>, _: bool) -> Result<Findings> {
        let results = results(&self.series(), &tallies);
        let all_arrived = results.iter().all(|row| row.failures.is_empty());
        let status = if all_arrived { Status::Succeeded } else { Status::Failed };
        let (blocks, figures) = (blocks(&results), json!({ "rows": results }));
        Ok(Findings { status, blocks, figures, drawings: Vec::new() })
    }
}

/// From anywhere to a place that is not near.
fn drive(ground: &TestGround, request: &ExperimentRequest, seed: u64) -> Result<MissionTrial> {
    let mut stream = Stream::new(seed, "errand");
    let drawn = (0..DRAWS).find_map(|_| {
        let destination = draw_place(&ground.world, &mut stream);
        let start = draw_start(ground, destination, &mut stream)?;
        Some((robot_at(&ground.site, seed, &start)?, start, destination))
    });
    let (robot, start, destination) = drawn.with_context(|| no_errand(ground, seed))?;
    let goal = Goal { pose_in_map: destination.pose_in_map, item: None };
    let text = format!("(go-to '{})", destination.name);
    run_errand(ground, robot, &text, request, seed, goal, path_length_m(&start.path))
}

pub(super) fn no_errand(ground: &TestGround, seed: u64) -> String {
    format!("no start and goal in `{}` for seed {seed}", ground.world.name)
}

/// Runs a plan to its end and measures it; `optimum_m` is the shortest way.
pub(super) fn run_errand(
    ground: &TestGround,
    robot: SiteRobot,
    text: &str,
    request: &ExperimentRequest,
    seed: u64,
    goal: Goal,
    optimum_m: f64,
) -> Result<MissionTrial> {
    let loaded = sites::load_text(&ground.site, "errand.rpl", text, &mut NoFiles, false)?;
    let system = ground.site.start_traced_with(Robot::Office(Box::new(robot)), loaded, seed);
    let mut trial = one_trial(system, seed, request.until_us, Some(goal))?;
    let way_m = trial.measure(&Quantity::Distance).filter(|_| trial.succeeded());
    trial.measures.push((Quantity::WayByOptimum, way_m.map(|way_m| way_m / optimum_m)));
    Ok(trial)
}

pub(super) fn draw_place<'w>(world: &'w World, stream: &mut Stream) -> &'w Place {
    &world.places[stream.index(world.places.len().max(1))]
}

/// A start with some room around it, from where a place that is not near can be reached.
pub(super) fn draw_start(ground: &TestGround, destination: &Place, stream: &mut Stream) -> Option<StartPoint> {
    let (bounds, floor) = (ground.world.bounds(), &ground.floor);
    let goal = destination.pose_in_map.point();
    let start =
        Point::new(stream.uniform_in(bounds.min.x, bounds.max.x), stream.uniform_in(bounds.min.y, bounds.max.y));
    let heading_rad = stream.uniform_in(-std::f64::consts::PI, std::f64::consts::PI);
    if distance_m(start, goal) < APART_M || floor.obstacle_distance_m(start) < floor.robot_radius_m() + START_AIR_M {
        return None;
    }
    let path = floor.cost_to_go(goal).path(start)?;
    Some(StartPoint { at_in_map: Pose::new(start.x, start.y, heading_rad), path })
}

/// The robot at a start; none if somebody stands there.
pub(super) fn robot_at(site: &Site, seed: u64, start: &StartPoint) -> Option<SiteRobot> {
    let Robot::Office(robot) = site.robot(seed) else { return None };
    robot.starting_at(start.at_in_map).ok()
}

fn blocks(rows: &[RowResult]) -> Vec<Block> {
    let mut table =
        Table::new(&["", "arrived", "95 % interval", "contacts", "way [m]", "way / opt.", "90 %", "time [s]", "lost"]);
    for row in rows {
        table.row([
            row.name.clone(),
            row.succeeded.fraction(),
            row.succeeded.interval(),
            row.total(&Quantity::ContactsCaused),
            row.median(&Quantity::Distance),
            row.median(&Quantity::WayByOptimum),
            row.nine_in_ten(&Quantity::WayByOptimum),
            row.median(&Quantity::Time),
            row.total(&Quantity::Relocalizations),
        ]);
    }
    let mut blocks = vec![Block::Table(table)];
    blocks.extend(rows.iter().filter_map(|row| {
        let seeds = row.failed_seeds.as_ref()?;
        Some(Block::Lines(format!("{}: not with seed {seeds}", row.name)))
    }));
    blocks.push(Block::Lines(
        "contacts: caused by the robot, total; way, way / optimum and time: medians; lost: relocalizations, total.\n\
         The optimum is the straightened way of the value field for the robot's radius on the real floor, at 5 cm."
            .into(),
    ));
    blocks
}
