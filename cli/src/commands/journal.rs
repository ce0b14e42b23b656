//! `rpl journal DIR`: what is in a journal.

use crate::version::BUILD;
use anyhow::{Context, Result, bail};
use clap::ValueHint;
use rpl_drive::journal::{self, JournalEnd, KeptRun, LOG, OUTPUT, PastSession, checkpoint_times};
use rpl_link::journal::folder::taken_by;
use rpl_link::recording::Typed;
use rpl_shell::files::inputs;
use rpl_shell::files::shown::Shown;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::fs;
use std::path::{Path, PathBuf};

/// Columns of the words before what they are about.
const KEY_COLUMNS: usize = 12;

/// Show what is in a journal (`rpl run --journal`): the run, how far it has come, and its texts
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Folder of the journal
    #[arg(value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub journal: PathBuf,
    /// Print one of its texts to standard output: the plan, the scenario, or a file that they load
    #[arg(long, value_name = "NAME")]
    pub text: Option<String>,
}

/// Tells it.
///
/// # Errors
/// There is no journal, it is damaged, or it has no such text.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let path = &arguments.journal;
    let kept = KeptRun::read(path, BUILD)?;
    if let Some(name) = &arguments.text {
        let Some((_, text)) = kept.head.texts().find(|(known, _)| known == name) else {
            let names: Vec<&str> = kept.head.texts().map(|(name, _)| name).collect();
            bail!("the journal `{}` has no text `{name}`; it has {}", path.shown(), names.join(", "));
        };
        console.print(text.strip_suffix('\n').unwrap_or(text))?;
        return Ok(Status::Succeeded);
    }
    if kept.is_session() {
        return tell_session(path, &kept, console);
    }
    let mut lines = Vec::new();
    let mut tell = |key: &str, what: String| lines.push(format!("{key:KEY_COLUMNS$}{what}"));
    tell("run", described(&kept));
    tell("now", standing(path)?);
    for (time_us, bytes) in checkpoint_times(path, kept.checksum)? {
        tell("checkpoint", format!("at {:.1} s, {}", time_us as f64 / 1e6, size(bytes)));
    }
    tell("printed", length(&path.join(OUTPUT)));
    tell("told", length(&path.join(LOG)));
    let trace = journal::went_on(path)?.map_or_else(|| kept.head.trace.clone(), |how| how.trace);
    if let Some(trace) = &trace {
        tell("trace", format!("{}, {}", trace.shown(), length(trace)));
    }
    for (name, text) in kept.head.texts() {
        tell("text", format!("{name}, {}", size(text.len() as u64)));
    }
    for file in journal::changed_files(&kept, &journal::changes(path)?) {
        tell("changed", file.shown());
    }
    lines.iter().try_for_each(|line| console.explain_hanging(line, KEY_COLUMNS))?;
    Ok(Status::Succeeded)
}

/// A session at the prompt, and what was typed.
fn tell_session(path: &Path, kept: &KeptRun, console: &mut Console) -> Result<Status> {
    let past = PastSession::read(path)?;
    let taken = taken_by(path).with_context(|| format!("cannot read the journal `{}`", path.shown()))?;
    let now = match taken {
        Some(process) => format!("goes on: process {process} writes it"),
        None => format!("`rpl repl --journal {}` goes on with it", path.shown()),
    };
    let mut lines = vec![("session", described(kept)), ("now", now)];
    lines.extend(past.typed.iter().filter(|typed| !typed.typed.trim().is_empty()).map(|Typed { typed, time_us }| {
        ("typed", format!("at {:.1} s: {}", *time_us as f64 / 1e6, typed.lines().next().unwrap_or_default()))
    }));
    lines
        .iter()
        .try_for_each(|(key, what)| console.explain_hanging(&format!("{key:KEY_COLUMNS$}{what}"), KEY_COLUMNS))?;
    Ok(Status::Succeeded)
}

fn described(kept: &KeptRun) -> String {
    let run = &kept.head.run;
    let named = |option: &str, name: Option<&str>| name.map_or(String::new(), |name| format!(" --{option} {name}"));
    let world = named("world", run.world.as_ref().map(|world| &*world.name));
    let robot = named("robot", run.robot.as_ref().map(|robot| &*robot.name).filter(|name| !name.is_empty()));
    let scenario = named("scenario", run.scenario.as_ref().map(|scenario| &*scenario.name));
    let host = named("host", run.host.as_ref().map(|host| &*host.address));
    let modules: String = run.modules.iter().map(|module| named("module", Some(&module.name))).collect();
    format!(
        "{}{world}{robot}{scenario}{host}{modules} --seed {}",
        kept.head.plan.as_ref().map_or("", |plan| &plan.name),
        run.seed
    )
}

/// Whether it goes on, stands still or is over.
fn standing(path: &Path) -> Result<String> {
    let taken = taken_by(path).with_context(|| format!("cannot read the journal `{}`", path.shown()))?;
    if let Some(process) = taken {
        return Ok(format!("goes on: process {process} writes it"));
    }
    Ok(match JournalEnd::read(path)? {
        Some(end) => format!("it {}, at {:.1} s", end.how.told(), end.time_us as f64 / 1e6),
        None => format!("it was killed; `rpl resume {}` goes on with it", path.shown()),
    })
}

fn length(path: &Path) -> String {
    fs::metadata(path).map_or_else(|error| inputs::reason(&error), |known| size(known.len()))
}

fn size(bytes: u64) -> String {
    if bytes < 10_000 { format!("{bytes} bytes") } else { format!("{:.2} MB", bytes as f64 / 1e6) }
}
