//! `rpl repl` and `rpl step`: the prompt, and the prompt that stands before the first form of a file.

use crate::version::BUILD;
use anyhow::{Context, Result, bail};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_drive::hosts::{self, HostArguments, Use};
use rpl_drive::journal::{self, KeptRun, KeptText, PastSession, SessionJournal, Writing};
use rpl_drive::recorded_run::{RecordedRun, RecordedText, RunKind};
use rpl_link::recording::RecordedTurns;
use rpl_prompt::{Intervention, SessionStart, Until};
use rpl_robot::world::World;
use rpl_shell::arguments::completion;
use rpl_shell::arguments::duration::parse_duration_us;
use rpl_shell::arguments::site::SiteArguments;
use rpl_shell::files::inputs;
use rpl_shell::files::module_files::{GoingBack, ModuleVoices};
use rpl_shell::files::overrides::Overrides;
use rpl_shell::files::plans::{self, PlanText};
use rpl_shell::files::project_file::Project;
use rpl_shell::files::shown::Shown;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::path::{Path, PathBuf};

/// Arguments of `rpl repl` and `rpl step`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Plan file or built-in example to begin with; or the folder of a journal (`rpl run --journal`), whose run
    /// is repeated up to its last instant
    #[arg(value_name = "FILE", add = ArgValueCompleter::new(completion::plans))]
    pub file: Option<String>,
    /// Record the session in this folder, so that it can be continued after a crash; if the folder has a session,
    /// continue it
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath, conflicts_with_all = ["record", "at"])]
    pub journal: Option<PathBuf>,
    /// Stop at this time of a journal's run, such as 90s or 5min
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
    if let Some(journal) = &arguments.journal {
        return with_journal(journal, arguments, command_line, stops_at_start, console);
    }
    let arguments = &in_project(arguments, stops_at_start, console)?;
    let source = arguments.host.reach(&arguments.site, arguments.file.as_deref().unwrap_or("a session"))?;
    let (site, world, modules) = arguments.site.build(ModuleVoices::Processes(GoingBack::Session))?;
    let plan = first_plan(arguments)?;
    let until = if stops_at_start { Until::Step } else { Until::End };
    let seed = arguments.site.seed();
    let recorder = arguments.host.record(&RecordedRun {
        host: source.heard(),
        ..recorded(arguments, plan.as_ref(), world.as_ref(), stops_at_start)?
    })?;
    modules.start(&site, seed, recorder.as_ref())?;
    let (robot, _) = source.robot(&site, seed, Use::Session, recorder.clone())?;
    let opening = SessionStart {
        world,
        robot,
        seed,
        plan,
        until,
        recorder: recorder.clone(),
        journal: None,
        past: PastSession::default(),
        interventions: Vec::new(),
        reads: true,
        command_line,
    };
    let status = rpl_prompt::run(&site, opening, console)?;
    if let Some(recorder) = recorder {
        recorder.finish().context("the recording cannot be written")?;
    }
    Ok(status)
}

/// The arguments, with what the project of the plan says, or, without a plan, that of the working folder. What they say
/// themselves holds. To step through a project is to step through its plan.
fn in_project(arguments: &Arguments, steps: bool, console: &mut Console) -> Result<Arguments> {
    let mut arguments = arguments.clone();
    let named = arguments.file.as_slice();
    let project = if named.is_empty() {
        Project::around_prompt(console)?
    } else {
        Project::of(named, ("repl", "plan"), console)?
    };
    let Some(project) = project else { return Ok(arguments) };
    arguments.file = match arguments.file.take() {
        None if steps => project.says.plan.clone(),
        None => None,
        named => Some(project.plan_or(named)?),
    };
    arguments.site.in_project(&project.says);
    if arguments.host.host.is_some() {
        arguments.site.scenario = None;
    }
    Ok(arguments)
}

/// The plan that the session begins with.
fn first_plan(arguments: &Arguments) -> Result<Option<PlanText>> {
    if arguments.file.as_deref() == Some(inputs::STANDARD_INPUT) {
        bail!("standard input is what the prompt reads; `rpl run -` runs a plan from there");
    }
    arguments.file.as_deref().map(plans::plan).transpose()
}

/// What is said of the session where it is written down.
fn recorded(
    arguments: &Arguments,
    plan: Option<&PlanText>,
    world: Option<&World>,
    stops_at_start: bool,
) -> Result<RecordedRun> {
    Ok(RecordedRun {
        kind: if stops_at_start { RunKind::Step } else { RunKind::Session },
        plan: arguments.file.as_deref().zip(plan).map(|(name, text)| RecordedText::of(name, text)),
        ..RecordedRun::at(&arguments.site, world)?
    })
}

