//! Lines of output that wait to be taken.

use serde::{Deserialize, Serialize};

/// A task that prints is switched out when this many lines have not been taken yet, so that an endless loop that prints
/// is seen and does not fill the memory. It stays at the front of its line.
pub const MAX_WAITING_OUTPUT: usize = 4096;

/// The same for the bytes of lines.
pub const MAX_WAITING_OUTPUT_BYTES: usize = 1 << 20;

/// Where a line of output goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Channel {
    /// From `print`: to standard output.
    Print,
    /// From `log`, and warnings: to standard error.
    Log,
}

/// A line of output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    /// Where it goes.
    pub channel: Channel,
    /// What it says.
    pub text: String,
    /// Virtual time.
    pub time_us: u64,
    /// The number of the next event of the trace: it stands before that one.
    pub sequence: u64,
}
