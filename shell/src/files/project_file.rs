//! `rpl.toml`: what the plans of a folder are for.

use super::foreign::why_foreign;
use super::inputs;
use crate::files::shown::Shown;
use crate::terminal::console::Console;
use anyhow::{Result, anyhow, bail};
use rpl_robot::file_text::Finding;
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

    /// The project that a command is about: one that is named by its file, or, if nothing is named, that of the working
    /// folder, which is told. None if something else is named; what was to be named, and by which command, is said if
    /// there is nothing.
    ///
    /// # Errors
    /// There is none, somebody else may have written it, it cannot be read, or it has faults.
    pub fn of(
        names: &[String],
        (command, what): (&str, &str),
        console: &mut Console,
    ) -> Result<Option<(PathBuf, Self)>> {
        let file = match names {
            [] => {
                let file = Self::of_working_folder(command, what)?;
                if !console.quiet {
                    console.note(&format!("the project is `{}`", file.shown()));
                }
                file
            }
            [name] if Path::new(name).file_name().is_some_and(|name| name == PROJECT_FILE) => name.into(),
            _ => return Ok(None),
        };
        let project = Self::read(&file)?;
        Ok(Some((file, project)))
    }

    /// The file of the working folder or above it that this user can be taken to mean.
    fn of_working_folder(command: &str, what: &str) -> Result<PathBuf> {
        let here = std::env::current_dir().map_err(|error| anyhow!("the working folder is gone: {error}"))?;
        // As if it were a file in the working folder.
        let file = Self::above(&here.join(PROJECT_FILE)).ok_or_else(|| {
            anyhow!(
                "no {what} is named, and there is no `{PROJECT_FILE}` in this folder or above it; name one, or begin a \
                 project with `rpl new NAME`"
            )
        })?;
        let file = file.strip_prefix(&here).map_or(file.clone(), Path::to_path_buf);
        let shown = file.shown();
        let why = match is_above_home(&file) {
            true => Some("it lies above the home folder".to_string()),
            false => why_foreign(&file).map_err(|error| anyhow!("cannot look at `{shown}`: {error}"))?,
        };
        match why {
            Some(why) => bail!(
                "no {what} is named, and `{shown}` may not be yours: {why}; it can start programs, so look into it, and \
                 name it then: `rpl {command} {shown}`"
            ),
            None => Ok(file),
        }
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
        let known: Self = toml::from_str(&text).map_err(|error| {
            let help = "project files are TOML, see toml.io";
            let finding = Finding::new(&name, &text, error.span().unwrap_or(0..0), "", error.message(), help);
            anyhow!("`{name}` has faults\n{finding}")
        })?;
        // A pipe would hold whoever looks at the project, such as an editor, for ever.
        let beside = |named: String| {
            let there = file.with_file_name(&named);
            match there.metadata() {
                Ok(known) if known.is_file() => Ok(there.to_string_lossy().into_owned()),
                Ok(_) => Err(anyhow!("`{}`, which `{name}` names, is no file", there.shown())),
                Err(_) => Ok(named),
            }
        };
        Ok(Self {
            plan: known.plan.map(|plan| file.with_file_name(plan).to_string_lossy().into_owned()),
            world: known.world.map(beside).transpose()?,
            robot: known.robot.map(beside).transpose()?,
            seed: known.seed,
            runs: known.runs,
            modules: known.modules.into_iter().map(beside).collect::<Result<_>>()?,
        })
    }
}

/// Whether the home folder lies below that of a file: then it is no project of one user.
fn is_above_home(file: &Path) -> bool {
    let folder = Path::new(&ProjectFile::folder_of(file)).canonicalize();
    let home = std::env::home_dir().filter(|home| home.is_absolute()).and_then(|home| home.canonicalize().ok());
    folder.ok().zip(home).is_some_and(|(folder, home)| home != folder && home.starts_with(&folder))
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
