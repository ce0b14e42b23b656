//! `rpl man FOLDER`: manual pages, one for each command.

use crate::console::Console;
use crate::outputs::OutputFolder;
use crate::status::Status;
use crate::{CommandLine, VERSION};
use anyhow::{Context, Result};
use clap::{Command, CommandFactory};
use clap_mangen::Man;
use std::path::PathBuf;

/// Arguments of `rpl man`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// The folder, such as ~/.local/share/man/man1; it is made if it is not there
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

/// Writes the pages.
///
/// # Errors
/// The folder or a page cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let folder = &arguments.folder;
    let output = OutputFolder::open(folder, "man")?;
    let pages = pages()?;
    pages.iter().try_for_each(|(name, text)| output.write(name, text))?;
    console.note(&format!("{} pages in {}", pages.len(), folder.display()));
    Ok(Status::Succeeded)
}

/// The pages, each with the name of its file: `rpl.1`, `rpl-run.1`, `rpl-trace-diff.1`, ...
fn pages() -> Result<Vec<(String, Vec<u8>)>> {
    let mut command = CommandLine::command().disable_help_subcommand(true);
    command.build();
    let mut pages = Vec::new();
    add(&command, &mut pages)?;
    Ok(pages)
}

fn add(command: &Command, pages: &mut Vec<(String, Vec<u8>)>) -> Result<()> {
    let page = Man::new(command.clone()).source(format!("rpl {VERSION}")).manual("RPL");
    let mut text = Vec::new();
    page.render(&mut text).context("a manual page cannot be made")?;
    pages.push((page.get_filename(), text));
    command.get_subcommands().filter(|command| !command.is_hide_set()).try_for_each(|command| add(command, pages))
}
