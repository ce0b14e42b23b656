//! Standard output and standard error: what is written there, how wide, in which colours.

pub mod colour;
pub mod console;
pub mod layout;
pub mod page;
pub mod progress;
mod status_line;
pub mod table;
