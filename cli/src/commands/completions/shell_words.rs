//! Words of a line as a shell hands them over, with their quotes, and names as it wants them back.

use clap::Command;
use clap_complete::engine::complete;
use clap_complete::env::{Bash as PlainBash, EnvCompleter};
use std::env;
use std::ffi::OsString;
use std::io::{self, Write};
use std::path::Path;

/// Bash, which puts what it is given into the line as it is: names that its words cannot hold are
/// quoted.
pub struct Bash;

/// A shell that quotes by itself what it puts into the line.
pub struct Quoting<S>(pub S);

impl EnvCompleter for Bash {
    fn name(&self) -> &'static str {
        PlainBash.name()
    }

    fn is(&self, name: &str) -> bool {
        PlainBash.is(name)
    }

    fn write_registration(
        &self,
        variable: &str,
        name: &str,
        command: &str,
        completer: &str,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        PlainBash.write_registration(variable, name, command, completer, out)
    }

    fn write_complete(
        &self,
        command: &mut Command,
        words: Vec<OsString>,
        folder: Option<&Path>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        // Both are set by the script; without it the last word is meant, and lines are separated.
        let index = env::var("_CLAP_COMPLETE_INDEX").ok().and_then(|index| index.parse().ok());
        let separator = env::var("_CLAP_IFS").unwrap_or("\n".to_string());
        let index = index.unwrap_or(words.len().saturating_sub(1));
        let found = complete(command, all_unquoted(&words), index, folder)?;
        let names: Vec<String> = found.iter().map(|name| quoted(&name.get_value().to_string_lossy())).collect();
        write!(out, "{}", names.join(&separator))
    }
}

impl<S: EnvCompleter> EnvCompleter for Quoting<S> {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn is(&self, name: &str) -> bool {
        self.0.is(name)
    }

    fn write_registration(
        &self,
        variable: &str,
        name: &str,
        command: &str,
        completer: &str,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        self.0.write_registration(variable, name, command, completer, out)
    }

    fn write_complete(
        &self,
        command: &mut Command,
        words: Vec<OsString>,
        folder: Option<&Path>,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        self.0.write_complete(command, all_unquoted(&words), folder, out)
    }
}

fn all_unquoted(words: &[OsString]) -> Vec<OsString> {
    words.iter().map(|word| OsString::from(unquoted(&word.to_string_lossy()))).collect()
}

/// A name as one word of the shell.
fn quoted(name: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=+,:@%~°–".contains(c);
    name.chars().flat_map(|c| (!is_plain(c)).then_some('\\').into_iter().chain([c])).collect()
}

/// A word of the shell, perhaps not finished, without its quotes.
fn unquoted(word: &str) -> String {
    let mut name = String::new();
    let mut is_escaped = false;
    for c in word.chars() {
        match c {
            c if is_escaped => {
                name.push(c);
                is_escaped = false;
            }
            '\\' => is_escaped = true,
            '"' | '\'' => {}
            c => name.push(c),
        }
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_quoted_is_read_back() {
        for name in ["dept", "no relocalization", "turned by 20–180°", "a'b\"c\\d", "(x) & $y", "furniture, people"]
        {
            assert_eq!(unquoted(&quoted(name)), name);
        }
        assert_eq!(quoted("no relocalization"), "no\\ relocalization");
        assert_eq!(unquoted("\"no rel"), "no rel");
    }
}
