//! The prompt: with its lines from a pipe, what is shown and the exit status; and at a terminal.

mod at_terminal;
mod commands;
mod definitions;
mod forms;
mod history;
mod stepping;
mod understanding;

use crate::rpl::{Ended, feed, rpl};
use std::path::Path;

/// A plan that several sessions define.
const GREET: &str = "(def-plan greet (who)\n  (print who)\n  (wait-time 2)\n  (list 'hello who))\n";

/// A session with these lines from a pipe.
fn session(arguments: &[&str], lines: &str) -> Ended {
    session_in(Path::new("."), "false", arguments, lines)
}

/// A session in a folder, with an editor.
fn session_in(folder: &Path, editor: &str, arguments: &[&str], lines: &str) -> Ended {
    feed(rpl(arguments).current_dir(folder).env("EDITOR", editor).env_remove("VISUAL"), lines)
}
