//! `rpl completions SHELL`: what makes a shell ask this program, and the answer when it asks.

mod shell_words;

use anyhow::{Context, Result};
use clap_complete::Shell;
use clap_complete::env::{CompleteEnv, Elvish, Fish, Powershell, Shells, Zsh};
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use shell_words::{Bash, Quoting};
use std::env;
use std::path::Path;

/// Print the completion script for a shell
///
/// With it the shell completes commands, options, worlds, plans, experiments, rows and names. Load it when the
/// shell starts: `source <(rpl completions bash)` in ~/.bashrc, the same with `zsh` in ~/.zshrc,
/// `rpl completions fish | source` in ~/.config/fish/config.fish.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Shell
    shell: Shell,
}

/// Writes it.
///
/// # Errors
/// There is nothing for this shell, or standard output is closed.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    console.print(&script(arguments.shell)?)?;
    Ok(Status::Succeeded)
}

/// A shell that asks says so in this variable.
const VARIABLE: &str = "RPL_COMPLETE";

const SHELLS: Shells<'static> = Shells(&[&Bash, &Quoting(Elvish), &Quoting(Fish), &Powershell, &Quoting(Zsh)]);

/// Answers a shell that asks about this command line, and ends the program; returns if none has asked.
pub fn answer(command_line: fn() -> clap::Command) {
    CompleteEnv::with_factory(command_line).var(VARIABLE).shells(SHELLS).complete();
}

/// What makes a shell ask.
///
/// # Errors
/// There is nothing for this shell.
fn script(shell: Shell) -> Result<String> {
    let name = shell.to_string();
    let adapter = SHELLS.completer(&name).with_context(|| format!("there are no completions for {name}"))?;
    let mut script = Vec::new();
    adapter.write_registration(VARIABLE, "rpl", "rpl", &program(), &mut script)?;
    Ok(String::from_utf8_lossy(&script).trim_end().to_string())
}

/// The program as it was called: by its name, or else by its whole path.
fn program() -> String {
    let called = env::args().next().unwrap_or_default();
    if Path::new(&called).components().count() < 2 {
        return "rpl".to_string();
    }
    env::current_exe().map_or(called, |path| path.to_string_lossy().into_owned())
}
