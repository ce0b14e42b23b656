//! `rpl fmt FILE...`: plan texts laid out as they should be.

use crate::console::Console;
use crate::files;
use crate::status::Status;
use anyhow::{Result, anyhow};
use rpl_lang::diagnostic::render;
use rpl_lang::formatter;
use rpl_lang::source::Sources;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Arguments of `rpl fmt`.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Plan files; `-` for standard input, which is written to standard output
    #[arg(value_name = "FILE", required = true)]
    pub files: Vec<String>,
    /// Changes nothing: lists the files that are not formatted, with exit status 1
    #[arg(long)]
    pub check: bool,
}

/// Formats every file, or tells which ones it would change.
///
/// # Errors
/// Standard output is closed.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let mut status = Status::Succeeded;
    for name in &arguments.files {
        // What is wrong with one file is no reason to leave the others.
        match format(name, arguments.check, console)? {
            Outcome::Clean => {}
            Outcome::Differs if status == Status::Succeeded => status = Status::Failed,
            Outcome::Differs => {}
            Outcome::Wrong => status = Status::Wrong,
        }
    }
    Ok(status)
}

/// What came of a file.
enum Outcome {
    /// It is formatted now, or was.
    Clean,
    /// It would be changed.
    Differs,
    /// It cannot be read or written.
    Wrong,
}

fn format(name: &str, only_check: bool, console: &mut Console) -> Result<Outcome> {
    let is_stdin = name == "-";
    let shown = if is_stdin { "<stdin>" } else { name };
    let text = match if is_stdin { files::standard_input() } else { read(name) } {
        Ok(text) => text,
        Err(error) => {
            console.note(&format!("error: {error:#}"));
            return Ok(Outcome::Wrong);
        }
    };
    let mut sources = Sources::default();
    let source = sources.add(shown, &text);
    let formatted = match formatter::format(&text, source) {
        Ok(formatted) => formatted,
        Err(faults) => {
            console.note(render(&faults, &sources, console.colour).trim_end());
            console.note(&format!("{shown}: left as it is"));
            return Ok(Outcome::Wrong);
        }
    };
    if only_check {
        return match formatted == text {
            true => Ok(Outcome::Clean),
            false => console.print(shown).map(|()| Outcome::Differs).map_err(Into::into),
        };
    }
    if is_stdin {
        console.print(formatted.trim_end_matches('\n'))?;
    } else if formatted != text {
        if let Err(error) = replace(Path::new(name), &formatted) {
            console.note(&format!("error: cannot write `{name}`: {error}"));
            return Ok(Outcome::Wrong);
        }
        console.note(&format!("{name}: formatted"));
    }
    Ok(Outcome::Clean)
}

fn read(name: &str) -> Result<String> {
    files::read_text(Path::new(name)).map_err(|reason| anyhow!("cannot read the plan `{name}`: {reason}"))
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
