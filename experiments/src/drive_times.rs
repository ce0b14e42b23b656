//! How well it is foreseen how long a drive takes: undisturbed drives between places drawn from the seed,
//! each beside the time that the table of foresight gives its way.

use super::conduct::chosen;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::request::ExperimentRequest;
use anyhow::{Result, bail};
use rpl_lang::compile::NoFiles;
use rpl_mission::robot::Robot;
use rpl_mission::run::{Reached, run_to};
use rpl_mission::site::Site;
use rpl_random::Stream;
use rpl_robot::foresight::drive_times::{DriveTimes, WayFeatures};
use rpl_robot::foresight::ways::{Way, Ways};
use rpl_runtime::run::system::Outcome;
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::ops::ControlFlow::Continue;

/// The worlds whose drives are timed.
pub(super) const WORLDS: [&str; 4] = ["dept", "long-corridor", "small-office", "two-wings"];

/// A drive is foreseen well if its time is off by less.
const WELL: f64 = 0.06;

/// A drive that has arrived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimedDrive {
    seed: u64,
    way: WayFeatures,
    took_s: f64,
    expected_s: f64,
}

impl TimedDrive {
    fn error(&self) -> f64 {
        (self.expected_s / self.took_s - 1.0).abs()
    }
}

/// Drives that are timed, world by world.
pub struct TimedDrives {
    request: ExperimentRequest,
    worlds: Vec<&'static str>,
}

impl TimedDrives {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let worlds = worlds(&request)?;
        Ok(Self { request, worlds })
    }
}

/// The worlds that are asked for, by `--row` or `--world`.
///
/// # Errors
/// None has the name.
pub(super) fn worlds(request: &ExperimentRequest) -> Result<Vec<&'static str>> {
    let mut worlds: Vec<&'static str> = chosen(request, &WORLDS, |world| *world)?.into_iter().copied().collect();
    if let Some(asked) = &request.world {
        worlds.retain(|world| world == asked);
        if worlds.is_empty() {
            bail!(request.no_row(asked, &WORLDS));
        }
    }
    Ok(worlds)
}

impl ExperimentKind for TimedDrives {
    type Ground = Site;
    /// None if there is no way, or the drive does not arrive.
    type Record = Option<TimedDrive>;
    type Tally = Vec<Option<TimedDrive>>;

    fn series(&self) -> Vec<String> {
        self.worlds.iter().map(|world| (*world).to_string()).collect()
    }

    fn ground(&self, series: usize) -> Result<Site> {
        self.request.office(self.worlds[series])
    }

    fn run(&self, _: usize, site: &Site, run: Run) -> Result<Option<TimedDrive>> {
        drive(site, run.seed, self.request.until_us)
    }

    fn head(&self, _: &Option<TimedDrive>) -> String {
        "world,seed,took_s,expected_s,hallway_m,office_m,doorway_m,turned_rad".to_string()
    }

    fn lines(&self, series: &str, _: Run, drive: &Option<TimedDrive>) -> String {
        let Some(TimedDrive { seed, way, took_s, expected_s }) = drive else { return String::new() };
        let WayFeatures { hallway_m, office_m, doorway_m, turned_rad } = way;
        format!(
            "{series},{seed},{took_s:.2},{expected_s:.2},{hallway_m:.3},{office_m:.3},{doorway_m:.3},{turned_rad:.3}\n"
        )
    }

    fn findings(&self, tallies: Vec<Vec<Option<TimedDrive>>>, _: bool) -> Result<Findings> {
        let heads = ["world", "arrived", "time [s]", "median error [%]", "90 % within [%]", "within 6 %"];
        let mut table = Table::new(&heads);
        let worlds = self.worlds.iter().zip(&tallies);
        let mut rows: Vec<Value> = worlds.map(|(world, drives)| tell(world, drives, &mut table)).collect();
        if rows.len() > 1 {
            rows.push(tell("all", &tallies.concat(), &mut table));
        }
        let (blocks, figures) = (vec![Block::Table(table)], json!({ "rows": rows }));
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings: Vec::new() })
    }
}

fn tell(world: &str, driven: &[Option<TimedDrive>], table: &mut Table) -> Value {
    let (drives, of): (Vec<&TimedDrive>, usize) = (driven.iter().flatten().collect(), driven.len());
    let mut errors: Vec<f64> = drives.iter().map(|drive| drive.error()).collect();
    errors.sort_by(f64::total_cmp);
    let quantile = |share: f64| errors.get((share * errors.len() as f64) as usize).copied();
    let time_s = drives.iter().map(|drive| drive.took_s).sum::<f64>() / drives.len().max(1) as f64;
    let well = errors.iter().filter(|&&error| error < WELL).count();
    let (median, most) = (quantile(0.5), quantile(0.9));
    let percent = |error: Option<f64>| error.map_or(NOTHING.to_string(), |error| format!("{:.1}", 100.0 * error));
    table.row([
        world.to_string(),
        format!("{} of {of}", drives.len()),
        if drives.is_empty() { NOTHING.to_string() } else { format!("{time_s:.1}") },
        percent(median),
        percent(most),
        well.to_string(),
    ]);
    json!({ "row": world, "arrived": drives.len(), "of": of, "mean_time_s": time_s, "median_error": median, "error_90": most, "well": well })
}

/// One drive from a place to another, both drawn; none if they are the same or have no way between them, or if
/// it does not arrive.
fn drive(site: &Site, seed: u64, until_us: u64) -> Result<Option<TimedDrive>> {
    let Some(office) = site.office() else { bail!("drives need a world") };
    let Some(map) = &office.map else { bail!("drives need a map") };
    let mut stream = Stream::new(seed, "errand");
    let places = &office.world.places;
    let from = &places[stream.index(places.len())];
    let to = &places[stream.index(places.len())];
    let robot = site.office_robot(seed).and_then(|robot| robot.starting_at(from.pose_in_map).ok());
    let (Some(robot), true) = (robot, from.name != to.name) else { return Ok(None) };
    let plan = map.topology.plan(&map.navigation.planner, from.pose_in_map, to, &[]);
    let way = plan
        .ok()
        .and_then(|plan| Way::over(&Ways::default(), map.ways(&office.world), from.pose_in_map, &plan.targets));
    let Some(way) = way else { return Ok(None) };
    let loaded = site.compile("drive.rpl", &format!("(go-to '{})", to.name), &mut NoFiles)?;
    let mut system = site.start_traced_with(Robot::Office(Box::new(robot)), loaded, seed);
    let reached = run_to(&mut system, until_us, |system| {
        system.machine.trace.take();
        Continue(())
    });
    let Reached::End(Outcome::Succeeded(_)) = reached else { return Ok(None) };
    let way = way.features();
    let expected_s = DriveTimes::of(&office.settings.robot).time_s(&way);
    Ok(Some(TimedDrive { seed, way, took_s: system.machine.now_s(), expected_s }))
}
