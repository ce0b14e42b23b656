//! The description that an editor gives of itself at the beginning: the folders that are open in it, and its abilities.

use crate::document::file_of;
use lsp_types::Uri;
use serde_json::Value;
use std::path::PathBuf;

/// The command of an editor that runs a plan; it gets the file.
pub(super) const RUN: &str = "rpl.run";

/// The command of an editor that runs a test; it gets the file and the name of the test.
pub(super) const TEST: &str = "rpl.test";

/// An editor, as it has described itself.
#[derive(Default)]
pub(super) struct Editor {
    /// The folders that are open in it.
    pub(super) folders: Vec<PathBuf>,
    /// The commands of lenses that it has.
    pub(super) commands: Vec<String>,
    /// Whether it asks for the texts of schemes that no other program knows.
    pub(super) asks_for_texts: bool,
    /// Whether it watches the files that a server names.
    pub(super) watches_files: bool,
}

impl Editor {
    /// By what `initialize` says. A field that is not understood counts as missing.
    pub(super) fn of(params: &Value) -> Self {
        let says = |pointer: &str| params.pointer(pointer);
        let can = |pointer: &str| says(pointer).and_then(Value::as_bool).unwrap_or(false);
        let folders: Vec<PathBuf> = match says("/workspaceFolders").and_then(Value::as_array) {
            Some(folders) => folders.iter().filter_map(|folder| folder_of(&folder["uri"])).collect(),
            None => says("/rootUri").and_then(folder_of).into_iter().collect(),
        };
        let commands = says("/initializationOptions/commands").and_then(Value::as_array).into_iter().flatten();
        Self {
            folders,
            commands: commands.filter_map(Value::as_str).map(str::to_string).collect(),
            asks_for_texts: says("/capabilities/workspace/textDocumentContent").is_some_and(Value::is_object),
            watches_files: can("/capabilities/workspace/didChangeWatchedFiles/dynamicRegistration"),
        }
    }

    /// Whether it has the command of a lens.
    pub(super) fn has(&self, command: &str) -> bool {
        self.commands.iter().any(|known| known == command)
    }

    /// Folders were opened and closed in it.
    pub(super) fn change_folders(&mut self, opened: &[Uri], closed: &[Uri]) {
        let closed: Vec<PathBuf> = closed.iter().filter_map(file_of).collect();
        self.folders.retain(|folder| !closed.contains(folder));
        self.folders.extend(opened.iter().filter_map(file_of));
    }
}

fn folder_of(uri: &Value) -> Option<PathBuf> {
    file_of(&uri.as_str()?.parse().ok()?)
}
