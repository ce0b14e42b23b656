//! Completions: the shells ask the program itself, which knows its worlds, plans, experiments and
//! names. `rpl completions SHELL` writes what makes a shell ask.

mod words;

use crate::CommandLine;
use crate::examples;
use crate::experiment;
use crate::overrides;
use crate::reference::{Reference, TOPICS};
use anyhow::{Context, Result};
use clap::CommandFactory;
use clap::builder::StyledStr;
use clap_complete::Shell;
use clap_complete::engine::{CompletionCandidate, PathCompleter, ValueCompleter};
use clap_complete::env::{CompleteEnv, Elvish, Fish, Powershell, Shells, Zsh};
use rpl_robot::world::World;
use std::env;
use std::ffi::OsStr;
use std::path::Path;
use words::{Bash, Quoting};

/// A shell that asks says so in this variable.
const VARIABLE: &str = "RPL_COMPLETE";

const SHELLS: Shells<'static> = Shells(&[&Bash, &Quoting(Elvish), &Quoting(Fish), &Powershell, &Quoting(Zsh)]);

/// Answers a shell, and ends the program; returns if none has asked.
pub fn answer() {
    CompleteEnv::with_factory(CommandLine::command).var(VARIABLE).shells(SHELLS).complete();
}

/// What makes a shell ask.
///
/// # Errors
/// There is nothing for this shell.
pub fn script(shell: Shell) -> Result<String> {
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
    env::current_exe().map_or(called, |path| path.display().to_string())
}

type Candidates = Vec<CompletionCandidate>;

fn candidate(name: &str, purpose: &str) -> CompletionCandidate {
    let purpose = (!purpose.is_empty()).then(|| StyledStr::from(purpose.to_string()));
    CompletionCandidate::new(name).help(purpose)
}

/// Those that begin with what is typed.
fn beginning_with<'a>(typed: &OsStr, known: impl IntoIterator<Item = (&'a str, &'a str)>) -> Candidates {
    let typed = typed.to_string_lossy();
    let meant = known.into_iter().filter(|(name, _)| name.starts_with(typed.as_ref()));
    meant.map(|(name, purpose)| candidate(name, purpose)).collect()
}

/// Files with one of these extensions, and folders that may have some.
fn files(typed: &OsStr, extensions: &'static [&'static str]) -> Candidates {
    let is_wanted = move |path: &Path| {
        path.is_file() && path.extension().is_some_and(|found| extensions.iter().any(|wanted| found == *wanted))
    };
    PathCompleter::any().filter(is_wanted).complete(typed)
}

/// Worlds: built-in ones, and files.
pub fn worlds(typed: &OsStr) -> Candidates {
    let purposes: Vec<(&str, String)> =
        World::builtin_names().map(|name| (name, World::builtin_purpose(name).unwrap_or_default())).collect();
    let mut found = beginning_with(typed, purposes.iter().map(|(name, purpose)| (*name, purpose.as_str())));
    found.extend(files(typed, &["toml", "yaml", "yml"]));
    found
}

/// Maps of the ROS map_server.
pub fn maps(typed: &OsStr) -> Candidates {
    files(typed, &["yaml", "yml"])
}

/// Plans: files, and built-in examples that are no scenarios.
pub fn plans(typed: &OsStr) -> Candidates {
    let mut found = plan_files(typed);
    found.extend(beginning_with(typed, examples::all().filter(|(name, _)| !name.starts_with(SCENARIOS))));
    found
}

/// Plans that are files.
pub fn plan_files(typed: &OsStr) -> Candidates {
    files(typed, &["rpl"])
}

/// Built-in examples.
pub fn built_in(typed: &OsStr) -> Candidates {
    beginning_with(typed, examples::all())
}

const SCENARIOS: &str = "scenarios/";

/// Scenarios: files, and built-in ones, which need no folder.
pub fn scenarios(typed: &OsStr) -> Candidates {
    let mut found = plan_files(typed);
    let scenarios = examples::all().filter_map(|(name, purpose)| Some((name.strip_prefix(SCENARIOS)?, purpose)));
    found.extend(beginning_with(typed, scenarios));
    found.extend(beginning_with(typed, examples::all().filter(|(name, _)| name.starts_with("experiments/"))));
    found
}

/// Experiments with a name, and plans.
pub fn experiments(typed: &OsStr) -> Candidates {
    let mut found = beginning_with(typed, experiment::names().map(|(name, _)| (name, "an experiment")));
    found.extend(plans(typed));
    found
}

/// The rows of the experiment that stands in the line.
pub fn rows(typed: &OsStr) -> Candidates {
    let words: Vec<String> = env::args().skip_while(|word| word != "experiment").collect();
    let asked = experiment::names().filter(|(name, _)| words.iter().skip(1).any(|word| word == name));
    asked.flat_map(|(_, rows)| beginning_with(typed, rows.into_iter().map(|row| (row, "")))).collect()
}

/// Whatever `rpl doc` documents.
pub fn documented(typed: &OsStr) -> Candidates {
    let topics = TOPICS.iter().map(|topic| (topic.word, topic.title));
    // Without the library there is nothing to complete.
    let Ok(reference) = Reference::new() else { return beginning_with(typed, topics) };
    let commands = reference.entries().filter_map(|entry| Some((entry.name.strip_prefix("rpl ")?, entry.summary())));
    let names = reference.names().map(|entry| (entry.name.as_str(), entry.summary()));
    beginning_with(typed, topics.chain(commands).chain(names))
}

/// `NAME=` for the variables of the plan that stands in the line.
pub fn variables(typed: &OsStr) -> Candidates {
    // Nothing that would have to be waited for.
    let is_plan = |word: &String| Path::new(word).is_file() || examples::find(word).is_some();
    let plans = env::args().filter(is_plan).filter_map(|word| crate::files::plan(&word).ok());
    let names: Vec<String> =
        plans.flat_map(|plan| overrides::definitions(&plan.text)).map(|name| format!("{name}=")).collect();
    beginning_with(typed, names.iter().map(|name| (name.as_str(), "")))
}
