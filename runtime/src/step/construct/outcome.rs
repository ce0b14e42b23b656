//! How a construct ends: the rule looks at each child that does.

use crate::state::machine::Machine;
use crate::state::task::{Children, Decision, Leaving, Scope, ScopeKind, State, Waiting, Wake};
use crate::state::value::Value;
use crate::step::native::Surroundings;
use rpl_lang::code::{Failures, Quorum, Successes, Values};

/// The outcome of a construct, before it is on the heap.
enum Verdict {
    /// It has this value.
    Value(Value),
    /// It has the list of these values.
    Values(Vec<Value>),
    /// It has the failure of a child.
    Failure(Value),
    /// It has a failure of its own, with a message, made of those of children.
    Failures(String, Vec<Value>),
}

/// What the end of one child decides.
fn verdict(children: &mut Children, state: State, result: Value, position: u32) -> Option<Verdict> {
    let is_last = position + 1 == children.total;
    let Quorum { successes, failures, values } = children.quorum;
    match (state, successes) {
        (State::Failed, _) if failures == Failures::Count(1) => return Some(Verdict::Failure(result)),
        (State::Failed, _) if failures == Failures::Settled => set_value(children, position, result),
        (State::Failed, _) => children.failures.push(result),
        (State::Succeeded, _) if values == Values::InOrder => set_value(children, position, result),
        (State::Succeeded, _) if values == Values::AsTheyCame => children.values.push(result),
        (State::Succeeded, Successes::All) if is_last => children.last_value = result,
        (State::Succeeded, Successes::Last) if is_last => return Some(Verdict::Value(result)),
        (State::Succeeded, Successes::Count(_)) => return Some(Verdict::Value(result)),
        (State::Evaporated, Successes::Last) if is_last => return Some(Verdict::Value(Value::Nil)),
        _ => {}
    }
    if values == Values::AsTheyCame && successes == Successes::Count(children.values.len() as u32) {
        return Some(Verdict::Values(std::mem::take(&mut children.values)));
    }
    // When no child is left, the end of the construct says it.
    let (alive, failed) = (children.alive as usize, children.failures.len());
    let message = match failures {
        _ if alive == 0 => None,
        Failures::Count(count) if failed >= count as usize => Some(format!("{failed} of {} failed", children.total)),
        Failures::Count(_) | Failures::All => {
            shortfall(children.quorum, children.values.len() + alive, children.total as usize)
        }
        Failures::Settled => None,
    };
    message.map(|message| Verdict::Failures(message, std::mem::take(&mut children.failures)))
}

fn set_value(children: &mut Children, position: u32, value: Value) {
    if let Some(place) = children.values.get_mut(position as usize) {
        *place = value;
    }
}

