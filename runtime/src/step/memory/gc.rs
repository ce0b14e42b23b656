//! Garbage collection: mark and sweep, at safe points, triggered by allocation counts only.

use crate::state::fluent::{Fluent, Origin};
use crate::state::heap::{HeapMarks, vector_elements};
use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::slab::{Marks, NONE};
use crate::state::task::{Decision, Leaving, Scope, ScopeKind, Task, Then, Waiting};
use crate::state::value::Value;
use rpl_lang::code::Program;
use rpl_lang::source::Span;
use std::collections::BTreeSet;

/// Which codes and texts something refers to.
#[derive(Debug, Default)]
pub(crate) struct CodeMarks {
    pub(crate) codes: Marks,
    pub(crate) sources: Marks,
}

impl CodeMarks {
    pub(crate) fn new(program: &Program) -> Self {
        Self { codes: Marks::new(program.codes.len()), sources: Marks::new(program.sources.len()) }
    }
}

/// No pair: what is below it in the stack of a marker is a vector.
const VECTOR: u32 = u32::MAX;

struct Marker {
    heap: HeapMarks,
    fluents: Marks,
    tasks: Marks,
    /// Pairs that are marked and not yet looked into; and vectors that were left, each as [`VECTOR`] on top of its
    /// number and of how many elements were looked into. One stack for both, which grows with the depth of data only.
    rests: Vec<u32>,
    /// Other objects that may have parts.
    waiting: Vec<Value>,
    /// Bytes of the parts of what is marked.
    bytes: usize,
    /// Codes and texts that are referred to, if somebody wants to know.
    code: Option<CodeMarks>,
}

impl Marker {
    /// Takes a value up: what has no parts is marked at once.
    #[inline]
    fn push(&mut self, value: Value) {
        match value {
            Value::Cons(pair) => {
                if self.heap.pairs.set(pair) {
                    self.rests.push(pair);
                }
            }
            Value::Str(text) => drop(self.heap.strings.set(text)),
            Value::Cell(cell) => self.wait(value, |marker| marker.heap.cells.set(cell)),
            Value::Closure(closure) => self.wait(value, |marker| marker.heap.closures.set(closure)),
            Value::Table(table) => self.wait(value, |marker| marker.heap.tables.set(table)),
            Value::Vector(vector) => self.wait(value, |marker| marker.heap.vectors.set(vector)),
            Value::Failure(failure) => self.wait(value, |marker| marker.heap.failures.set(failure)),
            Value::Fluent(fluent) => self.wait(value, |marker| marker.fluents.set(fluent)),
            // Its record may be gone.
            Value::Task(_) => self.waiting.push(value),
            Value::Nil
            | Value::True
            | Value::Int(_)
            | Value::Float(_)
            | Value::Symbol(_)
            | Value::Keyword(_)
            | Value::Native(_)
            | Value::Valve(_)
            | Value::Behaviour(_)
            | Value::Unbound => {}
            Value::Function(code) => self.refer_to(code),
        }
    }

    /// Keeps an object to be looked into, if it was not marked before.
    fn wait(&mut self, value: Value, mark: impl FnOnce(&mut Self) -> bool) {
        if mark(self) {
            self.waiting.push(value);
        }
    }

    /// Notes a code that something refers to.
    fn refer_to(&mut self, code: u32) {
        if let Some(marks) = &mut self.code {
            marks.codes.set(code);
        }
    }

    /// Notes a text that something refers to.
    fn refer_to_text(&mut self, span: Option<Span>) {
        if let (Some(marks), Some(span)) = (&mut self.code, span) {
            marks.sources.set(span.source.0);
        }
    }

    fn extend<'v>(&mut self, values: impl IntoIterator<Item = &'v Value>) {
        values.into_iter().for_each(|&value| self.push(value));
    }
}

impl Machine {
    /// Frees every object that nothing refers to.
    pub fn collect(&mut self) {
        self.collect_and_mark(None);
    }

    /// The same, and tells which codes and texts of a program something refers to.
    pub(crate) fn collect_for(&mut self, program: &Program) -> CodeMarks {
        self.collect_and_mark(Some(CodeMarks::new(program))).unwrap_or_default()
    }

