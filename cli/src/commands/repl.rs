//! `rpl repl` and `rpl step`: the prompt, and the prompt that stands before the first form of a file.

use crate::arguments::completion;
use crate::arguments::site::SiteArguments;
use crate::files::inputs;
use crate::files::plans;
use crate::repl::{self, SessionStart, Until};
use crate::status::Status;
use crate::terminal::console::Console;
use anyhow::{Result, bail};
use clap_complete::engine::ArgValueCompleter;

/// Arguments of `rpl repl` and `rpl step`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// A plan file to begin with, or a built-in example
    #[arg(value_name = "FILE", add = ArgValueCompleter::new(completion::plans))]
    pub file: Option<String>,
    #[command(flatten)]
    pub site: SiteArguments,
}

/// Runs a session, which documents the commands of this command line too. With `stops_at_start` the
/// file is loaded and stands before its first form.
///
/// # Errors
/// The command line is wrong, or standard output is closed.
pub fn run(
    arguments: &Arguments,
    command_line: clap::Command,
    stops_at_start: bool,
    console: &mut Console,
) -> Result<Status> {
    let (site, world) = arguments.site.build()?;
    if arguments.file.as_deref() == Some(inputs::STANDARD_INPUT) {
        bail!("standard input is what the prompt reads; `rpl run -` runs a plan from there");
    }
    let plan = arguments.file.as_deref().map(plans::plan).transpose()?;
    let until = if stops_at_start { Until::Step } else { Until::End };
    repl::run(&site, SessionStart { world, seed: arguments.site.seed, plan, until, command_line }, console)
}
