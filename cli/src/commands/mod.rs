//! The subcommands, one file each: its arguments with their help, and what it does. Another one is such
//! a file, and a line here in each of three places.

pub mod cases;
pub mod check;
pub mod completions;
pub mod dap;
pub mod doc;
pub mod eval;
pub mod examples;
pub mod experiment;
pub mod explain;
pub mod explore;
pub mod fmt;
pub mod journal;
pub mod localize;
pub mod lsp;
pub mod man;
pub mod new;
pub mod project;
pub mod repl;
pub mod replay;
pub mod resume;
pub mod robots;
pub mod run;
pub mod simulate;
pub mod test;
pub mod trace;
pub mod view;
pub mod worlds;

use crate::version::VERSION;
use anyhow::Result;
use clap::error::{ContextKind, ContextValue};
use clap::{ColorChoice, CommandFactory, Parser, Subcommand};
use rpl_lang::suggest::suggest;
use rpl_lang::visible::shortened;
use rpl_shell::arguments::site::SiteArguments;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use rpl_shell::terminal::layout;
use std::error::Error as _;

/// Run, check and debug robot plans
#[derive(Parser, Debug)]
#[command(name = "rpl", version = VERSION, max_term_width = layout::HELP_COLUMNS)]
#[command(
    after_help = "Exit status: 0 success, 1 the plan or its scenario failed, 2 the text or the command line is wrong, \
                        3 --until was reached, 130 interrupted."
)]
pub struct CommandLine {
    #[command(subcommand)]
    /// The subcommand; none is the prompt.
    pub command: Option<Command>,
    /// When to use colours: `auto`, `always` or `never`
    #[arg(long, global = true, value_name = "WHEN", default_value_t = ColorChoice::Auto, hide_possible_values = true)]
    pub color: ColorChoice,
    /// What `rpl` alone takes, which is the prompt.
    #[command(flatten, next_help_heading = "Options of the prompt (`rpl` alone)")]
    pub prompt: SiteArguments,
}

/// What `rpl` can be asked for.
#[derive(Subcommand, Debug)]
pub enum Command {
    Run(Box<run::Arguments>),
    /// Start the prompt, which reads forms and runs them; `rpl` alone does the same
    Repl(repl::Arguments),
    /// Start the prompt and stop before the first form of a file
    Step(repl::Arguments),
    Resume(resume::Arguments),
    Journal(journal::Arguments),
    Project(Box<project::Arguments>),
    Replay(Box<replay::Arguments>),
    Simulate(simulate::Arguments),
    Trace(trace::Arguments),
    New(new::Arguments),
    Explain(explain::Arguments),
    Explore(explore::Arguments),
    View(view::Arguments),
    Check(check::Arguments),
    Test(test::Arguments),
    Fmt(fmt::Arguments),
    Eval(eval::Arguments),
    Lsp(lsp::Arguments),
    Dap(dap::Arguments),
    Worlds(worlds::Arguments),
    Robots(robots::Arguments),
    Cases(cases::Arguments),
    Examples(examples::Arguments),
    Doc(doc::Arguments),
    Experiment(experiment::Arguments),
    Localize(Box<localize::Arguments>),
    Completions(completions::Arguments),
    Man(man::Arguments),
}

