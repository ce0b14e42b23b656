//! Constructs of concurrent children: one primitive, and a rule that looks at how each child ends.

use crate::active_time::ActiveTime;
use crate::failure::Raise;
use crate::machine::{Machine, Surroundings};
use crate::memory;
use crate::scheduler::Alarm;
use crate::task::{Children, Decision, Held, Leaving, NONE, Scope, ScopeKind, State, Task, Waiting, Wake};
use crate::value::Value;
use rpl_lang::code::{Child, Construct, NO_REG, Reg, Rule};
use rpl_lang::kind::Kind;

impl Machine {
    /// A task for code, with the values it captures from registers of the current frame.
    fn child_task(
        &mut self,
        around: &Surroundings<'_>,
        child: &Child,
        argument: Option<Value>,
        base: usize,
        priority: (u32, u16),
    ) -> Task {
        let code = &around.program.codes[child.code as usize];
        let stack = &self.scratch.stack[base..];
        let captured = code.captures.iter().map(|&register| stack[usize::from(register)]);
        let count = usize::from(argument.is_some()) + code.captures.len();
        self.heap.allocated += memory::TASK + count * size_of::<Value>();
        let registers = self.tasks.registers.make(count, argument.into_iter().chain(captured));
        let mut task = Task::new(child.code, registers, code.name, priority.0);
        task.priority_depth = priority.1;
        let maker = &self.tasks[self.current];
        if maker.budget_instant == self.instant {
            task.budget_instant = self.instant;
            task.strikes = maker.strikes;
        }
        task
    }

    /// Uses the record of a tag that was not reached yet, or makes a new one and rebinds the tag.
    fn place_task(&mut self, child: &Child, task: Task, base: usize) -> u32 {
        if child.tag == NO_REG {
            return self.tasks.insert(task);
        }
        let register = base + usize::from(child.tag);
        let holder = self.scratch.stack[register];
        let known = match holder {
            Value::Cell(cell) => self.heap.cells[cell],
            other => other,
        };
        if let Value::Task(known) = known
            && let Some(index) = self.tasks.find_alive(known)
            && self.tasks[index].state == State::Created
            && self.tasks[index].parent == NONE
        {
            let rare = self.tasks[index].rare.take();
            self.tasks[index] = Task { exposed: true, rare, ..task };
            return index;
        }
        let index = self.tasks.insert(task);
        let value = self.expose(index);
        match holder {
            Value::Cell(cell) => self.heap.cells[cell] = value,
            _ => self.scratch.stack[register] = value,
        }
        index
    }

    /// Starts a construct in the current task. `elements` is a proper list: there is one child for
    /// each element instead of the listed children.
    ///
    /// Gives the decision if there is nothing to wait for.
    pub(crate) fn start_construct(
        &mut self,
        around: &mut Surroundings<'_>,
        construct: &Construct,
        elements: Option<Value>,
        result: Reg,
        base: usize,
    ) -> Result<Option<Value>, Raise> {
        let parent = self.current;
        let total = match elements {
            Some(elements) => self.heap.length(elements).unwrap_or(0),
            None => construct.children.len(),
        };
        let argument =
            (construct.argument != NO_REG).then(|| self.scratch.stack[base + usize::from(construct.argument)]);
        let number = match argument {
            Some(number) if construct.with_priority => Some(self.priority_argument(number)?),
            _ => None,
        };
        let due_us = match argument {
            Some(seconds) if construct.rule == Rule::Timeout => {
                Some(self.instant_after(seconds, || "the time of `with-timeout`".into())?)
            }
            _ => None,
        };
        let appends = construct.rule == Rule::Policy || construct.with_priority;
        if appends && self.tasks[parent].priority_depth == u16::MAX {
            let message = format!("policies and priorities are nested more than {} deep", u16::MAX);
            return Err(Raise::new("stack-overflow", message));
        }
        let occurrence = self.count_use(parent, construct.name);
        if total == 0 {
            return self.empty_construct(construct.rule);
        }
        let scope = self.tasks[parent].scopes.len() as u32;
        let depth = self.scratch.frames.len() as u32;
        let children = Children {
            rule: construct.rule,
            name: construct.name,
            occurrence,
            result,
            alive: total as u32,
            total: total as u32,
            decided: None,
            last_value: Value::Nil,
            failures: Vec::new(),
            order: sorted(&construct.order),
            held: Vec::new(),
            seconds: argument.and_then(Value::as_f64).unwrap_or(0.0),
            timer: 0,
            active: due_us.filter(|_| construct.active).map(ActiveTime::Due),
            expired_us: None,
        };
        let kind = ScopeKind::Children(Box::new(children));
        let is_first = self.tasks[parent].scopes.is_empty();
        self.heap.allocated += memory::scope(&kind) + if is_first { memory::SCOPE_STACK } else { 0 };
        self.tasks[parent].scopes.push(Scope { kind, depth });
        let constraints = constraints_of(&construct.order, total);
        let mut held = Vec::new();
        let mut rest = elements.unwrap_or_default();
        for position in 0..total {
            let (child, argument) = match rest {
                Value::Cons(pair) => {
                    let (element, next) = self.heap.pair(pair);
                    rest = next;
                    (&construct.children[0], Some(element))
                }
                _ => (&construct.children[position], None),
            };
            let priority = self.child_priority(construct, parent, position, number);
            let task = self.child_task(around, child, argument, base, priority);
            let index = self.place_task(child, task, base);
            self.name_child(index, child, construct, position, occurrence);
            self.adopt(parent, scope, index);
            match constraints.get(position) {
                Some(&constraints @ 1..) => {
                    held.push(Held { position: position as u16, constraints, task: self.tasks.reference(index) });
                }
                _ => self.start_task(around, index),
            }
        }
        if let ScopeKind::Children(children) = &mut self.tasks[parent].scopes[scope as usize].kind {
            children.held = held;
        }
        if let Some(due_us) = due_us {
            self.set_deadline(parent, scope, due_us);
            self.children_of_scope(parent, scope).into_iter().for_each(|body| self.turn_clocks(body));
        }
        Ok(None)
    }

