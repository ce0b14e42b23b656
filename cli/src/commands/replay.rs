//! `rpl replay FILE`: a recorded run again, without the host or the processes that it had.

use crate::commands::run::{self, Output};
use anyhow::{Context, Result, anyhow, bail};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_drive::hosts;
use rpl_drive::journal::PastSession;
use rpl_drive::recorded_run::{RecordedRun, RecordedText, RunKind, Sameness};
use rpl_link::recording::Recording;
use rpl_prompt::{SessionStart, Until};
use rpl_shell::arguments::completion;
use rpl_shell::arguments::journal::JournalArguments;
use rpl_shell::files::module_files::ModuleVoices;
use rpl_shell::files::shown::Shown;
use rpl_shell::files::{inputs, plans};
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::path::PathBuf;

/// Replay a recorded run (`rpl run --record`) without its host and modules
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Recording
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub file: PathBuf,
    /// Run another plan instead of the recorded one, up to where it acts differently
    #[arg(long, value_name = "FILE", add = ArgValueCompleter::new(completion::plans))]
    pub plan: Option<String>,
    /// Start the prompt, with the plan stopped before its first form, or after everything that was typed: stepper,
    /// `:why` and `:back` work
    #[arg(long)]
    pub prompt: bool,
    #[command(flatten)]
    pub output: Output,
}

/// Repeats the run.
///
/// # Errors
/// The recording cannot be read, or what it belongs to is not there any more.
pub fn run(arguments: &Arguments, command_line: clap::Command, console: &mut Console) -> Result<Status> {
    let shown = arguments.file.shown();
    let text =
        inputs::read_text(&arguments.file).map_err(|why| anyhow!("cannot read the recording `{shown}`: {why}"))?;
    let recording: Recording<RecordedRun> =
        Recording::read(&text).with_context(|| format!("the recording `{shown}` cannot be read"))?;
    let source = hosts::recorded(&recording).with_context(|| format!("the recording `{shown}` cannot be read"))?;
    let voices = ModuleVoices::Recording(&recording.turns);
    let (recorded, typed) = (recording.run, recording.typed);
    let plan = arguments.plan.clone().or_else(|| recorded.plan.as_ref().map(|plan| plan.name.clone()));
    if plan.as_deref() == Some(inputs::STANDARD_INPUT) {
        bail!("the plan was read from standard input; name a file that has it with `--plan FILE`");
    }
    let text = plan.as_deref().map(plans::plan).transpose()?;
    if let (Some(name), Some(text), Some(then)) = (&plan, &text, &recorded.plan)
        && then.compare(&RecordedText::of(name, text)) == Sameness::Changed
        && !arguments.output.quiet
    {
        console.note(&format!("`{name}` is not the text that was recorded; it runs up to where it acts differently"));
    }
    let site = recorded.site()?;
    let is_session = recorded.kind != RunKind::Run;
    if arguments.prompt || is_session {
        let (built, world, _) = site.build(voices)?;
        let (robot, _) = source.robot(&built, site.seed(), hosts::Use::Session, None)?;
        let until = if recorded.kind == RunKind::Session { Until::End } else { Until::Step };
        let (seed, reads) = (site.seed(), arguments.prompt);
        let (past, interventions) = (PastSession::recorded(typed), Vec::new());
        let opening = SessionStart {
            world,
            robot,
            seed,
            plan: text,
            until,
            recorder: None,
            journal: None,
            past,
            interventions,
            reads,
            command_line,
        };
        return rpl_prompt::run(&built, opening, console);
    }
    let plan = plan.context("the recording has no plan; name one with `--plan FILE`")?;
    let run = run::Arguments {
        schedule: None,
        file: Some(plan),
        site,
        host: hosts::HostArguments::default(),
        cases: None,
        journal: JournalArguments::default(),
        set: recorded.set,
        until: recorded.until_us,
        realtime: None,
        max_steps: recorded.max_steps,
        output: arguments.output.clone(),
    };
    run::run_on(&run, source, voices, typed.first().map(|stopped| stopped.time_us), console)
}
