//! The texts of files that people write, and what is wrong with them: every fault at once, each with its
//! place, what was expected, and what to type.

mod finding;
mod syntax_fault;
mod toml_reader;

pub use finding::{FileFaults, Finding, Findings};
pub use syntax_fault::syntax_fault;
pub use toml_reader::{Placed, Reader, TomlTable, TomlValue, example_help};

pub(crate) use finding::nearest;