    /// Starts a spawned child, which lives at most as long as the plan call around it.
    pub(crate) fn start_spawned(
        &mut self,
        around: &mut Surroundings<'_>,
        construct: &Construct,
        base: usize,
    ) -> Result<Value, Raise> {
        let child = &construct.children[0];
        let Some((owner, scope)) = self.plan_call_around(self.current) else {
            return Err(Raise::new("control-error", "`spawn` needs a plan around it that the child belongs to"));
        };
        let record = &self.tasks[self.current];
        let task = self.child_task(around, child, None, base, (record.priority, record.priority_depth));
        let index = self.place_task(child, task, base);
        let occurrence = self.count_use(owner, child.name.unwrap_or(construct.name));
        self.name_child(index, child, construct, 0, occurrence);
        self.tasks[index].named_by_construct = false;
        self.adopt(owner, scope as u32, index);
        if let ScopeKind::Call(call) = &mut self.tasks[owner].scopes[scope].kind {
            call.spawned += 1;
        }
        let value = self.expose(index);
        self.start_task(around, index);
        Ok(value)
    }

    pub(crate) fn start_task(&mut self, around: &mut Surroundings<'_>, task: u32) {
        self.make_ready(task);
        self.trace_task_begin(task);
        self.update_task_fluents(around, task);
    }

    fn name_child(&mut self, task: u32, child: &Child, construct: &Construct, position: usize, occurrence: u32) {
        let record = &mut self.tasks[task];
        record.position = position as u32;
        record.name = child.name.unwrap_or(construct.name);
        record.named_by_construct = child.name.is_none() && !matches!(construct.rule, Rule::Single | Rule::Timeout);
        record.occurrence = occurrence;
    }

    /// The number `with-priority` appends.
    fn priority_argument(&self, value: Value) -> Result<i64, Raise> {
        match value {
            Value::Int(number) => Ok(number),
            // A float counts as its integer, which must be exact.
            Value::Float(number) if libm::trunc(number) == number && number.abs() < (1_u64 << 53) as f64 => {
                Ok(number as i64)
            }
            _ => Err(self.wrong_type("the priority of `with-priority`", Kind::Integer.noun(), value)),
        }
    }

    fn child_priority(
        &mut self,
        construct: &Construct,
        parent: u32,
        position: usize,
        number: Option<i64>,
    ) -> (u32, u16) {
        let (priority, depth) = (self.tasks[parent].priority, self.tasks[parent].priority_depth);
        let appended = match construct.rule {
            Rule::Policy => i64::from(position == 0),
            Rule::Single if construct.with_priority => number.unwrap_or(0),
            _ => return (priority, depth),
        };
        (self.priorities.appended(priority, usize::from(depth), appended), depth + 1)
    }

