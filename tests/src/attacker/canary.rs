//! A file that nobody named: it must stay as it is.

use std::path::Path;

/// What stands where nothing may be changed.
const CANARY: &str = "nobody named this file\n";

/// Puts a file there that must stay as it is.
pub(super) fn put_canary(path: &Path) -> Result<(), String> {
    std::fs::write(path, CANARY).map_err(|error| format!("{}: {error}", path.to_string_lossy()))
}

/// Whether the file is as it was.
pub(super) fn look_at_canary(path: &Path) -> Result<(), String> {
    match std::fs::read_to_string(path) {
        Ok(text) if text == CANARY => Ok(()),
        Ok(text) => {
            Err(format!("{} was overwritten: {:?}", path.to_string_lossy(), text.chars().take(200).collect::<String>()))
        }
        Err(error) => Err(format!("{} is gone: {error}", path.to_string_lossy())),
    }
}
