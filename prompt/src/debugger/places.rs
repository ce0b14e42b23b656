//! Places as debuggers name them: files, lines and columns, from 0 or from 1 as they have said.

use rpl_editor::dap::messages::Source;
use rpl_editor::lines::Lines;
use rpl_lang::source::{SourceId, Span};
use rpl_mission::robot::Robot;
use rpl_runtime::run::system::System;
use std::collections::BTreeSet;
use std::path::Path;

/// How a debugger counts.
#[derive(Clone, Copy, Debug)]
pub struct Counting {
    /// The number of the first line.
    pub first_line: i64,
    /// The number of the first column.
    pub first_column: i64,
}

impl Counting {
    /// Lines and columns of the beginning and the end of a form, in a text whose lines are known.
    pub fn of(&self, lines: &Lines, text: &str, span: Span) -> [(i64, i64); 2] {
        let range = lines.range(text, span.start as usize..span.end as usize);
        [range.start, range.end].map(|position| {
            (i64::from(position.line) + self.first_line, i64::from(position.character) + self.first_column)
        })
    }
}

/// A text as a debugger is told of it: by its file, or by the number under which it can ask for it.
pub fn source(system: &System<Robot>, id: SourceId) -> Source {
    let name = &*system.program.sources.get(id).name;
    match Path::new(name).canonicalize() {
        Ok(path) if path.is_file() => Source {
            name: Path::new(name).file_name().map(|name| name.to_string_lossy().into_owned()),
            path: Some(path.to_string_lossy().into_owned()),
            source_reference: None,
        },
        _ => Source { name: Some(name.to_string()), path: None, source_reference: Some(i64::from(id.0) + 1) },
    }
}

/// The text that a debugger means.
pub fn meant(system: &System<Robot>, meant: &Source) -> Option<SourceId> {
    let sources = &system.program.sources;
    let mut ids = (0..sources.len() as u32).map(SourceId);
    match (&meant.path, meant.source_reference) {
        (_, Some(number)) if number > 0 => ids.find(|id| i64::from(id.0) + 1 == number),
        (Some(path), _) => {
            let path = Path::new(path).canonicalize().ok()?;
            ids.find(|&id| Path::new(&*sources.get(id).name).canonicalize().is_ok_and(|known| known == path))
        }
        (None, _) => None,
    }
}

/// The lines, from 1, in which a run can stop. Cost: linear in the program.
pub fn stopping_lines(system: &System<Robot>, id: SourceId) -> BTreeSet<usize> {
    let text = &system.program.sources.get(id).text;
    let lines = Lines::of(text);
    let steps = system.program.codes.iter().flat_map(|code| {
        let steps = code.ops.iter().zip(&code.spans).filter(|(op, span)| op.is_step() && span.source == id);
        steps.map(|(_, span)| span.start as usize)
    });
    steps.map(|start| lines.line(start) + 1).collect()
}
