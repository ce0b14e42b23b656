//! Long texts at a terminal go through a pager: `RPL_PAGER`, `PAGER`, or `less -FRX`.

use crate::interrupt;
use crate::status::Status;
use crate::terminal::console::Console;
use anyhow::Result;
use std::env;
use std::io::{self, IsTerminal, Write};
use std::process::{Child, Command, Stdio};

/// Leaves at once if the text fits the screen, shows colours, and leaves the text on the screen.
const USUAL: &str = "less -FRX";

/// Lets a command write its text, through a pager if standard output is a terminal.
///
/// # Errors
/// Those of the command, or standard output is closed.
pub fn paged(console: &mut Console, write: impl FnOnce(&mut Console) -> Result<Status>) -> Result<Status> {
    let Some(command) = wanted() else { return write(console) };
    console.keep(true);
    let finished = write(console);
    let text = console.take_kept().join("\n");
    console.keep(false);
    if !text.is_empty() && !has_shown(&command, &text) {
        console.print(&text)?;
    }
    finished
}

/// The pager, if there is to be one: an empty name, and a terminal that can do nothing, ask for none.
fn wanted() -> Option<String> {
    let is_able = io::stdout().is_terminal() && env::var_os("TERM").is_some_and(|terminal| terminal != "dumb");
    let named = ["RPL_PAGER", "PAGER"].iter().find_map(|name| env::var(name).ok());
    named.or_else(|| Some(USUAL.to_string())).filter(|command| is_able && !command.trim().is_empty())
}

/// Whether a pager has shown a text; one that is not there, or gives up, has not.
fn has_shown(command: &str, text: &str) -> bool {
    // Ctrl-C is for the pager, which ends by itself.
    let _is_for_pager = interrupt::is_for_another();
    let Ok(mut pager) = shell(command).stdin(Stdio::piped()).spawn() else { return false };
    hand_over(&mut pager, text);
    // A pager that was killed was there, and its reader knows why.
    pager.wait().is_ok_and(|status| status.code().is_none_or(|code| code == 0))
}

/// Whoever leaves a pager early has read enough.
fn hand_over(pager: &mut Child, text: &str) {
    if let Some(mut input) = pager.stdin.take() {
        writeln!(input, "{text}").ok();
    }
}

/// The names are commands with arguments, as a shell reads them.
fn shell(command: &str) -> Command {
    let (shell, option) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
    let mut shell = Command::new(shell);
    shell.args([option, command]);
    shell
}
