//! `rpl.toml`: what the plans of a folder are for.

use super::inputs;
use crate::files::shown::Shown;
use anyhow::{Result, anyhow};
use serde::Deserialize;
use std::num::NonZero;
use std::path::{Path, PathBuf};

/// The name of the file, in the folder of the plans or above it.
pub const PROJECT_FILE: &str = "rpl.toml";

/// What it says.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProjectFile {
    /// What `rpl run` runs: a file beside this one.
    pub plan: Option<String>,
    /// The world that the robot is in: a name, or a file beside this one.
    pub world: Option<String>,
    /// The robot: a name, or a file beside this one.
    pub robot: Option<String>,
    /// The seed of runs, and the first of an experiment.
    pub seed: Option<u64>,
    /// How many runs `rpl experiment` makes.
    pub runs: Option<NonZero<u32>>,
    /// Manifests of modules in other processes.
    #[serde(default)]
    pub modules: Vec<String>,
}

impl ProjectFile {
    /// The project file that a path belongs to.
    pub fn above(path: &Path) -> Option<PathBuf> {
        path.ancestors().skip(1).map(|folder| folder.join(PROJECT_FILE)).find(|file| file.is_file())
    }

    /// The project that the working folder belongs to, for a command that was given no file; what was to be named is
    /// said if there is none.
    ///
    /// # Errors
    /// There is none, or its file cannot be read, or has faults.
    pub fn of_working_folder(what: &str) -> Result<(PathBuf, Self)> {
        let here = std::env::current_dir().map_err(|error| anyhow!("the working folder is gone: {error}"))?;
        // As if it were a file in the working folder.
        let file = Self::above(&here.join(PROJECT_FILE)).ok_or_else(|| {
            anyhow!(
                "no {what} is named, and there is no `{PROJECT_FILE}` in this folder or above it; name one, or begin a \
                 project with `rpl new NAME`"
            )
        })?;
        let file = file.strip_prefix(&here).map_or(file.clone(), Path::to_path_buf);
        let project = Self::read(&file)?;
        Ok((file, project))
    }

    /// What `rpl run` runs.
    ///
    /// # Errors
    /// The file, which is named so, does not say.
    pub fn plan_to_run(&self, file: &Path) -> Result<String> {
        self.plan.clone().ok_or_else(|| {
            anyhow!(
                "`{}` names no plan to run; add a line such as `plan = \"main.rpl\"`, or name the plan",
                file.shown()
            )
        })
    }

    /// The folder that a project file stands for.
    pub fn folder_of(file: &Path) -> String {
        match file.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_string_lossy().into_owned(),
            _ => ".".to_string(),
        }
    }

    /// Reads a project file; what it names beside it is found from anywhere then.
    ///
    /// # Errors
    /// It cannot be read, or has faults.
    pub fn read(file: &Path) -> Result<Self> {
        let name = file.shown();
        let text = inputs::read_text(file).map_err(|reason| anyhow!("cannot read `{name}`: {reason}"))?;
        let known: Self = toml::from_str(&text).map_err(|error| anyhow!("`{name}` has faults\n{error}"))?;
        let beside = |named: String| {
            let there = file.with_file_name(&named);
            if there.exists() { there.to_string_lossy().into_owned() } else { named }
        };
        Ok(Self {
            plan: known.plan.map(|plan| file.with_file_name(plan).to_string_lossy().into_owned()),
            world: known.world.map(beside),
            robot: known.robot.map(beside),
            seed: known.seed,
            runs: known.runs,
            modules: known.modules.into_iter().map(beside).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_nothing_asks_for_is_a_fault() {
        let known: ProjectFile = toml::from_str("world = \"dept\"\nmodules = [\"camera.toml\"]").expect("it is right");
        assert_eq!(known.world.as_deref(), Some("dept"));
        assert_eq!(known.modules, ["camera.toml"]);
        let error = toml::from_str::<ProjectFile>("wordl = \"dept\"").expect_err("it is misspelt");
        assert!(error.to_string().contains("unknown field `wordl`"), "{error}");
    }
}
