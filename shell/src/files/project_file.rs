//! `rpl.toml`: what the plans of a folder are for.

use super::foreign::why_foreign;
use super::toml_files;
use crate::files::shown::Shown;
use crate::terminal::console::Console;
use anyhow::{Result, anyhow, bail};
use serde::Deserialize;
use std::num::NonZero;
use std::path::{Path, PathBuf};

/// The name of the file, in the folder of the plans or above it.
pub const PROJECT_FILE: &str = "rpl.toml";

/// What it says.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProjectFile {
    /// What `rpl run` runs: a file beside this one.
    pub plan: Option<String>,
    /// The world that the robot is in: a name, or a file beside this one.
    pub world: Option<String>,
    /// The robot: a name, or a file beside this one.
    pub robot: Option<String>,
    /// What happens on the way: a name, or a file beside this one.
    pub scenario: Option<String>,
    /// Further files that are scenarios.
    #[serde(default)]
    pub scenarios: Vec<String>,
    /// The seed of runs, and the first of an experiment.
    pub seed: Option<u64>,
    /// How many runs `rpl experiment` makes.
    pub runs: Option<NonZero<u32>>,
    /// Manifests of modules in other processes.
    #[serde(default)]
    pub modules: Vec<String>,
    /// First values of variables of the plan.
    #[serde(default)]
    set: toml::Table,
}

impl ProjectFile {
    /// The project file that a path belongs to.
    pub fn above(path: &Path) -> Option<PathBuf> {
        path.ancestors().skip(1).map(|folder| folder.join(PROJECT_FILE)).find(|file| file.is_file())
    }

    /// Reads a project file; what it names beside it is found from anywhere then.
    ///
    /// # Errors
    /// It cannot be read, or has faults.
    pub fn read(file: &Path) -> Result<Self> {
        let known: Self = toml_files::read(file, "project files")?;
        let beside = |named: String| toml_files::beside(file, named);
        if let Some(missing) = known.scenarios.iter().find(|named| !file.with_file_name(named).is_file()) {
            bail!("there is no scenario `{missing}`, which `{}` names", file.shown());
        }
        Ok(Self {
            plan: known.plan.map(|plan| file.with_file_name(plan).to_string_lossy().into_owned()),
            world: known.world.map(beside).transpose()?,
            robot: known.robot.map(beside).transpose()?,
            scenario: known.scenario.map(beside).transpose()?,
            scenarios: known.scenarios.into_iter().map(beside).collect::<Result<_>>()?,
            modules: known.modules.into_iter().map(beside).collect::<Result<_>>()?,
            ..known
        })
    }
}

/// A project that a command is about.
#[derive(Clone, Debug)]
pub struct Project {
    /// Its file.
    pub file: PathBuf,
    /// What it says.
    pub says: ProjectFile,
    /// Whether it was named, or nothing was: then it is about the plan that it names.
    pub is_meant: bool,
}

impl Project {
    /// The project that a command is about: one that is named by its file; if nothing is named, that of the working
    /// folder; if plans are named, that in whose folder they all lie, if there is one. It is told. What was to be named,
    /// and by which command, is said if there is nothing.
    ///
    /// # Errors
    /// Nothing is named, and there is no project, or one that somebody else may have written; it cannot be read, or has
    /// faults.
    pub fn of(names: &[String], (command, what): (&str, &str), console: &mut Console) -> Result<Option<Self>> {
        match names {
            [] => Self::told(of_working_folder(command, what)?, true, console).map(Some),
            [name] if Path::new(name).file_name().is_some_and(|name| name == PROJECT_FILE) => {
                Ok(Some(Self { file: name.into(), says: ProjectFile::read(Path::new(name))?, is_meant: true }))
            }
            _ => around(names).map_or(Ok(None), |file| Self::unless_foreign(file, console)),
        }
    }

    /// The project around the working folder, for a prompt without a file.
    ///
    /// # Errors
    /// It cannot be read, or has faults.
    pub fn around_prompt(console: &mut Console) -> Result<Option<Self>> {
        match around(&[".".to_string()]) {
            Some(file) => Self::unless_foreign(file, console),
            None => Ok(None),
        }
    }

