//! What is asked of an experiment.

use crate::experiment_file::ExperimentFile;
use anyhow::Result;
use rpl_lang::suggest::suggest;
use rpl_mission::site::{Setup, Site};
use rpl_robot::description::RobotDescription;
use rpl_robot::office::OfficeSettings;
use rpl_shell::files::outputs::OutputFolder;
use rpl_shell::files::world_files;
use std::path::PathBuf;
use std::sync::Arc;

/// What is asked of an experiment, the same whatever it is about.
#[derive(Clone, Debug)]
pub struct ExperimentRequest {
    /// The build that does it: two of the same name give the same runs.
    pub build: &'static str,
    /// An experiment with a name, or a plan.
    pub name: String,
    /// How many seeds; at least 1.
    pub runs: u32,
    /// How many runs at a time; at least 1.
    pub jobs: usize,
    /// The first seed.
    pub first_seed: u64,
    /// Another world than that of the experiment.
    pub world: Option<String>,
    /// The robot.
    pub robot: Arc<RobotDescription>,
    /// How the user has named it, if at all.
    pub robot_name: Option<String>,
    /// What an experiment file says, if `name` is one.
    pub file: Option<ExperimentFile>,
    /// Manifests of modules in other processes, for a plan of one's own.
    pub modules: Vec<String>,
    /// First values of variables of a plan of one's own, each as `NAME=EXPR`.
    pub set: Vec<String>,
    /// What variants of such a plan differ in, each as `NAME=A,B`.
    pub vary: Vec<String>,
    /// Another scenario than that of the experiment.
    pub scenario: Option<String>,
    /// The only row of the table.
    pub row: Option<String>,
    /// The folder of the recorded floor plans that take the place of drawn ones.
    pub maps: Option<PathBuf>,
    /// What the robot of each run remembers at its start of driving by cases.
    pub cases: Option<PathBuf>,
    /// The folder for every run, and for charts.
    pub results: Option<PathBuf>,
    /// Time of the plan after which a run counts as failed.
    pub until_us: u64,
    /// Whether errors of plans are told in colour.
    pub colour: bool,
}

impl ExperimentRequest {
    /// What is said of a row that the experiment does not have.
    pub fn no_row(&self, name: &str, rows: &[&str]) -> String {
        let meant =
            suggest(name, rows.iter().copied()).map_or(String::new(), |meant| format!("; did you mean `{meant}`?"));
        let stop = if meant.is_empty() { ";" } else { "" };
        let quoted = rows.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        format!("the experiment `{}` has no row `{name}`{meant}{stop} it has {quoted}", self.name)
    }

    /// The robot in its world, or in another one if none is asked for.
    ///
    /// # Errors
    /// The world cannot be read or has faults, or the robot cannot be simulated there.
    pub fn office(&self, world: &str) -> Result<Site> {
        let world = world_files::for_all_seeds(self.world.as_deref().unwrap_or(world), &self.robot)?;
        let settings = OfficeSettings::of(self.robot.clone());
        Ok(Site::new(Setup { world: Some(world), settings, ..Setup::default() })?)
    }

    /// The folder for results, if there is to be one, tried.
    ///
    /// # Errors
    /// It cannot be made or written.
    pub fn results_folder(&self) -> Result<Option<OutputFolder>> {
        self.results.as_deref().map(|path| OutputFolder::open(path, "experiment")).transpose()
    }
}
