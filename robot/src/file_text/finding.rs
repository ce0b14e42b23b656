//! What is wrong with a file: every finding at once, each with its place in the text.

use rpl_lang::visible::{pictured, visible};
use std::fmt;
use std::ops::Range;
use toml::Spanned;
use toml::de::DeTable;

/// More faults of a file are counted and not shown: one that has this many is no such file.
const MOST_SHOWN: usize = 100;

/// Characters of a line of the file that are shown.
const MOST_OF_LINE: usize = 120;

/// Characters of a message.
const MOST_OF_MESSAGE: usize = 2_000;

/// A file with faults; it holds the first of them, in the order of the text.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{}", .findings.iter().map(Finding::to_string).collect::<Vec<_>>().join("\n\n"), and_more(*.more))]
pub struct FileFaults {
    /// At least one.
    pub findings: Vec<Finding>,
    /// How many more there are.
    pub more: usize,
}

fn and_more(more: usize) -> String {
    if more == 0 { String::new() } else { format!("\n\nand {more} more") }
}

/// Faults, as they are found.
#[derive(Debug, Default)]
pub struct Findings {
    found: Vec<Finding>,
    more: usize,
}

impl Findings {
    /// Adds one, which is made only if it is to be shown.
    pub fn add(&mut self, finding: impl FnOnce() -> Finding) {
        if self.found.len() < MOST_SHOWN { self.found.push(finding()) } else { self.more += 1 }
    }

    /// What is read, if there was no fault.
    ///
    /// # Errors
    /// All faults.
    pub fn or_value<T>(mut self, value: Option<T>) -> Result<T, FileFaults> {
        match value {
            Some(value) if self.found.is_empty() => Ok(value),
            _ => {
                self.found.sort_by_key(|finding| (finding.line, finding.column));
                Err(FileFaults { findings: self.found, more: self.more })
            }
        }
    }
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
    /// The line of the file, or what is around the place in a long one.
    pub source_line: String,
    /// How many characters of it are before the mark.
    pub before_mark: usize,
    /// How many characters of the line are marked.
    pub marked: usize,
}

impl Finding {
    /// A fault at a place of a text, given in bytes.
    pub fn new(
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
        let column = text[line_start..start].chars().count();
        let left_out = if column > MOST_OF_LINE / 2 { column - MOST_OF_LINE / 4 } else { 0 };
        let source_line: String =
            text[line_start..line_end].trim_end().chars().skip(left_out).take(MOST_OF_LINE).collect();
        // A tab has the width of a space, so that the mark stands below what it marks.
        let source_line = pictured(&source_line.replace(['\t', '\r'], " "));
        Self {
            file: visible(file).into_owned(),
            line: text[..start].matches('\n').count() + 1,
            column: column + 1,
            key: key.to_owned(),
            message: told(&message.into()),
            help: told(&help.into()),
            marked: marked.min(MOST_OF_LINE - (column - left_out).min(MOST_OF_LINE - 1)),
            before_mark: column - left_out,
            source_line,
        }
    }
}

impl Finding {
    /// A finding about a key of a table of a TOML file that was read before, such as the third
    /// `[[place]]`; at the table, or at the beginning, if the key is not there.
    pub fn in_toml(file: &str, text: &str, table: Option<(&str, usize)>, key: &str, message: &str, help: &str) -> Self {
        let (document, _) = DeTable::parse_recoverable(text);
        let top = document.get_ref();
        let span = match table {
            None => top.get(key).map(Spanned::span),
            Some((kind, number)) => {
                let tables = top.get(kind).and_then(|tables| tables.get_ref().as_array());
                tables.and_then(|tables| tables.get(number)).map(|table| {
                    let value = table.get_ref().as_table().and_then(|table| table.get(key));
                    value.map_or(table.span(), Spanned::span)
                })
            }
        };
        Self::new(file, text, span.unwrap_or(0..0), key, message, help)
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(out, "{}:{}:{}: {}", self.file, self.line, self.column, self.message)?;
        let gutter = self.line.to_string();
        writeln!(out, "  {gutter} | {}", self.source_line)?;
        let margin = 2 + gutter.len();
        write!(out, "{:margin$} | {}{}", "", " ".repeat(self.before_mark), "^".repeat(self.marked))?;
        if !self.help.is_empty() {
            write!(out, "\n{:margin$} = {}", "", self.help)?;
        }
        Ok(())
    }
}

/// A message on one line, with what it quotes of the file made visible, and not endless.
fn told(message: &str) -> String {
    match message.char_indices().nth(MOST_OF_MESSAGE) {
        None => visible(message).into_owned(),
        Some((end, _)) => format!("{}…", visible(&message[..end])),
    }
}

fn floor_char_boundary(text: &str, at: usize) -> usize {
    (0..=at.min(text.len())).rev().find(|&index| text.is_char_boundary(index)).unwrap_or(0)
}

/// The candidate a misspelt word most likely stands for, if one is near enough.
pub(crate) fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    // No word is that long, and comparing takes the product of the lengths.
    const LONGEST: usize = 60;
    if word.len() > LONGEST {
        return None;
    }
    candidates
        .filter(|candidate| candidate.len() <= LONGEST)
        .map(|candidate| (strsim::damerau_levenshtein(&word.to_lowercase(), &candidate.to_lowercase()), candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.chars().count() / 4)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_file_says_forges_no_line_and_hides_nothing() {
        let text = "name = \"a\u{9b}2J\u{202e}\tb\u{200b}\"\r\n";
        let message = "\"a\nerror: forged\u{1b}[31m\" is no name";
        let finding = Finding::new("x\n.toml", text, 7..10, "name", message, "type\u{85}one");
        let shown = finding.to_string();
        assert!(shown.starts_with("x\\n.toml:1:8: \"a\\nerror: forged\\u{1b}[31m\" is no name\n"), "{shown}");
        assert_eq!(shown.lines().count(), 4, "{shown}");
        let mark = shown.lines().nth(2).expect("a mark").find('^').expect("it marks");
        let line = shown.lines().nth(1).expect("the line");
        assert_eq!(line.chars().nth(mark), Some('"'), "{shown}");
        assert!(!shown.chars().any(|c| c != '\n' && rpl_lang::visible::is_invisible(c)), "{shown:?}");
    }
}