    fn set_deadline(&mut self, parent: u32, scope: u32, due_us: u64) {
        self.heap.allocated += memory::TIMER;
        let timer = self.timers.set(due_us, self.tasks.reference(parent), Alarm::Deadline);
        if let ScopeKind::Children(children) = &mut self.tasks[parent].scopes[scope as usize].kind {
            children.timer = timer;
        }
    }

    fn empty_construct(&mut self, rule: Rule) -> Result<Option<Value>, Raise> {
        match rule {
            Rule::Pursue | Rule::TryAll => Err(Raise::Again(self.composite(Vec::new()))),
            _ => Ok(Some(Value::Nil)),
        }
    }

    pub(crate) fn composite(&mut self, parts: Vec<Value>) -> Value {
        let message = match parts.len() {
            0 => "there was nothing that could succeed".to_string(),
            1 => "the only way failed".to_string(),
            count => format!("all {count} ways failed"),
        };
        let class = self.symbols.intern("composite-failure");
        let failure = self.new_failure(class, message, Vec::new());
        if let Value::Failure(index) = failure {
            let is_runaway =
                |part: &Value| matches!(part, Value::Failure(part) if self.heap.failures[*part].is_runaway);
            let has_runaway = parts.iter().any(is_runaway);
            let record = &mut self.heap.failures[index];
            record.parts = parts;
            record.is_runaway = has_runaway;
        }
        failure
    }

    /// The deadline of a timeout has come. While the task is suspended it waits for the resume.
    pub(crate) fn deadline(&mut self, around: &mut Surroundings<'_>, task: u32, timer: u64) {
        let Some(scope) = self.scope_of_deadline(task, timer) else { return };
        let now_us = self.now_us;
        let is_held = self.tasks[task].is_held();
        let fixed = self.children_of_scope(task, scope).into_iter().find_map(|child| self.fixed_failure(around, child));
        let waits = is_held && fixed.is_none();
        if let Some(children) = self.children_mut(task, scope) {
            children.expired_us = waits.then_some(now_us);
        }
        if waits {
            return;
        }
        let failure = self.timeout_failure(task, scope);
        if let Some(first) = fixed {
            self.attach_failure(around, Decision::Fail(first), failure);
            return;
        }
        self.as_one(around, |machine, around| {
            machine.decide(around, task, scope, Decision::Fail(failure));
            machine.finish_if_done(around, task, scope);
        });
    }

    fn scope_of_deadline(&self, task: u32, timer: u64) -> Option<u32> {
        let scopes = self.tasks[task].scopes.iter();
        let is_meant = |scope: &Scope| matches!(&scope.kind, ScopeKind::Children(children) if children.timer == timer && children.decided.is_none());
        scopes.enumerate().rev().find(|(_, scope)| is_meant(scope)).map(|(index, _)| index as u32)
    }

    fn children_mut(&mut self, task: u32, scope: u32) -> Option<&mut Children> {
        match self.tasks[task].scopes.get_mut(scope as usize).map(|scope| &mut scope.kind) {
            Some(ScopeKind::Children(children)) => Some(children),
            _ => None,
        }
    }

    fn timeout_failure(&mut self, task: u32, scope: u32) -> Value {
        let seconds = self.children_mut(task, scope).map_or(0.0, |children| children.seconds);
        let slot = self.symbols.intern("seconds");
        let class = self.symbols.intern("timeout");
        let failure =
            self.new_failure(class, format!("not done within {seconds} s"), vec![(slot, Value::Float(seconds))]);
        if let Value::Failure(index) = failure {
            self.heap.failures[index].path = self.path(task);
            self.heap.failures[index].calls = self.plan_calls(task);
        }
        failure
    }

    /// Deadlines that came while tasks were suspended take effect, in the order in which they came.
    pub(crate) fn take_up_deadlines(&mut self, around: &mut Surroundings<'_>, resumed: &[u32]) {
        let mut expired = Vec::new();
        for &task in resumed {
            for scope in self.tasks[task].scopes.iter() {
                if let ScopeKind::Children(children) = &scope.kind
                    && let Some(expired_us) = children.expired_us
                {
                    expired.push((expired_us, children.timer, self.tasks.reference(task)));
                }
            }
        }
        expired.sort_unstable_by_key(|&(expired_us, timer, _)| (expired_us, timer));
        for (_, timer, task) in expired {
            if let Some(task) = self.tasks.find_alive(task) {
                self.deadline(around, task, timer);
            }
        }
    }

