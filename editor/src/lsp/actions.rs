//! What can be done about a finding: typed what its hint says, where that is plan text, or the warning allowed.
//!
//! A hint is offered only if it helps: with it the finding is gone, and nothing new is found.

use super::diagnostics::touching;
use super::library;
use super::session::{Answer, Session};
use crate::analysis::Analysis;
use crate::document::Document;
use lsp_types::{
    CodeAction, CodeActionKind, CodeActionOrCommand, CodeActionParams, CodeActionResponse, TextEdit, WorkspaceEdit,
};
use rpl_lang::check::RULES;
use rpl_lang::diagnostic::{Diagnostic, Severity};
use rpl_lang::source::line_start;
use std::collections::HashMap;
use std::ops::Range;

/// Findings in one place that hints are tried for.
const MOST_FINDINGS: usize = 8;

/// A change of a text, and how it is called.
struct Change {
    title: String,
    bytes: Range<usize>,
    text: String,
}

pub(super) fn actions(session: &mut Session<'_>, params: CodeActionParams) -> Answer<Option<CodeActionResponse>> {
    let uri = &params.text_document.uri;
    let analysis = session.analysis(uri)?;
    let document = session.document(uri)?;
    if library::is_of_library(session, document) {
        return Ok(None);
    }
    let bytes = document.lines.bytes_of(&document.text, params.range);
    let mut found = Vec::new();
    for (finding, shown) in touching(&analysis, bytes).take(MOST_FINDINGS) {
        let hinted = hinted(document, finding).into_iter().filter(|change| helps(session, document, &analysis, change));
        let fixes: Vec<Change> = hinted.take(1).collect();
        let is_fixed = !fixes.is_empty();
        for (at, change) in fixes.into_iter().chain(allowed(document, finding)).enumerate() {
            let edit = TextEdit::new(document.range(change.bytes), change.text);
            let action = CodeAction {
                title: change.title,
                kind: Some(CodeActionKind::QUICKFIX),
                diagnostics: Some(vec![shown.clone()]),
                edit: Some(WorkspaceEdit::new(HashMap::from([(uri.clone(), vec![edit])]))),
                is_preferred: Some(is_fixed && at == 0),
                ..CodeAction::default()
            };
            found.push(CodeActionOrCommand::CodeAction(action));
        }
    }
    Ok(Some(found))
}

/// What a hint may say to type, and where: in the place of what is marked, or, if it is a definition, above the form.
fn hinted(document: &Document, finding: &Diagnostic) -> Vec<Change> {
    let marked = finding.span.start as usize..finding.span.end as usize;
    let Some(help) = &finding.help else { return Vec::new() };
    if help.starts_with("remove it") {
        return vec![Change { title: "Remove it".into(), bytes: marked, text: String::new() }];
    }
    let Some(written) = help.split('`').nth(1) else { return Vec::new() };
    if has_gaps(written) {
        return Vec::new();
    }
    if written.starts_with("(def") {
        let start = document.outline().form(marked.start).map_or(0, |form| form.start);
        return vec![Change {
            title: format!("Define it: `{written}`"),
            bytes: start..start,
            text: format!("{written}\n\n"),
        }];
    }
    let change = |bytes: Range<usize>| Change { title: format!("Write `{written}`"), bytes, text: written.to_string() };
    let mut changes = vec![change(marked.clone())];
    // A form is marked whole where only its head, or a name in it, is meant.
    let outline = document.outline();
    let inside = outline.lexemes.iter().filter(|lexeme| marked.start <= lexeme.start && lexeme.end <= marked.end);
    let names =
        inside.filter(|lexeme| !matches!(lexeme.token, rpl_lang::lexer::Token::Open | rpl_lang::lexer::Token::Close));
    changes.extend(names.take(MOST_FINDINGS).map(|lexeme| change(lexeme.start..lexeme.end)));
    // A unit that stands apart is marked without its number.
    if let Some(number) = outline.lexemes.iter().rev().find(|lexeme| lexeme.end <= marked.start) {
        changes.push(change(number.start..marked.end));
    }
    changes
}

/// Whether something in it is still to be filled in.
fn has_gaps(written: &str) -> bool {
    let words = written.split(|c: char| !c.is_alphanumeric() && c != '-');
    let is_gap = |word: &str| word.len() > 1 && word.chars().all(|c| c.is_uppercase() || c == '-') && word != "-";
    written.is_empty() || written.contains('…') || written.contains("...") || words.into_iter().any(is_gap)
}

/// Whether the text with the change has one finding less, and none that it has not without.
fn helps(session: &Session<'_>, document: &Document, analysis: &Analysis, change: &Change) -> bool {
    let mut text = document.text.clone();
    text.replace_range(change.bytes.clone(), &change.text);
    let Ok(changed) = session.examine(document, &text) else { return false };
    let counts = |analysis: &Analysis| {
        let errors = analysis.examined.diagnostics.iter().filter(|one| one.severity == Severity::Error).count();
        (errors, analysis.examined.diagnostics.len())
    };
    let (before, after) = (counts(analysis), counts(&changed));
    // Warnings are told only of forms without errors: with one error less there may be more of them.
    after.0 < before.0 || after.0 == before.0 && after.1 < before.1
}

/// A warning can be taken away by a comment in the line above.
fn allowed(document: &Document, finding: &Diagnostic) -> Option<Change> {
    if !RULES.contains(&finding.code) {
        return None;
    }
    let start = line_start(&document.text, finding.span.start as usize);
    let line = &document.text[start..];
    let indent = &line[..line.len() - line.trim_start_matches([' ', '\t']).len()];
    let text = format!("{indent}; check: allow {}\n", finding.code);
    Some(Change { title: format!("Allow `{}` here", finding.code), bytes: start..start, text })
}
