//! What a journal says of its run: all that is needed to build the same one, the texts themselves included.

use super::changes::Change;
use crate::arguments::journal::SyncArgument;
use crate::files::inputs;
use crate::files::plans::{self, Folder, KeptLoad, PlanText};
use crate::recorded_run::RecordedRun;
use crate::sites;
use crate::version::VERSION;
use anyhow::{Context, Result, anyhow, bail};
use rpl_link::journal::frames;
use rpl_mission::site::{Setup, Site};
use rpl_robot::office::OfficeSettings;
use rpl_robot::world::World;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The file that has it.
pub const RUN: &str = "run";

const MAGIC: &[u8; 8] = b"RPLJOURN";

/// The version of the layout.
const LAYOUT: u64 = 1;

/// A longer file is none of a journal.
const MOST_BYTES: u64 = 512 << 20;

/// What the run is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JournalHead {
    /// The version of the layout.
    journal: u64,
    /// The program that wrote it, with its commit.
    build: String,
    /// What was asked for.
    pub run: RecordedRun,
    /// The plan.
    pub plan: KeptText,
    /// The scenario, if there is one.
    scenario: Option<KeptText>,
    /// What both have loaded.
    loads: Vec<KeptLoad>,
    /// The files that all of it was read from.
    files: Vec<KeptFile>,
    /// Where the trace goes.
    pub trace: Option<PathBuf>,
    /// How often it tells where the robot is.
    pub pose_every_us: Option<u64>,
    /// How fast the run goes by the clock; as fast as possible without.
    pub factor: Option<f64>,
    /// When what is written is brought to the disk.
    pub sync: SyncArgument,
    /// Whether the run stops when the journal cannot be written.
    pub must: bool,
}

/// A main text.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptText {
    /// The name in errors.
    pub name: String,
    /// The text.
    pub text: String,
    is_built_in: bool,
}

/// A file as it was.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptFile {
    /// From the root.
    path: PathBuf,
    /// CRC-32 of its bytes.
    checksum: u32,
}

/// Where the run takes place: the world with all that was read from other files, and what was set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptPlace {
    /// The world.
    pub world: World,
    /// Robot, simulator and filters.
    settings: OfficeSettings,
}

/// A journal's first file, read.
#[derive(Debug)]
pub struct KeptRun {
    /// What the run is.
    pub head: JournalHead,
    /// Where, if it has a robot.
    pub place: Option<KeptPlace>,
    /// Tells this run from others.
    pub checksum: u32,
}

/// What was asked for beside the run itself.
pub struct Writing {
    /// As the head has it.
    pub trace: Option<PathBuf>,
    /// As the head has it.
    pub pose_every_us: Option<u64>,
    /// As the head has it.
    pub factor: Option<f64>,
    /// As the head has it.
    pub sync: SyncArgument,
    /// As the head has it.
    pub must: bool,
}

impl JournalHead {
    /// All texts, by the names that errors have for them.
    pub fn texts(&self) -> impl Iterator<Item = (&str, &str)> {
        let scenario = self.scenario.iter().map(|text| (&*text.name, &*text.text));
        self.plan_texts().chain(scenario)
    }

    /// The plan, and what it and the scenario load.
    pub fn plan_texts(&self) -> impl Iterator<Item = (&str, &str)> {
        let plan = (&*self.plan.name, &*self.plan.text);
        std::iter::once(plan).chain(self.loads.iter().map(|load| (&*load.name, &*load.text)))
    }
}

impl KeptText {
    /// A plan or a scenario.
    pub fn of(text: &PlanText) -> Self {
        let is_built_in = matches!(text.folder, Folder::BuiltIn);
        Self { name: text.name.clone(), text: text.text.clone(), is_built_in }
    }
}

impl KeptFile {
    /// A file as it is now; none if it is not there.
    pub fn now(path: &Path) -> Option<Self> {
        // Pipes and devices are not what they were, and would be waited for.
        let is_file = path.metadata().is_ok_and(|known| known.is_file());
        let bytes = is_file.then(|| std::fs::read(path).ok())??;
        let path = std::path::absolute(path).ok()?;
        Some(Self { path, checksum: crc32fast::hash(&bytes) })
    }
}

