//! The task tree.

use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::slab::NONE;
use crate::state::task::ScopeKind;
use crate::state::value::Value;
use rpl_lang::symbol::Symbol;

impl Machine {
    /// A name for a task that a plan can keep.
    pub(crate) fn expose(&mut self, task: u32) -> Value {
        self.tasks[task].exposed = true;
        Value::Task(self.tasks.reference(task))
    }

    /// Adds a task under a scope of its parent.
    pub(crate) fn adopt(&mut self, parent: u32, parent_scope: u32, task: u32) {
        let last = self.tasks[parent].last_child;
        self.tasks[task].parent = parent;
        self.tasks[task].parent_scope = parent_scope;
        self.tasks[task].previous_sibling = last;
        let inherited = self.stop_for_child(parent, parent_scope);
        let record = &mut self.tasks[task];
        let stop = record.own_stops() + if record.named_as_hook() { 0 } else { inherited };
        if stop != record.stop() {
            record.rare().stop = stop;
        }
        if last == NONE {
            self.tasks[parent].first_child = task;
        } else {
            self.tasks[last].next_sibling = task;
        }
        self.tasks[parent].last_child = task;
    }

    /// A child shares its parent's suspensions, unless it belongs to a clean-up of the parent.
    fn stop_for_child(&self, parent: u32, scope: u32) -> u32 {
        let record = &self.tasks[parent];
        if record.stop() == 0 || record.is_within_clean_up(scope) { 0 } else { record.stop() }
    }

    pub(crate) fn disown(&mut self, task: u32) {
        let record = &mut self.tasks[task];
        let (parent, previous, next) = (record.parent, record.previous_sibling, record.next_sibling);
        if parent == NONE {
            return;
        }
        (record.previous_sibling, record.next_sibling) = (NONE, NONE);
        if previous == NONE {
            self.tasks[parent].first_child = next;
        } else {
            self.tasks[previous].next_sibling = next;
        }
        if next == NONE {
            self.tasks[parent].last_child = previous;
        } else {
            self.tasks[next].previous_sibling = previous;
        }
    }

    /// Living children of one scope, in order of creation.
    pub(crate) fn children_of_scope(&self, parent: u32, scope: u32) -> Vec<u32> {
        self.look_for_children(parent, scope).0
    }

    /// The same, and how many were looked at. They are looked for from the last one back, and no
    /// further than the first of them: the innermost scope's are the last.
    pub(crate) fn look_for_children(&self, parent: u32, scope: u32) -> (Vec<u32>, u64) {
        let count = match self.tasks[parent].scopes.get(scope as usize).map(|scope| &scope.kind) {
            Some(ScopeKind::Children(children)) => children.alive as usize,
            Some(ScopeKind::Call(call)) => call.spawned as usize,
            _ => 0,
        };
        let mut children = Vec::with_capacity(count);
        let (mut at, mut looked_at) = (self.tasks[parent].last_child, 0);
        while at != NONE && children.len() < count {
            looked_at += 1;
            let child = &self.tasks[at];
            if child.parent_scope == scope && !child.named_as_hook() {
                children.push(at);
            }
            at = child.previous_sibling;
        }
        children.reverse();
        (children, looked_at)
    }

    /// The innermost plan call around what a task does now: the task it belongs to, and its scope.
    pub(crate) fn plan_call_around(&mut self, task: u32) -> Option<(u32, usize)> {
        let (mut at, mut upto) = (task, usize::MAX);
        while at != NONE {
            self.scratch.work += 1;
            let record = &self.tasks[at];
            if let Some(call) = record.scopes.call_within(upto) {
                return Some((at, call));
            }
            (at, upto) = (record.parent, record.parent_scope as usize + 1);
        }
        None
    }

    /// Living children, in order of creation.
    pub fn children(&self, parent: u32) -> Vec<u32> {
        let mut children = Vec::new();
        let mut at = self.tasks[parent].first_child;
        while at != NONE {
            children.push(at);
            at = self.tasks[at].next_sibling;
        }
        children
    }

    /// Main and all tasks below it, each before its children. Which slots they have depends on what
    /// was collected before, so what a plan can see goes by this order.
    pub fn living_tasks(&self) -> Vec<u32> {
        let mut tasks = Vec::new();
        let mut waiting = vec![self.main];
        while let Some(task) = waiting.pop() {
            tasks.push(task);
            waiting.extend(self.children(task).into_iter().rev());
        }
        tasks
    }

    /// Whether a task is another or below it.
    pub(crate) fn is_within(&self, task: u32, ancestor: u32) -> bool {
        let mut at = task;
        while at != NONE {
            if at == ancestor {
                return true;
            }
            at = self.tasks[at].parent;
        }
        false
    }

    /// How often a name has been used at this node of the tree, this use included: the innermost
    /// plan call of the task, or the task itself.
    pub(crate) fn count_use(&mut self, task: u32, name: Symbol) -> u32 {
        let record = &mut self.tasks[task];
        let counters = match record.scopes.innermost_call() {
            Some(call) => &mut call.counters,
            None => &mut record.rare.get_or_insert_default().counters,
        };
        if counters.is_empty() {
            self.heap.allocated += memory::COUNTERS;
        }
        let count = counters.entry(name).or_insert(0);
        *count += 1;
        *count
    }
}
