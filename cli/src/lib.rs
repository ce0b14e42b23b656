//! The `rpl` command: `commands` has a file for each subcommand, with its arguments, its help and what it does. Runs
//! are driven by the crate `drive`, the prompt is the crate `prompt`, and runs over many seeds are those of
//! `experiments`; files and terminal are reached by `shell`.
//!
//! Read in this order: this file (from words to an exit status), `commands`, then any of its files; `version` (the
//! build) and `embedded` (for programs that have the command in them).

mod commands;
pub mod embedded;
mod version;

use clap::error::{ContextKind, ContextValue};
use clap::{CommandFactory, Parser};
use commands::{Command, CommandLine, completions};
use rpl_drive::hosts::HostArguments;
use rpl_lang::visible::visible;
use rpl_shell::interrupt;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use rpl_shell::terminal::{colour, console};
use std::env;
use std::ffi::OsString;
use std::io;
use std::process::ExitCode;

/// The command as a program of its own.
pub fn main() -> ExitCode {
    completions::answer(CommandLine::command);
    status_of(env::args_os().collect()).into()
}

/// What the command does with these words, of which the first is its own name, and how that ends. It takes the signals
/// of the process.
fn status_of(words: Vec<OsString>) -> Status {
    interrupt::catch();
    let command = match CommandLine::try_parse_from(&words) {
        Ok(CommandLine { command, prompt: site, color }) => {
            colour::choose(color);
            command.unwrap_or(Command::Repl(commands::repl::Arguments {
                file: None,
                at: None,
                journal: None,
                site,
                host: HostArguments::default(),
            }))
        }
        Err(error) => {
            colour::choose(colour::asked_in(words));
            return answered(on_one_line(commands::with_suggestion(error)));
        }
    };
    let quiet = match &command {
        Command::Run(arguments) => arguments.output.quiet,
        Command::Replay(arguments) => arguments.output.quiet,
        Command::Resume(arguments) => arguments.quiet,
        _ => false,
    };
    let mut console = Console::new(quiet);
    let finished = command.run(&mut console).and_then(|status| Ok(console.flush().map(|()| status)?));
    match finished {
        Ok(status) => status,
        // Whoever closed the pipe has read enough.
        Err(error) if is_closed_pipe(&error) => Status::Succeeded,
        Err(error) => {
            console.end_status();
            console.note(&format!("error: {}", told(&error)));
            Status::Wrong
        }
    }
}

/// What was typed stands on one line in what is said of it, with what steers a terminal written out.
fn on_one_line(mut error: clap::Error) -> clap::Error {
    let typed = |(kind, value): (ContextKind, &ContextValue)| match value {
        ContextValue::String(text) => Some((kind, ContextValue::String(visible(text).into_owned()))),
        _ => None,
    };
    for (kind, value) in error.context().filter_map(typed).collect::<Vec<_>>() {
        error.insert(kind, value);
    }
    error
}

/// What clap itself answers: help, the version, or what is wrong with the command line.
fn answered(error: clap::Error) -> Status {
    let status = if error.use_stderr() { Status::Wrong } else { Status::Succeeded };
    match console::answer(&error.render().ansi().to_string(), error.use_stderr()) {
        Ok(()) => status,
        // Whoever closed the pipe has read enough.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => status,
        Err(error) => {
            console::note(&format!("error: {CANNOT_WRITE}: {error}"));
            Status::Wrong
        }
    }
}

/// Files are named where they are read and written; what nobody has named is standard output.
fn told(error: &anyhow::Error) -> String {
    // Not `error.is`, which looks below what was said of it, too.
    let is_unnamed = error.chain().next().is_some_and(|first| first.is::<io::Error>());
    if is_unnamed { format!("{CANNOT_WRITE}: {error}") } else { format!("{error:#}") }
}

const CANNOT_WRITE: &str = "cannot write to standard output";

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .any(|cause| cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe))
}
