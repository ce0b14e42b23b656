//! Whether what was read from bytes is a machine of its program: every number that names something
//! names something. What is true between the parts is checked after this by
//! [`Machine::check_invariants`], which relies on it.

use crate::state::fluent::Origin;
use crate::state::line::Line;
use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::slab::Marks;
use crate::state::slab::NONE;
use crate::state::task::{Children, Decision, Leaving, Raises, Scope, ScopeKind, Swap, Task, Then, Waiting};
use crate::state::value::{TaskRef, Value};
use crate::state::valve_place::{HoldPurpose, LinkKind};
use crate::step::exec::WINDOW;
use rpl_lang::code::{Op, Program};
use rpl_lang::symbol::Symbol;

/// Counters that only grow stay far from their end.
const MAX_COUNT: u32 = u32::MAX / 2;

fn ensure(holds: bool, what: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(what.to_string()) }
}

/// What the numbers in a machine may name.
pub(crate) struct Bounds<'p> {
    pub(crate) program: &'p Program,
    pub(crate) natives: usize,
    pub(crate) behaviours: usize,
}

impl Bounds<'_> {
    fn code(&self, code: u32) -> Result<(), String> {
        ensure((code as usize) < self.program.codes.len(), "a code is not in the program")
    }
}

impl Machine {
    /// Checks everything that is named by a number.
    ///
    /// # Errors
    /// One sentence about the first thing that names nothing. Cost: linear.
    pub(crate) fn validate(&self, bounds: &Bounds<'_>) -> Result<(), String> {
        ensure(self.is_whole(), "a table's list of free places is wrong")?;
        ensure(
            self.constants.len() == bounds.program.constants.len(),
            "there are not as many constants as in the program",
        )?;
        ensure(self.globals.len() == bounds.program.globals.len(), "there are not as many globals as in the program")?;
        ensure(self.current == NONE, "a task runs between two steps")?;
        ensure(self.now_us <= u64::MAX / 4, "the clock has run out")?;
        ensure(self.instant <= MAX_COUNT && self.next_identity <= u64::MAX / 2, "a counter has run out")?;
        // It is asked for after its end.
        let has_main = self.main != SCRATCH_TASK && self.tasks.get(self.main).is_some_and(|main| main.exposed);
        ensure(has_main && self.tasks.get(SCRATCH_TASK).is_some(), "there is no main task")?;
        for &value in self.globals.iter().chain(&self.constants) {
            self.validate_value(bounds, value)?;
        }
        self.validate_heap(bounds)?;
        self.validate_fluents(bounds)?;
        self.validate_valves(bounds)?;
        for (index, task) in self.tasks.iter() {
            let has_code = !task.state().is_dead() && (task.parent != NONE || index == self.main);
            self.validate_task(bounds, task, has_code).map_err(|what| format!("task {index}: {what}"))?;
        }
        ensure(self.priorities.is_whole(), "the table of priorities is wrong")?;
        self.validate_lines()?;
        for (name, _) in self.measures.iter() {
            self.symbol(name)?;
        }
        for timer in self.timers.iter() {
            self.validate_reference(timer.task)?;
        }
        Ok(())
    }

    fn is_whole(&self) -> bool {
        self.fluents.is_whole() && self.watches.is_whole() && self.tasks.is_whole() && self.heap.is_whole()
    }

    fn symbol(&self, symbol: Symbol) -> Result<(), String> {
        ensure(self.symbols.contains(symbol), "a symbol has no name")
    }

    fn validate_reference(&self, task: TaskRef) -> Result<(), String> {
        ensure(self.tasks.may_be_named(task), "a task is not in its table")
    }

    fn validate_link(&self, task: u32) -> Result<(), String> {
        ensure(task == NONE || self.tasks.get(task).is_some(), "a link leads to no task")
    }

    fn fluent(&self, fluent: u32) -> Result<(), String> {
        ensure(self.fluents.get(fluent).is_some(), "a fluent is not in its table")
    }

