//! Lenses above a plan and above each of its tests, which run them. Only an editor that has the commands is offered them.

use super::editor::{RUN, TEST};
use super::library;
use super::messages::Refusal;
use super::session::{Answer, Session};
use crate::definitions::{definitions, runs_something};
use lsp_types::{CodeLens, CodeLensParams, Command, Position, Range, SymbolKind};
use serde_json::Value;

pub(super) fn lenses(session: &mut Session<'_>, params: CodeLensParams) -> Answer<Option<Vec<CodeLens>>> {
    let document = session.document(&params.text_document.uri)?;
    // Files are run, no texts.
    if document.path.as_os_str().is_empty() || library::is_of_library(session, document) {
        return Ok(None);
    }
    if !session.surroundings().setting(&document.path).map_err(Refusal::failed)?.is_of_plans {
        return Ok(None);
    }
    let file = document.path.to_string_lossy().into_owned();
    let lens = |line: u32, title: &str, command: &str, arguments: &[&str]| CodeLens {
        range: Range::new(Position::new(line, 0), Position::new(line, 0)),
        command: Some(Command {
            title: title.into(),
            command: command.into(),
            arguments: Some(arguments.iter().copied().map(Value::from).collect()),
        }),
        data: None,
    };
    let outline = document.outline();
    let mut lenses = Vec::new();
    if session.editor.has(RUN) && runs_something(&document.text, &outline) {
        lenses.push(lens(0, "Run", RUN, &[&file]));
    }
    if session.editor.has(TEST) {
        let tests = definitions(&document.text, &outline, &document.lines);
        let tests = tests.iter().filter(|one| one.kind == SymbolKind::EVENT);
        lenses.extend(tests.map(|test| lens(test.line, "Run this test", TEST, &[&file, &test.name])));
    }
    Ok(Some(lenses))
}
