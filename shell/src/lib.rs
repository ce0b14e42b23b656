//! What lies between the command and the machine it runs on: files, terminal, signals, exit status, and the arguments
//! that several commands take. Nothing here knows a run.
//!
//! `files` finds plans, worlds, robots and modules by their names, reads within limits and never writes over what was
//! read; `terminal` lays texts out and colours them; `arguments` are parts of command lines; `sites` puts together
//! where a plan runs, by what they say.

pub mod arguments;
pub mod files;
pub mod interrupt;
pub mod pager;
pub mod sites;
pub mod status;
pub mod terminal;
