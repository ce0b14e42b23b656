//! A recorded run as a file: written event by event, and read again as far as it goes.

mod file;
mod reader;

pub use file::{Header, TraceFile, TracedPose};
pub(crate) use file::{VERSION, line};
pub use reader::{TraceLine, TraceReader};
