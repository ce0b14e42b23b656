//! What a journal says of its run: all that is needed to build the same one, the texts themselves included.

use super::kept_file::KeptFile;
use crate::recorded_run::{RecordedRun, RunKind};
use anyhow::{Context, Result, anyhow, bail};
use rpl_link::journal::{frames, own_file};
use rpl_mission::site::{Setup, Site};
use rpl_robot::office::OfficeSettings;
use rpl_robot::world::World;
use rpl_shell::arguments::journal::SyncArgument;
use rpl_shell::files::inputs;
use rpl_shell::files::module_files::{self, ManifestFile, ModuleVoices, Modules};
use rpl_shell::files::plans::{self, Folder, KeptLoad, PlanText};
use rpl_shell::files::shown::Shown;
use rpl_shell::sites;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};

/// The file that has it.
pub const RUN: &str = "run";

const MAGIC: &[u8; 8] = b"RPLJOURN";

/// The version of the layout.
const LAYOUT: u64 = 1;

/// What the run is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JournalHead {
    /// The version of the layout.
    journal: u64,
    /// The program that wrote it, with its sources.
    build: String,
    /// What was asked for.
    pub run: RecordedRun,
    /// The plan; a session may have none.
    pub plan: Option<KeptText>,
    /// The scenario, if there is one.
    scenario: Option<KeptText>,
    /// What both have loaded.
    pub loads: Vec<KeptLoad>,
    /// The files that all of it was read from.
    pub files: Vec<KeptFile>,
    /// The manifests of its modules, from the root.
    pub modules: Vec<PathBuf>,
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

/// Where the run takes place: the world with all that was read from other files, and what was set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptPlace {
    /// The world.
    pub world: World,
    /// Robot, simulator and filters.
    pub settings: OfficeSettings,
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
#[derive(Default)]
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
    /// Whether something of the run is in other processes.
    pub fn has_outside(&self) -> bool {
        self.run.host.is_some() || !self.modules.is_empty()
    }

    /// All texts, by the names that errors have for them.
    pub fn texts(&self) -> impl Iterator<Item = (&str, &str)> {
        let scenario = self.scenario.iter().map(|text| (&*text.name, &*text.text));
        self.plan_texts().chain(scenario)
    }

    /// The plan, and what it and the scenario load.
    pub fn plan_texts(&self) -> impl Iterator<Item = (&str, &str)> {
        let plan = self.plan.iter().map(|plan| (&*plan.name, &*plan.text));
        plan.chain(self.loads.iter().map(|load| (&*load.name, &*load.text)))
    }
}

impl KeptText {
    /// A plan or a scenario.
    pub fn of(text: &PlanText) -> Self {
        let is_built_in = matches!(text.folder, Folder::BuiltIn);
        Self { name: text.name.clone(), text: text.text.clone(), is_built_in }
    }
}

impl KeptRun {
    /// The run that is about to begin at a site, of this plan.
    ///
    /// # Errors
    /// The scenario cannot be read any more.
    pub fn new(
        build: &str,
        run: RecordedRun,
        plan: Option<KeptText>,
        site: &Site,
        world: Option<&World>,
        writing: Writing,
    ) -> Result<Self> {
        let scenario = run.scenario.as_ref().map(|text| plans::scenario(&text.name)).transpose()?;
        let place = world
            .zip(site.office())
            .map(|(world, office)| KeptPlace { world: world.clone(), settings: office.settings.clone() });
        let modules = run.modules.iter().map(|module| std::path::absolute(&module.name));
        let modules = modules.collect::<Result<_, _>>().context("the working folder is gone")?;
        let Writing { trace, pose_every_us, factor, sync, must } = writing;
        let head = JournalHead {
            journal: LAYOUT,
            build: build.to_string(),
            run,
            plan,
            scenario: scenario.as_ref().map(KeptText::of),
            loads: plans::loaded_after(0),
            modules,
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

    /// Whether it is a session at the prompt.
    pub fn is_session(&self) -> bool {
        self.head.run.kind != RunKind::Run
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
    pub fn read(journal: &Path, build: &str) -> Result<Self> {
        let shown = journal.shown();
        let path = journal.join(RUN);
        let bytes = own_file::read(&path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => {
                anyhow!("`{shown}` is no journal: it has no file `{RUN}`; `rpl run FILE --journal {shown}` begins one")
            }
            _ => anyhow!("cannot read the journal `{shown}`: `{RUN}`: {}", inputs::reason(&error)),
        })?;
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
        if (written.journal, &*written.build) != (LAYOUT, build) {
            bail!(
                "the journal `{shown}` was written by rpl {}, and this is rpl {build}; only a build of the same sources goes on with it",
                written.build
            );
        }
        let head = serde_json::from_slice(head).with_context(|| format!("the journal `{shown}` cannot be read"))?;
        let place = postcard::from_bytes(place).with_context(|| format!("the journal `{shown}` cannot be read"))?;
        Ok(Self { head, place, checksum: crc32fast::hash(&bytes) })
    }

    /// The site of the run, and the modules in other processes that it had, which these voices speak for.
    ///
    /// # Errors
    /// As when it was built first; or a module has changed.
    pub fn site(&self, voices: ModuleVoices<'_>) -> Result<(Site, Option<World>, Modules)> {
        let JournalHead { run, scenario, .. } = &self.head;
        let world = self.place.as_ref().map(|place| place.world.clone());
        let settings = self.place.as_ref().map(|place| place.settings.clone()).unwrap_or_default();
        let names = run.modules.iter().map(|module| module.name.clone());
        let manifests = names.zip(self.head.modules.clone()).map(|(name, path)| ManifestFile { name, path });
        let (modules, sources) = module_files::opened(&manifests.collect::<Vec<_>>(), voices)?;
        let setup = Setup { world: world.clone(), settings, memory_gib: run.memory_gib, ..Setup::default() };
        let site = sites::build(setup, scenario.as_ref().map(|text| self.text(text)), sources)?;
        Ok((site, world, modules))
    }

    /// A plan or a scenario, with what it loads.
    pub fn text(&self, text: &KeptText) -> PlanText {
        self.text_with(text, |text| text)
    }

    /// The plan of a session, whose loads are kept elsewhere.
    pub fn text_loading(&self, text: &KeptText, loads: Vec<KeptLoad>) -> PlanText {
        let KeptText { name, text, is_built_in } = text.clone();
        PlanText { name, text, folder: Folder::kept(loads, is_built_in) }
    }

    /// The same, each text exchanged for another.
    pub fn text_with(&self, text: &KeptText, mut exchange: impl FnMut(String) -> String) -> PlanText {
        let KeptText { name, text, is_built_in } = text.clone();
        let text = exchange(text);
        let mut loads = self.head.loads.clone();
        loads.iter_mut().for_each(|load| load.text = exchange(std::mem::take(&mut load.text)));
        PlanText { name, text, folder: Folder::kept(loads, is_built_in) }
    }
}
