//! Hooks that run while a valve changes hands.

use crate::state::machine::Machine;
use crate::state::registers::Registers;
use crate::state::task::{ScopeKind, State, Task};
use crate::state::value::Value;
use crate::state::valve_place::{Handover, HoldPurpose};
use crate::step::native::Surroundings;
use std::collections::BTreeSet;

impl Machine {
    /// Closures of the active hooks of a subtree, innermost first, but for what is interrupted
    /// already.
    pub(crate) fn hooks_of(&self, root: u32, place: u32, on_interrupt: bool) -> Vec<Value> {
        let places = self.valves[self.valve_of_place(place) as usize].places();
        let marks = places.flat_map(|place| self.places[place as usize].interrupted());
        let marks = marks.filter_map(|mark| self.tasks.find(mark));
        let interrupted: BTreeSet<u32> = marks.filter(|&mark| mark != root).collect();
        let mut hooks = Vec::new();
        let mut waiting = vec![(root, false)];
        while let Some((task, children_done)) = waiting.pop() {
            if !children_done {
                waiting.push((task, true));
                let children = self.children(task).into_iter().rev();
                waiting.extend(children.filter(|child| !interrupted.contains(child)).map(|child| (child, false)));
                continue;
            }
            hooks.extend(self.tasks[task].scopes.iter().rev().filter_map(|scope| match scope.kind {
                ScopeKind::OnInterrupt(hook) if on_interrupt => Some(hook),
                ScopeKind::OnResume(hook) if !on_interrupt => Some(hook),
                _ => None,
            }));
        }
        hooks
    }

    /// Runs hooks in a task of their own below the subtree's root, which holds the place meanwhile.
    /// Tells whether there is anything to run.
    pub(crate) fn start_hooks(
        &mut self,
        around: &mut Surroundings<'_>,
        root: u32,
        place: u32,
        hooks: &[Value],
        handover: Handover,
    ) -> bool {
        let runner = self.symbols.find("%run-hooks").and_then(|name| around.program.names.get(&name));
        let runner = runner.map(|&global| self.globals[global as usize]);
        let (Some(Value::Function(code)), false) = (runner, hooks.is_empty()) else { return false };
        self.places[place as usize].handover = Some(handover);
        let list = self.heap.list(hooks);
        let name = self.symbols.intern("hooks");
        let registers = self.tasks.registers.set(Registers::default(), &[list]);
        let mut task = Task::new(code, registers, name, self.tasks[root].priority);
        task.priority_depth = self.tasks[root].priority_depth;
        task.rare().hooks_for = Some(place);
        task.occurrence = self.count_use(root, name);
        let index = self.tasks.insert(task);
        self.adopt(root, self.tasks[root].scopes.len() as u32, index);
        self.take(index, place, HoldPurpose::Hooks);
        self.set_claim(place, None);
        self.make_ready(index);
        self.trace_task_begin(index);
        true
    }

    /// If the task ran hooks, the valve changes hands now.
    pub(crate) fn hooks_ended(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let Some(place) = self.tasks[task].rare.as_ref().and_then(|rare| rare.hooks_for) else { return };
        if self.tasks[task].state() == State::Failed {
            let failure = *self.tasks[task].value();
            self.warn_of_failure(around.program, failure, "in a hook");
        }
        if self.places[place as usize].handover.take() == Some(Handover::GiveBack) {
            self.lift_mark(around, place);
        }
        self.stir(around, self.valve_of_place(place));
    }
}
