//! The `rpl` command: files, terminal, wall clock, signals, and threads for runs over many seeds.
//!
//! One file per subcommand; `mission` says what a plan runs with, `drive` runs it.

mod check;
mod choice_figures;
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
mod mission;
mod outputs;
mod overrides;
mod reference;
mod repl;
mod run;
mod setting;
mod situation;
mod status;
mod status_line;
mod test;
mod time;
mod trace;
mod why;
mod worlds;

use anyhow::Result;
use clap::{CommandFactory, Parser, Subcommand};
use console::Console;
use setting::Setting;
use status::Status;
use std::io;
use std::process::ExitCode;

/// Reactive plans, and a robot that carries them out
#[derive(Parser, Debug)]
#[command(name = "rpl", version)]
#[command(
    after_help = "Exit status: 0 success, 1 the plan or its scenario failed, 2 the text or the command line is wrong, \
                        3 --until was reached, 130 interrupted."
)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
    /// What `rpl` alone takes, which is the prompt.
    #[command(flatten, next_help_heading = "Options of the prompt, which starts without a command")]
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
    Check {
        /// Plan files
        #[arg(value_name = "FILE", required = true)]
        files: Vec<String>,
        /// The files are scenarios: plans with hands in the world
        #[arg(long)]
        scenario: bool,
    },
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
        #[arg(value_name = "NAME")]
        name: Option<String>,
    },
    /// Documents a name or a topic, searches for a word, or lists all names
    Doc {
        /// Whatever has a name in the language, the library or the robot, a command, a topic such as
        /// `behaviours`, or a word to search for
        #[arg(value_name = "NAME")]
        name: Option<String>,
    },
    /// Runs a plan with many seeds and makes a table
    Experiment(experiment::Arguments),
    /// Finds the robot in a recorded drive, and says how well
    Localize(Box<localize::Arguments>),
    /// Writes the completions of a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

fn main() -> ExitCode {
    interrupt::catch();
    let command = match CommandLine::try_parse() {
        Ok(CommandLine { command: Some(command), .. }) => command,
        Ok(CommandLine { prompt: setting, .. }) => Command::Repl(repl::Arguments { file: None, setting }),
        Err(error) => {
            // What cannot be written has nobody to read it.
            error.print().ok();
            return ExitCode::from(if error.use_stderr() { Status::Wrong } else { Status::Succeeded });
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
            console.note(&format!("error: {error:#}"));
            Status::Wrong.into()
        }
    }
}

fn dispatch(command: &Command, console: &mut Console) -> Result<Status> {
    match command {
        Command::Run(arguments) => run::run(arguments, console),
        Command::Repl(arguments) => repl::run(arguments, false, console),
        Command::Step(arguments) => repl::run(arguments, true, console),
        Command::Trace(arguments) => trace::run(arguments, console),
        Command::Check { files, scenario } => check::run(files, *scenario, console),
        Command::Test(arguments) => test::run(arguments, console),
        Command::Fmt(arguments) => fmt::run(arguments, console),
        Command::Eval(arguments) => eval::run(arguments, console),
        Command::Worlds(arguments) => worlds::run(arguments, console),
        Command::Examples { name } => examples::run(name.as_deref(), console),
        Command::Doc { name } => doc::run(name.as_deref(), console),
        Command::Experiment(arguments) => experiment::run(arguments, console),
        Command::Localize(arguments) => localize::run(arguments, console),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut CommandLine::command(), "rpl", &mut script);
            console.print(String::from_utf8_lossy(&script).trim_end())?;
            Ok(Status::Succeeded)
        }
    }
}

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
