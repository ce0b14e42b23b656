//! `rpl lsp`: the language server, over standard input and output.

use anyhow::Result;
use rpl_editor::lsp::{Ending, serve};
use rpl_editor::surroundings::{Setting, Surroundings};
use rpl_lang::check::KnownPlaces;
use rpl_lang::compile::{Loader, NoFiles};
use rpl_mission::reference::Reference;
use rpl_mission::site::{Setup, Site};
use rpl_shell::arguments::plan_files;
use rpl_shell::files::module_files::{self, GoingBack, ManifestFile, ModuleVoices};
use rpl_shell::files::plans::OnDisk;
use rpl_shell::files::plans::{self, PlanText};
use rpl_shell::files::project_file::ProjectFile;
use rpl_shell::files::roles::{Role, Roles};
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
    /// The files of each project that are no plans.
    roles: RefCell<BTreeMap<PathBuf, Roles>>,
}

/// The project of a text, and whether it is a scenario.
type SettingKey = (Option<PathBuf>, bool);

impl Files {
    /// Whether a text of a project is a scenario, by what the project and its other texts say.
    fn is_scenario(&self, project: &Path, path: &Path) -> bool {
        let mut roles = self.roles.borrow_mut();
        let roles = roles.entry(project.to_path_buf()).or_insert_with(|| {
            let folder = project.parent().unwrap_or(project).to_string_lossy().into_owned();
            let texts: Vec<PlanText> =
                plan_files::named(&[folder]).iter().flatten().filter_map(|file| plans::plan(file).ok()).collect();
            Roles::of(ProjectFile::read(project).ok().as_ref(), texts.iter())
        });
        roles.role(&path.to_string_lossy()) == Role::Scenario
    }
}

impl Surroundings for Files {
    fn setting(&self, path: &Path) -> Result<Arc<Setting>, String> {
        let file = ProjectFile::above(path);
        let is_scenario = file.as_deref().is_some_and(|file| self.is_scenario(file, path));
        let of = (file, is_scenario);
        if let Some(known) = self.settings.borrow().get(&of) {
            return Ok(known.clone());
        }
        let setting = setting_of(of.0.as_deref(), is_scenario).map_err(|error| format!("{error:#}"))?;
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

    fn files_changed(&self) {
        self.settings.borrow_mut().clear();
        self.roles.borrow_mut().clear();
    }
}

/// What the texts of a project are looked at with; without a project file, what `rpl check` looks at texts with.
fn setting_of(file: Option<&Path>, is_scenario: bool) -> Result<Setting> {
    if is_scenario {
        let library = Site::for_checking_scenarios()?.library;
        return Ok(Setting { reference: Reference::of(&library), libraries: vec![library], world: None });
    }
    let project = file.map(ProjectFile::read).transpose()?.unwrap_or_default();
    let manifests: Vec<ManifestFile> =
        project.modules.iter().map(|name| ManifestFile { name: name.clone(), path: name.into() }).collect();
    let (_, sources) = module_files::opened(&manifests, ModuleVoices::Processes(GoingBack::Never))?;
    let robotless = Site::with_processes(Setup::default(), sources.clone())?;
    let robot = Site::for_checking(sources)?;
    let world = project.world.as_deref().map(|world| places_of(world, project.robot.as_deref())).transpose()?;
    let reference = Reference::of(&robot.library);
    Ok(Setting { libraries: vec![robotless.library, robot.library], reference, world })
}

fn places_of(world: &str, robot: Option<&str>) -> Result<KnownPlaces> {
    let robot = robot_files::named(robot)?;
    // No arena has places, whatever its seed.
    let world = world_files::named(world, &robot, 0)?;
    Ok(KnownPlaces { names: world.places.iter().map(|place| place.name.clone()).collect(), world: world.name })
}