/// A session that is written down while it goes on; or goes on with what was written down.
fn with_journal(
    path: &Path,
    arguments: &Arguments,
    command_line: clap::Command,
    stops_at_start: bool,
    console: &mut Console,
) -> Result<Status> {
    let shown = path.shown();
    if arguments.host.host.is_some() || !arguments.site.module.is_empty() {
        bail!("a session with a host or a module in another process has no journal; `--record FILE` writes it down");
    }
    if journal::is_there(path) {
        return go_on_with(path, arguments, command_line, console);
    }
    let mut arguments = in_project(arguments, stops_at_start, console)?;
    if !arguments.site.module.is_empty() {
        console
            .note("the modules of the project are left out: a session with a module in another process has no journal");
        arguments.site.module.clear();
    }
    let arguments = &arguments;
    let (site, world, _) = arguments.site.build(ModuleVoices::Processes(GoingBack::Session))?;
    let plan = first_plan(arguments)?;
    let recorded = recorded(arguments, plan.as_ref(), world.as_ref(), stops_at_start)?;
    let kept =
        KeptRun::new(BUILD, recorded, plan.as_ref().map(KeptText::of), &site, world.as_ref(), Writing::default())?;
    let journal = SessionJournal::begin(path, &kept)?;
    let opening = SessionStart {
        robot: site.robot(arguments.site.seed()),
        world,
        seed: arguments.site.seed(),
        plan,
        until: if stops_at_start { Until::Step } else { Until::End },
        recorder: None,
        journal: Some(journal),
        past: PastSession::default(),
        interventions: Vec::new(),
        reads: true,
        command_line,
    };
    console.note(&format!("what is typed is written to `{shown}`; `rpl repl --journal {shown}` goes on with it"));
    rpl_prompt::run(&site, opening, console)
}

/// The prompt stands where the session of a journal stood, and goes on.
fn go_on_with(
    path: &Path,
    arguments: &Arguments,
    command_line: clap::Command,
    console: &mut Console,
) -> Result<Status> {
    let kept = KeptRun::read(path, BUILD)?;
    journal::refuse_run(path, &kept)?;
    let then = kept.head.run.plan.as_ref().map(|plan| &plan.name);
    let world = kept.head.run.world.as_ref().map(|world| &world.name);
    let is_other = |asked: &Option<String>, known: Option<&String>| asked.is_some() && asked.as_ref() != known;
    if is_other(&arguments.file, then) || is_other(&arguments.site.world, world) {
        let shown = path.shown();
        bail!("`{shown}` is the journal of another session; `rpl journal {shown}` tells which, or name another folder");
    }
    let (journal, past) = SessionJournal::go_on(path)?;
    session_of(&kept, past, Some(journal), command_line, console)
}

/// The session of a journal, repeated; with the journal itself it goes on.
fn session_of(
    kept: &KeptRun,
    past: PastSession,
    journal: Option<SessionJournal>,
    command_line: clap::Command,
    console: &mut Console,
) -> Result<Status> {
    if kept.head.has_outside() {
        bail!(
            "the journal is no session's: it names modules or a host in other processes, and a session with a journal has none"
        );
    }
    let (site, world, _) = kept.site(ModuleVoices::Processes(GoingBack::Session))?;
    let seed = kept.head.run.seed;
    let loads = past.loads_at(0);
    let opening = SessionStart {
        world,
        robot: site.robot(seed),
        seed,
        plan: kept.head.plan.as_ref().map(|plan| kept.text_loading(plan, loads)),
        until: if kept.head.run.kind == RunKind::Step { Until::Step } else { Until::End },
        recorder: None,
        journal,
        past,
        interventions: Vec::new(),
        reads: true,
        command_line,
    };
    rpl_prompt::run(&site, opening, console)
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
    let kept = KeptRun::read(path, BUILD)?;
    let Some(plan) = kept.head.plan.as_ref().filter(|_| !kept.is_session()) else {
        return session_of(&kept, PastSession::read(path)?, None, command_line, console);
    };
    let changes = journal::changes(path)?;
    let past = if kept.head.has_outside() { Some(journal::inputs_from_start(path)?) } else { None };
    let resumed_at = past.as_ref().map_or(Vec::new(), |past| past.resumed_at.clone());
    let mut interventions: Vec<Intervention> = resumed_at.into_iter().map(Intervention::Resumption).collect();
    interventions.extend(changes.into_iter().map(Intervention::Change));
    // Where both came at the end of one instant, the run was gone on with first.
    interventions.sort_by_key(|come| come.instant().unwrap_or(u32::MAX));
    let reached_us = past.as_ref().and_then(|past| past.reached_us).unwrap_or(journal::reached_us(path, &kept)?);
    let turns = RecordedTurns::of_journal(past.map_or(Vec::new(), |past| past.turns))
        .with_context(|| format!("what came from outside in the journal `{}` cannot be read", path.shown()))?;
    let until = match arguments.at {
        Some(time_us) => Until::Time(time_us),
        None if stops_at_start => Until::Step,
        None => Until::Time(reached_us),
    };
    let (site, world, _) = kept.site(ModuleVoices::Recording(&turns))?;
    let mut overrides = Overrides::parse(&kept.head.run.set)?;
    let plan = kept.text_with(plan, |text| overrides.apply(text));
    let seed = kept.head.run.seed;
    let (robot, _) = hosts::heard(kept.head.run.host.as_ref(), &turns)?.robot(&site, seed, Use::Session, None)?;
    let opening = SessionStart {
        world,
        robot,
        seed,
        plan: Some(plan),
        until,
        recorder: None,
        journal: None,
        past: PastSession::default(),
        interventions,
        reads: true,
        command_line,
    };
    rpl_prompt::run(&site, opening, console)
}
