//! `rpl explain CODE`: what an error or a warning means, from the pages of the book that tell of them.

use anyhow::{Result, bail};
use rpl_lang::suggest::suggest;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;

/// The pages, each with a section for a code.
const PAGES: [&str; 2] = [include_str!("../../../docs/errors.md"), include_str!("../../../docs/warnings.md")];

/// Explain an error or a warning
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Code, as in `error[unclosed-list]` (default: list all codes)
    #[arg(value_name = "CODE", add = clap_complete::engine::ArgValueCompleter::new(complete))]
    code: Option<String>,
}

/// Codes that begin so, for shells.
fn complete(current: &std::ffi::OsStr) -> Vec<clap_complete::CompletionCandidate> {
    let begun = current.to_string_lossy();
    let codes = sections().map(|(code, _)| code).filter(|code| code.starts_with(begun.as_ref()));
    codes.map(clap_complete::CompletionCandidate::new).collect()
}

/// Prints the section of a code.
///
/// # Errors
/// There is no such code, or standard output is closed.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let Some(typed) = &arguments.code else {
        let codes: Vec<&str> = sections().map(|(code, _)| code).collect();
        console.explain(&codes.join("\n"))?;
        return Ok(Status::Succeeded);
    };
    // As it stands in the message, too.
    let code = typed.split(['[', ']']).nth(usize::from(typed.contains('['))).unwrap_or(typed);
    match sections().find(|(known, _)| *known == code) {
        Some((code, text)) => console.explain_hanging(&format!("{code}\n\n{}", plain(text)), 0)?,
        None => {
            let near = suggest(code, sections().map(|(code, _)| code));
            let near = near.map_or("`rpl explain` lists all".to_string(), |near| format!("did you mean `{near}`?"));
            bail!("no error or warning has the code `{code}`; {near}");
        }
    }
    Ok(Status::Succeeded)
}

/// Each code with its section, in the order of the pages.
fn sections() -> impl Iterator<Item = (&'static str, &'static str)> {
    PAGES.iter().flat_map(|page| page.split("\n## ").skip(1)).filter_map(|section| section.split_once('\n'))
}

/// A section as text: what stands in boxes is indented.
fn plain(section: &str) -> String {
    let mut is_boxed = false;
    let mut lines = Vec::new();
    for line in section.trim().lines() {
        if line.starts_with("```") {
            is_boxed = !is_boxed;
        } else {
            lines.push(if is_boxed { format!("    {line}").trim_end().to_string() } else { line.to_string() });
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_tests::repository;
    use std::collections::BTreeSet;
    use std::fs;

    /// Codes that stand between these in a text.
    fn codes(text: &str, before: &str, after: char) -> Vec<String> {
        let found = text.split(before).skip(1).filter_map(|rest| rest.trim_start().split_once(after));
        let is_code =
            |code: &&str| !code.is_empty() && code.chars().all(|sign| sign.is_ascii_lowercase() || sign == '-');
        found.map(|(code, _)| code).filter(is_code).map(str::to_string).collect()
    }

    #[test]
    fn every_code_has_its_section_and_none_has_two() {
        let known: Vec<&str> = sections().map(|(code, _)| code).collect();
        let once: BTreeSet<&str> = known.iter().copied().collect();
        assert_eq!(known.len(), once.len(), "a code has two sections");
        let root = repository::root();
        let mut said = BTreeSet::new();
        // What the compiler's sources can say, and what the cases show that it does say.
        for path in repository::files_below(&root.join("lang/src"), &["rs"]) {
            let text = fs::read_to_string(path).expect("a source");
            let text = text.split("#[cfg(test)]").next().unwrap_or_default().replace(['\n', ' '], "");
            for before in ["Diagnostic::error(\"", "Diagnostic::warning(\"", "self.error(\"", ".malformed(\""] {
                said.extend(codes(&text, before, '"'));
            }
        }
        for path in repository::files_below(&root.join("tests"), &["snap", "expected"]) {
            let text = fs::read_to_string(path).expect("a case");
            said.extend(codes(&text, "error[", ']').into_iter().chain(codes(&text, "warning[", ']')));
        }
        let missing: Vec<&String> = said.iter().filter(|code| !once.contains(code.as_str())).collect();
        assert!(said.len() > 40 && missing.is_empty(), "{} found; without a section: {missing:?}", said.len());
        let rules = rpl_lang::check::RULES.iter().filter(|rule| !once.contains(**rule)).count();
        assert_eq!(rules, 0, "each rule of the checker has its section");
    }
}
