//! The options of the example programs, and the command that they start.

use std::path::PathBuf;
use std::str::FromStr;

/// What stands behind an option on the command line.
pub fn option(name: &str) -> Option<String> {
    let arguments: Vec<String> = std::env::args().collect();
    let place = arguments.iter().position(|argument| argument == name)?;
    arguments.get(place + 1).cloned()
}

/// The number behind an option, and another one if there is none.
pub fn number<N: FromStr>(name: &str, default: N) -> N {
    option(name).and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Whether an option is there.
pub fn is_given(name: &str) -> bool {
    std::env::args().any(|argument| argument == name)
}

/// The command beside the examples – `target/release/rpl` for `target/release/examples/kills` – or that of `--command`.
pub fn command() -> Option<PathBuf> {
    let beside = || std::env::current_exe().ok()?.parent()?.parent().map(|folder| folder.join("rpl"));
    option("--command").map(PathBuf::from).or_else(beside)?.canonicalize().ok()
}
