//! Memory: collections, and the room that is left.

pub(crate) mod gc;
pub mod room;
