//! Where a task stands: its path, its plan calls, and the form in the text.

use crate::state::machine::Machine;
use crate::state::slab::NONE;
use crate::state::task::{Frame, Naming, PlanCall, Task};
use rpl_lang::code::Program;
use rpl_lang::source::Span;
use rpl_lang::symbol::{Symbol, Symbols};
use rpl_lang::visible::visible;
use std::fmt::Write;

/// Names a path shows at most; what is deeper shows its innermost ones.
const MAX_SEGMENTS: usize = 32;

/// Plan calls that are told of a failure at most, and tasks that are gone through for them.
const MAX_CALLS: usize = 64;

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

/// Bytes that there is room for beside each name: nearly always those of a separator.
const SEGMENT_MARKS: usize = 1;

/// A name in a path.
struct Segment {
    name: Symbol,
    /// Which of those of the same name it is, counted from 1.
    occurrence: u32,
    /// The position among children that have no other name.
    position: Option<u32>,
}

impl Segment {
    fn of_call(call: &PlanCall) -> Self {
        Self { name: call.name, occurrence: call.occurrence, position: None }
    }

    fn of_task(task: &Task) -> Self {
        let position = (task.naming == Naming::Position).then_some(task.position);
        Self { name: task.name, occurrence: task.occurrence, position }
    }

    fn write(&self, symbols: &Symbols, path: &mut String) {
        path.push_str(&visible(symbols.name(self.name)));
        let written = match (self.occurrence, self.position) {
            (0 | 1, None) => Ok(()),
            (0 | 1, Some(position)) => write!(path, "[{position}]"),
            (occurrence, None) => write!(path, ".{occurrence}"),
            (occurrence, Some(position)) => write!(path, ".{occurrence}[{position}]"),
        };
        debug_assert!(written.is_ok(), "a string takes what is written");
    }
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
        let mut segments = Vec::with_capacity(MAX_SEGMENTS);
        let (mut at, mut upto, mut is_whole) = (task, scopes, false);
        while let Some(record) = self.tasks.get(at) {
            let calls = record.scopes.calls_within(upto);
            let named = calls.filter(|&(index, _)| index > 0 || record.parent != NONE || at != self.main);
            let left = MAX_SEGMENTS - segments.len();
            segments.extend(named.take(left).map(|(_, call)| Segment::of_call(call)));
            if segments.len() == MAX_SEGMENTS {
                break;
            }
            segments.push(Segment::of_task(record));
            if record.parent == NONE {
                is_whole = true;
                break;
            }
            if segments.len() == MAX_SEGMENTS {
                break;
            }
            upto = record.parent_scope as usize + 1;
            at = record.parent;
        }
        is_whole |= self.tasks.get(at).is_none();
        let names = segments.iter().map(|segment| self.symbols.name(segment.name).len() + SEGMENT_MARKS);
        let mut path = String::with_capacity(names.sum::<usize>() + '…'.len_utf8());
        if !is_whole {
            path.push('…');
        }
        for segment in segments.iter().rev() {
            if !path.is_empty() {
                path.push('/');
            }
            segment.write(&self.symbols, &mut path);
        }
        path
    }

    /// The plan calls around a place in a task, innermost first.
    pub(crate) fn plan_calls(&self, task: u32) -> Vec<(Symbol, Option<Span>)> {
        let mut calls = Vec::new();
        let (mut at, mut upto) = (task, usize::MAX);
        let mut tasks = 0;
        while at != NONE && calls.len() < MAX_CALLS && tasks < MAX_CALLS {
            tasks += 1;
            let record = &self.tasks[at];
            let around = record.scopes.calls_within(upto).filter(|(_, call)| call.span.is_some());
            calls.extend(around.take(MAX_CALLS - calls.len()).map(|(_, call)| (call.name, call.span)));
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