    fn validate_value(&self, bounds: &Bounds<'_>, value: Value) -> Result<(), String> {
        let heap = &self.heap;
        match value {
            Value::Nil | Value::True | Value::Int(_) | Value::Float(_) | Value::Unbound => Ok(()),
            Value::Symbol(symbol) | Value::Keyword(symbol) => self.symbol(symbol),
            Value::Cons(pair) => ensure((pair as usize) < heap.pairs.places(), "a pair is not in the heap"),
            Value::Str(text) => ensure(heap.strings.get(text).is_some(), "a string is not in the heap"),
            Value::Cell(cell) => ensure(heap.cells.get(cell).is_some(), "a cell is not in the heap"),
            Value::Function(code) => bounds.code(code),
            Value::Closure(closure) => ensure(heap.closures.get(closure).is_some(), "a closure is not in the heap"),
            Value::Native(native) => ensure(usize::from(native) < bounds.natives, "there is no such native function"),
            Value::Fluent(fluent) => self.fluent(fluent),
            Value::Task(task) => self.validate_reference(task),
            Value::Valve(valve) => ensure((valve as usize) < self.valves.len(), "there is no such valve"),
            Value::Failure(failure) => ensure(heap.failures.get(failure).is_some(), "a failure is not in the heap"),
            Value::Table(table) => ensure(heap.tables.get(table).is_some(), "a table is not in the heap"),
            Value::Vector(vector) => ensure(heap.vectors.get(vector).is_some(), "a vector is not in the heap"),
            Value::Behaviour(number) => ensure(usize::from(number) < bounds.behaviours, "there is no such behaviour"),
        }
    }

    fn validate_failure(&self, bounds: &Bounds<'_>, value: Value) -> Result<(), String> {
        ensure(matches!(value, Value::Failure(_)), "what is raised is no failure")?;
        self.validate_value(bounds, value)
    }

