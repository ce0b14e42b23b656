//! Experiment files: variants of a mission, in TOML.

use anyhow::{Result, anyhow};
use rpl_shell::arguments::duration::parse_duration_us;
use rpl_shell::files::project_file::ProjectFile;
use rpl_shell::files::shown::Shown;
use rpl_shell::files::toml_files::{self, beside, first_value};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::num::NonZero;
use std::path::{Path, PathBuf};

/// An experiment of one's own, as a file says it. What it says outside of its variants holds for all that say nothing
/// else.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExperimentFile {
    /// Where it is.
    #[serde(skip)]
    path: PathBuf,
    /// How many seeds.
    pub runs: Option<NonZero<u32>>,
    /// The first seed.
    pub seed: Option<u64>,
    /// A run that takes longer counts as failed, such as `30min`.
    until: Option<String>,
    plan: Option<String>,
    world: Option<String>,
    robot: Option<String>,
    scenario: Option<String>,
    /// Manifests of modules in other processes.
    #[serde(default)]
    modules: Vec<String>,
    /// First values of variables of the plan.
    #[serde(default)]
    set: BTreeMap<String, toml::Value>,
    /// The variants; the others are compared with the first.
    #[serde(default)]
    variant: Vec<Entry>,
}

/// A variant, as a file says it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    plan: Option<String>,
    world: Option<String>,
    robot: Option<String>,
    scenario: Option<String>,
    #[serde(default)]
    modules: Vec<String>,
    #[serde(default)]
    set: BTreeMap<String, toml::Value>,
}

/// A variant of a file, with what it shares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileVariant {
    /// What its row is called.
    pub name: String,
    /// The plan.
    pub plan: String,
    /// Where.
    pub world: Option<String>,
    /// The robot.
    pub robot: Option<String>,
    /// What happens on the way.
    pub scenario: Option<String>,
    /// Manifests of modules in other processes.
    pub modules: Vec<String>,
    /// `NAME=EXPR`
    pub set: Vec<String>,
}

impl ExperimentFile {
    /// Whether a name is that of such a file.
    pub fn is_named(name: &str) -> bool {
        Path::new(name).extension().is_some_and(|extension| extension == "toml")
    }

    /// Reads one.
    ///
    /// # Errors
    /// It cannot be read, or has faults.
    pub fn read(path: &Path) -> Result<Self> {
        let file: Self = toml_files::read(path, "experiment files")?;
        Ok(Self { path: path.to_path_buf(), ..file })
    }

    /// Takes from a project what is not said here. What a project names is found from anywhere.
    pub fn in_project(&mut self, project: &ProjectFile) {
        let absolute = |named: &String| match std::path::absolute(named) {
            Ok(path) if path.exists() => path.to_string_lossy().into_owned(),
            _ => named.clone(),
        };
        let or = |mine: &mut Option<String>, its: &Option<String>| {
            *mine = mine.take().or_else(|| its.as_ref().map(absolute))
        };
        or(&mut self.plan, &project.plan);
        or(&mut self.world, &project.world);
        or(&mut self.robot, &project.robot);
        or(&mut self.scenario, &project.scenario);
        if self.modules.is_empty() {
            self.modules = project.modules.iter().map(absolute).collect();
        }
        self.seed = self.seed.or(project.seed);
        self.runs = self.runs.or(project.runs);
    }

    /// After what time of the plan a run counts as failed, in microseconds.
    ///
    /// # Errors
    /// What it says is no time.
    pub fn until_us(&self) -> Result<Option<u64>> {
        let read = |text: &String| parse_duration_us(text).map_err(|why| self.fault("until", text, &why));
        self.until.as_ref().map(read).transpose()
    }

    fn fault(&self, key: &str, text: &str, why: &str) -> anyhow::Error {
        anyhow!("`{}` has faults\n{key} = \"{text}\": {why}", self.path.shown())
    }

    /// The variants; where there are none, the one that is said outside of them.
    ///
    /// # Errors
    /// A variant has no plan, or what a file names beside itself is no file.
    pub fn variants(&self) -> Result<Vec<FileVariant>> {
        let alone = [Entry { name: self.plan.clone().unwrap_or_default(), ..Entry::default() }];
        let entries = if self.variant.is_empty() { &alone[..] } else { &self.variant };
        entries.iter().map(|entry| self.whole(entry)).collect()
    }

    /// A variant with what all share.
    fn whole(&self, entry: &Entry) -> Result<FileVariant> {
        let or = |own: &Option<String>, shared: &Option<String>| {
            own.clone().or_else(|| shared.clone()).map(|named| beside(&self.path, named)).transpose()
        };
        let plan = or(&entry.plan, &self.plan)?.ok_or_else(|| {
            let (file, name) = (self.path.shown(), &entry.name);
            anyhow!("`{file}` names no plan for the variant `{name}`; add a line such as `plan = \"main.rpl\"`")
        })?;
        let set: BTreeMap<&String, &toml::Value> = self.set.iter().chain(&entry.set).collect();
        let modules = if entry.modules.is_empty() { &self.modules } else { &entry.modules };
        Ok(FileVariant {
            name: entry.name.clone(),
            plan,
            world: or(&entry.world, &self.world)?,
            robot: or(&entry.robot, &self.robot)?,
            scenario: or(&entry.scenario, &self.scenario)?,
            modules: modules.iter().map(|named| beside(&self.path, named.clone())).collect::<Result<_>>()?,
            set: set.into_iter().map(|(name, value)| first_value(name, value)).collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> ExperimentFile {
        toml::from_str(text).expect("it is right")
    }

    #[test]
    fn a_variant_has_what_all_share_and_what_it_says_itself() {
        let text = "plan = \"a.rpl\"\nworld = \"dept\"\nset = { speed = 0.3, far = true }\n\
                    [[variant]]\nname = \"slow\"\nset = { speed = \"(/ 1 5)\" }\n\
                    [[variant]]\nname = \"b\"\nplan = \"b.rpl\"\nworld = \"lab\"";
        let variants = file(text).variants().expect("two");
        let texts = |set: &[&str]| set.iter().map(|text| (*text).to_string()).collect::<Vec<_>>();
        assert_eq!(variants[0].set, texts(&["far=t", "speed=(/ 1 5)"]));
        assert_eq!(variants[0].world.as_deref(), Some("dept"));
        let b = &variants[1];
        assert_eq!(
            (b.plan.as_str(), b.world.as_deref(), &b.set),
            ("b.rpl", Some("lab"), &texts(&["far=t", "speed=0.3"]))
        );
    }

    #[test]
    fn a_file_without_a_plan_says_what_to_add() {
        let error = file("[[variant]]\nname = \"a\"").variants().expect_err("no plan").to_string();
        assert!(error.contains("names no plan for the variant `a`; add a line such as `plan ="), "{error}");
        assert!(file("until = \"soon\"").until_us().is_err());
    }
}
