//! What can be folded: lists and comments of several lines.

use super::session::{Answer, Session};
use lsp_types::{FoldingRange, FoldingRangeKind, FoldingRangeParams};
use rpl_lang::lexer::Token;

pub(super) fn folds(session: &mut Session<'_>, params: FoldingRangeParams) -> Answer<Option<Vec<FoldingRange>>> {
    let document = session.document(&params.text_document.uri)?;
    let outline = document.outline();
    let line = |byte: usize| document.lines.line(byte) as u32;
    let mut folds: Vec<FoldingRange> = Vec::new();
    let mut add = |start_line: u32, end_line: u32, kind: Option<FoldingRangeKind>| {
        // An editor folds a line once: the outermost list that begins in it.
        if start_line < end_line && folds.last().is_none_or(|last| last.start_line != start_line) {
            folds.push(FoldingRange { start_line, end_line, kind, ..FoldingRange::default() });
        }
    };
    let mut comment: Option<(u32, u32)> = None;
    for (at, lexeme) in outline.lexemes.iter().enumerate() {
        let (first, last) = (line(lexeme.start), line(lexeme.end.saturating_sub(1)));
        match lexeme.token {
            Token::LineComment => {
                let is_alone = at == 0 || line(outline.lexemes[at - 1].end) < first;
                comment = match comment {
                    Some((start, end)) if end + 1 == first && is_alone => Some((start, first)),
                    _ if is_alone => Some((first, first)),
                    other => other,
                };
                let goes_on = outline
                    .lexemes
                    .get(at + 1)
                    .is_some_and(|next| next.token == Token::LineComment && line(next.start) == first + 1);
                if let (Some((start, end)), false) = (comment, goes_on) {
                    add(start, end, Some(FoldingRangeKind::Comment));
                    comment = None;
                }
            }
            Token::BlockComment => add(first, last, Some(FoldingRangeKind::Comment)),
            Token::Open => add(first, line(outline.list(at).end.saturating_sub(1)), None),
            _ => {}
        }
    }
    Ok(Some(folds))
}
