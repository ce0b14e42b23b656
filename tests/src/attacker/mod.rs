//! Attacks on what listens to others, and on what reads that which others wrote: sockets on this machine, the servers of
//! editors, hosts, modules, projects and journals, forged files; and what must hold meanwhile.
//!
//! A [`Surface`] starts the command and is attacked in ways drawn from a stream of chance. After each attack it looks
//! whether somebody with good intentions is served in time, whether the command took more memory than it may, what it
//! wrote, and whether anything ran or changed that nobody named.

mod canary;
mod editors;
mod files;
mod journals;
mod modules;
mod page;
mod peer;
mod projects;
mod simulator;
mod surface;
mod victim;

pub use surface::{Judged, Surface};

use std::path::Path;

/// Starts the command for a surface, in a folder that is its own.
type Start = fn(&Path, &Path) -> Result<Box<dyn Surface>, String>;

/// All surfaces by their names, and how many of a hundred attacks are for each: those that start a process take longer.
pub const SURFACES: [(&str, usize, Start); 9] = [
    ("page", 30, page::start),
    ("simulator", 20, simulator::start),
    ("language server", 20, editors::start_language_server),
    ("debug adapter", 10, editors::start_debug_adapter),
    ("files", 10, files::start),
    ("projects", 3, projects::start),
    ("journals", 3, journals::start),
    ("hosts", 2, peer::start),
    ("modules", 2, modules::start),
];
