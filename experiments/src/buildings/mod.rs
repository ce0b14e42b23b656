//! Drives in buildings nobody has tuned anything to: of each kind, and on recorded floor plans, undisturbed and
//! disturbed.

mod certainty;
mod disturbance;
mod rows;
mod table;
mod trial;

pub use rows::row_names;

use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::request::ExperimentRequest;
use anyhow::{Context, Result, bail};
use disturbance::Disturbance;
use rows::{BuildingRow, Plot};
use rpl_mission::cost::{MEMORY_GIB, TooLarge};
use rpl_mission::libraries::robot_library;
use rpl_mission::modules::own_modules;
use rpl_mission::site::Site;
use rpl_robot::buildings::{Building, Furniture};
use rpl_robot::description::RobotDescription;
use rpl_robot::localization::LocalizationParameters;
use rpl_robot::office::{OfficeModel, OfficeSettings};
use rpl_runtime::run::library::{Library, Loaded};
use rpl_shell::files::plans;
use rpl_shell::sites;
use rpl_shell::status::Status;
use std::sync::Arc;
use table::Tables;
use trial::BuildingTrial;

/// The errand, the same everywhere.
const ERRAND: &str = "experiments/three-places.rpl";

/// A run that takes longer, in the plan's time, has not arrived.
const MOST_US: u64 = 1_800_000_000;

/// The factor by which wheels that slip err more than the description of the robot says.
const SLIP: f64 = 10.0;

/// Drives in buildings, series by series.
pub struct Buildings {
    request: ExperimentRequest,
    rows: Vec<BuildingRow>,
    /// What the buildings of each row are drawn on.
    plots: Vec<Arc<Plot>>,
}

impl Buildings {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name, there is no map, or a map has faults.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let rows = BuildingRow::asked(&request)?;
        let mut plots: Vec<Arc<Plot>> = Vec::new();
        for (index, row) in rows.iter().enumerate() {
            let plot = match plots.last() {
                Some(last) if rows[index - 1].ground == row.ground => last.clone(),
                _ => Arc::new(Plot::of(&row.ground, request.robot.radius_m)?),
            };
            plots.push(plot);
        }
        Ok(Self { request, rows, plots })
    }
}

/// What all runs of a series share.
pub struct BuildingGround {
    plot: Arc<Plot>,
    library: Arc<Library>,
    errand: Loaded,
    /// The robot as it really is.
    simulated: Arc<RobotDescription>,
}

impl BuildingGround {
    /// The building of a seed with the robot in it, and what happens there.
    fn site(&self, row: &BuildingRow, robot: &Arc<RobotDescription>, seed: u64) -> Result<(Site, Building)> {
        let building = self.plot.building(seed, robot.radius_m, row.furniture())?;
        let settings = OfficeSettings::of(robot.clone());
        if let Some(too_large) = TooLarge::of(&building.mapped, &settings, MEMORY_GIB) {
            bail!("{too_large}");
        }
        let model = OfficeModel::new(building.mapped.clone(), settings)
            .with_context(|| format!("nothing can be localized in `{}`", building.mapped.name))?
            .simulated_as(building.real.clone(), self.simulated.clone());
        let site = Site::of(self.library.clone(), Arc::new(model), own_modules().clone());
        let site = match row.disturbance.scenario(&building, robot.radius_m, seed) {
            Some(scenario) => sites::with_scenario(&site, scenario)?,
            None => site,
        };
        Ok((site, building))
    }
}

impl ExperimentKind for Buildings {
    type Ground = BuildingGround;
    type Record = BuildingTrial;
    type Tally = Vec<BuildingTrial>;

    fn series(&self) -> Vec<String> {
        self.rows.iter().map(BuildingRow::name).collect()
    }

    fn ground(&self, series: usize) -> Result<BuildingGround> {
        let row = &self.rows[series];
        let robot = &self.request.robot;
        let plot = self.plots[series].clone();
        let library = robot_library(own_modules(), Vec::new())?;
        let simulated = match row.disturbance {
            Disturbance::Slip => {
                let odometry = robot.odometry.times(SLIP);
                Arc::new(RobotDescription { odometry, ..RobotDescription::clone(robot) })
            }
            Disturbance::None
            | Disturbance::Turned
            | Disturbance::Carried
            | Disturbance::Furniture
            | Disturbance::Doors => robot.clone(),
        };
        // Any building has the places of the errand.
        let first = plot.building(self.request.first_seed, robot.radius_m, Furniture::AsMapped)?;
        let model = OfficeModel::new(first.mapped, OfficeSettings::of(robot.clone()))?;
        let site = Site::of(library.clone(), Arc::new(model), own_modules().clone());
        let errand = sites::load(&site, &plans::plan(ERRAND)?, self.request.colour)?;
        Ok(BuildingGround { plot, library, errand, simulated })
    }

    fn run(&self, series: usize, ground: &BuildingGround, run: Run) -> Result<BuildingTrial> {
        let (site, building) = ground.site(&self.rows[series], &self.request.robot, run.seed)?;
        let system = site.start_traced(ground.errand.clone(), run.seed);
        Ok(BuildingTrial::of(system, run.seed, &building.mapped.places, self.request.until_us.min(MOST_US)))
    }

    fn head(&self, _: &BuildingTrial) -> String {
        BuildingTrial::HEAD.to_string()
    }

    fn lines(&self, series: &str, _: Run, trial: &BuildingTrial) -> String {
        trial.line(series)
    }

    fn findings(&self, tallies: Vec<Vec<BuildingTrial>>, _: bool) -> Result<Findings> {
        let parameters = LocalizationParameters::of(&self.request.robot);
        let is_measured = tallies.iter().flatten().all(BuildingTrial::is_measured);
        let status = if is_measured { Status::Succeeded } else { Status::Failed };
        let tables = Tables::of(&self.rows, &tallies, &parameters);
        Ok(Findings { status, blocks: tables.blocks(), figures: tables.figures(), drawings: Vec::new() })
    }
}