    fn collect_and_mark(&mut self, code: Option<CodeMarks>) -> Option<CodeMarks> {
        let mut marker = Marker {
            heap: HeapMarks::new(&self.heap),
            fluents: Marks::new(self.fluents.slots()),
            tasks: Marks::new(self.tasks.slots()),
            rests: Vec::new(),
            waiting: Vec::new(),
            bytes: 0,
            code,
        };
        let asked = self.scratch.asked.as_ref().map(|(place, ..)| place.frame);
        self.scratch.frames.iter().chain(asked.as_ref()).for_each(|frame| marker.refer_to(frame.code));
        marker.extend(&self.globals);
        marker.extend(&self.constants);
        if self.current != NONE {
            marker.extend(&self.scratch.stack[..self.scratch.top]);
        }
        for activation in &self.activations {
            activation.signals().for_each(|signal| marker.push(signal.unwrap_or_else(|failure| failure)));
        }
        // Living tasks keep what they hold, whether a plan can name them or not.
        let mut dead_tasks = Vec::new();
        let mut priorities = Marks::new(self.priorities.slots());
        for (index, task) in self.tasks.iter() {
            match task.state().is_dead() {
                true => dead_tasks.push(index),
                false => {
                    self.mark_task(&mut marker, index, task);
                    mark_priorities(&mut priorities, task);
                }
            }
        }
        self.mark(&mut marker);
        let dead = |&(index, _): &(u32, &Fluent)| !marker.fluents.is_set(index);
        let dead: Vec<u32> = self.fluents.iter().filter(dead).map(|(index, _)| index).collect();
        let inputs: BTreeSet<u32> = dead.iter().flat_map(|&index| self.fluents[index].inputs.iter().copied()).collect();
        for input in inputs {
            if let Some(fluent) = self.fluents.get_mut(input) {
                fluent.dependents.retain(|&dependent| marker.fluents.is_set(dependent));
            }
        }
        for fluent in dead {
            self.fluents.remove(fluent);
        }
        marker.bytes += self.fluents.iter().map(|(_, fluent)| memory::fluent_parts(fluent)).sum::<usize>();
        for index in dead_tasks {
            if index == self.main || marker.tasks.is_set(index) {
                mark_priorities(&mut priorities, &self.tasks[index]);
            } else {
                self.tasks.free(index);
            }
        }
        let slack = self.slack();
        self.priorities.retain(priorities, slack);
        self.heap.sweep(&marker.heap, slack);
        self.fluents.shrink(slack);
        self.watches.shrink(slack);
        self.tasks.shrink(slack);
        self.measure(marker.bytes);
        marker.code
    }

    #[inline]
    fn mark_task(&self, marker: &mut Marker, index: u32, task: &Task) {
        if !marker.tasks.set(index) {
            return;
        }
        if !task.state().is_dead() {
            marker.refer_to(task.frame.code);
        }
        marker.extend(self.tasks.registers.get(task.registers));
        match task.waiting() {
            Some(Waiting::Fluent { fluent, .. }) => marker.push(Value::Fluent(fluent)),
            Some(_) => {}
            None => marker.push(*task.value()),
        }
        if task.rare.is_some() || !task.scopes.is_empty() || !task.frames.is_empty() {
            self.mark_more_of_task(marker, task);
        }
    }

    /// Marks what not all tasks have.
    #[inline(never)]
    fn mark_more_of_task(&self, marker: &mut Marker, task: &Task) {
        marker.bytes += memory::task(task);
        if !task.state().is_dead() {
            task.frames.iter().for_each(|frame| marker.refer_to(frame.code));
        }
        if let Some(rare) = &task.rare {
            if let Some(swap) = &rare.swap_pending {
                marker.refer_to(swap.code);
            }
            if let Some(leaving) = &rare.leaving {
                mark_leaving(marker, leaving);
            }
            let fluents = &rare.fluents;
            for fluent in [fluents.status, fluents.result, fluents.begin, fluents.end].into_iter().flatten() {
                marker.push(Value::Fluent(fluent));
            }
        }
        for scope in task.scopes.iter() {
            self.mark_scope(marker, scope);
        }
    }

    fn mark_scope(&self, marker: &mut Marker, scope: &Scope) {
        match &scope.kind {
            ScopeKind::OnInterrupt(hook) | ScopeKind::OnResume(hook) => marker.push(*hook),
            ScopeKind::InCleanup(then) => {
                if let Then::Leave(leaving) = &**then {
                    mark_leaving(marker, leaving);
                }
            }
            ScopeKind::Children(children) => {
                marker.push(children.last_value);
                marker.extend(&children.values);
                marker.extend(&children.failures);
                if let Some(Decision::Succeed(value) | Decision::Fail(value)) = children.decided {
                    marker.push(value);
                }
            }
            ScopeKind::Watch(watch) => {
                if let Some(watch) = self.watches.get(*watch) {
                    marker.push(Value::Fluent(watch.fluent));
                }
            }
            ScopeKind::Call(call) => {
                marker.refer_to_text(call.span);
                call.tags.iter().for_each(|&tag| marker.push(Value::Task(tag)));
                marker.extend(&call.failure);
            }
            ScopeKind::Suspended(task) => marker.push(Value::Task(*task)),
            ScopeKind::Handler { code, .. } => marker.refer_to(*code),
            ScopeKind::Block { .. } | ScopeKind::Cleanup { .. } | ScopeKind::Valve(_) | ScopeKind::Fence => {}
        }
    }

