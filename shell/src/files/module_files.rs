//! Modules in other processes, as the command line names them: by the files of their manifests.

use super::inputs;
use crate::files::shown::Shown;
use crate::terminal::console::Console;
use anyhow::{Result, anyhow, bail};
use rpl_lang::visible::{shortened, visible};
use rpl_link::process_opener::{Opener, line_name};
use rpl_link::recording::{RecordedTurns, Recorder};
use rpl_link::transcript::{Divergence, Kept, Live, Transcript};
use rpl_mission::site::Site;
use rpl_protocol::line::Line;
use rpl_protocol::module::manifest::{Manifest, Spokesman};
use rpl_protocol::module::message::{Greeting, ModuleAnswer, ModuleWords, Pace};
use rpl_protocol::module::process_modules::{ModuleSource, OpenLine};
use rpl_robot::office::PlanText;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Turns of a module that a session keeps, to go back to: an hour at 20 steps a second.
const TURNS_OF_A_SESSION: usize = 72_000;

/// The modules of a run, before it begins.
#[derive(Debug, Default)]
pub struct Modules {
    /// Those that are to be started.
    openers: Vec<Arc<Opener>>,
    /// What those of a recording have said.
    recorded: Vec<Arc<Transcript<ModuleWords, ModuleAnswer>>>,
}

/// Who speaks for modules.
#[derive(Clone, Copy, Debug)]
pub enum ModuleVoices<'r> {
    /// Their processes.
    Processes(GoingBack),
    /// A recording of them.
    Recording(&'r RecordedTurns),
}

/// Whether a run can go back, and needs to hear again what its modules have said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoingBack {
    /// Never.
    Never,
    /// At the prompt.
    Session,
}

/// A manifest, by the name that the command line has for it, and where it lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ManifestFile {
    /// Messages and texts are called by it.
    pub name: String,
    /// The file.
    pub path: PathBuf,
}

/// The modules of the manifests that the command line names.
///
/// # Errors
/// As for [`opened`].
pub fn named(names: &[String], voices: ModuleVoices<'_>) -> Result<(Modules, Vec<ModuleSource>)> {
    let manifests: Vec<ManifestFile> =
        names.iter().map(|name| ManifestFile { name: name.clone(), path: name.into() }).collect();
    opened(&manifests, voices)
}

/// The modules of some manifests.
///
/// # Errors
/// A manifest cannot be read or has faults, or the plans of one cannot be read; or the recording of one.
pub fn opened(manifests: &[ManifestFile], voices: ModuleVoices<'_>) -> Result<(Modules, Vec<ModuleSource>)> {
    let mut modules = Modules::default();
    let mut sources: Vec<ModuleSource> = Vec::new();
    for file in manifests {
        let (ManifestFile { name, path }, (manifest, plans)) = (file, read(file)?);
        if let Some(before) = sources.iter().find(|before| before.manifest.name == manifest.name) {
            let (called, first) = (&manifest.name, &before.manifest.file);
            bail!(
                "two modules are called `{called}`: `{}` and `{}`; leave one away, or rename it",
                visible(first),
                visible(name)
            );
        }
        let open = modules.open(manifest.clone(), folder_of(path), voices)?;
        let waits = manifest.pace == Pace::LockStep || matches!(voices, ModuleVoices::Recording(_));
        sources.push(ModuleSource::new(manifest, plans, open, waits));
    }
    Ok((modules, sources))
}

/// What speaks for a module within this process, for a run that is greeted so.
pub type Speaker = dyn Fn(Arc<Manifest>, Greeting) -> Box<dyn Live<ModuleWords, ModuleAnswer>> + Send + Sync;

/// A module within this process, with the manifest in a file.
///
/// # Errors
/// As for [`opened`].
pub fn within(name: &str, speaker: Arc<Speaker>) -> Result<ModuleSource> {
    let (manifest, plans) = read(&ManifestFile { name: name.to_string(), path: name.into() })?;
    let offered = manifest.clone();
    let open = Arc::new(move |greeting| -> Arc<dyn Line<ModuleWords, ModuleAnswer>> {
        let live = speaker(offered.clone(), greeting);
        Arc::new(Transcript::live(&line_name(&offered.name), live, Kept::Last, None))
    });
    let waits = manifest.pace == Pace::LockStep;
    Ok(ModuleSource::new(manifest, plans, open, waits))
}

