//! `rpl doc [NAME]`: documentation of a name, a topic, or everything that mentions a word.
//!
//! It documents the commands too, and so knows the command line that it is a part of: that circle is in
//! the matter.

use super::CommandLine;
use crate::arguments::completion::{Offers, beginning_with};
use crate::reference::{Reference, TOPICS};
use crate::show::documentation::document;
use crate::status::Status;
use crate::terminal::console::Console;
use crate::terminal::pager;
use anyhow::Result;
use clap::CommandFactory;
use clap_complete::engine::ArgValueCompleter;
use std::ffi::OsStr;

/// Documents a name or a topic, searches for a word, or lists all names
///
/// At a terminal through a pager: `RPL_PAGER`, else `PAGER`, else `less -FRX`; none if that is empty.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Whatever has a name in the language, the library or the robot, a command, a topic such as
    /// `behaviours`, or a word to search for
    #[arg(value_name = "NAME", add = ArgValueCompleter::new(documented))]
    name: Option<String>,
}

/// Documents, at a terminal through a pager.
///
/// # Errors
/// Nothing has the name, and nothing mentions it.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let reference = Reference::new()?.with_commands(&CommandLine::command());
    pager::paged(console, |console| document(&reference, arguments.name.as_deref(), console))
}

/// Whatever `rpl doc` documents.
fn documented(typed: &OsStr) -> Offers {
    let topics = TOPICS.iter().map(|topic| (topic.word, topic.title));
    // Without the library there is nothing to complete.
    let Ok(reference) = Reference::new() else { return beginning_with(typed, topics) };
    let reference = reference.with_commands(&CommandLine::command());
    let commands = reference.entries().filter_map(|entry| Some((entry.name.strip_prefix("rpl ")?, entry.summary())));
    let names = reference.names().map(|entry| (entry.name.as_str(), entry.summary()));
    beginning_with(typed, topics.chain(commands).chain(names))
}