    fn validate_values<'v>(
        &self,
        bounds: &Bounds<'_>,
        values: impl IntoIterator<Item = &'v Value>,
    ) -> Result<(), String> {
        values.into_iter().try_for_each(|&value| self.validate_value(bounds, value))
    }

    fn validate_heap(&self, bounds: &Bounds<'_>) -> Result<(), String> {
        for (car, cdr) in self.heap.pairs.iter() {
            self.validate_value(bounds, car)?;
            self.validate_value(bounds, cdr)?;
        }
        for (_, &value) in self.heap.cells.iter() {
            self.validate_value(bounds, value)?;
        }
        for (_, closure) in self.heap.closures.iter() {
            bounds.code(closure.code)?;
            let code = &bounds.program.codes[closure.code as usize];
            let captures = code.captures.len();
            ensure(closure.captured.len() == captures, "a closure has captured what its code does not name")?;
            self.validate_values(bounds, closure.captured.iter())?;
        }
        for (_, table) in self.heap.tables.iter() {
            for entry in table.entries() {
                self.validate_values(bounds, &[entry.key, entry.value])?;
                ensure(entry.is_whole(&self.heap.strings), "an entry of a table has the hash of another key")?;
            }
        }
        for (_, vector) in self.heap.vectors.iter() {
            self.validate_values(bounds, vector.elements())?;
        }
        for (_, failure) in self.heap.failures.iter() {
            self.symbol(failure.class)?;
            for &(name, value) in &failure.slots {
                self.symbol(name)?;
                self.validate_value(bounds, value)?;
            }
            for &part in failure.parts.iter().chain(&failure.while_cleaning_up) {
                self.validate_value(bounds, part)?;
            }
            for &(name, _) in &failure.calls {
                self.symbol(name)?;
            }
        }
        Ok(())
    }

    fn validate_fluents(&self, bounds: &Bounds<'_>) -> Result<(), String> {
        for (_, fluent) in self.fluents.iter() {
            fluent.name.map_or(Ok(()), |name| self.symbol(name))?;
            self.validate_value(bounds, fluent.value)?;
            fluent.failure.map_or(Ok(()), |failure| self.validate_failure(bounds, failure))?;
            fluent.inputs.iter().chain(fluent.dependents.iter()).try_for_each(|&other| self.fluent(other))?;
            let rises = fluent.inputs.iter().all(|&input| self.fluents[input].height < MAX_COUNT);
            ensure(rises, "a network is too deep")?;
            if let Origin::Network { code, captured } = &fluent.origin {
                bounds.code(*code)?;
                let captures = bounds.program.codes[*code as usize].captures.len();
                ensure(captured.len() == captures, "a network has captured what its code does not name")?;
                self.validate_values(bounds, captured)?;
            }
            let known = |&(_, watch): &(u64, u32)| self.watches.get(watch).is_some();
            ensure(fluent.watches.iter().all(known), "a watch is not in its table")?;
        }
        for (_, watch) in self.watches.iter() {
            self.fluent(watch.fluent)?;
            ensure(self.tasks.get(watch.task).is_some(), "a watch belongs to no task")?;
        }
        Ok(())
    }

    fn validate_valves(&self, bounds: &Bounds<'_>) -> Result<(), String> {
        for place in &self.places {
            ensure((place.valve as usize) < self.valves.len(), "a place belongs to no valve")?;
            for link in &place.links {
                self.validate_reference(link.task)?;
                if let LinkKind::Hold { count, purpose } = link.kind {
                    ensure(count > 0 && count <= MAX_COUNT, "a hold counts nothing")?;
                    if let HoldPurpose::Activation(behaviour) = purpose {
                        ensure(usize::from(behaviour) < bounds.behaviours, "there is no such behaviour")?;
                    }
                }
            }
            if let Some(claim) = place.claim {
                self.validate_reference(claim.root)?;
                ensure(self.priorities.knows(claim.priority), "a priority is not in its table")?;
            }
        }
        for valve in &self.valves {
            self.symbol(valve.name)?;
            let last = valve.first_place.checked_add(valve.places);
            let is_there = last.is_some_and(|last| valve.places > 0 && last as usize <= self.places.len());
            ensure(is_there, "a valve has places that are not in their table")?;
            for (&task, waiter) in &valve.waiters {
                ensure(self.tasks.get_alive(task).is_some(), "a task that waits for a valve is not in its table")?;
                ensure(self.priorities.knows(waiter.turn.priority), "a priority is not in its table")?;
            }
            let lines = valve.lines.values().flat_map(|below| below.line.iter());
            for (turn, task) in valve.line.iter().chain(lines) {
                ensure(self.priorities.knows(turn.priority), "a priority is not in its table")?;
                ensure(valve.waiters.contains_key(&task), "a line has a task that does not wait")?;
            }
            ensure(valve.asked <= u64::MAX / 2 && valve.last_link <= u64::MAX / 2, "a counter has run out")?;
        }
        ensure(self.activations.len() <= bounds.behaviours, "there is no such behaviour")?;
        for activation in &self.activations {
            activation.task.map_or(Ok(()), |task| self.validate_reference(task))?;
            activation.kept.iter().try_for_each(|(task, _)| self.validate_reference(*task))?;
            activation.signals().try_for_each(|signal| match signal {
                Ok(value) => self.validate_value(bounds, value),
                Err(failure) => self.validate_failure(bounds, failure),
            })?;
        }
        Ok(())
    }

    fn validate_task(&self, bounds: &Bounds<'_>, task: &Task, has_code: bool) -> Result<(), String> {
        self.symbol(task.name)?;
        self.validate_values(bounds, self.tasks.registers.get(task.registers).iter().chain([task.value()]))?;
        ensure(
            task.raises == Raises::Nothing || task.state().is_dead() || matches!(task.value(), Value::Failure(_)),
            "what is raised is no failure",
        )?;
        // The record of a dead task may outlive those around it, and its links are followed no more.
        // Places in a line are checked with the line: a task in none keeps old ones.
        if !task.state().is_dead() {
            let links = [task.parent, task.first_child, task.last_child, task.next_sibling, task.previous_sibling];
            links.into_iter().try_for_each(|link| self.validate_link(link))?;
        }
        ensure(self.priorities.knows(task.priority), "a priority is not in its table")?;
        ensure(task.stop() <= MAX_COUNT, "a counter has run out")?;
        if has_code {
            let mut base = 0;
            for frame in task.frames.iter().chain([&task.frame]) {
                bounds.code(frame.code)?;
                let code = &bounds.program.codes[frame.code as usize];
                ensure((frame.pc as usize) < code.ops.len(), "a frame goes on beyond its code")?;
                ensure(frame.base >= base && frame.base - base <= WINDOW as u32, "a frame lies beyond its caller's")?;
                base = frame.base;
            }
        }
        for scope in task.scopes.iter() {
            self.validate_scope(bounds, task, scope)?;
        }
        if let Some(leaving) = task.leaving() {
            self.validate_leaving(bounds, task, leaving)?;
        }
        if let Some(waiting) = task.waiting() {
            self.validate_waiting(bounds, waiting)?;
        }
        let Some(rare) = &task.rare else { return Ok(()) };
        let fluents = [rare.fluents.status, rare.fluents.result, rare.fluents.begin, rare.fluents.end];
        fluents.into_iter().flatten().try_for_each(|fluent| self.fluent(fluent))?;
        rare.counters.keys().chain(rare.finished.keys()).try_for_each(|&name| self.symbol(name))?;
        rare.swap_pending.as_ref().map_or(Ok(()), |swap| self.validate_swap(bounds, swap))?;
        ensure(rare.suspensions <= MAX_COUNT && rare.holds <= MAX_COUNT, "a counter has run out")?;
        ensure(rare.boost.is_none_or(|boost| self.priorities.knows(boost)), "a priority is not in its table")?;
        rare.suspended_by.iter().chain(&rare.hooks_before).try_for_each(|&by| self.validate_reference(by))?;
        let mut places = rare.held.iter().chain(&rare.marked).chain(&rare.claimed).chain(&rare.hooks_for);
        ensure(places.all(|&place| (place as usize) < self.places.len()), "there is no such place of a valve")
    }

    fn validate_waiting(&self, bounds: &Bounds<'_>, waiting: Waiting) -> Result<(), String> {
        match waiting {
            Waiting::Fluent { fluent, .. } => self.fluent(fluent),
            Waiting::Watch(watch) => ensure(self.watches.get(watch).is_some(), "a watch is not in its table"),
            Waiting::Valve(valve) => ensure((valve as usize) < self.valves.len(), "there is no such valve"),
            Waiting::Death(other) | Waiting::Rest(other) | Waiting::Swap(other) | Waiting::Hooks(other) => {
                ensure(self.tasks.get(other).is_some(), "a task waits for one that is not there")
            }
            Waiting::Signal(behaviour) => {
                ensure(usize::from(behaviour) < bounds.behaviours, "there is no such behaviour")
            }
            Waiting::Time | Waiting::Children | Waiting::Spawned | Waiting::Answer => Ok(()),
        }
    }

    fn validate_scope(&self, bounds: &Bounds<'_>, task: &Task, scope: &Scope) -> Result<(), String> {
        let depth = scope.depth as usize;
        ensure(depth <= task.frames.len(), "a scope belongs to no frame")?;
        let frame = task.frames.get(depth).unwrap_or(&task.frame);
        let length = bounds.program.codes.get(frame.code as usize).map_or(0, |code| code.ops.len());
        match &scope.kind {
            ScopeKind::Block { target, .. } | ScopeKind::Cleanup { target } => {
                ensure((*target as usize) < length, "a scope goes on beyond its code")
            }
            ScopeKind::Handler { code, index, target, .. } => {
                ensure((*target as usize) < length, "a scope goes on beyond its code")?;
                bounds.code(*code)?;
                let handlers = bounds.program.codes[*code as usize].handlers.len();
                ensure((*index as usize) < handlers, "a handler is not in its code")
            }
            ScopeKind::InCleanup(then) => match &**then {
                Then::Continue => Ok(()),
                Then::Leave(leaving) => self.validate_leaving(bounds, task, leaving),
            },
            ScopeKind::Call(call) => {
                self.symbol(call.name)?;
                call.counters.keys().try_for_each(|&name| self.symbol(name))?;
                call.tags.iter().try_for_each(|&tag| self.validate_reference(tag))?;
                call.failure.map_or(Ok(()), |failure| self.validate_failure(bounds, failure))
            }
            ScopeKind::Children(children) => self.validate_children(bounds, children),
            ScopeKind::Valve(valve) => ensure((*valve as usize) < self.valves.len(), "there is no such valve"),
            ScopeKind::OnInterrupt(hook) | ScopeKind::OnResume(hook) => self.validate_value(bounds, *hook),
            ScopeKind::Suspended(task) => self.validate_reference(*task),
            ScopeKind::Watch(watch) => ensure(self.watches.get(*watch).is_some(), "a watch is not in its table"),
            ScopeKind::Fence => Ok(()),
        }
    }

    fn validate_children(&self, bounds: &Bounds<'_>, children: &Children) -> Result<(), String> {
        self.symbol(children.name)?;
        self.validate_value(bounds, children.last_value)?;
        children.values.iter().try_for_each(|&value| self.validate_value(bounds, value))?;
        children.held.iter().try_for_each(|held| self.validate_reference(held.task))?;
        children.later.iter().try_for_each(|&task| self.validate_reference(task))?;
        ensure(children.later.len() <= children.total as usize, "more children wait than there are")?;
        children.failures.iter().try_for_each(|&failure| self.validate_failure(bounds, failure))?;
        match children.decided {
            Some(Decision::Fail(failure)) => self.validate_failure(bounds, failure),
            Some(Decision::Succeed(value)) => self.validate_value(bounds, value),
            None => Ok(()),
        }
    }

    fn validate_leaving(&self, bounds: &Bounds<'_>, task: &Task, leaving: &Leaving) -> Result<(), String> {
        match leaving {
            Leaving::Evaporate => Ok(()),
            Leaving::Swap(swap) => self.validate_swap(bounds, swap),
            Leaving::Fail(failure) | Leaving::FailCall { failure, .. } => self.validate_failure(bounds, *failure),
            Leaving::Block { value, .. } => self.validate_value(bounds, *value),
            Leaving::Jump { target, depth, .. } => {
                let depth = *depth as usize;
                ensure(depth <= task.frames.len(), "a departure leads to no frame")?;
                let frame = task.frames.get(depth).unwrap_or(&task.frame);
                let length = bounds.program.codes.get(frame.code as usize).map_or(0, |code| code.ops.len());
                ensure((*target as usize) < length, "a departure goes on beyond its code")
            }
        }
    }

    fn validate_swap(&self, bounds: &Bounds<'_>, swap: &Swap) -> Result<(), String> {
        bounds.code(swap.code)?;
        swap.by.map_or(Ok(()), |by| self.validate_reference(by))?;
        swap.in_the_way.iter().try_for_each(|&task| self.validate_reference(task))?;
        let mut kept = swap.kept.iter();
        ensure(kept.all(|&valve| (valve as usize) < self.valves.len()), "there is no such valve")
    }

    /// No line is a circle, no task stands in two.
    fn validate_lines(&self) -> Result<(), String> {
        let mut seen = Marks::new(self.tasks.slots());
        let fluents = self.fluents.iter().map(|(_, fluent)| fluent.waiters);
        let rare = self.tasks.iter().filter_map(|(_, task)| task.rare.as_ref());
        for line in fluents.chain(self.priorities.lines()) {
            self.validate_line(line, &mut seen)?;
        }
        for rare in rare {
            let count = self.validate_line(rare.mourners, &mut seen)? + self.validate_line(rare.resters, &mut seen)?;
            ensure(count == rare.in_lines, "a task counts others in line that are not")?;
        }
        let mut children = Marks::new(self.tasks.slots());
        for (index, task) in self.tasks.iter() {
            let mut at = task.first_child;
            while at != NONE {
                self.validate_link(at)?;
                ensure(children.set(at) && self.tasks[at].parent == index, "a task is a child of two")?;
                at = self.tasks[at].next_sibling;
            }
        }
        let mut main_reaches = 0;
        let mut waiting: Vec<u32> =
            self.tasks.iter().filter(|(_, task)| task.parent == NONE).map(|(index, _)| index).collect();
        while let Some(task) = waiting.pop() {
            main_reaches += 1;
            waiting.extend(self.children(task));
        }
        let linked = self.tasks.iter().filter(|(_, task)| task.parent == NONE || !task.state().is_dead()).count();
        ensure(main_reaches == linked, "the task tree is no tree")
    }

    /// Gives how many stand in a line.
    fn validate_line(&self, line: Line, seen: &mut Marks) -> Result<u32, String> {
        self.validate_link(line.first)?;
        self.validate_link(line.last)?;
        let (mut at, mut before, mut count) = (line.first, NONE, 0);
        while at != NONE {
            count += 1;
            ensure(seen.set(at) && self.tasks[at].previous == before, "a line of tasks is a circle")?;
            (before, at) = (at, self.tasks[at].next);
            self.validate_link(at)?;
        }
        ensure(line.last == before, "a line of tasks ends elsewhere")?;
        Ok(count)
    }
}

