//! What the runs of a part are runs of. Parts make one table only if it is the same.

use crate::request::ExperimentRequest;
use anyhow::{Result, anyhow};
use rpl_shell::files::inputs;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The form of parts; another one cannot be read.
pub const FORM: u32 = 1;

/// What the runs of a part are runs of: the first line of the part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// The form of the file.
    pub rpl_part: u32,
    /// The build that made the runs.
    pub build: String,
    /// An experiment with a name, or a plan.
    pub experiment: String,
    /// How many runs the whole experiment has.
    pub runs: u32,
    /// The seed of its first run.
    pub first_seed: u64,
    /// Time of the plan after which a run counts as failed.
    pub until_us: u64,
    /// `--world`
    pub world: Option<String>,
    /// `--robot`
    pub robot: Option<String>,
    /// `--scenario`
    pub scenario: Option<String>,
    /// `--module`
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub modules: Vec<String>,
    /// `--set`
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<String>,
    /// `--vary`
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub vary: Vec<String>,
    /// `--row`
    pub row: Option<String>,
    /// `--maps`
    pub maps: Option<PathBuf>,
    /// `--cases`
    pub cases: Option<PathBuf>,
    /// How many shards there are, if all runs here are of shards of that many.
    pub shards: Option<u32>,
}

impl Identity {
    /// Of what is asked for.
    pub fn of(request: &ExperimentRequest, shards: Option<u32>) -> Self {
        Self {
            rpl_part: FORM,
            build: request.build.to_string(),
            experiment: request.name.clone(),
            runs: request.runs,
            first_seed: request.first_seed,
            until_us: request.until_us,
            world: request.world.clone(),
            robot: request.robot_name.clone(),
            scenario: request.scenario.clone(),
            modules: request.modules.clone(),
            set: request.set.clone(),
            vary: request.vary.clone(),
            row: request.row.clone(),
            maps: request.maps.clone(),
            cases: request.cases.clone(),
            shards,
        }
    }

    /// What keeps a part from making one table with another one, if anything; `name` and `other_name` are their files.
    pub fn unlike(&self, name: &str, other: &Self, other_name: &str) -> Option<String> {
        let told = |what: &Option<String>| what.as_ref().map_or("none".to_string(), |what| format!("`{what}`"));
        let quoted = |what: &str| format!("`{what}`");
        let pairs = [
            ("build", quoted(&self.build), quoted(&other.build)),
            ("plan or experiment", quoted(&self.experiment), quoted(&other.experiment)),
            ("number of runs", self.runs.to_string(), other.runs.to_string()),
            ("first seed", self.first_seed.to_string(), other.first_seed.to_string()),
            ("limit of time", seconds(self.until_us), seconds(other.until_us)),
            ("world", told(&self.world), told(&other.world)),
            ("robot", told(&self.robot), told(&other.robot)),
            ("scenario", told(&self.scenario), told(&other.scenario)),
            ("set of modules", quoted(&self.modules.join(" ")), quoted(&other.modules.join(" "))),
            ("first value", quoted(&self.set.join(" ")), quoted(&other.set.join(" "))),
            ("set of variants", quoted(&self.vary.join(" ")), quoted(&other.vary.join(" "))),
            ("row", told(&self.row), told(&other.row)),
            ("folder of maps", told(&shown(&self.maps)), told(&shown(&other.maps))),
            ("case file", told(&shown(&self.cases)), told(&shown(&other.cases))),
        ];
        let (what, mine, others) = pairs.into_iter().find(|(_, mine, others)| mine != others)?;
        Some(format!(
            "`{name}` and `{other_name}` are no parts of one experiment: they have another {what}, {mine} and {others}"
        ))
    }

    /// What a file is to these runs.
    pub fn role(&self, file: &str) -> &'static str {
        let is = |named: &Option<String>| named.as_deref().is_some_and(|named| file_name(named) == file);
        match () {
            () if file_name(&self.experiment) == file => "plan",
            () if is(&self.world) => "world",
            () if is(&self.scenario) => "scenario",
            () if is(&self.robot) => "robot",
            () if is(&shown(&self.cases)) => "case file",
            () => "file",
        }
    }
}

fn shown(path: &Option<PathBuf>) -> Option<String> {
    path.as_ref().map(|path| path.to_string_lossy().into_owned())
}

fn seconds(time_us: u64) -> String {
    format!("{} s", time_us as f64 / 1e6)
}

/// A file that was read for some runs: another machine may have it in another folder.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Its name, without folders.
    pub file: String,
    /// The checksum of what is in it (CRC-32).
    pub crc32: u32,
}

impl Input {
    /// The files this process has read so far.
    ///
    /// # Errors
    /// One of them cannot be read any more.
    pub fn read_so_far() -> Result<Vec<Self>> {
        let mut all = Vec::new();
        for path in inputs::files() {
            let shown = path.to_string_lossy().into_owned();
            let bytes = inputs::read_bytes(&path, u64::MAX - 1)
                .map_err(|reason| anyhow!("cannot read `{shown}` again, to tell it apart from others: {reason}"))?;
            all.push(Self { file: file_name(&shown), crc32: crc32fast::hash(&bytes) });
        }
        all.sort();
        all.dedup();
        Ok(all)
    }
}

fn file_name(path: &str) -> String {
    Path::new(path).file_name().map_or(path.into(), |name| name.to_string_lossy()).into_owned()
}
