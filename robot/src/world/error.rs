//! What is wrong with a world file: every finding at once, each with its place in the text.

use std::fmt;
use std::ops::Range;

/// A world file with faults; it holds all of them, in the order of the text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", .findings.iter().map(Finding::to_string).collect::<Vec<_>>().join("\n\n"))]
pub struct WorldError {
    /// At least one.
    pub findings: Vec<Finding>,
}

/// One fault.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The file, as the user named it.
    pub file: String,
    /// Counted from 1.
    pub line: usize,
    /// In characters, counted from 1.
    pub column: usize,
    /// The key it is about, empty if the text is not TOML at all.
    pub key: String,
    /// What was found.
    pub message: String,
    /// What to type.
    pub help: String,
    /// The line of the file.
    pub source_line: String,
    /// How many characters of the line are marked.
    pub marked: usize,
}

impl Finding {
    pub(crate) fn new(
        file: &str,
        text: &str,
        span: Range<usize>,
        key: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        let start = floor_char_boundary(text, span.start);
        let end = floor_char_boundary(text, span.end.max(start));
        let line_start = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |newline| start + newline);
        let marked = text[start..end.min(line_end)].trim_end().chars().count().max(1);
        Self {
            file: file.to_owned(),
            line: text[..start].matches('\n').count() + 1,
            column: text[line_start..start].chars().count() + 1,
            key: key.to_owned(),
            message: message.into(),
            help: help.into(),
            source_line: text[line_start..line_end].trim_end().to_owned(),
            marked,
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "{}:{}:{}: {}", self.file, self.line, self.column, self.message)?;
        let gutter = self.line.to_string();
        writeln!(out, "  {gutter} | {}", self.source_line.replace('\t', " "))?;
        let margin = 2 + gutter.len();
        write!(out, "{:margin$} | {}{}", "", " ".repeat(self.column - 1), "^".repeat(self.marked))?;
        if !self.help.is_empty() {
            write!(out, "\n{:margin$} = {}", "", self.help)?;
        }
        Ok(())
    }
}

fn floor_char_boundary(text: &str, at: usize) -> usize {
    (0..=at.min(text.len())).rev().find(|&index| text.is_char_boundary(index)).unwrap_or(0)
}

/// The candidate a misspelt word most likely stands for, if one is near enough.
pub(crate) fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .map(|candidate| (strsim::damerau_levenshtein(&word.to_lowercase(), &candidate.to_lowercase()), candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.chars().count() / 4)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}
