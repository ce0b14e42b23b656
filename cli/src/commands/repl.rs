//! `rpl repl` and `rpl step`: the prompt, and the prompt that stands before the first form of a file.

use crate::arguments::completion;
use crate::arguments::duration::parse_duration_us;
use crate::arguments::overrides::Overrides;
use crate::arguments::site::SiteArguments;
use crate::files::inputs;
use crate::files::module_files::{GoingBack, ModuleVoices};
use crate::files::plans;
use crate::hosts::{HostArguments, Use};
use crate::journal::{self, KeptRun};
use crate::recorded_run::{RecordedRun, RecordedText, RunKind};
use crate::repl::{self, SessionStart, Until};
use crate::status::Status;
use crate::terminal::console::Console;
use anyhow::{Context, Result, bail};
use clap_complete::engine::ArgValueCompleter;
use std::path::Path;

/// Arguments of `rpl repl` and `rpl step`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// A plan file to begin with, or a built-in example; or the folder of a journal (`rpl run --journal`), whose
    /// run is repeated up to where it came
    #[arg(value_name = "FILE", add = ArgValueCompleter::new(completion::plans))]
    pub file: Option<String>,
    /// The time of a journal's run at which the prompt stands, such as 90s or 5min
    #[arg(long, value_name = "TIME", requires = "file", value_parser = parse_duration_us)]
    pub at: Option<u64>,
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
    if let Some(journal) = arguments.file.as_deref().map(Path::new).filter(|file| file.is_dir()) {
        return open_journal(journal, arguments, command_line, stops_at_start, console);
    }
    if arguments.at.is_some() {
        bail!("`--at` is a time in a journal, and there is none; `:until TIME` goes on to a time");
    }
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

/// The prompt in the run of a journal: before its first form, at a time, or where the run has come to. The journal
/// stays as it is.
fn open_journal(
    path: &Path,
    arguments: &Arguments,
    command_line: clap::Command,
    stops_at_start: bool,
    console: &mut Console,
) -> Result<Status> {
    let kept = KeptRun::read(path)?;
    if !journal::changes(path)?.is_empty() {
        bail!(
            "the run of `{}` has taken new definitions on the way, and cannot be repeated at the prompt",
            path.display()
        );
    }
    let until = match arguments.at {
        Some(time_us) => Until::Time(time_us),
        None if stops_at_start => Until::Step,
        None => Until::Time(journal::reached_us(path, &kept)?),
    };
    let (site, world) = kept.site()?;
    let mut overrides = Overrides::parse(&kept.head.run.set)?;
    let plan = kept.text_with(&kept.head.plan, |text| overrides.apply(text));
    let seed = kept.head.run.seed;
    let (robot, typed) = (site.robot(seed), Vec::new());
    let opening =
        SessionStart { world, robot, seed, plan: Some(plan), until, recorder: None, typed, reads: true, command_line };
    repl::run(&site, opening, console)
}