/// Whether code that was read from bytes names only what there is.
///
/// # Errors
/// One sentence about the first thing that names nothing.
pub(crate) fn validate_program(program: &Program, from: usize) -> Result<(), String> {
    let has_code = |code: u32| (code as usize) < program.codes.len();
    for code in &program.codes[from.min(program.codes.len())..] {
        ensure(code.spans.len() == code.ops.len(), "an instruction has no place")?;
        let children = code.constructs.iter().flat_map(|construct| &construct.children);
        ensure(children.into_iter().all(|child| has_code(child.code)), "a child has no code")?;
        ensure(
            matches!(code.ops.last(), Some(Op::Return(_) | Op::Jump(_) | Op::TailCall(..) | Op::TailCallValue(..))),
            "code has no end",
        )?;
        for op in &code.ops {
            let holds = match *op {
                Op::Const(_, constant) => (constant as usize) < program.constants.len(),
                Op::Global(_, global) | Op::SetGlobal(_, global) | Op::DefFluent(_, global) => {
                    (global as usize) < program.globals.len()
                }
                Op::Call(_, _, global)
                | Op::CallSlot(_, _, global)
                | Op::CallSetSlot(_, _, global)
                | Op::TailCall(_, _, global) => (global as usize) < program.globals.len(),
                Op::CallCode(_, number) | Op::Closure(_, number) | Op::Network(_, number) => has_code(number),
                Op::Parallel(_, number) | Op::ParallelMap(_, _, number) | Op::Spawn(_, number) => {
                    (number as usize) < code.constructs.len()
                }
                Op::PushHandler(_, number, _) => usize::from(number) < code.handlers.len(),
                _ => true,
            };
            ensure(holds, "an instruction names what is not there")?;
        }
    }
    let is_free = |free: &[u32], first: usize, end: usize| {
        let mut seen = Marks::new(end);
        free.iter().all(|&place| (first..end).contains(&(place as usize)) && seen.set(place))
    };
    ensure(is_free(&program.free_codes, from, program.codes.len()), "a free place is not in the program")?;
    ensure(is_free(&program.free_constants, 0, program.constants.len()), "a free place is not in the program")?;
    ensure(is_free(program.sources.free_places(), 0, program.sources.len()), "a free place is not in the program")?;
    let known = |code: &u32| has_code(*code);
    ensure(program.macros.values().all(known), "a macro has no code")?;
    ensure(program.names.values().all(|&global| (global as usize) < program.globals.len()), "a name has no global")
}
