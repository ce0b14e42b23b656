//! Files in TOML that say what is to be run: project files and experiment files.

use super::inputs;
use super::shown::Shown;
use anyhow::{Result, anyhow};
use rpl_robot::file_text::Finding;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Reads a file; `kind` is what such files are called, in the plural.
///
/// # Errors
/// It cannot be read, or has faults: the first is shown in its line.
pub fn read<T: DeserializeOwned>(file: &Path, kind: &str) -> Result<T> {
    let name = file.shown();
    let text = inputs::read_text(file).map_err(|reason| anyhow!("cannot read `{name}`: {reason}"))?;
    toml::from_str(&text).map_err(|error| {
        let help = format!("{kind} are TOML, see toml.io");
        let finding = Finding::new(&name, &text, error.span().unwrap_or(0..0), "", error.message(), help);
        anyhow!("`{name}` has faults\n{finding}")
    })
}

/// What a file names: the file of that name beside it if there is one, else the name itself.
///
/// # Errors
/// What stands there is no file. A pipe would hold whoever looks at it, such as an editor, for ever.
pub fn beside(file: &Path, named: String) -> Result<String> {
    let there = file.with_file_name(&named);
    match there.metadata() {
        Ok(known) if known.is_file() => Ok(there.to_string_lossy().into_owned()),
        Ok(_) => Err(anyhow!("`{}`, which `{}` names, is no file", there.shown(), file.shown())),
        Err(_) => Ok(named),
    }
}

/// The first value of a variable, as `NAME=EXPR`: a text is an expression, a number itself.
pub fn first_value(name: &str, value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => format!("{name}={text}"),
        toml::Value::Boolean(is_so) => format!("{name}={}", if *is_so { "t" } else { "nil" }),
        other => format!("{name}={other}"),
    }
}
