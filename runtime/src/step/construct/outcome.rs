//! How a construct ends: the rule looks at each child that does.

use crate::state::machine::Machine;
use crate::state::task::{Children, Decision, Leaving, Scope, ScopeKind, State, Waiting, Wake};
use crate::state::value::Value;
use crate::step::native::Surroundings;
use rpl_lang::code::Rule;

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

impl Machine {
    pub(crate) fn composite(&mut self, task: u32, parts: Vec<Value>) -> Value {
        let message = match parts.len() {
            0 => "there was nothing that could succeed".to_string(),
            1 => "the only way failed".to_string(),
            count => format!("all {count} ways failed"),
        };
        let class = self.symbols.intern("composite-failure");
        let failure = self.new_failure(task, class, message, Vec::new());
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

    pub(crate) fn children_mut(&mut self, task: u32, scope: u32) -> Option<&mut Children> {
        match self.tasks[task].scopes.get_mut(scope as usize).map(|scope| &mut scope.kind) {
            Some(ScopeKind::Children(children)) => Some(children),
            _ => None,
        }
    }

    /// A child has died: the rule looks at it.
    pub(crate) fn child_ended(&mut self, around: &mut Surroundings<'_>, parent: u32, scope: u32, child: u32) {
        self.as_one(around, |machine, around| machine.look_at_child(around, parent, scope, child));
    }

    fn look_at_child(&mut self, around: &mut Surroundings<'_>, parent: u32, scope: u32, child: u32) {
        let (state, result, position) =
            (self.tasks[child].state(), self.tasks[child].value, self.tasks[child].position);
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
    pub(crate) fn decide(&mut self, around: &mut Surroundings<'_>, parent: u32, scope: u32, decision: Decision) {
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
    pub(crate) fn attach_failure(&mut self, around: &Surroundings<'_>, decision: Decision, failure: Value) {
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
                && self.tasks[child].state() == State::Created
            {
                self.start_task(around, child);
            }
        }
    }

    pub(crate) fn finish_if_done(&mut self, around: &mut Surroundings<'_>, parent: u32, scope: u32) {
        let record = &self.tasks[parent];
        // Its owner may have gone on already: several children can die in one step.
        let Some(ScopeKind::Children(children)) = record.scopes.get(scope as usize).map(|scope| &scope.kind) else {
            return;
        };
        if children.alive > 0 || record.state() != State::Blocked || record.scopes.len() != scope as usize + 1 {
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
            (None, Rule::Pursue | Rule::TryAll) => Decision::Fail(self.composite(parent, children.failures)),
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
        if none_left && record.state() == State::Blocked && record.waiting == Waiting::Spawned {
            if record.is_leaving() {
                self.unwind(around, owner);
            } else {
                self.wake(owner, Wake::Nothing);
            }
        }
    }
}
