//! Files: which are read and written, and what is in them.

#[cfg(unix)]
mod accounts;
pub mod case_files;
pub mod foreign;
pub mod inputs;
pub mod maps;
pub mod module_files;
pub mod outputs;
pub mod overrides;
pub mod packed;
pub mod plans;
pub mod project_file;
pub mod robot_files;
pub mod roles;
pub mod shown;
pub mod toml_files;
pub mod world_files;