impl KeptRun {
    /// The run that is about to begin at a site, of this plan.
    ///
    /// # Errors
    /// The scenario cannot be read any more.
    pub fn new(run: RecordedRun, plan: KeptText, site: &Site, world: Option<&World>, writing: Writing) -> Result<Self> {
        let scenario = run.scenario.as_ref().map(|text| plans::scenario(&text.name)).transpose()?;
        let place = world
            .zip(site.office())
            .map(|(world, office)| KeptPlace { world: world.clone(), settings: office.settings.clone() });
        let Writing { trace, pose_every_us, factor, sync, must } = writing;
        let head = JournalHead {
            journal: LAYOUT,
            build: VERSION.to_string(),
            run,
            plan,
            scenario: scenario.as_ref().map(KeptText::of),
            loads: plans::loaded(),
            files: inputs::files().iter().filter_map(|path| KeptFile::now(path)).collect(),
            trace,
            pose_every_us,
            factor,
            sync,
            must,
        };
        let mut kept = Self { head, place, checksum: 0 };
        kept.checksum = crc32fast::hash(&kept.bytes()?);
        Ok(kept)
    }

    /// As it stands in its file.
    ///
    /// # Errors
    /// A fault of its type.
    pub fn bytes(&self) -> Result<Vec<u8>> {
        let mut bytes = MAGIC.to_vec();
        frames::push(&mut bytes, &serde_json::to_vec(&self.head)?);
        frames::push(&mut bytes, &postcard::to_allocvec(&self.place)?);
        Ok(bytes)
    }

    /// The run of a journal.
    ///
    /// # Errors
    /// There is none, it was damaged, or another build wrote it.
    pub fn read(journal: &Path) -> Result<Self> {
        let shown = journal.display();
        let path = journal.join(RUN);
        if !path.exists() {
            bail!("`{shown}` is no journal: it has no file `{RUN}`; `rpl run FILE --journal {shown}` begins one");
        }
        let bytes = inputs::read_bytes(&path, MOST_BYTES)
            .map_err(|why| anyhow!("cannot read the journal `{shown}`: `{RUN}`: {why}"))?;
        let damaged = || anyhow!("the journal `{shown}` is damaged: the file `{RUN}` was changed or cut off");
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            bail!("`{shown}` is no journal: its file `{RUN}` does not begin with `RPLJOURN`");
        };
        let found = frames::read(rest);
        let [head, place] = found.whole[..] else { return Err(damaged()) };
        if found.length != rest.len() {
            return Err(damaged());
        }
        #[derive(Deserialize)]
        struct Written {
            journal: u64,
            build: String,
        }
        let written: Written = serde_json::from_slice(head).map_err(|_| damaged())?;
        if (written.journal, &*written.build) != (LAYOUT, VERSION) {
            bail!(
                "the journal `{shown}` was written by rpl {}, and this is rpl {VERSION}; only the same build goes on with it",
                written.build
            );
        }
        let head = serde_json::from_slice(head).with_context(|| format!("the journal `{shown}` cannot be read"))?;
        let place = postcard::from_bytes(place).with_context(|| format!("the journal `{shown}` cannot be read"))?;
        Ok(Self { head, place, checksum: crc32fast::hash(&bytes) })
    }

    /// The site of the run.
    ///
    /// # Errors
    /// As when it was built first.
    pub fn site(&self) -> Result<(Site, Option<World>)> {
        let JournalHead { run, scenario, .. } = &self.head;
        let world = self.place.as_ref().map(|place| place.world.clone());
        let settings = self.place.as_ref().map(|place| place.settings.clone()).unwrap_or_default();
        let setup = Setup { world: world.clone(), settings, memory_gib: run.memory_gib, natives: Vec::new() };
        let site = sites::build(setup, scenario.as_ref().map(|text| self.text(text)), Vec::new())?;
        Ok((site, world))
    }

    /// A plan or a scenario, with what it loads.
    pub fn text(&self, text: &KeptText) -> PlanText {
        self.text_with(text, |text| text)
    }

    /// The same, each text exchanged for another.
    pub fn text_with(&self, text: &KeptText, mut exchange: impl FnMut(String) -> String) -> PlanText {
        let KeptText { name, text, is_built_in } = text.clone();
        let text = exchange(text);
        let mut loads = self.head.loads.clone();
        for load in &mut loads {
            load.text = exchange(std::mem::take(&mut load.text));
        }
        let loads = loads.into();
        PlanText { name, text, folder: Folder::Kept { loads, is_built_in } }
    }

    /// Files of the run that are there, and not what they were when it last took something from them.
    pub fn changed_files(&self, changes: &[Change]) -> Vec<&Path> {
        let is_changed = |file: &&KeptFile| {
            let taken = changes.iter().rev().flat_map(|change| &change.files).find(|taken| taken.path == file.path);
            let then = taken.unwrap_or(file).checksum;
            KeptFile::now(&file.path).is_some_and(|now| now.checksum != then)
        };
        self.head.files.iter().filter(is_changed).map(|file| &*file.path).collect()
    }
}
