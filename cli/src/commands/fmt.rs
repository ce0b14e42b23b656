//! `rpl fmt FILE...`: plan texts laid out as they should be.

use anyhow::{Result, anyhow};
use clap_complete::engine::ArgValueCompleter;
use rpl_lang::diagnostic::render;
use rpl_lang::formatter;
use rpl_lang::source::Sources;
use rpl_shell::arguments::{completion, plan_files};
use rpl_shell::files::inputs;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use similar::TextDiff;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Lines of a text that stand around each change in a diff.
const AROUND: usize = 3;

/// Format plans: indentation, spaces, and lines that are too long
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Plan files or folders with plans; `-` formats standard input to standard output
    #[arg(value_name = "FILE", required = true, add = ArgValueCompleter::new(completion::plan_files))]
    files: Vec<String>,
    /// Change nothing; list the files that are not formatted, with exit status 1
    #[arg(long, conflicts_with = "diff")]
    check: bool,
    /// Change nothing; show the changes as a unified diff, with exit status 1
    #[arg(long)]
    diff: bool,
}

/// What becomes of a text that is not formatted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Treatment {
    /// It is formatted.
    Make,
    /// Its name is told.
    List,
    /// The lines that would change are shown.
    Show,
}

/// Formats every file, or tells which ones it would change.
///
/// # Errors
/// Standard output is closed.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let change = match arguments {
        Arguments { check: true, .. } => Treatment::List,
        Arguments { diff: true, .. } => Treatment::Show,
        Arguments { .. } => Treatment::Make,
    };
    let mut status = Status::Succeeded;
    for name in plan_files::named(&arguments.files) {
        let outcome = match name {
            Ok(name) => format(&name, change, console)?,
            Err(reason) => {
                console.note(&format!("error: {reason}"));
                FileOutcome::Wrong
            }
        };
        // What is wrong with one file is no reason to leave the others.
        match outcome {
            FileOutcome::Clean => {}
            FileOutcome::Differs if status == Status::Succeeded => status = Status::Failed,
            FileOutcome::Differs => {}
            FileOutcome::Wrong => status = Status::Wrong,
        }
    }
    Ok(status)
}

/// What came of a file.
enum FileOutcome {
    /// It is formatted now, or was.
    Clean,
    /// It would be changed.
    Differs,
    /// It cannot be read or written.
    Wrong,
}

fn format(name: &str, change: Treatment, console: &mut Console) -> Result<FileOutcome> {
    let is_stdin = name == inputs::STANDARD_INPUT;
    let shown = if is_stdin { "<stdin>" } else { name };
    let text = match if is_stdin { inputs::standard_input() } else { read(name) } {
        Ok(text) => text,
        Err(error) => {
            console.note(&format!("error: {error:#}"));
            return Ok(FileOutcome::Wrong);
        }
    };
    let mut sources = Sources::default();
    let source = sources.add(shown, &text);
    let formatted = match formatter::format(&text, source) {
        Ok(formatted) => formatted,
        Err(faults) => {
            console.note(render(&faults, &sources, console.colour).trim_end());
            console.note(&format!("{shown}: left as it is"));
            return Ok(FileOutcome::Wrong);
        }
    };
    match change {
        Treatment::Make if is_stdin => console.print(formatted.trim_end_matches('\n'))?,
        Treatment::Make | Treatment::List | Treatment::Show if formatted == text => {}
        Treatment::List => {
            console.print(shown)?;
            return Ok(FileOutcome::Differs);
        }
        Treatment::Show => {
            console.print(diff(shown, &text, &formatted, console.out_colour()).trim_end_matches('\n'))?;
            return Ok(FileOutcome::Differs);
        }
        Treatment::Make => {
            if let Err(error) = replace(Path::new(name), &formatted) {
                console.note(&format!("error: cannot write `{name}`: {error}"));
                return Ok(FileOutcome::Wrong);
            }
            console.note(&format!("{name}: formatted"));
        }
    }
    Ok(FileOutcome::Clean)
}

/// What changes, in the unified form.
fn diff(name: &str, text: &str, formatted: &str, colour: bool) -> String {
    let diff = TextDiff::from_lines(text, formatted);
    let unified = diff.unified_diff().context_radius(AROUND).header(name, name).to_string();
    if !colour {
        return unified;
    }
    let painted = unified.split_inclusive('\n').map(|line| match (line.bytes().next(), line.trim_end_matches('\n')) {
        (Some(b'-'), bare) => format!("\u{1b}[31m{bare}\u{1b}[0m\n"),
        (Some(b'+'), bare) => format!("\u{1b}[32m{bare}\u{1b}[0m\n"),
        (Some(b'@'), bare) => format!("\u{1b}[36m{bare}\u{1b}[0m\n"),
        (Some(_) | None, _) => line.to_string(),
    });
    painted.collect()
}

fn read(name: &str) -> Result<String> {
    inputs::read_text(Path::new(name)).map_err(|reason| anyhow!("cannot read the plan `{name}`: {reason}"))
}

/// Puts a text in the place of a file: whoever reads it meanwhile, or after a crash, finds the old
/// text or the new one.
fn replace(path: &Path, text: &str) -> io::Result<()> {
    // A link stays one.
    let path = path.canonicalize()?;
    let permissions = path.metadata()?.permissions();
    if permissions.readonly() {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "it is write-protected"));
    }
    let beside = beside(&path);
    let written = write(&beside, text, permissions).and_then(|()| fs::rename(&beside, &path));
    written.inspect_err(|_| {
        // It may not even exist.
        fs::remove_file(&beside).ok();
    })
}

fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.{}.new", std::process::id()))
}

fn write(path: &Path, text: &str, permissions: fs::Permissions) -> io::Result<()> {
    let mut file = File::create_new(path)?;
    file.write_all(text.as_bytes())?;
    file.set_permissions(permissions)?;
    file.sync_all()
}
