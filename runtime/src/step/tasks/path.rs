//! Where a task stands: its path, its plan calls, and the form in the text.

use crate::state::machine::Machine;
use crate::state::slab::NONE;
use crate::state::task::{Frame, Naming, Task};
use rpl_lang::code::Program;
use rpl_lang::source::Span;
use rpl_lang::symbol::Symbol;
use rpl_lang::visible::visible;

/// Names a path shows at most; what is deeper shows its innermost ones.
const MAX_SEGMENTS: usize = 64;

/// The form at a frame, or that of the innermost caller outside the library. `callers` are the
/// frames around it, outermost first.
pub(crate) fn form_in_plan(program: &Program, frame: Frame, callers: &[Frame]) -> Option<Span> {
    let span_of = |frame: &Frame| {
        program.codes.get(frame.code as usize)?.spans.get((frame.pc as usize).saturating_sub(1)).copied()
    };
    let here = span_of(&frame);
    if here.is_none_or(|span| span.source.0 >= program.library_sources) {
        return here;
    }
    let mut outer = callers.iter().rev().filter_map(span_of);
    outer.find(|span| span.source.0 >= program.library_sources).or(here)
}

impl Machine {
    /// The path of a task, such as `main/deliver.2/try-all[1]`.
    pub fn path(&self, task: u32) -> String {
        self.path_within(task, usize::MAX)
    }

    /// The path a task began with: that of the place it was made in, and its name.
    pub fn own_path(&self, task: u32) -> String {
        self.path_within(task, 0)
    }

    /// The path of a task and of its plan calls among the first scopes. Only the last
    /// [`MAX_SEGMENTS`] names are written.
    fn path_within(&self, task: u32, scopes: usize) -> String {
        let mut parts = Vec::new();
        let (mut at, mut upto) = (task, scopes);
        while let Some(record) = self.tasks.get(at) {
            let calls = record.scopes.calls_within(upto);
            let named = calls.filter(|&(index, _)| index > 0 || record.parent != NONE || at != self.main);
            let left = MAX_SEGMENTS.saturating_sub(parts.len());
            parts.extend(named.take(left).map(|(_, call)| self.counted(call.name, call.occurrence)));
            if parts.len() >= MAX_SEGMENTS {
                parts.push("…".to_string());
                break;
            }
            parts.push(self.segment(record));
            if parts.len() >= MAX_SEGMENTS && record.parent != NONE {
                parts.push("…".to_string());
                break;
            }
            if record.parent == NONE {
                break;
            }
            upto = record.parent_scope as usize + 1;
            at = record.parent;
        }
        parts.reverse();
        parts.join("/")
    }

    fn segment(&self, task: &Task) -> String {
        let name = self.counted(task.name, task.occurrence);
        if task.naming == Naming::Position { format!("{name}[{}]", task.position) } else { name }
    }

    fn counted(&self, name: Symbol, occurrence: u32) -> String {
        let name = visible(self.symbols.name(name));
        if occurrence > 1 { format!("{name}.{occurrence}") } else { name.into_owned() }
    }

    /// The plan calls around a place in a task, innermost first.
    pub(crate) fn plan_calls(&self, task: u32) -> Vec<(Symbol, Option<Span>)> {
        let mut calls = Vec::new();
        let (mut at, mut upto) = (task, usize::MAX);
        let mut tasks = 0;
        while at != NONE && calls.len() < MAX_SEGMENTS && tasks < MAX_SEGMENTS {
            tasks += 1;
            let record = &self.tasks[at];
            let around = record.scopes.calls_within(upto).filter(|(_, call)| call.span.is_some());
            calls.extend(around.take(MAX_SEGMENTS - calls.len()).map(|(_, call)| (call.name, call.span)));
            upto = record.parent_scope as usize + 1;
            at = record.parent;
        }
        calls
    }

    /// The form a task stands in: inside a function of the library, the one that calls it.
    pub fn form_of(&self, program: &Program, task: u32) -> Option<Span> {
        let record = self.tasks.get(task)?;
        form_in_plan(program, record.frame, &record.frames)
    }
}