impl Command {
    /// Does what is asked for.
    ///
    /// # Errors
    /// What each of them says; or standard output is closed.
    pub fn run(&self, console: &mut Console) -> Result<Status> {
        match self {
            Command::Run(arguments) => run::run(arguments, console),
            Command::Repl(arguments) => repl::run(arguments, CommandLine::command(), false, console),
            Command::Step(arguments) => repl::run(arguments, CommandLine::command(), true, console),
            Command::Journal(arguments) => journal::run(arguments, console),
            Command::Resume(arguments) => resume::run(arguments, console),
            Command::Project(arguments) => project::run(arguments, console),
            Command::Replay(arguments) => replay::run(arguments, CommandLine::command(), console),
            Command::Simulate(arguments) => simulate::run(arguments, console),
            Command::Trace(arguments) => trace::run(arguments, console),
            Command::Explain(arguments) => explain::run(arguments, console),
            Command::Explore(arguments) => explore::run(arguments, console),
            Command::New(arguments) => new::run(arguments, console),
            Command::View(arguments) => view::run(arguments, CommandLine::command(), console),
            Command::Check(arguments) => check::run(arguments, console),
            Command::Test(arguments) => test::run(arguments, console),
            Command::Fmt(arguments) => fmt::run(arguments, console),
            Command::Eval(arguments) => eval::run(arguments, console),
            Command::Lsp(arguments) => lsp::run(arguments),
            Command::Dap(arguments) => dap::run(arguments),
            Command::Worlds(arguments) => worlds::run(arguments, console),
            Command::Robots(arguments) => robots::run(arguments, console),
            Command::Cases(arguments) => cases::run(arguments, console),
            Command::Examples(arguments) => examples::run(arguments, console),
            Command::Doc(arguments) => doc::run(arguments, console),
            Command::Experiment(arguments) => experiment::run(arguments, console),
            Command::Localize(arguments) => localize::run(arguments, console),
            Command::Completions(arguments) => completions::run(arguments, console),
            Command::Man(arguments) => man::run(arguments, CommandLine::command(), console),
        }
    }
}

/// The error with the command that was probably meant. In a word of three letters clap takes an
/// exchange of two for another word.
pub fn with_suggestion(mut error: clap::Error) -> clap::Error {
    if error.kind() == clap::error::ErrorKind::UnknownArgument {
        // That what looks like an option may be a value helps nobody who has misspelt one.
        error.remove(ContextKind::Suggested);
        if let Some(meant) = option_meant(&error) {
            error.insert(ContextKind::SuggestedArg, ContextValue::String(meant.to_string()));
        } else if let Some(advice) = option_of_another(&error) {
            error.remove(ContextKind::SuggestedArg);
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![advice.into()]));
        }
        return error;
    }
    if error.kind() == clap::error::ErrorKind::ValueValidation
        && error.source().is_some_and(|source| source.is::<std::num::ParseIntError>())
    {
        let said = |kind| error.get(kind).map(ContextValue::to_string).unwrap_or_default();
        let (option, value) = (said(ContextKind::InvalidArg), said(ContextKind::InvalidValue));
        let message = format!("`{}` is no value of `{option}`: write a whole number, such as 7\n", shortened(&value));
        return clap::Error::raw(clap::error::ErrorKind::ValueValidation, message);
    }
    let is_known = error.get(ContextKind::SuggestedSubcommand).is_some();
    let typed = match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(typed)) if !is_known || typed.ends_with(".rpl") => typed.clone(),
        Some(_) | None => return error,
    };
    if typed.ends_with(".rpl") {
        error.remove(ContextKind::SuggestedSubcommand);
        let advice = format!("to run a plan write `rpl run {typed}`");
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![advice.into()]));
        return error;
    }
    let commands = CommandLine::command();
    if let Some(meant) = suggest(&typed, commands.get_subcommands().map(clap::Command::get_name)) {
        error.insert(ContextKind::SuggestedSubcommand, ContextValue::Strings(vec![meant.to_string()]));
    }
    error
}

/// Options that other programs have, and what they are called here.
const FOREIGN_OPTIONS: &[(&[&str], &str)] = &[
    (&["--time", "--duration", "--max-time", "--timeout", "--limit"], "--until"),
    (&["--output", "--out", "--log"], "--trace"),
    (&["--gui", "--view", "--show", "--visualize", "--web", "--display"], "--live"),
    (&["--map", "--env", "--environment", "--building"], "--world"),
    (&["--param", "--define", "--arg"], "--set"),
    (&["--repeat", "--trials", "--count", "--n", "--seeds"], "--runs"),
    (&["--random-seed", "--rng"], "--seed"),
];

