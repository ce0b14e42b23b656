//! Since when nothing has happened.

use serde::{Deserialize, Serialize};

/// Since when nothing has happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stall {
    /// When something drove, or a task that is no policy ran.
    pub since_us: u64,
    /// It was reported, and nothing has happened since.
    pub is_reported: bool,
    /// The charge of the battery then, in thousandths; none before it was looked at, or without a battery.
    pub charge_permille: Option<u16>,
}
