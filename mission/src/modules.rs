//! What the robot of a site is composed of: the modules of the office robot, and those that programs of
//! somebody else bring.

use crate::error::SiteError;
use crate::libraries::{is_taken, robot_library};
use rpl_lola::{Lola, LolaSettings};
use rpl_protocol::module::process_modules::{ModuleSource, ModuleSources, ProcessModules};
use rpl_robot::office::{Composition, OfficeModules, OfficeRobot, SimulatedHost};
use rpl_runtime::robot::RobotTables;
use rpl_runtime::step::native::Native;
use rpl_rupart::Rupart;
use std::sync::{Arc, LazyLock};

rpl_robot::modules! {
    /// The modules of a robot.
    pub struct SiteModules {
        /// Those of the office robot.
        pub office: OfficeModules,
        /// What it takes to follow instructions without a map.
        pub lola: Lola,
        /// What it takes to drive by cases.
        pub rupart: Rupart,
        /// Those in other processes.
        pub processes: ProcessModules,
    }
}

/// A simulated robot with the modules of a site.
pub type SiteRobot = OfficeRobot<SimulatedHost, SiteModules>;

/// The modules of a robot without any in other processes.
pub fn own_modules() -> &'static Arc<Composition<SiteModules>> {
    static MODULES: LazyLock<Arc<Composition<SiteModules>>> =
        LazyLock::new(|| match Composition::new(Default::default()) {
            Ok(modules) => modules,
            Err(fault) => unreachable!("the modules of the robot fit together: {fault}"),
        });
    &MODULES
}

/// The same modules, following instructions in another way: the rows of experiments.
///
/// # Errors
/// Never: what follows from the settings has no names.
pub fn modules_with(lola: LolaSettings) -> Result<Arc<Composition<SiteModules>>, SiteError> {
    Composition::new((Default::default(), lola, Default::default(), Default::default()))
        .map_err(|fault| SiteError::Modules(fault.to_string()))
}

/// What plans see of that robot.
pub fn tables() -> &'static RobotTables {
    &own_modules().tables
}

/// Its functions.
pub fn natives() -> Vec<Native> {
    own_modules().functions.clone()
}

/// A robot with these modules in other processes beside its own.
///
/// # Errors
/// Two of them have something of one name, or a name has a meaning in the language or its library.
pub fn composed(sources: Vec<ModuleSource>) -> Result<Arc<Composition<SiteModules>>, SiteError> {
    if sources.is_empty() {
        return Ok(own_modules().clone());
    }
    let sources = ModuleSources(sources);
    let library = robot_library(own_modules(), Vec::new())?;
    // What belongs to the robot is told by its composition, with the name of the module.
    let is_robots = |name: &str| own_modules().tables.names().any(|known| known == name);
    for manifest in sources.0.iter().map(|source| &source.manifest) {
        if let Some(name) = manifest.names().find(|name| !is_robots(name) && is_taken(&library, name)) {
            let (module, place) = (&manifest.name, manifest.place(name));
            return Err(SiteError::Modules(format!(
                "`{name}` of the module `{module}` ({place}) has a meaning in the language or its library; \
                 give it another name"
            )));
        }
    }
    let told = sources.clone();
    Composition::new((Default::default(), Default::default(), Default::default(), sources))
        .map_err(|fault| SiteError::Modules(told.told(&fault)))
}
