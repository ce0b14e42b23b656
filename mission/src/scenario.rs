//! The experimenter's plan, compiled: a second system, which runs beside the plans, sees the truth and
//! meddles with the world.

use crate::error::SiteError;
use crate::libraries::scenario_library;
use rpl_lang::compile::Loader;
use rpl_robot::office::{OfficeModel, Oracle};
use rpl_runtime::run::library::{Library, Loaded};
use rpl_runtime::run::system::System;
use std::sync::Arc;

/// A scenario, compiled for a world.
#[derive(Clone)]
pub(crate) struct Scenario {
    library: Arc<Library>,
    loaded: Loaded,
}

impl Scenario {
    /// Compiles a scenario.
    ///
    /// # Errors
    /// Its text is wrong.
    pub fn compile(name: &str, text: &str, loader: &mut dyn Loader) -> Result<Self, SiteError> {
        let library = scenario_library()?;
        match library.load(name, text, loader) {
            Ok(loaded) => Ok(Self { library, loaded }),
            Err(rejected) => Err(SiteError::Scenario { name: name.to_string(), rejected }),
        }
    }

    /// The scenario at its start.
    pub fn start(&self, office: &OfficeModel, seed: u64) -> System<Oracle> {
        let oracle = Oracle::new(office.simulator.clone(), seed);
        System::new(self.library.clone(), self.loaded.clone(), oracle, seed)
    }
}
