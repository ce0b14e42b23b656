//! `rpl man FOLDER`: manual pages, one for each command.

use crate::version::VERSION;
use anyhow::{Context, Result};
use clap::Command;
use clap_mangen::Man;
use rpl_shell::files::outputs::OutputFolder;
use rpl_shell::files::shown::Shown;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::path::PathBuf;

/// Write manual pages into a folder, one for each command
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Folder, such as ~/.local/share/man/man1; it is created if necessary
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

/// Writes the pages of the whole command line.
///
/// # Errors
/// The folder or a page cannot be written.
pub fn run(arguments: &Arguments, command_line: Command, console: &mut Console) -> Result<Status> {
    let folder = &arguments.folder;
    let output = OutputFolder::open(folder, "man")?;
    let pages = pages(command_line)?;
    pages.iter().try_for_each(|(name, text)| output.write(name, text))?;
    console.note(&format!("{} pages in {}", pages.len(), folder.shown()));
    Ok(Status::Succeeded)
}

/// The pages, each with the name of its file: `rpl.1`, `rpl-run.1`, `rpl-trace-diff.1`, ...
fn pages(command_line: Command) -> Result<Vec<(String, Vec<u8>)>> {
    let mut command = command_line.disable_help_subcommand(true);
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
