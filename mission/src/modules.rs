//! What the robot of a site is composed of; `foreign_modules` adds those that programs of somebody else bring.

use crate::error::SiteError;
use rpl_lola::{Lola, LolaSettings};
use rpl_protocol::module::process_modules::ProcessModules;
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