    /// A child has died: the rule looks at it.
    pub(crate) fn child_ended(&mut self, around: &mut Surroundings<'_>, parent: u32, scope: u32, child: u32) {
        self.as_one(around, |machine, around| machine.look_at_child(around, parent, scope, child));
    }

    fn look_at_child(&mut self, around: &mut Surroundings<'_>, parent: u32, scope: u32, child: u32) {
        let (state, result, position) = (self.tasks[child].state, self.tasks[child].value, self.tasks[child].position);
        self.disown(child);
        match &mut self.tasks[parent].scopes[scope as usize].kind {
            ScopeKind::Call(call) => {
                call.spawned -= 1;
                self.spawned_ended(around, parent, scope, state, result);
            }
            ScopeKind::Children(children) => {
                children.alive -= 1;
                let decided = children.decided;
                if decided.is_none() && children.expired_us.is_some() {
                    // The deadline was first: it waits for the resume no longer.
                    let timeout = self.timeout_failure(parent, scope);
                    self.decide(around, parent, scope, Decision::Fail(timeout));
                    if state == State::Failed {
                        self.attach_failure(around, Decision::Fail(timeout), result);
                    }
                    self.finish_if_done(around, parent, scope);
                    return;
                }
                match (decided, verdict(children, state, result, position)) {
                    (None, Some(decision)) => self.decide(around, parent, scope, decision),
                    (None, None) => self.start_successors(around, parent, scope, position as u16),
                    (Some(decision), _) if state == State::Failed => self.attach_failure(around, decision, result),
                    (Some(_), _) => {}
                }
                self.finish_if_done(around, parent, scope);
            }
            other => unreachable!("a child belongs to a construct or a plan call, not to {other:?}"),
        }
    }

    /// Fixes the outcome of a construct: from now on its children run nothing but clean-ups.
    fn decide(&mut self, around: &mut Surroundings<'_>, parent: u32, scope: u32, decision: Decision) {
        if let ScopeKind::Children(children) = &mut self.tasks[parent].scopes[scope as usize].kind {
            if children.decided.is_some() {
                return;
            }
            children.decided = Some(decision);
        }
        let (children, looked_at) = self.look_for_children(parent, scope);
        self.scratch.work += looked_at;
        self.evaporate_all(around, &children);
    }

    /// A failure that comes after the decision is kept beside it.
    fn attach_failure(&mut self, around: &Surroundings<'_>, decision: Decision, failure: Value) {
        match (decision, failure) {
            (Decision::Fail(Value::Failure(index)), failure) if Value::Failure(index) != failure => {
                self.heap.failures[index].while_cleaning_up.push(failure);
            }
            (Decision::Succeed(_), failure) => self.warn_of_failure(around.program, failure, "in a clean-up"),
            _ => {}
        }
    }

    fn start_successors(&mut self, around: &mut Surroundings<'_>, parent: u32, scope: u32, dead: u16) {
        let ScopeKind::Children(children) = &mut self.tasks[parent].scopes[scope as usize].kind else { return };
        let Children { order, held, .. } = &mut **children;
        let first = order.partition_point(|&(before, _)| before < dead);
        let mut free = Vec::new();
        for &(_, after) in order[first..].iter().take_while(|&&(before, _)| before == dead) {
            let Ok(at) = held.binary_search_by_key(&after, |held| held.position) else { continue };
            held[at].constraints = held[at].constraints.saturating_sub(1);
            if held[at].constraints == 0 {
                free.push(held[at].task);
            }
        }
        for child in free {
            if let Some(child) = self.tasks.find_alive(child)
                && self.tasks[child].state == State::Created
            {
                self.start_task(around, child);
            }
        }
    }

