//! Modules in other processes, beside those of the robot.

use crate::error::SiteError;
use crate::libraries::{is_taken, robot_library};
use crate::modules::{SiteModules, own_modules};
use rpl_protocol::module::process_modules::{ModuleSource, ModuleSources};
use rpl_robot::office::Composition;
use rpl_rupart::RupartSettings;
use std::sync::Arc;

/// A robot that drives by cases so, with these modules in other processes beside its own.
///
/// # Errors
/// Two of them have something of one name, or a name has a meaning in the language or its library.
pub fn composed(
    rupart: RupartSettings,
    sources: Vec<ModuleSource>,
) -> Result<Arc<Composition<SiteModules>>, SiteError> {
    if sources.is_empty() && rupart == RupartSettings::default() {
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
    Composition::new((Default::default(), Default::default(), rupart, sources))
        .map_err(|fault| SiteError::Modules(told.told(&fault)))
}