/// A manifest, and the plans that belong to it.
fn read(ManifestFile { name, path }: &ManifestFile) -> Result<(Arc<Manifest>, Option<PlanText>)> {
    let text =
        inputs::short_text(path).map_err(|reason| anyhow!("cannot read the module `{}`: {reason}", visible(name)))?;
    let manifest =
        Manifest::parse(&text, name).map_err(|error| anyhow!("the module `{}` has faults\n{error}", visible(name)))?;
    let plans = manifest.plans.as_ref().map(|plans| plan_text(folder_of(path), plans, name)).transpose()?;
    Ok((Arc::new(manifest), plans))
}

/// The file of the plans that belong to the module of a manifest, as the manifest names it; none if there is none, or
/// the manifest has faults, which are told where it is used.
pub fn plans_of(manifest: &str) -> Option<String> {
    let text = inputs::short_text(Path::new(manifest)).ok()?;
    Manifest::parse(&text, manifest).ok()?.plans.as_ref().map(|plans| plans.to_string())
}

/// Where a manifest lies.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn plan_text(folder: &Path, plans: &str, manifest: &str) -> Result<PlanText> {
    let path = folder.join(plans);
    // The name is a part of the program, wherever the run goes on.
    let shown = folder_of(Path::new(manifest)).join(plans).to_string_lossy().into_owned();
    let text = inputs::read_text(&path)
        .map_err(|reason| anyhow!("cannot read `{shown}`, the plans of the module `{manifest}`: {reason}"))?;
    Ok(PlanText { name: shown.into(), text: text.into() })
}

impl Modules {
    /// What gives a run its line to a module.
    fn open(&mut self, manifest: Arc<Manifest>, folder: &Path, voices: ModuleVoices<'_>) -> Result<Arc<OpenLine>> {
        let going_back = match voices {
            ModuleVoices::Processes(going_back) => going_back,
            ModuleVoices::Recording(turns) => {
                let name = line_name(&manifest.name);
                let transcript = Arc::new(Transcript::recorded(&name, turns.of(&name)?));
                self.recorded.push(transcript.clone());
                return Ok(Arc::new(move |_| transcript.clone()));
            }
        };
        let kept = match going_back {
            GoingBack::Never => Kept::Last,
            GoingBack::Session => Kept::Newest(TURNS_OF_A_SESSION),
        };
        let opener = Arc::new(Opener::new(manifest, folder.to_path_buf(), kept));
        self.openers.push(opener.clone());
        Ok(Arc::new(move |greeting| opener.open(greeting)))
    }

    /// Tells what is started for them.
    pub fn tell(&self, console: &mut Console) {
        for module in &self.openers {
            let Manifest { name, spokesman, .. } = &*module.manifest;
            console.note(&match spokesman {
                Spokesman::Command(command) => {
                    let (command, folder) = (shortened(&command.join(" ")), module.folder.shown());
                    format!("the module `{name}` is started: `{command}`, in `{folder}`")
                }
                Spokesman::Address(address) => {
                    format!("the module `{name}` is connected to at `{}`", shortened(address))
                }
            });
        }
    }

    /// Starts them for the run that is about to begin at a site, with this seed.
    ///
    /// # Errors
    /// One does not start: what it did, and what it wrote to its standard error.
    pub fn start(&self, site: &Site, seed: u64, recorder: Option<&Arc<Recorder>>) -> Result<()> {
        let Some(period_us) = site.period_us() else { return Ok(()) };
        let greeting = Greeting { period_us, seed };
        for module in &self.openers {
            module.start_ahead(greeting, recorder.cloned())?;
        }
        Ok(())
    }

    /// The processes that were started go on where others were heard last.
    ///
    /// # Errors
    /// What was heard cannot be read.
    pub fn go_on(&self, past: &RecordedTurns, recorder: &Arc<Recorder>) -> Result<()> {
        for module in &self.openers {
            module.go_on(past.stretch(&line_name(&module.manifest.name))?, Some(recorder.clone()));
        }
        Ok(())
    }

    /// Where the run first wanted to say something else to one of them than was recorded, if it did.
    pub fn divergence(&self) -> Option<Divergence> {
        self.recorded.iter().filter_map(|module| module.divergence()).min_by_key(|divergence| divergence.turn)
    }
}
