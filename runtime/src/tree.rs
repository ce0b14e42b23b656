//! The task tree: links, paths, readiness, waiting and suspension.

use crate::machine::{Machine, Surroundings};
use crate::memory;
use crate::scheduler::Line;
use crate::task::{Frame, NONE, Rare, ScopeKind, State, Task, Waiting, Wake};
use crate::value::Value;
use rpl_lang::source::Span;
use rpl_lang::symbol::Symbol;
use rpl_lang::visible::visible;

/// Names a path shows at most; what is deeper shows its innermost ones.
const MAX_SEGMENTS: usize = 64;

impl Machine {
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
        let (parent, previous, next) =
            (self.tasks[task].parent, self.tasks[task].previous_sibling, self.tasks[task].next_sibling);
        if parent == NONE {
            return;
        }
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
        self.tasks[task].next_sibling = NONE;
        self.tasks[task].previous_sibling = NONE;
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
    pub(crate) fn path_within(&self, task: u32, scopes: usize) -> String {
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
        if task.named_by_construct { format!("{name}[{}]", task.position) } else { name }
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

    /// The priority a task runs at: its own, or that of a requester whose way it blocks.
    pub(crate) fn effective_priority(&self, task: u32) -> u32 {
        let record = &self.tasks[task];
        match record.rare.as_ref().and_then(|rare| rare.boost) {
            Some(boost) => self.priorities.higher(record.priority, boost),
            None => record.priority,
        }
    }

    /// Whether the task stands in the run queue: ready, and not held by a suspension.
    pub(crate) fn is_queued(&self, task: u32) -> bool {
        let record = &self.tasks[task];
        record.state == State::Ready && !record.is_held()
    }

    #[inline]
    pub(crate) fn set_state(&mut self, task: u32, state: State) {
        let record = &mut self.tasks[task];
        let from = record.state;
        if from == state {
            return;
        }
        if !from.may_become(state) {
            refuse_transition(from, state);
        }
        record.state = state;
        if record.rare.is_some() {
            self.note_status(task);
        }
    }

    /// Makes a task ready; unless it is suspended it enters the run queue.
    pub(crate) fn make_ready(&mut self, task: u32) {
        self.set_state(task, State::Ready);
        self.queue(task, false);
    }

    #[inline]
    fn queue(&mut self, task: u32, front: bool) {
        if self.claims > 0 {
            self.renew_boost(task);
        }
        let record = &self.tasks[task];
        let priority = if record.rare.is_none() && record.state == State::Ready {
            record.priority
        } else if self.is_queued(task) {
            self.effective_priority(task)
        } else {
            return;
        };
        self.priorities.enqueue(&mut self.tasks, task, priority, front);
        if self.current == NONE || self.scratch.switch {
            return;
        }
        let current = &self.tasks[self.current];
        if (current.priority != priority || current.rare.is_some())
            && self.priorities.is_higher(priority, self.effective_priority(self.current))
        {
            self.scratch.switch = true;
        }
    }

    /// Puts the running task back: at the front of its line, or aside if it is suspended.
    pub(crate) fn requeue_running(&mut self, task: u32) {
        self.set_state(task, State::Ready);
        self.queue(task, true);
    }

    /// Puts the running task back as if nothing had happened: no fluent tells of it.
    pub(crate) fn set_aside(&mut self, task: u32) {
        self.tasks[task].state = State::Ready;
        self.queue(task, true);
    }

    /// Takes a task out of the run queue, if it stands there.
    pub(crate) fn unqueue(&mut self, task: u32) {
        if self.is_queued(task) {
            let priority = self.effective_priority(task);
            self.priorities.withdraw(&mut self.tasks, task, priority);
        }
    }

    /// Wakes a blocked task with what it waited for. Only the first wake-up of a wait counts.
    pub(crate) fn wake(&mut self, task: u32, wake: Wake) {
        if self.tasks[task].state != State::Blocked {
            return;
        }
        self.stop_waiting(task);
        self.tasks[task].set_wake(wake);
        self.trace_woken(task);
        self.make_ready(task);
    }

    /// Gives a task's wait a number that no wait had before. The counter goes round, so that of two
    /// waits the earlier one is known as long as there are less than 2³¹ between them.
    pub(crate) fn number_wait(&mut self, task: u32) {
        self.waits = self.waits.wrapping_add(1);
        self.tasks[task].wait_number = self.waits;
    }

    /// Withdraws a task from whatever it waits for.
    pub(crate) fn stop_waiting(&mut self, task: u32) {
        let waiting = std::mem::take(&mut self.tasks[task].waiting);
        self.number_wait(task);
        match waiting {
            Waiting::Fluent { fluent, owned, timed } => {
                self.leave_fluent(task, fluent, owned);
                if timed {
                    self.forget_timer();
                }
            }
            Waiting::Watch(watch) => {
                if let Some(entry) = self.watches.get_mut(watch) {
                    entry.waits = false;
                }
            }
            Waiting::Time => {
                if self.end_timed_wait(task) {
                    self.forget_timer();
                }
            }
            Waiting::Valve(valve) => self.leave_valve_line(task, valve),
            Waiting::Death(other) => {
                self.leave_line(task, other, |rare| &mut rare.mourners);
            }
            Waiting::Rest(other) => {
                self.waits_for_rest -= 1;
                self.leave_line(task, other, |rare| &mut rare.resters);
            }
            Waiting::Nothing | Waiting::Children | Waiting::Spawned | Waiting::Signal(_) => {}
        }
    }

    /// Puts a task at the end of a line that another one keeps.
    pub(crate) fn join_line(&mut self, task: u32, other: u32, line: fn(&mut Rare) -> &mut Line) {
        let mut joined = *line(self.tasks[other].rare());
        joined.push_back(&mut self.tasks, task);
        let rare = self.tasks[other].rare();
        *line(rare) = joined;
        rare.in_lines += 1;
    }

    fn leave_line(&mut self, task: u32, other: u32, line: fn(&mut Rare) -> &mut Line) {
        let mut left = *line(self.tasks[other].rare());
        left.remove(&mut self.tasks, task);
        let rare = self.tasks[other].rare();
        *line(rare) = left;
        rare.in_lines -= 1;
    }

    pub(crate) fn forget_timer(&mut self) {
        let tasks = &self.tasks;
        self.timers.note_cancelled(|timer| is_current(tasks, timer));
    }

    /// Suspends a task and what is below it, once more, until `resume` takes it back; `by` is the
    /// task that wants it, if one does.
    pub(crate) fn suspend(&mut self, around: &mut Surroundings<'_>, task: u32, by: u32) {
        self.tasks[task].rare().suspensions += 1;
        self.add_stop(around, task, by);
    }

    /// Takes one suspension back; a surplus one does nothing.
    pub(crate) fn resume(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let rare: &mut Rare = self.tasks[task].rare();
        if rare.suspensions > 0 {
            rare.suspensions -= 1;
            self.remove_stop(around, task);
        }
    }

    /// Suspends a task and what is below it for a valve.
    pub(crate) fn hold(&mut self, around: &mut Surroundings<'_>, task: u32) {
        self.hold_for(around, task, NONE);
    }

    /// Suspends a task and what is below it for a scope of the task `by`, or for none.
    pub(crate) fn hold_for(&mut self, around: &mut Surroundings<'_>, task: u32, by: u32) {
        self.tasks[task].rare().holds += 1;
        self.add_stop(around, task, by);
    }

    /// Ends what [`Machine::hold`] began.
    pub(crate) fn unhold(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let rare: &mut Rare = self.tasks[task].rare();
        assert!(rare.holds > 0, "a hold ends once");
        rare.holds -= 1;
        self.remove_stop(around, task);
    }

    /// Tasks that a suspension of this one reaches: all children but those of its clean-ups and
    /// hooks.
    pub(crate) fn suspended_with(&self, task: u32) -> Vec<u32> {
        let record = &self.tasks[task];
        let cleans_up = record.is_cleaning_up();
        let mut children = self.children(task);
        children.retain(|&child| {
            let child = &self.tasks[child];
            !(child.named_as_hook() || cleans_up && record.is_within_clean_up(child.parent_scope))
        });
        children
    }

    fn add_stop(&mut self, around: &mut Surroundings<'_>, root: u32, by: u32) {
        let mut waiting = vec![root];
        while let Some(task) = waiting.pop() {
            let was_queued = self.is_queued(task);
            self.change_line(task, |machine| machine.tasks[task].rare().stop += 1);
            if self.tasks[task].stop() == 1 {
                self.trace_suspended(task, by);
            }
            if was_queued && !self.is_queued(task) {
                let priority = self.effective_priority(task);
                self.priorities.withdraw(&mut self.tasks, task, priority);
            }
            if task == self.current {
                self.scratch.switch = true;
            }
            self.turn_clocks(task);
            self.note_status(task);
            waiting.extend(self.suspended_with(task).into_iter().rev());
        }
        self.serve_valves(around);
    }

    fn remove_stop(&mut self, around: &mut Surroundings<'_>, root: u32) {
        let mut waiting = vec![root];
        let mut resumed = Vec::new();
        while let Some(task) = waiting.pop() {
            let was_queued = self.is_queued(task);
            self.change_line(task, |machine| machine.tasks[task].rare().stop -= 1);
            if !was_queued {
                self.queue(task, false);
            }
            self.turn_clocks(task);
            if self.tasks[task].stop() == 0 {
                self.trace_resumed(task);
                resumed.push(task);
            }
            self.note_status(task);
            waiting.extend(self.suspended_with(task).into_iter().rev());
        }
        self.take_up_deadlines(around, &resumed);
        self.serve_valves(around);
    }

    /// Whether no task of a subtree runs a clean-up, so that a suspension has reached all of it.
    pub(crate) fn is_at_rest(&self, root: u32) -> bool {
        let mut waiting = vec![root];
        while let Some(task) = waiting.pop() {
            let record = &self.tasks[task];
            if record.is_protected() {
                return false;
            }
            waiting.extend(self.children(task));
        }
        true
    }

    /// Lets the current task wait until a subtree it has suspended is at rest; tells whether it
    /// must.
    pub(crate) fn wait_for_rest(&mut self, other: u32) -> bool {
        let current = self.current;
        if self.is_within(current, other) || self.is_at_rest(other) {
            return false;
        }
        self.join_line(current, other, |rare| &mut rare.resters);
        self.tasks[current].waiting = Waiting::Rest(other);
        self.waits_for_rest += 1;
        true
    }

    /// A clean-up or departure of a task has ended: what waited for that goes on.
    pub(crate) fn protection_ended(&mut self, around: &mut Surroundings<'_>, task: u32) {
        if !self.tasks[task].state.is_dead() {
            self.turn_clocks(task);
        }
        let mut at = task;
        while self.waits_for_rest > 0 && at != NONE {
            let resters = self.tasks[at].rare.as_ref().map_or(Line::default(), |rare| rare.resters);
            if resters != Line::default() && (self.tasks[at].state.is_dead() || self.is_at_rest(at)) {
                for rester in resters.tasks(&self.tasks) {
                    self.wake(rester, Wake::Value(Value::Nil));
                }
            }
            at = self.tasks[at].parent;
        }
        self.stir_claims_above(around, task);
    }

    /// Notes that the state of a task has changed, for its status fluent.
    pub(crate) fn note_status(&mut self, task: u32) {
        if self.tasks[task].rare.as_ref().is_some_and(|rare| rare.fluents.status.is_some()) {
            let task = self.tasks.reference(task);
            self.scratch.status_changed.push(task);
        }
    }

    /// Brings the status fluents of the tasks whose state has changed up to date.
    #[inline]
    pub(crate) fn flush_status(&mut self, around: &mut Surroundings<'_>) {
        if !self.scratch.status_changed.is_empty() {
            self.flush_changed_status(around);
        }
    }

    #[cold]
    fn flush_changed_status(&mut self, around: &mut Surroundings<'_>) {
        while !self.scratch.status_changed.is_empty() {
            for task in std::mem::take(&mut self.scratch.status_changed) {
                if let Some(task) = self.tasks.find_alive(task) {
                    self.update_task_fluents(around, task);
                }
            }
        }
    }

    /// Moves the current task's registers and frames into its record.
    #[inline]
    pub(crate) fn store(&mut self, task: u32, frame: Frame, registers: usize) {
        let before = self.tasks.registers.bytes();
        self.tasks.set_registers(task, &self.scratch.stack[..frame.base as usize + registers]);
        self.heap.allocated += self.tasks.registers.bytes() - before;
        self.scratch.work += u64::from(frame.base);
        let record = &mut self.tasks[task];
        if !(record.frames.is_empty() && self.scratch.frames.is_empty()) {
            let more = self.scratch.frames.len().saturating_sub(record.frames.len());
            self.heap.allocated += more * size_of::<Frame>();
            record.frames.set(&self.scratch.frames);
        }
        record.frame = frame;
    }

    /// The fluents about a task follow its state.
    pub(crate) fn update_task_fluents(&mut self, around: &mut Surroundings<'_>, task: u32) {
        let Some(rare) = &self.tasks[task].rare else { return };
        let fluents = rare.fluents.clone();
        let record = &self.tasks[task];
        let (state, result) = (record.state, record.value);
        let suspended = record.is_held() && !state.is_dead() && state != State::Created;
        let begun = Value::truth(state != State::Created);
        let name = if suspended { "suspended" } else { state.name() };
        let status = Value::Symbol(self.symbols.intern(name));
        let ended = Value::truth(state.is_dead());
        let pairs = [
            (fluents.status, status),
            (fluents.result, if state.is_dead() { result } else { Value::Nil }),
            (fluents.begin, begun),
            (fluents.end, ended),
        ];
        let values: Vec<(u32, Value)> =
            pairs.into_iter().filter_map(|(fluent, value)| Some((fluent?, value))).collect();
        if !values.is_empty() {
            self.assign_all(around, &values);
        }
    }
}

#[cold]
fn refuse_transition(from: State, to: State) -> ! {
    panic!("a task cannot become {} after {}", to.name(), from.name())
}

/// Whether a timer still has something to do.
pub(crate) fn is_current(tasks: &crate::task::Tasks, timer: &crate::scheduler::Timer) -> bool {
    let Some(task) = tasks.find_alive(timer.task) else { return false };
    let record = &tasks[task];
    match timer.alarm {
        crate::scheduler::Alarm::Wake(number) => record.state == State::Blocked && record.wait_number == number,
        crate::scheduler::Alarm::Deadline => record.scopes.iter().rev().any(|scope| {
            matches!(&scope.kind, ScopeKind::Children(children)
                if children.timer == timer.number && children.decided.is_none())
        }),
    }
}

impl Machine {
    /// Lets a running task go to the end of the line of its priority: its wait is over already.
    pub(crate) fn give_way(&mut self, task: u32) {
        self.tasks[task].waiting = Waiting::Nothing;
        self.scratch.gives_way = true;
    }
}
