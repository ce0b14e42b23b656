//! A case memory as a file that people can read: lines of JSON, the first of which says what it is, each of the
//! others a case. Known places stand in it by name, so that a file outlives a new drawing of the building.

mod lines;
mod read;
#[cfg(test)]
mod tests;
mod write;

pub use lines::{MOST_CASES, VERSION};
pub use read::{read_memory, read_situation, world_of};
pub use write::memory_text;
