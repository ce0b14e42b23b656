//! Files in TOML that say what is to be run: project files and experiment files.

use super::inputs;
use super::shown::Shown;
use anyhow::{Result, anyhow};
use rpl_lang::suggest::suggest;
use rpl_robot::file_text::{Finding, syntax_fault};
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
        let span = error.span().unwrap_or(0..0);
        let (message, help) =
            syntax_fault(&text, &span, error.message()).unwrap_or_else(|| in_plain_words(error.message(), kind));
        let finding = Finding::new(&name, &text, span, "", message, help);
        anyhow!("`{name}` has faults\n{finding}")
    })
}

/// Keys that only other files, tables and the command line have, the kinds of file they are missing in, and advice.
const ELSEWHERE: &[(&[&str], &[&str], &str)] = &[
    (
        &["until", "timeout", "duration", "limit", "time"],
        &["project files"],
        "`rpl run --until 10min` ends a run, and an experiment file has the key `until`",
    ),
    (
        &["vary", "sweep", "grid", "params", "parameters"],
        &["experiment files", "project files"],
        "in an experiment file each value is a variant: `[[variant]]` with `name` and `set = { most = 6 }`; or `rpl experiment PLAN --vary most=6,20`",
    ),
    (
        &["variant", "variants"],
        &["project files"],
        "variants stand in an experiment file, which `rpl experiment FILE.toml` runs",
    ),
    (
        &["seeds", "repeat", "trials", "count"],
        &["experiment files", "project files"],
        "`runs = 20` makes 20 runs, and `seed = 1` is the seed of the first",
    ),
    (
        &["main", "entry", "file", "mission"],
        &["experiment files", "project files"],
        "the file that is run is named by `plan`",
    ),
    (&["tests", "test"], &["project files"], "tests need no key: `rpl test` finds them in all plans of the folder"),
    (&["variants"], &["experiment files"], "each variant is a table of its own: write `[[variant]]` above its keys"),
];

/// The words of the reader about types and keys, in those of people who write such files.
fn in_plain_words(message: &str, kind: &str) -> (String, String) {
    const TYPES: &[(&str, &str)] = &[
        ("a nonzero u32", "a whole number from 1 on"),
        ("a nonzero u64", "a whole number from 1 on"),
        ("u32", "a whole number from 0 on"),
        ("u64", "a whole number from 0 on"),
        ("a sequence", "a list, such as `[\"one\", \"two\"]`"),
        ("a map", "a table, such as `{ name = 4 }`"),
        ("a string", "a text in quotation marks"),
    ];
    let see_toml = || format!("{kind} are TOML, see toml.io");
    if let Some((found, expected)) = message.split_once(", expected ")
        && let Some((_, plain)) = TYPES.iter().find(|(word, _)| *word == expected)
    {
        return (format!("{found}, where {plain} is expected"), format!("write {plain}"));
    }
    if let Some((unknown, known)) = message.strip_prefix("unknown field `").and_then(|rest| rest.split_once('`')) {
        let names: Vec<&str> = known.split('`').skip(1).step_by(2).collect();
        let elsewhere = ELSEWHERE.iter().find(|(keys, kinds, _)| keys.contains(&unknown) && kinds.contains(&kind));
        let help = match (elsewhere, suggest(unknown, names.iter().copied())) {
            (Some((_, _, advice)), _) => advice.to_string(),
            (None, Some(near)) => format!("did you mean `{near}`?"),
            (None, None) => format!("the keys here are {}", names.join(", ")),
        };
        return (format!("there is no key `{unknown}`"), help);
    }
    (message.to_string(), see_toml())
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