/// What an unknown option is called here, if other programs have it.
fn foreign_option(typed: &str) -> Option<&'static str> {
    FOREIGN_OPTIONS.iter().find(|(names, _)| names.contains(&typed)).map(|&(_, meant)| meant)
}

/// The subcommand that an error is about.
fn command_of(error: &clap::Error, commands: &clap::Command) -> Option<clap::Command> {
    let usage = error.get(ContextKind::Usage)?.to_string();
    let command = usage.split_whitespace().skip_while(|&word| word != "rpl").nth(1)?;
    commands.find_subcommand(command).cloned()
}

fn has_option(command: &clap::Command, option: &str) -> bool {
    command.get_arguments().any(|argument| argument.get_long() == option.strip_prefix("--"))
}

/// The commands that an option is looked for in, the usual ones first.
const COMMON_COMMANDS: &[&str] = &["run", "experiment", "test", "check", "trace", "repl", "resume", "replay"];

/// The option that was probably meant by one that other programs have, if the command has it.
fn option_meant(error: &clap::Error) -> Option<&'static str> {
    let meant = foreign_option(&error.get(ContextKind::InvalidArg)?.to_string())?;
    let command = command_of(error, &CommandLine::command())?;
    has_option(&command, meant).then_some(meant)
}

/// Advice on an option that only other subcommands have.
fn option_of_another(error: &clap::Error) -> Option<String> {
    let typed = error.get(ContextKind::InvalidArg)?.to_string();
    let typed = typed.split(['=', ' ']).next()?;
    let commands = CommandLine::command();
    let command = command_of(error, &commands)?;
    let option = foreign_option(typed).unwrap_or(typed);
    if command.get_name() == "test" && option == "--scenario" {
        return Some("a test names its scenario itself: `(deftest NAME :scenario \"FILE\" FORM...)`".into());
    }
    let has = |name: &&str| commands.find_subcommand(name).is_some_and(|other| has_option(other, option));
    let other = COMMON_COMMANDS.iter().copied().filter(|name| *name != command.get_name()).find(has)?;
    Some(format!("`rpl {other}` has `{option}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is said of a command line that is wrong.
    fn told(words: &[&str]) -> String {
        match CommandLine::try_parse_from(words) {
            Ok(_) => panic!("{words:?} is right"),
            Err(error) => with_suggestion(error).to_string(),
        }
    }

    #[test]
    fn options_of_other_programs_are_told_by_what_they_are_called_here() {
        assert!(told(&["rpl", "run", "p.rpl", "--world", "dept", "--time", "60"]).contains("'--until'"));
        assert!(told(&["rpl", "run", "p.rpl", "--output", "x"]).contains("'--trace'"));
        let fmt = told(&["rpl", "fmt", "p.rpl", "--time", "60"]);
        assert!(!fmt.contains("'--until'") && fmt.contains("`rpl run` has `--until`"), "{fmt}");
        assert!(told(&["rpl", "run", "p.rpl", "--gui"]).contains("'--live'"), "`--grid` is only near");
        let seeds = told(&["rpl", "run", "p.rpl", "--seeds", "5"]);
        assert!(seeds.contains("`rpl experiment` has `--runs`") && !seeds.contains("'--seed'"), "{seeds}");
        let scenario = told(&["rpl", "test", "p.rpl", "--scenario", "s.rpl"]);
        assert!(scenario.contains("(deftest NAME :scenario \"FILE\""), "{scenario}");
        assert!(told(&["rpl", "run", "p.rpl", "--wrld", "dept"]).contains("'--world'"));
    }

    #[test]
    fn a_number_that_is_none_is_told_in_plain_words() {
        let told = told(&["rpl", "run", "p.rpl", "--seed", "abc"]);
        assert!(told.contains("`abc` is no value of `--seed <N>`: write a whole number"), "{told}");
    }

    #[test]
    fn the_command_line_is_consistent() {
        CommandLine::command().debug_assert();
    }
}
