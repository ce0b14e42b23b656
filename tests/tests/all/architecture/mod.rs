//! What ARCHITECTURE.md says of the code, as far as it can be read in the files.

mod arrows;
mod circles;
mod modules;
mod tokens;