    /// A project that nobody has named, unless somebody else may have written it, which is told.
    fn unless_foreign(file: PathBuf, console: &mut Console) -> Result<Option<Self>> {
        match why_not(&file)? {
            Some(why) => {
                console.note(&format!("`{}` is left out: {why}; to use it, name it", file.shown()));
                Ok(None)
            }
            None => Self::told(file, false, console).map(Some),
        }
    }

    fn told(file: PathBuf, is_meant: bool, console: &mut Console) -> Result<Self> {
        if !console.quiet {
            console.note(&format!("the project is `{}`", file.shown()));
        }
        let says = ProjectFile::read(&file)?;
        Ok(Self { file, says, is_meant })
    }

    /// The plan that is to be run: the one that was named, or else that of the project.
    ///
    /// # Errors
    /// The project was meant, and does not say.
    pub fn plan_or(&self, named: Option<String>) -> Result<String> {
        match named.filter(|_| !self.is_meant) {
            Some(named) => Ok(named),
            None => self.says.plan.clone().ok_or_else(|| {
                anyhow!(
                    "`{}` names no plan to run; add a line such as `plan = \"main.rpl\"`, or name the plan",
                    self.file.shown()
                )
            }),
        }
    }

    /// The first values of variables of a plan, each as `NAME=EXPR`: those of the project if the plan is its own, but
    /// for those that are given, and those.
    pub fn first_values(&self, plan: &str, given: &[String]) -> Vec<String> {
        let same = |one: &Path, other: &Path| {
            one.canonicalize().ok().is_some_and(|one| other.canonicalize().ok() == Some(one))
        };
        let is_own = self.says.plan.as_ref().is_some_and(|own| same(Path::new(own), Path::new(plan)));
        let is_given =
            |name: &str| given.iter().any(|given| given.split_once('=').is_some_and(|(known, _)| known.trim() == name));
        let own = self.says.set.iter().filter(|(name, _)| is_own && !is_given(name));
        own.map(|(name, value)| toml_files::first_value(name, value)).chain(given.iter().cloned()).collect()
    }

    /// The folder that the project file stands for.
    pub fn folder(&self) -> String {
        folder_of(&self.file)
    }
}

fn folder_of(file: &Path) -> String {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_string_lossy().into_owned(),
        _ => ".".to_string(),
    }
}

/// A path as it is seen from the working folder.
fn from_here(path: PathBuf) -> PathBuf {
    let here = std::env::current_dir().ok();
    here.and_then(|here| path.strip_prefix(here).ok().map(Path::to_path_buf)).unwrap_or(path)
}

/// The project file in or above the folder of each of some files and folders; none if they have not all the same one.
fn around(names: &[String]) -> Option<PathBuf> {
    let of = |name: &String| {
        let path = std::path::absolute(name).ok().filter(|path| path.exists())?;
        // A folder has its project within itself.
        ProjectFile::above(&if path.is_dir() { path.join(PROJECT_FILE) } else { path })
    };
    let first = of(names.first()?)?;
    names[1..].iter().all(|name| of(name).as_ref() == Some(&first)).then(|| from_here(first))
}

/// The file of the working folder or above it that this user can be taken to mean.
fn of_working_folder(command: &str, what: &str) -> Result<PathBuf> {
    let here = std::env::current_dir().map_err(|error| anyhow!("the working folder is gone: {error}"))?;
    // As if it were a file in the working folder.
    let file = ProjectFile::above(&here.join(PROJECT_FILE)).ok_or_else(|| {
        anyhow!(
            "no {what} is named, and there is no `{PROJECT_FILE}` in this folder or above it; name one, or begin a \
             project with `rpl new NAME`"
        )
    })?;
    let file = from_here(file);
    match why_not(&file)? {
        Some(why) => {
            let shown = file.shown();
            bail!(
                "no {what} is named, and `{shown}` may not be yours: {why}; it can start programs, so look into it, and \
                 name it then: `rpl {command} {shown}`"
            )
        }
        None => Ok(file),
    }
}

/// Why a project file that nobody has named may be somebody else's, if anything speaks for that.
fn why_not(file: &Path) -> Result<Option<String>> {
    if is_above_home(file) {
        return Ok(Some("it lies above the home folder".to_string()));
    }
    why_foreign(file).map_err(|error| anyhow!("cannot look at `{}`: {error}", file.shown()))
}

/// Whether the home folder lies below that of a file: then it is no project of one user.
fn is_above_home(file: &Path) -> bool {
    let folder = Path::new(&folder_of(file)).canonicalize();
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
