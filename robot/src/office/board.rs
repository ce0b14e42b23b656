//! The board: what the modules of the robot share. They do not write here themselves: position tracking
//! writes the position, through [`Position`]; everything else is put down by the controller, which
//! gathers what they answer, and by functions that plans call.

use super::immobility::Immobility;
use super::model::OfficeModel;
use super::position::Position;
use crate::geometry::Velocity;
use crate::simulator::Percept;
use crate::world::TravelMode;
use serde::{Deserialize, Serialize};

/// What the modules share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Board {
    /// Where the robot believes itself to be.
    pub position: Position,
    /// The percept of the last step; the controller writes it when the step is over.
    pub percept: Option<Percept>,
    /// How the robot is to drive; plans write it, with `set-travel-mode`.
    pub mode: TravelMode,
    /// What is asked of the wheels: by the last module at work that wants anything of them, and nothing
    /// once one that drives was stopped. The controller writes it.
    pub drive_request: Velocity,
    /// Whether the wheels do what is asked of them. The controller writes it.
    pub immobility: Immobility,
    /// What people have sent and no plan has read, the oldest first. The controller adds, `read-message`
    /// takes.
    pub inbox: Vec<Vec<String>>,
}

impl Board {
    /// The board at the start.
    pub(super) fn new(model: &OfficeModel) -> Self {
        Self {
            position: Position::new(model),
            percept: None,
            mode: TravelMode::Hallway,
            drive_request: Velocity::default(),
            immobility: Immobility::default(),
            inbox: Vec::new(),
        }
    }
}
