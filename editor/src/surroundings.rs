//! What lies around a text: the files it loads, and the world and robot it is for. The program around the server knows
//! them.

use rpl_lang::check::KnownPlaces;
use rpl_lang::compile::Loader;
use rpl_mission::reference::Reference;
use rpl_runtime::run::library::Library;
use std::path::Path;
use std::sync::Arc;

/// What the texts of a project are looked at with.
pub struct Setting {
    /// What plans can call, the smallest library first: a plan is looked at with the first that has all it names,
    /// or with the last, as `rpl check` does.
    pub libraries: Vec<Arc<Library>>,
    /// All names of the last of them, with their documentation.
    pub reference: Reference,
    /// The world that the project is for, if it says so: places that a plan names must be there.
    pub world: Option<KnownPlaces>,
}

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

    /// Files have changed: what was read before may be another thing now.
    fn files_changed(&self);
}
