//! A text in the user's own editor.

use rpl_shell::files::inputs;
use rpl_shell::files::shown::Shown;
use rpl_shell::interrupt;
use std::fs::OpenOptions;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What edits where nobody has said what does.
const USUAL_EDITOR: &str = "vi";

/// The text as it comes back from the editor that `VISUAL` or `EDITOR` names, which has the terminal
/// meanwhile if there is one.
///
/// # Errors
/// Why it does not come back; one sentence with what to do.
pub fn edited(text: &str, has_terminal: bool) -> Result<String, String> {
    let file = new_file(text)?;
    let ended = run_editor(&file, has_terminal);
    // Ctrl-C in the editor was meant for the editor.
    interrupt::forget();
    let result = ended.and_then(|()| {
        inputs::read_text(&file).map_err(|reason| format!("what the editor left cannot be read: {reason}"))
    });
    // Where it cannot be taken away it does no harm.
    std::fs::remove_file(&file).ok();
    result
}

fn editor() -> String {
    let named = ["VISUAL", "EDITOR"].into_iter().filter_map(|name| std::env::var(name).ok());
    named.into_iter().find(|editor| !editor.trim().is_empty()).unwrap_or_else(|| USUAL_EDITOR.to_string())
}

fn run_editor(file: &Path, has_terminal: bool) -> Result<(), String> {
    let editor = editor();
    // By the shell, as others do: the variable may hold options and quotes.
    let mut command = Command::new("sh");
    command.arg("-c").arg(format!("{editor} \"$@\"")).arg(&editor).arg(file);
    if !has_terminal {
        command.stdin(Stdio::null());
    }
    let _is_for_editor = interrupt::is_for_another();
    let status = command.status().map_err(|error| format!("the editor `{editor}` cannot be started: {error}"))?;
    match status.code() {
        Some(0) => Ok(()),
        Some(127) => Err(format!("there is no editor `{editor}`; set the variable EDITOR to yours. Nothing is run")),
        Some(code) => Err(format!("the editor `{editor}` ended with status {code}; nothing is run")),
        None => Err(format!("the editor `{editor}` was killed; nothing is run")),
    }
}

/// A file with the text that nobody else has.
fn new_file(text: &str) -> Result<PathBuf, String> {
    let folder = std::env::temp_dir();
    let failed = |error: std::io::Error| format!("no file can be written in `{}`: {error}", folder.shown());
    for number in 0.. {
        let path = folder.join(format!("rpl-{}-{number}.rpl", std::process::id()));
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(mut file) => {
                let line_end = if text.is_empty() || text.ends_with('\n') { "" } else { "\n" };
                file.write_all(text.as_bytes()).and_then(|()| file.write_all(line_end.as_bytes())).map_err(failed)?;
                return Ok(path);
            }
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(failed(error)),
        }
    }
    unreachable!("numbers do not end")
}
