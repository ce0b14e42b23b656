//! `rpl lsp`: the language server, over standard input and output.

mod library_files;
mod project_plans;

use anyhow::{Context, Result};
use library_files::LibraryFiles;
use project_plans::ProjectPlans;
use rpl_editor::lsp::{Ending, serve};
use rpl_editor::surroundings::{Setting, Surroundings, Version};
use rpl_lang::check::KnownPlaces;
use rpl_lang::compile::{Loader, NoFiles};
use rpl_mission::reference::Reference;
use rpl_mission::site::Site;
use rpl_protocol::module::process_modules::ModuleSource;
use rpl_shell::arguments::plan_files;
use rpl_shell::files::inputs::read_text;
use rpl_shell::files::module_files::{self, GoingBack, ManifestFile, ModuleVoices};
use rpl_shell::files::plans::OnDisk;
use rpl_shell::files::project_file::ProjectFile;
use rpl_shell::files::roles::Role;
use rpl_shell::files::{robot_files, world_files};
use rpl_shell::status::Status;
use rpl_shell::terminal::console;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The world whose places are offered where nothing says which is meant.
const USUAL_WORLD: &str = "dept";

/// Folders and plans below an open folder that are looked at: somebody may have opened all that is theirs.
const MOST_FOLDERS: usize = 20_000;
const MOST_PLANS: usize = 20_000;

/// Run the language server for editors: findings, documentation, names, formatting
///
/// It uses the Language Server Protocol over standard input and output; editors start it. The exit status is 0 after
/// `shutdown` and `exit`, and 1 otherwise.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// For editors that say how they speak: the only way there is
    #[arg(long, hide = true)]
    stdio: bool,
}

/// Serves until the editor says `exit` or is gone.
///
/// # Errors
/// None: what goes wrong is told to the editor, and if that cannot be, on standard error.
pub fn run(_: &Arguments) -> Result<Status> {
    let why = match serve(&Files::default(), BufReader::new(io::stdin()), io::stdout().lock()) {
        Ok(Ending::ShutDown) => return Ok(Status::Succeeded),
        Ok(Ending::ToldToExit) => "the editor said `exit` without `shutdown`".to_string(),
        Ok(Ending::Abandoned) => "the editor is gone without having said `shutdown` and `exit`".to_string(),
        Err(error) => format!("what the editor says and hears has broken off: {error}"),
    };
    console::note(&format!("error: {why}"));
    Ok(Status::Failed)
}

/// The files around the texts of an editor.
#[derive(Default)]
struct Files {
    /// What the texts of each project are looked at with, by its file and what they are for.
    settings: RefCell<BTreeMap<SettingKey, Arc<Setting>>>,
    /// The plans of each project, by its file.
    projects: RefCell<BTreeMap<PathBuf, ProjectPlans>>,
    library: LibraryFiles,
}

/// The project of a text, and what the text is for.
type SettingKey = (Option<PathBuf>, Role);

impl Files {
    /// The purpose of a text of a project, as the project and its other texts say it.
    fn role(&self, project: &Path, path: &Path) -> Role {
        let mut projects = self.projects.borrow_mut();
        projects.entry(project.to_path_buf()).or_insert_with(|| ProjectPlans::of(project)).role(path)
    }
}

impl Surroundings for Files {
    fn setting(&self, path: &Path) -> Result<Arc<Setting>, String> {
        let file = ProjectFile::above(path);
        let role = file.as_deref().map_or(Role::Plan, |file| self.role(file, path));
        let of = (file, role);
        if let Some(known) = self.settings.borrow().get(&of) {
            return Ok(known.clone());
        }
        let setting = setting_of(of.0.as_deref(), &of.1).map_err(|error| format!("{error:#}"))?;
        let setting = Arc::new(setting);
        self.settings.borrow_mut().insert(of, setting.clone());
        Ok(setting)
    }

    fn loader(&self, path: &Path) -> Box<dyn Loader> {
        match path.parent() {
            Some(folder) => Box::new(OnDisk(folder.to_path_buf())),
            None => Box::new(NoFiles),
        }
    }

    fn places(&self, path: &Path, world: Option<&str>) -> Option<KnownPlaces> {
        let beside = world.map(|world| path.with_file_name(world)).filter(|file| file.is_file());
        let named = beside.map(|file| file.to_string_lossy().into_owned());
        places_of(named.as_deref().or(world).unwrap_or(USUAL_WORLD), None).ok()
    }

    fn library_file(&self, name: &str, text: &str) -> Option<PathBuf> {
        self.library.file(name, text)
    }

    fn is_library_file(&self, path: &Path) -> bool {
        self.library.has(path)
    }

    fn plans_below(&self, folder: &Path) -> Vec<(PathBuf, Version)> {
        let version = |path: &Path| path.metadata().ok().map(|known| (known.modified().ok(), known.len()));
        let plans = plan_files::nearest(folder, MOST_FOLDERS, MOST_PLANS).into_iter();
        plans.filter_map(|path| Some((version(&path)?, path))).map(|(version, path)| (path, version)).collect()
    }

    fn text(&self, path: &Path) -> Option<String> {
        read_text(path).ok()
    }

    fn files_changed(&self, files: &[PathBuf]) -> bool {
        let (plans, others): (Vec<&PathBuf>, Vec<&PathBuf>) =
            files.iter().partition(|file| file.extension().is_some_and(|extension| extension == "rpl"));
        // A project may be for another world now, a robot be another one, or a module have other plans.
        if !others.is_empty() {
            self.settings.borrow_mut().clear();
        }
        let mut have_changed = !others.is_empty();
        for project in self.projects.borrow_mut().values_mut() {
            have_changed |= project.plans_changed(&plans);
            if !others.is_empty() {
                project.project_changed();
            }
        }
        have_changed
    }
}

/// What the texts of a project are looked at with; without a project file, what `rpl check` looks at texts with.
fn setting_of(file: Option<&Path>, role: &Role) -> Result<Setting> {
    let project = file.map(ProjectFile::read).transpose()?.unwrap_or_default();
    let manifests: Vec<ManifestFile> =
        project.modules.iter().map(|name| ManifestFile { name: name.clone(), path: name.into() }).collect();
    let sources = || anyhow::Ok(module_files::opened(&manifests, ModuleVoices::Processes(GoingBack::Never))?.1);
    let sources: Vec<ModuleSource> = match role {
        Role::Scenario => {
            let library = Site::for_checking_scenarios()?.library;
            let reference = Reference::of(&library);
            return Ok(Setting { reference, libraries: vec![library], world: None, is_of_plans: false });
        }
        Role::Plan => sources()?,
        // The plans of one define what it brings along.
        Role::OfModule(_) => sources()?.into_iter().map(|source| ModuleSource { plans: None, ..source }).collect(),
    };
    let libraries: Vec<_> = Site::without_world(sources)?.into_iter().map(|site| site.library).collect();
    let world = project.world.as_deref().map(|world| places_of(world, project.robot.as_deref())).transpose()?;
    // The last one has the robot's names, too.
    let reference = Reference::of(libraries.last().context("one site is for checking")?);
    Ok(Setting { libraries, reference, world, is_of_plans: *role == Role::Plan })
}

fn places_of(world: &str, robot: Option<&str>) -> Result<KnownPlaces> {
    let robot = robot_files::named(robot)?;
    // No arena has places, whatever its seed.
    let world = world_files::named(world, &robot, 0)?;
    Ok(KnownPlaces { names: world.places.iter().map(|place| place.name.clone()).collect(), world: world.name })
}
