//! Time worked: waits and deadlines that count only while their task is not suspended.

use serde::{Deserialize, Serialize};

/// A wait or deadline that counts time worked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ActiveTime {
    /// It counts, and ends at this instant unless a suspension comes first.
    Due(u64),
    /// Its task is suspended, and this many microseconds are left. It has no timer.
    Left(u64),
}