impl Machine {
    pub(crate) fn composite(&mut self, task: u32, message: String, parts: Vec<Value>) -> Value {
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

    /// A child has died: the rule looks at it. What it decides is a part of the death.
    pub(crate) fn child_ended(&mut self, around: &mut Surroundings<'_>, parent: u32, scope: u32, child: u32) {
        let record = &self.tasks[child];
        let (state, result, position) = (record.state(), *record.value(), record.position);
        self.disown(child);
        match &mut self.tasks[parent].scopes[scope as usize].kind {
            ScopeKind::Call(call) => {
                call.spawned -= 1;
                self.spawned_ended(around, parent, scope, state, result);
            }
            ScopeKind::Children(children) => {
                children.alive -= 1;
                let (decided, children_left) = (children.decided, children.alive);
                let (has_order, has_later) = (!children.order.is_empty(), !children.later.is_empty());
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
                let verdict = if decided.is_none() { verdict(children, state, result, position) } else { None };
                match (decided, verdict.map(|verdict| self.decision(parent, verdict))) {
                    (None, Some(decision)) => self.decide(around, parent, scope, decision),
                    (None, None) if has_order => self.start_successors(around, parent, scope, position as u16),
                    (None, None) if has_later => self.start_next(around, parent, scope, position),
                    (Some(decision), _) if state == State::Failed => self.attach_failure(around, decision, result),
                    (None, None) if children_left > 0 => return,
                    (None, None) | (Some(_), _) => {}
                }
                self.finish_if_done(around, parent, scope);
            }
            other => unreachable!("a child belongs to a construct or a plan call, not to {other:?}"),
        }
    }

    /// The outcome as the construct has it: what it is made of goes on the heap.
    fn decision(&mut self, parent: u32, verdict: Verdict) -> Decision {
        match verdict {
            Verdict::Value(value) => Decision::Succeed(value),
            Verdict::Values(values) => Decision::Succeed(self.heap.list(&values)),
            Verdict::Failure(failure) => Decision::Fail(failure),
            Verdict::Failures(message, parts) => Decision::Fail(self.composite(parent, message, parts)),
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

    /// A child of a map has ended: the next one that waits for its turn begins.
    fn start_next(&mut self, around: &mut Surroundings<'_>, parent: u32, scope: u32, ended: u32) {
        let ScopeKind::Children(children) = &mut self.tasks[parent].scopes[scope as usize].kind else { return };
        let had_begun = ended as usize + children.later.len() < children.total as usize;
        while had_begun
            && let ScopeKind::Children(children) = &mut self.tasks[parent].scopes[scope as usize].kind
            && let Some(next) = children.later.pop_front()
        {
            if let Some(next) = self.tasks.find_alive(next).filter(|&next| self.tasks[next].state() == State::Created) {
                self.start_task(around, next);
                return;
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
        let decision = match children.decided {
            Some(decision) => decision,
            None => self.decision(parent, verdict_at_end(*children)),
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
        if state == State::Failed && self.fail_call(around, owner, scope, result) {
            return;
        }
        let record = &self.tasks[owner];
        let none_left = matches!(&record.scopes[scope as usize].kind, ScopeKind::Call(call) if call.spawned == 0);
        if none_left && record.state() == State::Blocked && record.waiting() == Some(Waiting::Spawned) {
            if record.is_leaving() {
                self.unwind(around, owner);
            } else {
                self.wake(owner, Wake::Nothing);
            }
        }
    }

    /// A plan call fails with what did not happen in its own task; no handler within it is asked. Tells
    /// whether the task departs at once.
    pub(crate) fn fail_call(&mut self, around: &mut Surroundings<'_>, owner: u32, scope: u32, failure: Value) -> bool {
        let record = &self.tasks[owner];
        let clean_up = record.scopes.last_clean_up();
        if !record.is_leaving() && !record.is_committed() && clean_up.is_none_or(|clean_up| clean_up < scope) {
            self.depart(around, owner, Leaving::FailCall { scope, failure });
            return true;
        }
        // It takes effect when the clean-up is over, or is attached to what is under way.
        self.tasks[owner].rare().failure_pending = true;
        if let Some(ScopeKind::Call(call)) =
            self.tasks[owner].scopes.get_mut(scope as usize).map(|scope| &mut scope.kind)
        {
            match call.failure {
                None => call.failure = Some(failure),
                Some(first) => self.attach_failure(around, Decision::Fail(first), failure),
            }
        }
        false
    }
}

/// The outcome if all children are dead, and none of them has decided it.
fn verdict_at_end(children: Children) -> Verdict {
    let Children { quorum, values, failures, last_value, total, .. } = children;
    let (failed, total) = (failures.len(), total as usize);
    let has_failed = match quorum.failures {
        Failures::Count(count) => failed >= count as usize,
        Failures::All => failed == total,
        Failures::Settled => false,
    };
    match quorum.successes {
        Successes::Count(_) if quorum.values == Values::One => Verdict::Failures(all_failed(failed), failures),
        _ if has_failed => Verdict::Failures(format!("{failed} of {total} failed"), failures),
        Successes::Count(_) => {
            let message = shortfall(quorum, values.len(), total).unwrap_or_else(|| all_failed(failed));
            Verdict::Failures(message, failures)
        }
        Successes::All | Successes::Last if quorum.values != Values::One => Verdict::Values(values),
        Successes::All | Successes::Last => Verdict::Value(last_value),
    }
}

/// What to say if `left` children of `total`, those that have succeeded or still can, are too few.
pub(super) fn shortfall(quorum: Quorum, left: usize, total: usize) -> Option<String> {
    match quorum.successes {
        Successes::Count(count) if left < count as usize => Some(match quorum.values {
            Values::AsTheyCame | Values::InOrder => format!("only {left} of {total} can succeed, and {count} must"),
            Values::One => all_failed(0),
        }),
        Successes::Count(_) | Successes::All | Successes::Last => None,
    }
}

/// What a failure says that is made of those of all ways there were.
pub(crate) fn all_failed(ways: usize) -> String {
    match ways {
        0 => "there was nothing that could succeed".to_string(),
        1 => "the only way failed".to_string(),
        count => format!("all {count} ways failed"),
    }
}
