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
    /// Another scenario than that of the experiment.
    pub scenario: Option<String>,
    /// The only row of the table.
    pub row: Option<String>,
    /// The folder for every run, and for charts.
    pub results: Option<PathBuf>,
    /// Time of the plan after which a run counts as failed.
    pub until_us: u64,
}

impl ExperimentRequest {
    /// The seeds, in their order.
    pub fn seeds(&self) -> Vec<u64> {
        (0..u64::from(self.runs)).map(|run| self.first_seed.wrapping_add(run)).collect()
    }

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

    /// Writes texts, each with the name of its file, into the folder for results, if there is to be one.
    ///
    /// # Errors
    /// One of them cannot be written.
    pub fn write(&self, files: &[(String, String)]) -> Result<()> {
        let Some(mut folder) = self.results_folder()? else { return Ok(()) };
        files.iter().try_for_each(|(name, text)| match name.ends_with(".svg") {
            true => folder.draw(name, text),
            false => folder.write(name, text),
        })
    }
}
