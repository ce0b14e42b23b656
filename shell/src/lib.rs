//! What lies between the command and the machine it runs on: files, terminal, signals, exit status, and the arguments
//! that several commands take. Nothing here drives a run.
//!
//! Read in this order:
//!
//! - `status` and `interrupt`: the end of the command; the effect of a signal;
//! - `terminal`: texts laid out and coloured; `console` is where every command writes; `pager` for long texts;
//! - `files`: plans, worlds, robots and modules by their names, read within limits; no file that was read is written
//!   over;
//! - `arguments`: parts of command lines, and their completion;
//! - `sites`: where a plan runs, put together from all of these.

pub mod arguments;
pub mod files;
pub mod interrupt;
pub mod pager;
pub mod sites;
pub mod status;
pub mod terminal;
