//! What is kept while instructions are followed.

use super::counting::Counting;
use super::drive::Drive;
use super::hallway::Hallway;
use super::seeing::Seeing;
use super::settings::LolaSettings;
use crate::routines::Doorway;
use crate::state_set::StateSet;
use serde::{Deserialize, Serialize};

/// The state of following instructions. As long as no plan uses it, it does nothing and tells nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Lola {
    #[serde(skip)]
    pub(super) settings: LolaSettings,
    /// The hallway the robot is in, since it was registered.
    pub(super) hallway: Option<Hallway>,
    /// What it does with the wheels.
    pub(super) drive: Drive,
    /// The doorway it came through last.
    pub(super) doorway: Option<Doorway>,
    /// How far it has got with an instruction.
    pub(super) counting: Option<Counting>,
    /// The markers it looks for with its camera.
    pub(super) markers: Option<Seeing>,
    /// Whether something has changed since plans were told.
    pub(super) has_news: bool,
}

/// What an experimenter sees of it.
impl Lola {
    /// The hallway the robot is in, since it was begun with.
    pub fn hallway(&self) -> Option<&Hallway> {
        self.hallway.as_ref()
    }

    /// How far it has got with the instruction it is at.
    pub fn state_set(&self) -> Option<&StateSet> {
        self.counting.as_ref().map(|counting| &counting.state_set)
    }
}
