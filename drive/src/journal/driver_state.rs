//! What a checkpoint holds beside the run: how far its files were written.

use rpl_link::journal::ledger::LedgerMark;
use serde::{Deserialize, Serialize};

/// What is kept beside the saved run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriverState {
    /// The checksum of the run it belongs to.
    pub run: u32,
    /// Time of the run.
    pub time_us: u64,
    /// What plans printed before.
    pub output: LedgerMark,
    /// What was told before.
    pub log: LedgerMark,
    /// What was traced before.
    pub trace: Option<LedgerMark>,
    /// When the trace tells next where the robot is.
    pub pose_due_us: u64,
    /// How often active localization was started.
    pub relocalizations: u64,
    /// How many of the journal's changes had taken effect.
    pub changes: usize,
}