    /// Looks into everything that is marked. Few objects wait at a time: a list is left when an object
    /// is found in it, and gone on with afterwards.
    fn mark(&self, marker: &mut Marker) {
        loop {
            while let Some(value) = marker.waiting.pop() {
                self.mark_object(marker, value);
            }
            match marker.rests.pop() {
                Some(VECTOR) => {
                    let (vector, from) = (marker.rests.pop(), marker.rests.pop());
                    self.mark_vector(marker, vector.unwrap_or_default(), from.unwrap_or_default());
                }
                Some(pair) => self.mark_list(marker, pair),
                None => return,
            }
        }
    }

    /// Marks elements of a vector that is marked, up to one that has parts.
    fn mark_vector(&self, marker: &mut Marker, vector: u32, from: u32) {
        let elements = self.heap.vectors[vector].elements();
        if from == 0 {
            marker.bytes += vector_elements(elements.len());
        }
        let others = marker.rests.len();
        for (at, &element) in elements.iter().enumerate().skip(from as usize) {
            marker.push(element);
            if marker.rests.len() > others || !marker.waiting.is_empty() {
                // Below what was found, which is looked into first.
                let found = marker.rests.split_off(others);
                if at + 1 < elements.len() {
                    marker.rests.extend([at as u32 + 1, vector, VECTOR]);
                }
                return marker.rests.extend(found);
            }
        }
    }

    /// Marks what a pair that is marked holds, and the pairs behind it.
    fn mark_list(&self, marker: &mut Marker, first: u32) {
        let mut at = first;
        loop {
            let (car, cdr) = (self.heap.pairs.car(at), self.heap.pairs.cdr(at));
            if car.refers() {
                marker.push(*car);
            }
            match cdr {
                Value::Cons(next) if marker.heap.pairs.set(next) => at = next,
                Value::Cons(_) => return,
                other => return marker.push(other),
            }
            if !marker.waiting.is_empty() {
                return marker.rests.push(at);
            }
        }
    }

    fn mark_object(&self, marker: &mut Marker, value: Value) {
        match value {
            Value::Vector(vector) => self.mark_vector(marker, vector, 0),
            Value::Cell(cell) => marker.extend(self.heap.cells.get(cell)),
            Value::Closure(closure) => {
                if let Some(closure) = self.heap.closures.get(closure) {
                    marker.refer_to(closure.code);
                    marker.bytes += closure.captured.bytes();
                    marker.extend(closure.captured.iter());
                }
            }
            Value::Table(table) => {
                if let Some(table) = self.heap.tables.get(table) {
                    for entry in table.entries() {
                        marker.bytes += entry.bytes();
                        marker.push(entry.key);
                        marker.push(entry.value);
                    }
                }
            }
            Value::Failure(failure) => {
                if let Some(failure) = self.heap.failures.get(failure) {
                    marker.bytes += memory::failure(failure);
                    let calls = failure.calls.iter().map(|&(_, span)| span);
                    calls.chain([failure.span]).for_each(|span| marker.refer_to_text(span));
                    failure.slots.iter().for_each(|&(_, value)| marker.push(value));
                    marker.extend(&failure.parts);
                    marker.extend(&failure.while_cleaning_up);
                }
            }
            Value::Fluent(fluent) => self.mark_fluent(marker, fluent),
            Value::Task(task) => {
                if let Some(index) = self.tasks.find(task) {
                    self.mark_task(marker, index, &self.tasks[index]);
                }
            }
            // They have no parts, and do not wait.
            Value::Cons(_)
            | Value::Str(_)
            | Value::Nil
            | Value::True
            | Value::Int(_)
            | Value::Float(_)
            | Value::Symbol(_)
            | Value::Keyword(_)
            | Value::Function(_)
            | Value::Native(_)
            | Value::Valve(_)
            | Value::Behaviour(_)
            | Value::Unbound => {}
        }
    }

    fn mark_fluent(&self, marker: &mut Marker, index: u32) {
        let Some(fluent) = self.fluents.get(index) else { return };
        marker.push(fluent.value);
        marker.extend(&fluent.failure);
        fluent.inputs.iter().for_each(|&input| marker.push(Value::Fluent(input)));
        if let Origin::Network { code, captured } = &fluent.origin {
            marker.refer_to(*code);
            marker.extend(captured);
        }
    }
}

/// Marks the priorities of a task.
fn mark_priorities(priorities: &mut Marks, task: &Task) {
    priorities.set(task.priority);
    if let Some(boost) = task.rare.as_ref().and_then(|rare| rare.boost) {
        priorities.set(boost);
    }
}

fn mark_leaving(marker: &mut Marker, leaving: &Leaving) {
    match leaving {
        Leaving::Fail(value) | Leaving::FailCall { failure: value, .. } | Leaving::Block { value, .. } => {
            marker.push(*value);
        }
        Leaving::Swap(swap) => marker.refer_to(swap.code),
        Leaving::Evaporate | Leaving::Jump { .. } => {}
    }
}
