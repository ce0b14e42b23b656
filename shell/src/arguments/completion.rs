//! What a shell completes on the command line: worlds, plans and names, each where
//! it fits.

use crate::files::overrides;
use crate::files::{plans, world_files};
use clap::builder::StyledStr;
use clap_complete::engine::{CompletionCandidate, PathCompleter, ValueCompleter};
use rpl_mission::examples;
use rpl_robot::description::RobotDescription;
use std::env;
use std::ffi::OsStr;
use std::path::Path;

/// What a shell is offered.
pub type Offers = Vec<CompletionCandidate>;

fn candidate(name: &str, purpose: &str) -> CompletionCandidate {
    let purpose = (!purpose.is_empty()).then(|| StyledStr::from(purpose.to_string()));
    CompletionCandidate::new(name).help(purpose)
}

/// Those that begin with what is typed.
pub fn beginning_with<'a>(typed: &OsStr, known: impl IntoIterator<Item = (&'a str, &'a str)>) -> Offers {
    let typed = typed.to_string_lossy();
    let meant = known.into_iter().filter(|(name, _)| name.starts_with(typed.as_ref()));
    meant.map(|(name, purpose)| candidate(name, purpose)).collect()
}

/// Files with one of these extensions, and folders that may have some.
fn files(typed: &OsStr, extensions: &'static [&'static str]) -> Offers {
    let is_wanted = move |path: &Path| {
        path.is_file() && path.extension().is_some_and(|found| extensions.iter().any(|wanted| found == *wanted))
    };
    PathCompleter::any().filter(is_wanted).complete(typed)
}

/// Worlds: built-in ones, and files.
pub fn worlds(typed: &OsStr) -> Offers {
    let purposes: Vec<_> = world_files::names().collect();
    let mut found = beginning_with(typed, purposes.iter().map(|(name, purpose)| (*name, purpose.as_ref())));
    found.extend(files(typed, &["toml", "yaml", "yml"]));
    found
}

/// Robots: built-in ones, and files.
pub fn robots(typed: &OsStr) -> Offers {
    let robots: Vec<_> = RobotDescription::builtin_names().filter_map(RobotDescription::builtin).collect();
    let mut found = beginning_with(typed, robots.iter().map(|robot| (&*robot.name, &*robot.purpose)));
    found.extend(files(typed, &["toml"]));
    found
}

/// Maps of the ROS map_server.
pub fn maps(typed: &OsStr) -> Offers {
    files(typed, &["yaml", "yml"])
}

/// Plans: files, and built-in examples that are no scenarios.
pub fn plans(typed: &OsStr) -> Offers {
    let mut found = plan_files(typed);
    found.extend(beginning_with(typed, examples::all().filter(|(name, _)| !name.starts_with(SCENARIOS))));
    found
}

/// Plans that are files.
pub fn plan_files(typed: &OsStr) -> Offers {
    files(typed, &["rpl"])
}

/// Built-in examples.
pub fn built_in(typed: &OsStr) -> Offers {
    beginning_with(typed, examples::all())
}

const SCENARIOS: &str = "scenarios/";

/// Scenarios: files, and built-in ones, which need no folder.
pub fn scenarios(typed: &OsStr) -> Offers {
    let mut found = plan_files(typed);
    let scenarios = examples::all().filter_map(|(name, purpose)| Some((name.strip_prefix(SCENARIOS)?, purpose)));
    found.extend(beginning_with(typed, scenarios));
    found.extend(beginning_with(typed, examples::all().filter(|(name, _)| name.starts_with("experiments/"))));
    found
}

/// `NAME=` for the variables of the plan that stands in the line.
pub fn variables(typed: &OsStr) -> Offers {
    // Nothing that would have to be waited for.
    let is_plan = |word: &String| Path::new(word).is_file() || examples::find(word).is_some();
    let plans = env::args().filter(is_plan).filter_map(|word| plans::plan(&word).ok());
    let names: Vec<String> =
        plans.flat_map(|plan| overrides::definitions(&plan.text)).map(|name| format!("{name}=")).collect();
    beginning_with(typed, names.iter().map(|name| (name.as_str(), "")))
}
