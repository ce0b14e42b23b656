//! What is asked of an experiment.

use crate::files::outputs::OutputFolder;
use anyhow::Result;
use rpl_lang::suggest::suggest;
use rpl_robot::description::RobotDescription;
use std::path::PathBuf;
use std::sync::Arc;

/// What is asked of an experiment, the same whatever it is about.
#[derive(Clone, Debug)]
pub struct ExperimentRequest {
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
    /// Another scenario than that of the experiment.
    pub scenario: Option<String>,
    /// The only row of the table.
    pub row: Option<String>,
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

    /// The folder for results, if there is to be one, tried.
    ///
    /// # Errors
    /// It cannot be made or written.
    pub fn results_folder(&self) -> Result<Option<OutputFolder>> {
        self.results.as_deref().map(|path| OutputFolder::open(path, "experiment")).transpose()
    }
}
