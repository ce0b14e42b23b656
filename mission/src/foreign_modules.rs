//! Modules in other processes, beside those of the robot or alone.

use crate::error::SiteError;
use crate::libraries::{is_taken, library_without_robot, robot_library};
use crate::modules::{SiteModules, own_modules};
use rpl_protocol::module::process_modules::{ModuleSource, ModuleSources, ProcessModules};
use rpl_robot::office::{Composition, NameTaken};
use rpl_runtime::run::library::Library;
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
    // What belongs to the robot is told by its composition, with the name of the module.
    let is_robots = |name: &str| own_modules().tables.names().any(|known| known == name);
    refuse_taken(&sources, &*robot_library(own_modules(), Vec::new())?, is_robots)?;
    let told = sources.clone();
    Composition::new((Default::default(), Default::default(), rupart, sources))
        .map_err(|fault| SiteError::Modules(told.told(&fault)))
}

/// These modules in other processes, where there is no robot: the names of ours are free.
///
/// # Errors
/// As for [`composed`]; or one of them needs a robot.
pub fn alone(sources: Vec<ModuleSource>) -> Result<Arc<Composition<ProcessModules>>, SiteError> {
    let sources = ModuleSources(sources);
    if let Some(wanted) = sources.wants_robot() {
        return Err(SiteError::ModuleWithoutRobot(wanted));
    }
    refuse_taken(&sources, &*library_without_robot(Vec::new())?, |_| false)?;
    let told = sources.clone();
    Composition::new(sources).map_err(|fault| match &fault {
        NameTaken::NoValve { behaviour, module, valve } if own_modules().tables.valves.contains(&valve.into()) => {
            let place = told.places(module, behaviour);
            SiteError::ModuleWithoutRobot(format!(
                "the behaviour `{behaviour}` of the module `{module}`{place} needs the robot's valve `{valve}`"
            ))
        }
        _ => SiteError::Modules(told.told(&fault)),
    })
}

/// # Errors
/// A name of a module has a meaning in the library, and is not one that is told of otherwise.
fn refuse_taken(
    sources: &ModuleSources,
    library: &Library,
    is_told_otherwise: impl Fn(&str) -> bool,
) -> Result<(), SiteError> {
    for manifest in sources.0.iter().map(|source| &source.manifest) {
        if let Some(name) = manifest.names().find(|name| !is_told_otherwise(name) && is_taken(library, name)) {
            let (module, place) = (&manifest.name, manifest.place(name));
            return Err(SiteError::Modules(format!(
                "`{name}` of the module `{module}` ({place}) has a meaning in the language or its library; \
                 give it another name"
            )));
        }
    }
    Ok(())
}
