//! What plans see of it.

use rpl_robot::office::{Module, ModuleSpec, OfficeModel};
use serde::{Deserialize, Serialize};

/// The state of following instructions.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Lola {}

impl Module for Lola {
    type Settings = ();

    fn specs((): &()) -> Vec<ModuleSpec> {
        vec![ModuleSpec { name: "lola".into(), ..ModuleSpec::default() }]
    }

    fn new((): &(), _: &OfficeModel, _: u64) -> Self {
        Self::default()
    }
}
