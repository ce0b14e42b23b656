//! The `rpl` command: files, terminal, wall clock, signals, and threads for runs over many seeds.
//!
//! One file per subcommand; `mission` says what a plan runs with, `drive` runs it.

mod check;
mod choice_figures;
mod colour;
mod completion;
mod console;
mod doc;
mod drive;
mod eval;
mod event_line;
mod events;
mod examples;
mod experiment;
mod failure_report;
mod figures;
mod files;
mod fmt;
mod interrupt;
mod layout;
mod localize;
mod man;
mod mission;
mod outputs;
mod overrides;
mod page;
mod pager;
mod plan_files;
mod reference;
mod repl;
mod run;
mod setting;
mod situation;
mod status;
mod status_line;
mod table;
mod test;
mod time;
mod trace;
mod why;
mod worlds;

use anyhow::Result;
use clap::error::{ContextKind, ContextValue};
use clap::{ColorChoice, CommandFactory, Parser, Subcommand};
use clap_complete::engine::ArgValueCompleter;
use console::Console;
use rpl_lang::suggest::suggest;
use setting::Setting;
use status::Status;
use std::env;
use std::io;
use std::process::ExitCode;

/// The version, and in a release build the commit it was built from, if that is known.
const VERSION: &str = env!("RPL_VERSION");

/// Reactive plans, and a robot that carries them out
#[derive(Parser, Debug)]
#[command(name = "rpl", version = VERSION, max_term_width = layout::HELP_COLUMNS)]
#[command(
    after_help = "Exit status: 0 success, 1 the plan or its scenario failed, 2 the text or the command line is wrong, \
                        3 --until was reached, 130 interrupted."
)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
    /// Whether colours are written: `auto`, `always` or `never`
    #[arg(long, global = true, value_name = "WHEN", default_value_t = ColorChoice::Auto, hide_possible_values = true)]
    color: ColorChoice,
    /// What `rpl` alone takes, which is the prompt.
    #[command(flatten, next_help_heading = "Options of the prompt (`rpl` alone)")]
    prompt: Setting,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Runs a plan
    Run(Box<run::Arguments>),
    /// Reads forms and runs them: the prompt, with the stepper. So does `rpl` alone
    Repl(repl::Arguments),
    /// The same, stopped before the first form of a file
    Step(repl::Arguments),
    /// Shows a recorded run: its events, why a task waited or failed, what differs from another.
    ///
    /// `rpl run FILE --trace T` records one.
    Trace(trace::Arguments),
    /// Checks plans without running them: all faults at once, and what is probably wrong.
    ///
    /// An error is what keeps a plan from running, and makes the exit status 2; a warning is not, and
    /// leaves it 0. Each warning has the name of its rule. A comment `; check: allow RULE` in its line,
    /// or in the line above, takes it away; what is unused on purpose begins with an underscore.
    Check(check::Arguments),
    /// Runs the tests in plans
    Test(test::Arguments),
    /// Formats plans: indentation, spaces, and lines that are too long
    Fmt(fmt::Arguments),
    /// Evaluates an expression, or standard input, and prints the value
    Eval(eval::Arguments),
    /// Lists the worlds, or shows one
    Worlds(worlds::Arguments),
    /// Lists the built-in plans, or shows one
    Examples {
        /// A built-in plan
        #[arg(value_name = "NAME", add = ArgValueCompleter::new(completion::built_in))]
        name: Option<String>,
    },
    /// Documents a name or a topic, searches for a word, or lists all names
    ///
    /// At a terminal through a pager: `RPL_PAGER`, else `PAGER`, else `less -FRX`; none if that is empty.
    Doc {
        /// Whatever has a name in the language, the library or the robot, a command, a topic such as
        /// `behaviours`, or a word to search for
        #[arg(value_name = "NAME", add = ArgValueCompleter::new(completion::documented))]
        name: Option<String>,
    },
    /// Runs a plan with many seeds and makes a table
    Experiment(experiment::Arguments),
    /// Finds the robot in a recorded drive, and says how well
    Localize(Box<localize::Arguments>),
    /// Writes what makes a shell complete the words of this command
    ///
    /// The shell then asks this program, which knows its worlds, plans, experiments, rows and names. Best
    /// read by the shell when it starts: `source <(rpl completions bash)` in ~/.bashrc, the same with `zsh`
    /// in ~/.zshrc, `rpl completions fish | source` in ~/.config/fish/config.fish.
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Writes manual pages into a folder, one for each command
    Man(man::Arguments),
}

