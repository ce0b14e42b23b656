//! What lies around a text: the files it loads, and the world and robot it is for. The program around the server knows
//! them.

use rpl_lang::check::KnownPlaces;
use rpl_lang::compile::Loader;
use rpl_mission::reference::Reference;
use rpl_runtime::run::library::Library;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// What the texts of a project are looked at with.
pub struct Setting {
    /// What plans can call, the smallest library first: a plan is looked at with the first that has all it names,
    /// or with the last, as `rpl check` does.
    pub libraries: Vec<Arc<Library>>,
    /// All names of the last of them, with their documentation.
    pub reference: Reference,
    /// The world that the project is for, if it says so: places that a plan names must be there.
    pub world: Option<KnownPlaces>,
    /// Whether they are plans, which are run and have tests; scenarios and the plans of modules are not, and have none.
    pub is_of_plans: bool,
}

/// By what it is seen that a file has changed: when it was written, and how many bytes it has.
pub type Version = (Option<SystemTime>, u64);

/// Where texts and worlds come from.
pub trait Surroundings {
    /// What a text of this path is looked at with.
    ///
    /// # Errors
    /// One sentence on what is wrong with the project.
    fn setting(&self, path: &Path) -> Result<Arc<Setting>, String>;

    /// Finds what a text of this path loads.
    fn loader(&self, path: &Path) -> Box<dyn Loader>;

    /// The places of a world by its name; without a name, of the one that plans are tried in if nothing is said.
    fn places(&self, path: &Path, world: Option<&str>) -> Option<KnownPlaces>;

    /// A file that has a text of the library, by the name that programs have for it. It is written where it is not yet,
    /// and nothing is written over. None if there is no folder for it.
    fn library_file(&self, name: &str, text: &str) -> Option<PathBuf>;

    /// Whether a file is one of these.
    fn is_library_file(&self, path: &Path) -> bool;

    /// The plans below a folder, those nearest to it first, and no more of them than can be read while somebody waits.
    fn plans_below(&self, folder: &Path) -> Vec<(PathBuf, Version)>;

    /// The text of a plan, if it can be read.
    fn text(&self, path: &Path) -> Option<String>;

    /// Files have changed; whether open texts may mean another thing now beyond what they load.
    fn files_changed(&self, files: &[PathBuf]) -> bool;
}
