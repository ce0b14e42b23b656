//! `rpl repl` and `rpl step`: the prompt, and the prompt that stands before the first form of a file.

use crate::arguments::completion;
use crate::arguments::site::SiteArguments;
use crate::files::inputs;
use crate::files::module_files::{GoingBack, ModuleVoices};
use crate::files::plans;
use crate::hosts::{HostArguments, Use};
use crate::recorded_run::{RecordedRun, RecordedText, RunKind};
use crate::repl::{self, SessionStart, Until};
use crate::status::Status;
use crate::terminal::console::Console;
use anyhow::{Context, Result, bail};
use clap_complete::engine::ArgValueCompleter;

/// Arguments of `rpl repl` and `rpl step`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// A plan file to begin with, or a built-in example
    #[arg(value_name = "FILE", add = ArgValueCompleter::new(completion::plans))]
    pub file: Option<String>,
    #[command(flatten)]
    pub site: SiteArguments,
    #[command(flatten)]
    pub host: HostArguments,
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
    let source = arguments.host.reach(&arguments.site)?;
    let (site, world, modules) = arguments.site.build(ModuleVoices::Processes(GoingBack::Session))?;
    if arguments.file.as_deref() == Some(inputs::STANDARD_INPUT) {
        bail!("standard input is what the prompt reads; `rpl run -` runs a plan from there");
    }
    let plan = arguments.file.as_deref().map(plans::plan).transpose()?;
    let until = if stops_at_start { Until::Step } else { Until::End };
    let seed = arguments.site.seed;
    let recorder = arguments.host.record(&RecordedRun {
        kind: if stops_at_start { RunKind::Step } else { RunKind::Session },
        plan: arguments.file.as_deref().zip(plan.as_ref()).map(|(name, text)| RecordedText::of(name, text)),
        host: source.heard(),
        ..RecordedRun::at(&arguments.site, world.as_ref())?
    })?;
    modules.start(&site, seed, recorder.as_ref())?;
    let (robot, _) = source.robot(&site, seed, Use::Session, recorder.clone())?;
    let typed = Vec::new();
    let opening =
        SessionStart { world, robot, seed, plan, until, recorder: recorder.clone(), typed, reads: true, command_line };
    let status = repl::run(&site, opening, console)?;
    if let Some(recorder) = recorder {
        recorder.finish().context("the recording cannot be written")?;
    }
    Ok(status)
}
