//! Constructs and spawned tasks, started.

use crate::state::active_time::ActiveTime;
use crate::state::failure::Raise;
use crate::state::machine::Machine;
use crate::state::memory;
use crate::state::slab::NONE;
use crate::state::task::{Children, Held, Leaving, Naming, ScopeKind, State, Task};
use crate::state::value::Value;
use crate::step::construct::outcome::shortfall;
use crate::step::native::Surroundings;
use rpl_lang::code::{Argument, Child, Construct, Failures, NO_REG, Quorum, Reg, Successes, Values};
use rpl_lang::kind::Kind;
use rpl_lang::symbol::Symbol;
use std::collections::VecDeque;

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
        task
    }

    /// Uses the record of a tag that was not reached yet, or makes a new one and rebinds the tag. A tag that was
    /// evaporated before it is reached stays bound to the task that is dead; what is placed for it leaves at once.
    fn place_task(&mut self, child: &Child, mut task: Task, base: usize) -> u32 {
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
            && let Some(index) = self.tasks.find(known)
            && self.tasks[index].parent == NONE
        {
            let awaited = &mut self.tasks[index];
            match awaited.state() {
                State::Created => {
                    (task.exposed, task.rare) = (true, awaited.rare.take());
                    *awaited = task;
                    return index;
                }
                // Reached again, the tag means a new task.
                State::Evaporated if awaited.naming != Naming::Tag => {
                    awaited.naming = Naming::Tag;
                    task.leave(Leaving::Evaporate);
                    return self.tasks.insert(task);
                }
                State::Ready
                | State::Running
                | State::Blocked
                | State::Succeeded
                | State::Failed
                | State::Evaporated => {}
            }
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
        let value_of = |machine: &Self, register: Reg| machine.scratch.stack[base + usize::from(register)];
        let mut quorum = construct.quorum;
        let (mut number, mut seconds, mut active, mut most) = (None, None, false, total);
        match construct.argument {
            Some(Argument::Priority(register)) => number = Some(self.priority_argument(value_of(self, register))?),
            Some(Argument::Deadline { seconds: register, active: is_active }) => {
                (seconds, active) = (Some(value_of(self, register)), is_active);
            }
            Some(Argument::Quorum { successes, failures }) => {
                quorum = self.quorum_argument(value_of(self, successes), value_of(self, failures))?;
            }
            Some(Argument::Most(register)) => most = self.most_argument(construct.name, value_of(self, register))?,
            None => {}
        }
        let due_us = match seconds {
            Some(seconds) => Some(self.instant_after(seconds, || "the time of `with-timeout`".into())?),
            None => None,
        };
        let appends = construct.has_policy() || number.is_some();
        if appends && self.tasks[parent].priority_depth == u16::MAX {
            let message = format!("policies and priorities are nested more than {} deep", u16::MAX);
            return Err(Raise::new("stack-overflow", message));
        }
        let occurrence = self.count_use(parent, construct.name);
        if let Some(shortfall) = shortfall(quorum, total, total) {
            return Err(Raise::Again(self.composite(parent, shortfall, Vec::new())));
        }
        if total == 0 {
            return Ok(Some(Value::Nil));
        }
        let scope = self.tasks[parent].scopes.len() as u32;
        let children = Children {
            quorum,
            name: construct.name,
            occurrence,
            result,
            alive: total as u32,
            total: total as u32,
            decided: None,
            last_value: Value::Nil,
            values: match quorum.values {
                Values::InOrder => vec![Value::Nil; total],
                Values::One | Values::AsTheyCame => Vec::new(),
            },
            failures: Vec::new(),
            order: sorted(&construct.order),
            held: Vec::new(),
            later: VecDeque::new(),
            seconds: seconds.and_then(Value::as_f64).unwrap_or(0.0),
            timer: 0,
            active: due_us.filter(|_| active).map(ActiveTime::Due),
            expired_us: None,
        };
        self.push_scope(ScopeKind::Children(Box::new(children)));
        let constraints = constraints_of(&construct.order, total);
        let (mut held, mut later) = (Vec::new(), VecDeque::new());
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
                Some(&constraints @ 1..) if !self.tasks[index].is_leaving() => {
                    held.push(Held { position: position as u16, constraints, task: self.tasks.reference(index) });
                }
                _ if position >= most => later.push_back(self.tasks.reference(index)),
                _ => self.start_task(around, index),
            }
        }
        if let ScopeKind::Children(children) = &mut self.tasks[parent].scopes[scope as usize].kind {
            (children.held, children.later) = (held, later);
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
        self.adopt(owner, scope as u32, index);
        if let ScopeKind::Call(call) = &mut self.tasks[owner].scopes[scope].kind {
            call.spawned += 1;
        }
        let value = self.expose(index);
        self.start_task(around, index);
        Ok(value)
    }

    pub(crate) fn start_task(&mut self, around: &mut Surroundings<'_>, task: u32) {
        self.number_wait(task);
        self.make_ready(task);
        // What was evaporated before it was reached does not begin.
        if !self.tasks[task].is_leaving() {
            self.trace_task_begin(task);
            self.update_task_fluents(around, task);
        }
    }

    fn name_child(&mut self, task: u32, child: &Child, construct: &Construct, position: usize, occurrence: u32) {
        let record = &mut self.tasks[task];
        record.position = position as u32;
        record.name = child.name.unwrap_or(construct.name);
        record.naming = match child.name {
            Some(_) => Naming::Tag,
            None if construct.is_single() => Naming::Whole,
            None => Naming::Position,
        };
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
        let appended = match number {
            Some(number) => number,
            None if construct.has_policy() => i64::from(position == 0),
            None => return (priority, depth),
        };
        (self.priorities.appended(priority, usize::from(depth), appended), depth + 1)
    }

    /// What was told by `:most`.
    fn most_argument(&self, form: Symbol, value: Value) -> Result<usize, Raise> {
        match value {
            Value::Int(count @ 1..) => Ok(usize::try_from(count).unwrap_or(usize::MAX)),
            _ => {
                let which = format!("`:most` of `{}`", self.symbols.name(form));
                Err(self.wrong_type(&which, "an integer from 1 on", value))
            }
        }
    }

    /// What `quorum` was told.
    fn quorum_argument(&self, successes: Value, failures: Value) -> Result<Quorum, Raise> {
        let count = |which: &str, value: Value| match value {
            Value::Int(count @ 1..) => Ok(Some(u32::try_from(count).unwrap_or(u32::MAX))),
            Value::Keyword(word) if self.symbols.name(word) == "all" => Ok(None),
            _ => Err(self.wrong_type(which, "an integer from 1 on or :all", value)),
        };
        Ok(Quorum {
            successes: count("the successes of `quorum`", successes)?.map_or(Successes::All, Successes::Count),
            failures: count("the failures of `quorum`", failures)?.map_or(Failures::All, Failures::Count),
            ..Quorum::ASKED
        })
    }
}
