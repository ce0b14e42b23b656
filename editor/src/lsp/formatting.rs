//! Texts laid out as `rpl fmt` does, by the changes of lines that this takes.

use super::session::{Answer, Session};
use crate::document::Document;
use lsp_types::{DocumentFormattingParams, DocumentRangeFormattingParams, TextEdit};
use rpl_lang::formatter;
use rpl_lang::source::SourceId;
use similar::{DiffTag, TextDiff};
use std::ops::Range;

pub(super) fn whole(session: &mut Session<'_>, params: DocumentFormattingParams) -> Answer<Option<Vec<TextEdit>>> {
    let document = session.document(&params.text_document.uri)?;
    Ok(edits(document, 0..document.text.len()))
}

/// The forms that the range touches are laid out, whole.
pub(super) fn range(session: &mut Session<'_>, params: DocumentRangeFormattingParams) -> Answer<Option<Vec<TextEdit>>> {
    let document = session.document(&params.text_document.uri)?;
    let bytes = document.lines.bytes_of(&document.text, params.range);
    let outline = document.outline();
    let start = outline.form(bytes.start).map_or(bytes.start, |form| form.start);
    let end = outline.form(bytes.end).map_or(bytes.end, |form| form.end);
    Ok(edits(document, start..end))
}

/// In the place of a half of a character: an editor may have the whole, and has it in two halves here.
const HALF: char = '\u{fffd}';

/// The changes that touch some bytes; none if the text cannot be read. Lines with what may be half a character stay as
/// they are.
fn edits(document: &Document, within: Range<usize>) -> Option<Vec<TextEdit>> {
    let formatted = formatter::format(&document.text, SourceId(0)).ok()?;
    let diff = TextDiff::from_lines(document.text.as_str(), formatted.as_str());
    let (old, new) = (starts(diff.old_slices()), starts(diff.new_slices()));
    let changed = diff.ops().iter().filter(|op| op.tag() != DiffTag::Equal).filter_map(|op| {
        let bytes = old[op.old_range().start]..old[op.old_range().end];
        let touches = bytes.start <= within.end && within.start <= bytes.end;
        let text = &formatted[new[op.new_range().start]..new[op.new_range().end]];
        let is_known = !document.text[bytes.clone()].contains(HALF);
        (touches && is_known).then(|| TextEdit::new(document.range(bytes), text.to_string()))
    });
    Some(changed.collect())
}

/// Where each line begins, and where the last one ends.
fn starts(lines: &[&str]) -> Vec<usize> {
    let ends = lines.iter().scan(0, |at, line| {
        *at += line.len();
        Some(*at)
    });
    std::iter::once(0).chain(ends).collect()
}
