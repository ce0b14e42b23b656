//! Journals that somebody else may have written: going on with one starts what it names, and writes where it says.

use super::head::{KeptRun, RUN};
use anyhow::{Context, Result, bail};
use rpl_shell::files::foreign::why_foreign;
use rpl_shell::files::shown::Shown;
use rpl_shell::terminal::console::Console;
use std::io::{self, IsTerminal};
use std::path::Path;

/// Asks whether a run is to go on although its journal may be somebody else's, unless that was said before. Where nobody
/// can be asked, it does not.
///
/// # Errors
/// It is not to.
pub fn ask(journal: &Path, kept: &KeptRun, is_wanted: bool, console: &mut Console) -> Result<()> {
    let shown = journal.shown();
    let why = why_foreign(&journal.join(RUN)).with_context(|| format!("cannot look at the journal `{shown}`"))?;
    let Some(why) = why.filter(|_| !is_wanted) else { return Ok(()) };
    let told = format!("the journal `{shown}` may not be yours: {why}; {}", effects(kept));
    if !io::stdin().is_terminal() || !io::stderr().is_terminal() {
        bail!("{told}; `rpl resume {shown} --foreign` goes on with it all the same");
    }
    console.note(&format!("{told}\nis it to go on? (y/n)"));
    let mut answer = String::new();
    io::stdin().read_line(&mut answer).context("the answer cannot be read")?;
    match answer.trim() {
        "y" | "yes" => Ok(()),
        _ => bail!("the run does not go on"),
    }
}

/// What going on with a run does beside computing, as a clause.
fn effects(kept: &KeptRun) -> String {
    let modules = kept.head.modules.iter().map(|path| format!("starts the module `{}`", path.shown()));
    let host = kept.head.run.host.iter().map(|host| format!("commands the robot at {}", host.address));
    let trace = kept.head.trace.iter().map(|path| format!("writes the trace `{}`", path.shown()));
    let effects: Vec<String> = modules.chain(host).chain(trace).collect();
    if effects.is_empty() {
        "its run writes its folder alone".to_string()
    } else {
        format!("its run {}", effects.join(", "))
    }
}