fn main() -> ExitCode {
    interrupt::catch();
    completion::answer();
    let command = match CommandLine::try_parse() {
        Ok(CommandLine { command, prompt: setting, color }) => {
            colour::choose(color);
            command.unwrap_or(Command::Repl(repl::Arguments { file: None, setting }))
        }
        Err(error) => {
            colour::choose(colour::asked_in(env::args_os()));
            return answered(with_suggestion(error));
        }
    };
    let quiet = matches!(&command, Command::Run(arguments) if arguments.quiet);
    let mut console = Console::new(quiet);
    let finished = dispatch(&command, &mut console).and_then(|status| Ok(console.flush().map(|()| status)?));
    match finished {
        Ok(status) => status.into(),
        // Whoever closed the pipe has read enough.
        Err(error) if is_closed_pipe(&error) => Status::Succeeded.into(),
        Err(error) => {
            console.end_status();
            console.note(&format!("error: {}", told(&error)));
            Status::Wrong.into()
        }
    }
}

/// What clap itself answers: help, the version, or what is wrong with the command line.
fn answered(error: clap::Error) -> ExitCode {
    let status = if error.use_stderr() { Status::Wrong } else { Status::Succeeded };
    match console::answer(&error.render().ansi().to_string(), error.use_stderr()) {
        Ok(()) => status.into(),
        // Whoever closed the pipe has read enough.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => status.into(),
        Err(error) => {
            console::note(&format!("error: {CANNOT_WRITE}: {error}"));
            Status::Wrong.into()
        }
    }
}

/// The error with the command that was probably meant. In a word of three letters clap takes an
/// exchange of two for another word.
fn with_suggestion(mut error: clap::Error) -> clap::Error {
    let is_known = error.get(ContextKind::SuggestedSubcommand).is_some();
    let typed = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(typed)) if !is_known => typed.clone(),
        Some(_) | None => return error,
    };
    let commands = CommandLine::command();
    if let Some(meant) = suggest(&typed, commands.get_subcommands().map(clap::Command::get_name)) {
        error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(vec![meant.to_string()]));
    }
    error
}

fn dispatch(command: &Command, console: &mut Console) -> Result<Status> {
    match command {
        Command::Run(arguments) => run::run(arguments, console),
        Command::Repl(arguments) => repl::run(arguments, false, console),
        Command::Step(arguments) => repl::run(arguments, true, console),
        Command::Trace(arguments) => trace::run(arguments, console),
        Command::Check(arguments) => check::run(arguments, console),
        Command::Test(arguments) => test::run(arguments, console),
        Command::Fmt(arguments) => fmt::run(arguments, console),
        Command::Eval(arguments) => eval::run(arguments, console),
        Command::Worlds(arguments) => worlds::run(arguments, console),
        Command::Examples { name } => examples::run(name.as_deref(), console),
        Command::Doc { name } => pager::paged(console, |console| doc::run(name.as_deref(), console)),
        Command::Experiment(arguments) => experiment::run(arguments, console),
        Command::Localize(arguments) => localize::run(arguments, console),
        Command::Completions { shell } => {
            console.print(&completion::script(*shell)?)?;
            Ok(Status::Succeeded)
        }
        Command::Man(arguments) => man::run(arguments, console),
    }
}

/// Files are named where they are read and written; what has no name is standard output.
fn told(error: &anyhow::Error) -> String {
    if error.is::<io::Error>() { format!("{CANNOT_WRITE}: {error}") } else { format!("{error:#}") }
}

const CANNOT_WRITE: &str = "cannot write to standard output";

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .any(|cause| cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        CommandLine::command().debug_assert();
    }
}