    fn finish_if_done(&mut self, around: &mut Surroundings<'_>, parent: u32, scope: u32) {
        let record = &self.tasks[parent];
        // Its owner may have gone on already: several children can die in one step.
        let Some(ScopeKind::Children(children)) = record.scopes.get(scope as usize).map(|scope| &scope.kind) else {
            return;
        };
        if children.alive > 0 || record.state != State::Blocked || record.scopes.len() != scope as usize + 1 {
            return;
        }
        if record.is_leaving() {
            self.unwind(around, parent);
            return;
        }
        let Some(Scope { kind: ScopeKind::Children(children), .. }) = self.tasks[parent].scopes.pop() else { return };
        if children.timer != 0 {
            self.forget_timer();
        }
        self.tasks[parent].wake_register = children.result;
        let decision = match (children.decided, children.rule) {
            (Some(decision), _) => decision,
            (None, Rule::Pursue | Rule::TryAll) => {
                let failure = self.composite(children.failures);
                if let Value::Failure(index) = failure {
                    self.heap.failures[index].path = self.path(parent);
                    self.heap.failures[index].calls = self.plan_calls(parent);
                }
                Decision::Fail(failure)
            }
            (None, _) => Decision::Succeed(children.last_value),
        };
        let rare = self.tasks[parent].rare.as_ref();
        let is_wanted_otherwise = rare.is_some_and(|rare| rare.evaporation_pending || rare.failure_pending);
        match decision {
            Decision::Succeed(_) if is_wanted_otherwise && self.take_up_pending(around, parent) => {
                self.unwind(around, parent);
            }
            Decision::Succeed(value) => self.wake(parent, Wake::Value(value)),
            Decision::Fail(failure) if is_wanted_otherwise && !self.tasks[parent].is_cleaning_up() => {
                self.depart_failing(around, parent, failure);
            }
            Decision::Fail(failure) => self.wake(parent, Wake::Outcome(failure)),
        }
    }

    /// A spawned child has ended: its failure is that of the plan call it belongs to.
    fn spawned_ended(&mut self, around: &mut Surroundings<'_>, owner: u32, scope: u32, state: State, result: Value) {
        if state == State::Failed {
            let record = &self.tasks[owner];
            let clean_up = record.scopes.last_clean_up();
            if record.is_leaving() || record.is_committed() || clean_up.is_some_and(|clean_up| clean_up >= scope) {
                // It takes effect when the clean-up is over, or is attached to what is under way.
                self.tasks[owner].rare().failure_pending = true;
                if let ScopeKind::Call(call) = &mut self.tasks[owner].scopes[scope as usize].kind {
                    match call.failure {
                        None => call.failure = Some(result),
                        Some(first) => self.attach_failure(around, Decision::Fail(first), result),
                    }
                }
            } else {
                self.depart(around, owner, Leaving::FailCall { scope, failure: result });
                return;
            }
        }
        let record = &self.tasks[owner];
        let none_left = matches!(&record.scopes[scope as usize].kind, ScopeKind::Call(call) if call.spawned == 0);
        if none_left && record.state == State::Blocked && record.waiting == Waiting::Spawned {
            if record.is_leaving() {
                self.unwind(around, owner);
            } else {
                self.wake(owner, Wake::Nothing);
            }
        }
    }
}

fn sorted(order: &[(u16, u16)]) -> Vec<(u16, u16)> {
    let mut order = order.to_vec();
    order.sort_unstable();
    order
}

/// How many constraints there are on each child; nothing where there is no order at all.
fn constraints_of(order: &[(u16, u16)], children: usize) -> Vec<u32> {
    let mut constraints = vec![0; if order.is_empty() { 0 } else { children }];
    for &(_, after) in order {
        constraints[usize::from(after)] += 1;
    }
    constraints
}

/// What the end of one child decides.
fn verdict(children: &mut Children, state: State, result: Value, position: u32) -> Option<Decision> {
    let is_last = position + 1 == children.total;
    match (children.rule, state) {
        (Rule::Par | Rule::Plan | Rule::Pursue | Rule::Policy | Rule::Single | Rule::Timeout, State::Failed) => {
            Some(Decision::Fail(result))
        }
        (Rule::TryAll, State::Failed) => {
            children.failures.push(result);
            None
        }
        (Rule::Par | Rule::Plan, State::Succeeded) => {
            if is_last {
                children.last_value = result;
            }
            None
        }
        (Rule::Pursue | Rule::TryAll | Rule::Single | Rule::Timeout, State::Succeeded) => {
            Some(Decision::Succeed(result))
        }
        (Rule::Policy, State::Succeeded) => (position == 1).then_some(Decision::Succeed(result)),
        (Rule::Policy, State::Evaporated) => (position == 1).then_some(Decision::Succeed(Value::Nil)),
        (Rule::Single | Rule::Timeout, State::Evaporated) => Some(Decision::Succeed(Value::Nil)),
        _ => None,
    }
}
