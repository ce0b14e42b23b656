//! Garbage collection: mark and sweep, at safe points, triggered by allocation counts only.

use crate::fluent::Origin;
use crate::heap::HeapMarks;
use crate::machine::Machine;
use crate::slab::Marks;
use crate::task::{Decision, Leaving, NONE, Scope, ScopeKind, Then, Waiting};
use crate::value::Value;

struct Marker {
    heap: HeapMarks,
    fluents: Marks,
    tasks: Marks,
    waiting: Vec<Value>,
}

impl Machine {
    /// Frees every object that nothing refers to.
    pub fn collect(&mut self) {
        let mut marker = Marker {
            heap: HeapMarks::new(&self.heap),
            fluents: Marks::new(self.fluents.slots()),
            tasks: Marks::new(self.tasks.slots()),
            waiting: Vec::new(),
        };
        marker.waiting.extend_from_slice(&self.globals);
        marker.waiting.extend_from_slice(&self.constants);
        if self.current != NONE {
            marker.waiting.extend_from_slice(&self.scratch.stack[..self.scratch.top]);
        }
        for activation in &self.activations {
            marker.waiting.extend(activation.failures());
        }
        // Living tasks keep what they hold, whether a plan can name them or not.
        for (index, task) in self.tasks.iter() {
            if !task.state.is_dead() {
                self.mark_task(&mut marker, index);
            }
        }
        self.mark(&mut marker);
        let mut dead_networks = Vec::new();
        for (index, fluent) in self.fluents.iter() {
            if !marker.fluents.is_set(index) {
                dead_networks.push((index, fluent.inputs.clone()));
            }
        }
        for (index, inputs) in dead_networks {
            for input in inputs {
                if let Some(fluent) = self.fluents.get_mut(input) {
                    fluent.dependents.retain(|&dependent| dependent != index);
                }
            }
            self.fluents.remove(index);
        }
        let unnamed: Vec<u32> = self
            .tasks
            .iter()
            .filter(|&(index, task)| task.state.is_dead() && index != self.main && !marker.tasks.is_set(index))
            .map(|(index, _)| index)
            .collect();
        for task in unnamed {
            self.tasks.free(task);
        }
        self.heap.sweep(&marker.heap);
        self.heap.threshold = self.heap.threshold.max(self.tasks.slots());
    }

    fn mark_task(&self, marker: &mut Marker, index: u32) {
        let Some(task) = self.tasks.get(index) else { return };
        if !marker.tasks.set(index) {
            return;
        }
        marker.waiting.extend_from_slice(self.tasks.registers_of(index));
        marker.waiting.push(task.value);
        if let Waiting::Fluent { fluent, .. } = task.waiting {
            marker.waiting.push(Value::Fluent(fluent));
        }
        if let Some(rare) = &task.rare {
            if let Some(leaving) = &rare.leaving {
                mark_leaving(marker, leaving);
            }
            let fluents = &rare.fluents;
            for fluent in [fluents.status, fluents.result, fluents.begin, fluents.end].into_iter().flatten() {
                marker.waiting.push(Value::Fluent(fluent));
            }
        }
        for scope in task.scopes.iter() {
            self.mark_scope(marker, scope);
        }
    }

    fn mark_scope(&self, marker: &mut Marker, scope: &Scope) {
        match &scope.kind {
            ScopeKind::OnInterrupt(hook) | ScopeKind::OnResume(hook) => marker.waiting.push(*hook),
            ScopeKind::InCleanup(then) => {
                if let Then::Leave(leaving) = &**then {
                    mark_leaving(marker, leaving);
                }
            }
            ScopeKind::Children(children) => {
                marker.waiting.push(children.last_value);
                marker.waiting.extend_from_slice(&children.failures);
                if let Some(Decision::Succeed(value) | Decision::Fail(value)) = children.decided {
                    marker.waiting.push(value);
                }
            }
            ScopeKind::Watch(watch) => {
                if let Some(watch) = self.watches.get(*watch) {
                    marker.waiting.push(Value::Fluent(watch.fluent));
                }
            }
            ScopeKind::Call(call) => {
                marker.waiting.extend(call.tags.iter().map(|&tag| Value::Task(tag)));
                marker.waiting.extend(call.failure);
            }
            ScopeKind::Suspended(task) => marker.waiting.push(Value::Task(*task)),
            ScopeKind::Block { .. } | ScopeKind::Handler { .. } | ScopeKind::Cleanup { .. } | ScopeKind::Valve(_) => {}
        }
    }

    fn mark(&self, marker: &mut Marker) {
        while let Some(value) = marker.waiting.pop() {
            match value {
                Value::Cons(first) => {
                    let mut at = first;
                    while marker.heap.pairs.set(at) {
                        let (car, cdr) = &self.heap.pairs[at as usize];
                        if is_object(car) {
                            marker.waiting.push(*car);
                        }
                        match cdr {
                            Value::Cons(next) => at = *next,
                            other => {
                                marker.waiting.push(*other);
                                break;
                            }
                        }
                    }
                }
                Value::Str(text) => drop(marker.heap.strings.set(text)),
                Value::Cell(cell) => {
                    if marker.heap.cells.set(cell)
                        && let Some(&value) = self.heap.cells.get(cell)
                    {
                        marker.waiting.push(value);
                    }
                }
                Value::Closure(closure) => {
                    if marker.heap.closures.set(closure)
                        && let Some(closure) = self.heap.closures.get(closure)
                    {
                        marker.waiting.extend_from_slice(&closure.captured);
                    }
                }
                Value::Table(table) => {
                    if marker.heap.tables.set(table)
                        && let Some(table) = self.heap.tables.get(table)
                    {
                        for &(key, value) in table.entries.values() {
                            marker.waiting.push(key);
                            marker.waiting.push(value);
                        }
                    }
                }
                Value::Failure(failure) => {
                    if marker.heap.failures.set(failure)
                        && let Some(failure) = self.heap.failures.get(failure)
                    {
                        marker.waiting.extend(failure.slots.iter().map(|&(_, value)| value));
                        marker.waiting.extend_from_slice(&failure.parts);
                        marker.waiting.extend_from_slice(&failure.while_cleaning_up);
                    }
                }
                Value::Fluent(fluent) => self.mark_fluent(marker, fluent),
                Value::Task(task) => {
                    if let Some(index) = self.tasks.find(task) {
                        self.mark_task(marker, index);
                    }
                }
                _ => {}
            }
        }
    }

    fn mark_fluent(&self, marker: &mut Marker, index: u32) {
        let Some(fluent) = self.fluents.get(index) else { return };
        if !marker.fluents.set(index) {
            return;
        }
        marker.waiting.push(fluent.value);
        marker.waiting.extend(fluent.failure);
        marker.waiting.extend(fluent.inputs.iter().map(|&input| Value::Fluent(input)));
        if let Origin::Network { captured, .. } = &fluent.origin {
            marker.waiting.extend_from_slice(captured);
        }
    }
}

/// Whether there may be something to mark.
fn is_object(value: &Value) -> bool {
    !matches!(value, Value::Nil | Value::True | Value::Int(_) | Value::Float(_) | Value::Symbol(_) | Value::Keyword(_))
}

fn mark_leaving(marker: &mut Marker, leaving: &Leaving) {
    match leaving {
        Leaving::Fail(value) | Leaving::FailCall { failure: value, .. } | Leaving::Block { value, .. } => {
            marker.waiting.push(*value);
        }
        Leaving::Evaporate | Leaving::Jump { .. } => {}
    }
}
