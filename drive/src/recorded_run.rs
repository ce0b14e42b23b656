//! What a recording says of its run: all that is needed to build the same one.

use crate::trace::{self, Header};
use anyhow::{Result, anyhow, bail};
use clap::ValueEnum;
use rpl_robot::description::RobotDescription;
use rpl_robot::world::World;
use rpl_shell::arguments::site::{GridArgument, MapArgument, SiteArguments};
use rpl_shell::files::plans::PlanText;
use rpl_shell::files::{inputs, robot_files, world_files};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The first line of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedRun {
    /// The version of the program.
    pub rpl: String,
    /// What it was.
    pub kind: RunKind,
    /// The plan; a session may have none.
    pub plan: Option<RecordedText>,
    /// Other first values for variables of the plan.
    pub set: Vec<String>,
    /// The world, if there is one.
    pub world: Option<RecordedText>,
    /// The robot, if there is a world; without a name if the command line named none.
    pub robot: Option<RecordedText>,
    /// What the robot knows of it, and how finely it believes.
    pub map: String,
    /// As `--grid`.
    pub grid: String,
    /// As `--memory`.
    pub memory_gib: f64,
    /// The scenario, if there is one.
    pub scenario: Option<RecordedText>,
    /// The manifests of its modules.
    pub modules: Vec<RecordedText>,
    /// Of every random stream.
    pub seed: u64,
    /// As `--until`.
    pub until_us: Option<u64>,
    /// As `--max-steps`.
    pub max_steps: Option<u32>,
    /// The host in another process, if there was one.
    pub host: Option<HostHeard>,
}

/// What was recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RunKind {
    /// A plan from its start to its end.
    Run,
    /// The prompt.
    Session,
    /// The prompt, its plan stopped before the first form.
    Step,
}

/// A text by its name, and what shows that it is still the same.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedText {
    /// As the command line named it.
    pub name: String,
    /// CRC-32 of its bytes; of a world, of what was read from it.
    pub checksum: u32,
}

/// A host that was heard.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HostHeard {
    /// Where it was.
    pub address: String,
    /// Whether the robot stood where the world says it starts.
    pub start_known: bool,
}

/// Whether a text is the recorded one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sameness {
    /// It is.
    Same,
    /// It has changed since.
    Changed,
}

impl RecordedText {
    /// A plan or a scenario.
    pub fn of(name: &str, text: &PlanText) -> Self {
        Self { name: name.to_string(), checksum: crc32fast::hash(text.text.as_bytes()) }
    }

    /// A manifest of a module.
    fn of_file(name: &str) -> Result<Self> {
        let text =
            inputs::short_text(Path::new(name)).map_err(|why| anyhow!("cannot read the module `{name}`: {why}"))?;
        Ok(Self { name: name.to_string(), checksum: crc32fast::hash(text.as_bytes()) })
    }

    /// A world, with all that was read from other files.
    pub(crate) fn of_world(name: &str, world: &World) -> Self {
        // Whatever makes two worlds different is written here.
        let bytes = serde_json::to_vec(world).unwrap_or_default();
        Self { name: name.to_string(), checksum: crc32fast::hash(&bytes) }
    }

    /// A robot.
    pub(crate) fn of_robot(name: &str, robot: &RobotDescription) -> Self {
        let bytes = serde_json::to_vec(robot).unwrap_or_default();
        Self { name: name.to_string(), checksum: crc32fast::hash(&bytes) }
    }

    /// Whether this is the recorded text.
    pub fn compare(&self, now: &RecordedText) -> Sameness {
        if self.checksum == now.checksum { Sameness::Same } else { Sameness::Changed }
    }
}

impl RecordedRun {
    /// A run at a site, before its plan is known.
    pub fn at(site: &SiteArguments, world: Option<&World>) -> Result<Self> {
        let scenario = site.scenario.as_deref().map(|name| -> Result<RecordedText> {
            Ok(RecordedText::of(name, &rpl_shell::files::plans::scenario(name)?))
        });
        let robot = robot_files::named(site.robot.as_deref())?;
        Ok(Self {
            rpl: env!("CARGO_PKG_VERSION").to_string(),
            kind: RunKind::Run,
            plan: None,
            set: Vec::new(),
            world: site.world.as_deref().zip(world).map(|(name, world)| RecordedText::of_world(name, world)),
            robot: world.map(|_| RecordedText::of_robot(site.robot.as_deref().unwrap_or_default(), &robot)),
            map: site.map().name().to_string(),
            grid: value_name(site.grid()),
            memory_gib: site.memory_gib(),
            scenario: scenario.transpose()?,
            modules: site.module.iter().map(|name| RecordedText::of_file(name)).collect::<Result<_>>()?,
            seed: site.seed(),
            until_us: None,
            max_steps: None,
            host: None,
        })
    }

    /// The first line of its trace.
    pub fn trace_header(&self) -> Header {
        let name = |text: &Option<RecordedText>| text.as_ref().map(|text| text.name.clone());
        Header {
            version: trace::VERSION,
            rpl: Some(self.rpl.clone()),
            plan: name(&self.plan).unwrap_or_default(),
            world: name(&self.world),
            robot: name(&self.robot).filter(|name| !name.is_empty() && name != RobotDescription::PAPERS),
            map: self.world.is_some().then(|| self.map.clone()),
            scenario: name(&self.scenario),
            seed: self.seed,
        }
    }

    /// The arguments that lead to the same site.
    ///
    /// # Errors
    /// The world, the robot or the scenario has changed since: nothing could be repeated.
    pub fn site(&self) -> Result<SiteArguments> {
        let parsed =
            |what: &str, name: &str| format!("the recording has the {what} `{name}`, which this rpl does not know");
        let has_world = self.world.is_some();
        let site = SiteArguments {
            world: self.world.as_ref().map(|world| world.name.clone()),
            robot: self.robot.as_ref().map(|robot| robot.name.clone()).filter(|name| !name.is_empty()),
            map: has_world
                .then(|| MapArgument::from_str(&self.map, false))
                .transpose()
                .map_err(|_| anyhow!(parsed("map", &self.map)))?,
            grid: has_world
                .then(|| GridArgument::from_str(&self.grid, false))
                .transpose()
                .map_err(|_| anyhow!(parsed("grid", &self.grid)))?,
            memory: has_world.then_some(self.memory_gib),
            seed: Some(self.seed),
            scenario: self.scenario.as_ref().map(|scenario| scenario.name.clone()),
            module: self.modules.iter().map(|module| module.name.clone()).collect(),
            tells_modules: false,
        };
        let robot = robot_files::named(site.robot.as_deref())?;
        let world = site.world.as_deref().map(|name| world_files::named(name, &robot, self.seed)).transpose()?;
        let now = Self::at(&site, world.as_ref())?;
        let texts = [
            ("world", &self.world, &now.world),
            ("robot", &self.robot, &now.robot),
            ("scenario", &self.scenario, &now.scenario),
        ];
        let modules = self.modules.iter().zip(&now.modules).map(|(then, now)| ("module", Some(then), Some(now)));
        let texts = texts.into_iter().map(|(what, then, now)| (what, then.as_ref(), now.as_ref()));
        for (what, then, now) in texts.chain(modules) {
            if let (Some(then), Some(now)) = (then, now)
                && then.compare(now) == Sameness::Changed
            {
                bail!("the {what} `{}` is not what it was when the run was recorded; put the old one back", then.name);
            }
        }
        Ok(site)
    }
}

fn value_name(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or(String::new(), |value| value.get_name().to_string())
}
