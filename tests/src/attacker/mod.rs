//! Attacks on what listens to others, and on what reads that which others wrote: sockets on this machine, the servers of
//! editors, hosts, modules, projects and journals, forged files; and what must hold meanwhile.
//!
//! A [`Surface`] starts the command and is attacked in ways drawn from a stream of chance. After each attack it looks
//! whether somebody with good intentions is served in time, whether the command took more memory than it may, what it
//! wrote, and whether anything ran or changed that nobody named.

mod editors;
mod files;
mod journals;
mod modules;
mod page;
mod peer;
mod projects;
mod simulator;
mod victim;

use crate::generated::Dice;
use std::path::Path;

/// Which attack it was; or what must not be.
pub type Judged = Result<&'static str, String>;

/// Something that is attacked.
pub trait Surface {
    /// One attack.
    ///
    /// # Errors
    /// What must not be.
    fn attack(&mut self, dice: &mut Dice) -> Judged;

    /// The end of what was started.
    ///
    /// # Errors
    /// What must not be.
    fn end(&mut self) -> Result<(), String>;
}

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

/// What stands where nothing may be changed.
const CANARY: &str = "nobody named this file\n";

/// Puts a file there that must stay as it is.
fn put_canary(path: &Path) -> Result<(), String> {
    std::fs::write(path, CANARY).map_err(|error| format!("{}: {error}", path.to_string_lossy()))
}

/// Whether the file is as it was.
fn look_at_canary(path: &Path) -> Result<(), String> {
    match std::fs::read_to_string(path) {
        Ok(text) if text == CANARY => Ok(()),
        Ok(text) => {
            Err(format!("{} was overwritten: {:?}", path.to_string_lossy(), text.chars().take(200).collect::<String>()))
        }
        Err(error) => Err(format!("{} is gone: {error}", path.to_string_lossy())),
    }
}
