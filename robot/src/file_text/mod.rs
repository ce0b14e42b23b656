//! The texts of files that people write, and what is wrong with them: every fault at once, each with its
//! place, what was expected, and what to type.

mod finding;
mod toml_reader;

pub use finding::{FileFaults, Finding};

pub(crate) use finding::{Findings, nearest};
pub(crate) use toml_reader::{Placed, Reader, TomlTable, TomlValue, example_help};
