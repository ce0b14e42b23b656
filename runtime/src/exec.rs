//! The stepper: executes register code of one task until it blocks, ends or is switched out.

use crate::failure::Raise;
use crate::fluent::{Fluent, Origin};
use crate::machine::{Limits, Machine, SCRATCH_TASK, Surroundings};
use crate::memory;
use crate::native::{Call as NativeCall, Reply};
use crate::registers::Registers;
use crate::task::{self, Frame, Leaving, NONE, Raises, Scope, ScopeKind, State, Task, Then, Waiting, Wake};
use crate::unwind::{Landing, Unwound};
use crate::value::{TaskRef, Value};
use crate::waiting::form_in_plan;
use rpl_lang::code::{Code, CodeKind, NO_REG, Op, Parameters, Program, Reg};
use rpl_lang::compile::NativeSignature;
use rpl_lang::kind::Kind;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::hint::black_box;

/// How far the window of one frame reaches.
const WINDOW: usize = 256;

/// Registers within reach of the current frame: its own, those of any frame it calls, and a few
/// that are cleared along with them.
const REACH: usize = 2 * WINDOW + 4;

/// Registers that are kept from a task that needed them for one that does not.
const MAX_SPARE_REGISTERS: usize = 1 << 16;

/// Evaluations of networks inside one another; each takes some Rust stack.
const MAX_EVALUATIONS_DEEP: u32 = 64;

/// Why the stepper came back.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Exit {
    /// The outermost frame has ended with a value.
    Returned(Value),
    /// The task waits.
    Blocked,
    /// A more important task is ready, or the task is suspended.
    Switched,
    /// Somebody is to look at the task before the next instruction: the stepper, or the caller
    /// because a slice of steps is over.
    Paused,
    /// The task is dead.
    Dead,
    /// A datum is to be compiled; its code goes on in the register.
    Execute(Value, Reg),
}

/// The place of execution; in local variables while the loop runs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    frame: Frame,
    /// Steps until control goes back to the caller.
    fuel: u32,
    /// Steps that the task may take in this instant after those.
    reserve: u32,
}

impl Place {
    /// So many steps in slices.
    fn new(frame: Frame, steps: u32, slice: u32) -> Self {
        let fuel = steps.min(slice);
        Self { frame, fuel, reserve: steps - fuel }
    }

    /// Steps left of the budget.
    fn steps(&self) -> u32 {
        self.fuel + self.reserve
    }

    /// Takes steps, from the slice first.
    fn spend(&mut self, steps: usize) {
        let steps = u32::try_from(steps).unwrap_or(u32::MAX);
        *self = Self::new(self.frame, self.steps().saturating_sub(steps), self.fuel.saturating_sub(steps));
    }

    /// The frame that runs.
    pub(crate) fn frame(&self) -> Frame {
        self.frame
    }
}

impl Limits {
    /// Whether one more frame may start at this register above so many others.
    ///
    /// The calls of the running task take a quarter of the memory at most, beside the data.
    #[inline]
    fn allow(&self, frames: usize, base: usize) -> bool {
        frames < self.frames as usize && frames * size_of::<Frame>() + base * size_of::<Value>() < self.bytes / 4
    }
}

/// A copy made of the parts it was written in: reading the whole of a value whose parts have just
/// been written stalls the processor. The black box keeps the parts apart.
#[inline(always)]
fn copied(value: &Value) -> Value {
    match *value {
        Value::Int(value) => Value::Int(black_box(value)),
        Value::Cons(pair) => Value::Cons(black_box(pair)),
        other => other,
    }
}

#[inline(never)]
fn as_floats(left: &Value, right: &Value) -> Option<(f64, f64)> {
    Some((left.as_f64()?, right.as_f64()?))
}

#[cold]
#[inline(never)]
fn overflow(operation: &str) -> Raise {
    Raise::new("arithmetic-error", format!("integer overflow in {operation}: the result does not fit 64 bits"))
}

/// What came of a turn of the scheduler.
pub(crate) enum Ran {
    /// No task is ready.
    Nothing,
    /// A task ran.
    Task,
    /// A task ran and has not come to its end: the next turn is its own.
    Slice,
    /// The task that runs asks for a datum to be compiled.
    Asked(Value),
}

impl Machine {
    /// Runs the next ready task until it blocks, ends or is switched out.
    pub(crate) fn run_next(&mut self, around: &mut Surroundings<'_>) -> Ran {
        match self.priorities.pop(&mut self.tasks) {
            None => Ran::Nothing,
            Some(task) => self.run_ready(around, task),
        }
    }

    /// Runs a task of the run queue, whatever stands before it.
    pub(crate) fn run_ahead(&mut self, around: &mut Surroundings<'_>, task: u32) -> Ran {
        self.unqueue(task);
        self.run_ready(around, task)
    }

    fn run_ready(&mut self, around: &mut Surroundings<'_>, task: u32) -> Ran {
        if around.outside.period_us().is_some() {
            self.note_progress(task);
        }
        self.run_task(around, task)
    }

    /// Runs a ready task until it blocks, ends, is switched out or has taken a slice of steps. A datum
    /// to compile is answered; the task then goes on with [`Machine::enter`], before anything else runs.
    fn run_task(&mut self, around: &mut Surroundings<'_>, task: u32) -> Ran {
        self.set_state(task, State::Running);
        self.current = task;
        self.scratch.switch = false;
        let record = &mut self.tasks[task];
        if record.budget_instant != self.instant {
            record.budget_instant = self.instant;
            record.steps = 0;
            record.strikes = 0;
        }
        record.steps = record.steps.saturating_add(1);
        self.scratch.wake_at = None;
        self.scratch.burned = 0;
        self.flush_status(around);
        let record = &self.tasks[task];
        let steps = self.limits.steps.saturating_sub(record.steps);
        let mut place = Place::new(record.frame, steps, around.slice_steps);
        self.scratch.frames.clear();
        if !record.frames.is_empty() {
            self.scratch.frames.extend_from_slice(&record.frames);
        }
        self.restore_registers(around.program, task, place.frame);
        let exit = match self.take_up(around, task, &mut place) {
            Some(exit) => exit,
            None => self.execute(around, &mut place, 0),
        };
        self.steps += 1;
        self.leave_off(around, task, place, exit, steps)
    }

    /// Lays aside what ran and had so many steps left at first, as far as its exit asks for.
    fn leave_off(&mut self, around: &mut Surroundings<'_>, task: u32, place: Place, exit: Exit, steps: u32) -> Ran {
        // One that ran out of its limit has got it anew.
        self.steps += u64::from(steps.checked_sub(place.steps()).unwrap_or(self.limits.steps));
        if let Exit::Execute(datum, register) = exit {
            self.scratch.asked = Some((place, register));
            return Ran::Asked(datum);
        }
        if matches!(exit, Exit::Blocked) && self.pause(around, task, place) {
            return Ran::Task;
        }
        self.after_exit(around, task, place, exit)
    }

    /// Lets the running task, which asked for a datum to be compiled, go on in its code, or fail
    /// instead. It may ask again.
    pub(crate) fn enter(&mut self, around: &mut Surroundings<'_>, code: Result<u32, Raise>, steps: usize) -> Ran {
        let Some((mut place, register)) = self.scratch.asked.take() else { return Ran::Task };
        let (task, left) = (self.current, place.steps());
        place.spend(steps);
        let base = place.frame.base as usize + usize::from(register);
        let code = code.and_then(|code| match self.limits.allow(self.scratch.frames.len(), base) {
            true => Ok(code),
            false => Err(self.too_deep()),
        });
        let exit = match code {
            Ok(code) => {
                self.scratch.frames.push(place.frame);
                place.frame = Frame { code, pc: 0, base: base as u32 };
                self.clear_frame(&around.program.codes[code as usize], base);
                None
            }
            Err(raise) => self.raise(around, &mut place, raise),
        };
        let exit = exit.unwrap_or_else(|| self.execute(around, &mut place, 0));
        self.leave_off(around, task, place, exit, left)
    }

    /// Gives a task that goes on what it was woken with; answers how it left, if it did.
    #[inline]
    fn take_up(&mut self, around: &mut Surroundings<'_>, task: u32, place: &mut Place) -> Option<Exit> {
        let record = &mut self.tasks[task];
        if record.raises != Raises::Nothing || record.rare.is_some() {
            return self.take_up_slowly(around, task, place);
        }
        let register = record.wake_register;
        let at = place.frame.base as usize + usize::from(register);
        match &mut record.value {
            Value::Unbound => return None,
            Value::True if register != NO_REG => self.scratch.stack[at] = Value::True,
            value if register != NO_REG => self.scratch.stack[at] = *value,
            _ => {}
        }
        record.value = Value::Unbound;
        None
    }

    #[inline(never)]
    fn take_up_slowly(&mut self, around: &mut Surroundings<'_>, task: u32, place: &mut Place) -> Option<Exit> {
        let record = &mut self.tasks[task];
        let wake = record.take_wake();
        let register = record.frame.base as usize + usize::from(record.wake_register);
        let keeps_value = record.wake_register != NO_REG;
        if record.is_leaving() {
            return if self.unwind_running(around, place) { None } else { Some(Exit::Blocked) };
        }
        match wake {
            Wake::Raise(failure) | Wake::Outcome(failure) => return self.raise(around, place, Raise::Again(failure)),
            Wake::Value(value) if keeps_value => self.scratch.stack[register] = value,
            _ => {}
        }
        None
    }

    /// Lays a task aside that waits now, unless there is more to do than that.
    #[inline]
    fn pause(&mut self, around: &mut Surroundings<'_>, task: u32, place: Place) -> bool {
        let Some(record) = self.tasks.get_mut(task) else { return false };
        if record.state != State::Running || record.rare.is_some() || self.scratch.gives_way {
            return false;
        }
        record.state = State::Blocked;
        record.steps = self.limits.steps.saturating_sub(place.steps());
        let registers = usize::from(around.program.codes[place.frame.code as usize].registers);
        self.store(task, place.frame, registers);
        self.trace_blocked(around.program, task);
        self.current = NONE;
        self.flush_status(around);
        true
    }

    /// Puts a task's registers on the stack. What its record does not keep is nil.
    fn restore_registers(&mut self, program: &Program, task: u32, frame: Frame) {
        let end = |frame: &Frame| frame.base as usize + usize::from(program.codes[frame.code as usize].registers);
        let top = self.scratch.frames.iter().map(end).fold(end(&frame), usize::max);
        if self.scratch.stack.len() < top + WINDOW {
            self.scratch.stack.resize(top + 4 * WINDOW, Value::Nil);
        } else if self.scratch.stack.len() > (top + MAX_SPARE_REGISTERS) * 2 {
            self.scratch.stack.truncate(top + 4 * WINDOW);
            self.scratch.stack.shrink_to_fit();
            self.scratch.frames.shrink_to(self.scratch.frames.len() * 2);
        }
        let stack = &mut self.scratch.stack[..top];
        let values = self.tasks.registers_of(task);
        let kept = values.len().min(top);
        self.scratch.work += kept as u64;
        for (register, &value) in stack.iter_mut().zip(values) {
            *register = value;
        }
        stack[kept..].fill(Value::Nil);
    }

    fn after_exit(&mut self, around: &mut Surroundings<'_>, task: u32, place: Place, exit: Exit) -> Ran {
        let mut ran = Ran::Task;
        let alive = self.tasks.get(task).is_some_and(|record| !record.state.is_dead());
        if alive {
            self.tasks[task].steps = self.limits.steps.saturating_sub(place.steps());
        }
        match exit {
            Exit::Returned(value) => self.finish(around, task, value),
            Exit::Dead => {}
            Exit::Blocked | Exit::Switched | Exit::Paused if alive => {
                let registers = usize::from(around.program.codes[place.frame.code as usize].registers);
                self.store(task, place.frame, registers);
                self.current = NONE;
                match exit {
                    Exit::Switched => self.requeue_running(task),
                    Exit::Paused => {
                        // Going on is no step: how often a task was looked at makes no difference.
                        let record = &mut self.tasks[task];
                        record.steps = record.steps.saturating_sub(1);
                        self.steps -= 1;
                        self.set_aside(task);
                        ran = Ran::Slice;
                    }
                    _ => {
                        let gives_way = std::mem::take(&mut self.scratch.gives_way);
                        if self.tasks[task].state == State::Running {
                            self.set_state(task, State::Blocked);
                            if !gives_way {
                                self.trace_blocked(around.program, task);
                            }
                        }
                        if gives_way {
                            self.tasks[task].set_wake(Wake::Value(Value::Nil));
                            self.make_ready(task);
                        }
                    }
                }
            }
            _ => {}
        }
        self.current = NONE;
        self.flush_status(around);
        ran
    }

    /// The task's own code has ended: the children it spawned go first.
    fn finish(&mut self, around: &mut Surroundings<'_>, task: u32, value: Value) {
        while let Some(scope) = self.tasks[task].scopes.pop() {
            if let ScopeKind::Call(call) = scope.kind {
                self.end_call(around, &call.tags);
            }
        }
        self.die(around, task, State::Succeeded, value);
    }

    /// Evaluates the code of a network in the scratch task, above whatever runs now.
    pub(crate) fn evaluate_code(
        &mut self,
        around: &mut Surroundings<'_>,
        code: u32,
        arguments: &[Value],
    ) -> Result<Value, Value> {
        if self.scratch.evaluations == MAX_EVALUATIONS_DEEP {
            return Err(self.failure_from(Raise::new(
                "stack-overflow",
                format!("networks make networks more than {MAX_EVALUATIONS_DEEP} deep while they are evaluated"),
            )));
        }
        self.scratch.evaluations += 1;
        let outer_task = std::mem::replace(&mut self.current, SCRATCH_TASK);
        let outer_scopes = std::mem::take(&mut self.tasks[SCRATCH_TASK].scopes);
        let outer_top = self.scratch.top;
        let outer_switch = self.scratch.switch;
        if outer_task == NONE {
            self.scratch.frames.clear();
            self.scratch.top = 0;
        }
        let base = self.scratch.top;
        if self.scratch.stack.len() < base + 2 * WINDOW {
            self.scratch.stack.resize(base + 4 * WINDOW, Value::Nil);
        }
        let registers = usize::from(around.program.codes[code as usize].registers);
        self.scratch.stack[base..base + registers.max(arguments.len())].fill(Value::Nil);
        self.scratch.stack[base..base + arguments.len()].copy_from_slice(arguments);
        let entry = self.scratch.frames.len();
        let frame = Frame { code, pc: 0, base: base as u32 };
        let mut place = Place::new(frame, self.limits.steps / 10, u32::MAX);
        let exit = self.execute(around, &mut place, entry);
        self.scratch.burned =
            self.scratch.burned.saturating_add((self.limits.steps / 10).saturating_sub(place.steps()));
        self.scratch.evaluations -= 1;
        self.scratch.frames.truncate(entry);
        self.scratch.top = outer_top;
        self.scratch.switch |= outer_switch;
        self.tasks[SCRATCH_TASK].scopes = outer_scopes;
        let leaving = self.tasks[SCRATCH_TASK].take_leaving();
        self.current = outer_task;
        match (exit, leaving) {
            (Exit::Returned(value), _) => Ok(value),
            (_, Some(Leaving::Fail(failure))) => Err(failure),
            _ => Err(self.failure_from(Raise::new(
                "network-error",
                "this cannot be done while a fluent network or a macro is evaluated",
            ))),
        }
    }

    fn execute(&mut self, around: &mut Surroundings<'_>, place: &mut Place, entry: usize) -> Exit {
        loop {
            // Where a departure ends, what was protected until then is stopped before it goes on.
            if self.scratch.switch && self.current != SCRATCH_TASK {
                self.scratch.switch = false;
                if self.must_switch() {
                    return Exit::Switched;
                }
            }
            let exit = match self.scratch.stepping.is_on {
                false => self.instructions::<false>(around, place, entry),
                true => self.instructions::<true>(around, place, entry),
            };
            let raise = match exit {
                Ok(Exit::Blocked) if self.is_leaving() => {
                    if self.unwind_running(around, place) {
                        continue;
                    }
                    return if self.is_alive() { Exit::Blocked } else { Exit::Dead };
                }
                Ok(exit) => return exit,
                Err(raise) => raise,
            };
            if let Some(exit) = self.raise(around, place, raise) {
                return exit;
            }
        }
    }

    fn is_leaving(&self) -> bool {
        self.tasks.get(self.current).is_some_and(|task| task.is_leaving())
    }

    fn is_alive(&self) -> bool {
        self.tasks.get(self.current).is_some_and(|task| !task.state.is_dead())
    }

    /// Raises a failure where the current task stands; answers how it left, if it did.
    fn raise(&mut self, around: &mut Surroundings<'_>, place: &mut Place, raise: Raise) -> Option<Exit> {
        let failure = self.failure_from(raise);
        if let Value::Failure(index) = failure
            && self.heap.failures[index].span.is_none()
        {
            self.heap.failures[index].span = form_in_plan(around.program, place.frame, &self.scratch.frames);
        }
        let task = self.current;
        if task != SCRATCH_TASK {
            self.trace_failed(around.program, task, failure);
        }
        if !self.tasks[task].is_leaving() {
            self.tasks[task].leave(Leaving::Fail(failure));
        }
        if self.unwind_running(around, place) {
            return None;
        }
        Some(if self.is_alive() { Exit::Blocked } else { Exit::Dead })
    }

    /// Goes on with the current task's departure; tells whether code is to run now.
    fn unwind_running(&mut self, around: &mut Surroundings<'_>, place: &mut Place) -> bool {
        let task = self.current;
        let registers = usize::from(around.program.codes[place.frame.code as usize].registers);
        self.scratch.top = place.frame.base as usize + registers;
        loop {
            match self.unwind_step(around, task, true) {
                Unwound::Land(landing) => self.land_at(place, landing),
                Unwound::Waiting | Unwound::Dead => return false,
            }
            if !self.take_up_pending(around, task) {
                return true;
            }
        }
    }

    fn land_at(&mut self, place: &mut Place, landing: Landing) {
        if let Some(&frame) = self.scratch.frames.get(landing.depth as usize) {
            place.frame = frame;
            self.scratch.frames.truncate(landing.depth as usize);
        }
        place.frame.pc = landing.target;
        for (register, value) in landing.writes {
            if value != Value::Unbound {
                self.scratch.stack[place.frame.base as usize + usize::from(register)] = value;
            }
        }
    }

    fn push_scope(&mut self, kind: ScopeKind) {
        let depth = self.scratch.frames.len() as u32;
        let task = self.current;
        let is_first = self.tasks[task].scopes.is_empty();
        self.heap.allocated += memory::scope(&kind) + if is_first { memory::SCOPE_STACK } else { 0 };
        self.tasks[task].scopes.push(Scope { kind, depth });
    }

    /// Refuses what a network or a macro may not do.
    fn refuse_in_network(&self, what: &str) -> Result<(), Raise> {
        if self.current == SCRATCH_TASK {
            return Err(Raise::new("network-error", format!("{what} while a fluent network or a macro is evaluated")));
        }
        Ok(())
    }

    /// Arranges arguments for a function with optional, rest or key parameters.
    pub(crate) fn arrange(&mut self, code: &Code, first: usize, count: usize) -> Result<(), Raise> {
        let parameters: &Parameters = &code.parameters;
        if !parameters.accepts(count) {
            let name = self.symbols.name(code.name).to_string();
            let given = if count == 1 { "1 was given".into() } else { format!("{count} were given") };
            return Err(Raise::new("arity-error", format!("`{name}` takes {}, and {given}", parameters.describe())));
        }
        if parameters.is_simple() {
            return Ok(());
        }
        let required = usize::from(parameters.required);
        let optional = usize::from(parameters.optional);
        let given: Vec<Value> = self.scratch.stack[first..first + count].to_vec();
        let positional = given.len().min(required + optional);
        let mut arranged = given[..positional].to_vec();
        arranged.resize(required + optional, Value::Unbound);
        let rest = &given[positional..];
        if parameters.rest {
            arranged.push(self.heap.list(rest));
        }
        if !parameters.keys.is_empty() {
            let keys = arranged.len();
            arranged.resize(keys + parameters.keys.len(), Value::Unbound);
            for pair in rest.chunks(2) {
                let known = match pair[0] {
                    Value::Keyword(key) => parameters.keys.iter().position(|&known| known == key),
                    _ => None,
                };
                match (known, pair.get(1)) {
                    (Some(at), Some(&value)) => arranged[keys + at] = value,
                    _ if parameters.rest => {}
                    (None, _) => {
                        let names: Vec<String> =
                            parameters.keys.iter().map(|&key| format!(":{}", self.symbols.name(key))).collect();
                        let name = self.symbols.name(code.name);
                        return Err(Raise::new(
                            "arity-error",
                            format!(
                                "`{name}` takes the keywords {}, not {}",
                                names.join(" "),
                                self.describe_key(pair[0])
                            ),
                        ));
                    }
                    (Some(_), None) => {
                        return Err(Raise::new("arity-error", format!("{} has no value", self.describe_key(pair[0]))));
                    }
                }
            }
        }
        self.scratch.stack[first..first + arranged.len()].copy_from_slice(&arranged);
        Ok(())
    }

    fn describe_key(&self, value: Value) -> String {
        match value {
            Value::Keyword(key) => format!("`:{}`", self.symbols.name(key)),
            other => other.type_name().to_string(),
        }
    }

    #[cold]
    #[inline(never)]
    fn wrong_operands(&self, operation: &str, left: Value, right: Value) -> Raise {
        let culprit = if left.as_f64().is_none() { left } else { right };
        self.wrong_type(&format!("an operand of `{operation}`"), Kind::Number.noun(), culprit)
    }

    fn not_a_function(&self, value: Value) -> Raise {
        self.wrong_type("what is called", Kind::Function.noun(), value)
    }

    #[cold]
    #[inline(never)]
    fn describe_global(&self, around: &Surroundings<'_>, global: u32) -> Raise {
        let name = self.symbols.name(around.program.globals[global as usize].name);
        Raise::new("unbound-variable", format!("`{name}` has no value yet: its definition has not run"))
    }

    /// The loop. Comes back with an exit, or with a failure to raise at `place`.
    #[allow(
        clippy::too_many_lines,
        reason = "one arm an instruction; the loop must be one function to keep its state in registers"
    )]
    fn instructions<const STEPPING: bool>(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &mut Place,
        entry: usize,
    ) -> Result<Exit, Raise> {
        let program = around.program;
        let mut code: &Code = &program.codes[place.frame.code as usize];
        let mut code_number = place.frame.code;
        let mut pc = place.frame.pc as usize;
        let mut base = place.frame.base as usize;
        let mut fuel = place.fuel;

        macro_rules! save {
            () => {
                place.frame = Frame { code: code_number, pc: pc as u32, base: base as u32 };
                place.fuel = fuel;
                self.scratch.top = base + usize::from(code.registers);
            };
        }
        macro_rules! fail {
            ($raise:expr) => {{
                let raise = $raise;
                save!();
                return Err(raise);
            }};
        }
        macro_rules! attempt {
            ($result:expr) => {
                match $result {
                    Ok(value) => value,
                    Err(raise) => fail!(raise),
                }
            };
        }
        macro_rules! collect_if_full {
            () => {
                if self.heap.is_full() {
                    attempt!(self.collect_here(base + usize::from(code.registers)));
                }
            };
        }
        // After an instruction that may have made a more important task ready, ended or suspended
        // this one.
        macro_rules! check_switch {
            () => {
                if !self.scratch.status_changed.is_empty() {
                    save!();
                    self.flush_status(around);
                }
                if self.scratch.switch {
                    self.scratch.switch = false;
                    if self.current != SCRATCH_TASK && self.must_switch() {
                        save!();
                        return Ok(Exit::Switched);
                    }
                }
            };
        }
        macro_rules! check_leaving {
            () => {
                if self.tasks[self.current].is_leaving() {
                    save!();
                    return Ok(Exit::Blocked);
                }
            };
        }
        // After a call of a value, which may have been entered, or done if it is a native.
        macro_rules! go_on {
            () => {
                (code_number, pc, base) = (place.frame.code, place.frame.pc as usize, place.frame.base as usize);
                code = &program.codes[code_number as usize];
                spend!();
                check_leaving!();
                check_switch!();
            };
        }
        macro_rules! block {
            ($register:expr) => {{
                save!();
                let task = self.current;
                self.tasks[task].wake_register = $register;
                return Ok(Exit::Blocked);
            }};
        }
        // What a native or a network has burned, taken from the slice and then from what is behind it.
        macro_rules! spend {
            () => {
                let burned = std::mem::take(&mut self.scratch.burned);
                place.reserve = place.reserve.saturating_sub(burned.saturating_sub(fuel));
                fuel = fuel.saturating_sub(burned);
            };
        }
        // Before anything of the instruction is done: where a slice is over it begins anew.
        macro_rules! burn {
            () => {
                match fuel.checked_sub(1) {
                    Some(rest) => fuel = rest,
                    None if place.reserve > 0 => {
                        pc -= 1;
                        save!();
                        self.end_slice::<STEPPING>(place.frame);
                        return Ok(Exit::Paused);
                    }
                    None => {
                        let again = self.budget_anew(around, place.frame);
                        (fuel, place.reserve) = (again.fuel, again.reserve);
                        fail!(self.runaway());
                    }
                }
            };
        }

        'frame: loop {
            if STEPPING {
                let frame = Frame { code: code_number, pc: pc as u32, base: base as u32 };
                save!();
                if self.stops_before(program, &code.ops[pc], frame) {
                    return Ok(Exit::Paused);
                }
            }
            let window =
                self.scratch.stack.get_mut(base..base + REACH).and_then(|above| above.first_chunk_mut::<REACH>());
            let Some(r) = window else {
                self.grow_stack(base);
                continue 'frame;
            };
            macro_rules! r {
                ($register:expr) => {
                    r[$register as usize]
                };
            }
            // Registers of a frame that starts at `$first`, save `$count` arguments.
            // Four at a time, and so perhaps some behind the frame, where nothing lives.
            macro_rules! clear {
                ($callee:expr, $first:expr, $count:expr) => {
                    let mut at = $first + $count;
                    let end = $first + usize::from($callee.registers);
                    if let Some(four) = r[at..].first_chunk_mut::<4>() {
                        *four = [Value::Nil; 4];
                    }
                    while at + 4 < end {
                        at += 4;
                        if let Some(four) = r[at..].first_chunk_mut::<4>() {
                            *four = [Value::Nil; 4];
                        }
                    }
                };
            }
            // In parts, as in `copied`; what is neither is copied whole, never put together again.
            macro_rules! copy {
                ($to:expr, $from:expr) => {
                    match &r!($from) {
                        &Value::Int(value) => r!($to) = Value::Int(black_box(value)),
                        &Value::Cons(pair) => r!($to) = Value::Cons(black_box(pair)),
                        _ => r.copy_within(usize::from($from)..usize::from($from) + 1, usize::from($to)),
                    }
                };
            }
            macro_rules! arithmetic {
                ($to:expr, $a:expr, $b:expr, $name:literal, $checked:ident, $operator:tt) => {
                    match (&r!($a), &r!($b)) {
                        (&Value::Int(x), &Value::Int(y)) => match x.$checked(y) {
                            Some(value) => r!($to) = Value::Int(value),
                            None => fail!(overflow($name)),
                        },
                        (&Value::Float(x), &Value::Float(y)) => r!($to) = Value::Float(x $operator y),
                        (left, right) => match as_floats(left, right) {
                            Some((x, y)) => r!($to) = Value::Float(x $operator y),
                            None => {
                                let (left, right) = (*left, *right);
                                fail!(self.wrong_operands($name, left, right))
                            }
                        },
                    }
                };
            }
            macro_rules! compare {
                ($a:expr, $b:expr, $name:literal, $operator:tt) => {
                    match (&r!($a), &r!($b)) {
                        (&Value::Int(x), &Value::Int(y)) => x $operator y,
                        (left, right) => match as_floats(left, right) {
                            Some((x, y)) => x $operator y,
                            None => {
                                let (left, right) = (*left, *right);
                                fail!(self.wrong_operands($name, left, right))
                            }
                        },
                    }
                };
            }
            macro_rules! compare_int {
                ($a:expr, $value:expr, $name:literal, $operator:tt) => {
                    match &r!($a) {
                        &Value::Int(x) => x $operator i64::from($value),
                        &Value::Float(x) => x $operator f64::from($value),
                        other => {
                            let other = *other;
                            fail!(self.wrong_operands($name, other, other))
                        }
                    }
                };
            }
            macro_rules! jump {
                ($distance:expr) => {{
                    let distance = $distance;
                    if distance < 0 {
                        burn!();
                    }
                    pc = (pc as i64 + i64::from(distance)) as usize;
                }};
            }
            let ops = code.ops.as_slice();
            let mut is_looked_at = STEPPING;
            loop {
                if STEPPING && !std::mem::take(&mut is_looked_at) {
                    continue 'frame;
                }
                let op = &ops[pc];
                pc += 1;
                match *op {
                    Op::Nil(a) => r!(a) = Value::Nil,
                    Op::True(a) => r!(a) = Value::True,
                    Op::Int(a, value) => r!(a) = Value::Int(i64::from(value)),
                    Op::Const(a, constant) => r!(a) = self.constants[constant as usize],
                    Op::Global(a, global) => {
                        // By reference: a value taken apart and put together again is slow to read.
                        let value = &self.globals[global as usize];
                        if matches!(value, Value::Unbound) {
                            fail!(self.describe_global(around, global));
                        }
                        r!(a) = *value;
                    }
                    Op::SetGlobal(a, global) => {
                        let value = r!(a);
                        attempt!(self.refuse_in_network("a variable cannot be assigned"));
                        self.globals[global as usize] = value;
                        continue 'frame;
                    }
                    Op::DefFluent(a, global) => {
                        let value = r!(a);
                        attempt!(self.refuse_in_network("a fluent cannot be defined"));
                        let name = program.globals[global as usize].name;
                        let fluent = match value {
                            Value::Fluent(_) => value,
                            value => self.create_fluent(Fluent::new(Some(name), value, Origin::Plan)),
                        };
                        if let Value::Fluent(index) = fluent
                            && self.fluents[index].name.is_none()
                        {
                            self.fluents[index].name = Some(name);
                        }
                        self.globals[global as usize] = fluent;
                        self.scratch.stack[base + usize::from(a)] = fluent;
                        continue 'frame;
                    }
                    Op::Move(a, b) => copy!(a, b),
                    Op::CellNew(a, b) => {
                        r!(a) = self.heap.cell(r!(b));
                        collect_if_full!();
                        continue 'frame;
                    }
                    Op::CellGet(a, b) => {
                        if let Value::Cell(cell) = r!(b) {
                            r!(a) = self.heap.cells[cell];
                        }
                    }
                    Op::CellSet(a, b) => {
                        if let Value::Cell(cell) = r!(a) {
                            self.heap.cells[cell] = r!(b);
                        }
                    }
                    Op::Add(a, b, c) => arithmetic!(a, b, c, "+", checked_add, +),
                    Op::Sub(a, b, c) => arithmetic!(a, b, c, "-", checked_sub, -),
                    Op::Mul(a, b, c) => arithmetic!(a, b, c, "*", checked_mul, *),
                    Op::AddInt(a, b, value) => match &r!(b) {
                        &Value::Int(x) => match x.checked_add(i64::from(value)) {
                            Some(sum) => r!(a) = Value::Int(sum),
                            None => fail!(overflow("+")),
                        },
                        &Value::Float(x) => r!(a) = Value::Float(x + f64::from(value)),
                        other => {
                            let other = *other;
                            fail!(self.wrong_operands("+", other, other))
                        }
                    },
                    Op::Less(a, b, c) => r!(a) = Value::truth(compare!(b, c, "<", <)),
                    Op::LessEq(a, b, c) => r!(a) = Value::truth(compare!(b, c, "<=", <=)),
                    Op::NumEq(a, b, c) => r!(a) = Value::truth(compare!(b, c, "=", ==)),
                    Op::Eq(a, b, c) => r!(a) = Value::truth(r!(b) == r!(c)),
                    Op::Not(a, b) => r!(a) = Value::truth(matches!(r!(b), Value::Nil)),
                    Op::Cons(a, b, c) => {
                        r!(a) = self.heap.cons(copied(&r!(b)), copied(&r!(c)));
                        if self.heap.is_full() {
                            collect_if_full!();
                            continue 'frame;
                        }
                    }
                    Op::Car(a, b) => match &r!(b) {
                        &Value::Cons(pair) => r!(a) = self.heap.pairs[pair as usize].0,
                        Value::Nil => r!(a) = Value::Nil,
                        &other => fail!(self.wrong_type("the argument of `car`", Kind::List.noun(), other)),
                    },
                    Op::Cdr(a, b) => match &r!(b) {
                        &Value::Cons(pair) => r!(a) = self.heap.pairs[pair as usize].1,
                        Value::Nil => r!(a) = Value::Nil,
                        &other => fail!(self.wrong_type("the argument of `cdr`", Kind::List.noun(), other)),
                    },
                    Op::Jump(distance) => jump!(distance),
                    Op::JumpIfNil(a, distance) => {
                        if matches!(r!(a), Value::Nil) {
                            jump!(distance);
                        }
                    }
                    Op::JumpIfTrue(a, distance) => {
                        if !matches!(r!(a), Value::Nil) {
                            jump!(distance);
                        }
                    }
                    Op::JumpIfGiven(a, distance) => {
                        if !matches!(r!(a), Value::Unbound) {
                            jump!(distance);
                        }
                    }
                    Op::JumpUnlessLess(a, b, distance) => {
                        if !compare!(a, b, "<", <) {
                            jump!(distance);
                        }
                    }
                    Op::JumpUnlessLessEq(a, b, distance) => {
                        if !compare!(a, b, "<=", <=) {
                            jump!(distance);
                        }
                    }
                    Op::JumpUnlessNumEq(a, b, distance) => {
                        if !compare!(a, b, "=", ==) {
                            jump!(distance);
                        }
                    }
                    Op::JumpUnlessLessInt(a, value, distance) => {
                        if !compare_int!(a, value, "<", <) {
                            jump!(distance);
                        }
                    }
                    Op::JumpUnlessLessEqInt(a, value, distance) => {
                        if !compare_int!(a, value, "<=", <=) {
                            jump!(distance);
                        }
                    }
                    Op::JumpUnlessGreaterInt(a, value, distance) => {
                        if !compare_int!(a, value, ">", >) {
                            jump!(distance);
                        }
                    }
                    Op::JumpUnlessGreaterEqInt(a, value, distance) => {
                        if !compare_int!(a, value, ">=", >=) {
                            jump!(distance);
                        }
                    }
                    Op::JumpUnlessNumEqInt(a, value, distance) => {
                        if !compare_int!(a, value, "=", ==) {
                            jump!(distance);
                        }
                    }
                    Op::Call(first, count, global) => {
                        burn!();
                        match self.globals[global as usize] {
                            Value::Function(number) => {
                                let callee: &Code = &program.codes[number as usize];
                                let first = usize::from(first);
                                if !self.limits.allow(self.scratch.frames.len(), base + first) {
                                    fail!(self.too_deep());
                                }
                                if callee.exact_count == u16::from(count) {
                                    clear!(callee, first, usize::from(count));
                                } else {
                                    attempt!(self.arrange(callee, base + first, usize::from(count)));
                                    self.clear_frame(callee, base + first);
                                }
                                self.scratch.frames.push(Frame { code: code_number, pc: pc as u32, base: base as u32 });
                                (code, code_number, pc, base) = (callee, number, 0, base + first);
                                continue 'frame;
                            }
                            Value::Unbound => fail!(self.describe_global(around, global)),
                            function => {
                                save!();
                                let first = usize::from(first);
                                let arguments =
                                    self.scratch.stack[base + first..base + first + usize::from(count)].to_vec();
                                match self.call_value(
                                    around,
                                    place,
                                    function,
                                    &arguments,
                                    first,
                                    false,
                                    first as Reg,
                                )? {
                                    Some(exit) => return Ok(exit),
                                    None => {
                                        go_on!();
                                        continue 'frame;
                                    }
                                }
                            }
                        }
                    }
                    Op::TailCall(first, count, global) => {
                        burn!();
                        match self.globals[global as usize] {
                            Value::Function(number) if program.codes[number as usize].kind != CodeKind::Plan => {
                                let callee: &Code = &program.codes[number as usize];
                                let from = usize::from(first);
                                r.copy_within(from..from + usize::from(count), 0);
                                if callee.exact_count == u16::from(count) {
                                    clear!(callee, 0, usize::from(count));
                                } else {
                                    attempt!(self.arrange(callee, base, usize::from(count)));
                                    self.clear_frame(callee, base);
                                }
                                (code, code_number, pc) = (callee, number, 0);
                                continue 'frame;
                            }
                            Value::Unbound => fail!(self.describe_global(around, global)),
                            function => {
                                save!();
                                let first = usize::from(first);
                                let arguments =
                                    self.scratch.stack[base + first..base + first + usize::from(count)].to_vec();
                                match self.call_value(around, place, function, &arguments, first, true, first as Reg)? {
                                    Some(exit) => return Ok(exit),
                                    None => {
                                        go_on!();
                                        continue 'frame;
                                    }
                                }
                            }
                        }
                    }
                    Op::CallValue(callee, count) | Op::TailCallValue(callee, count) => {
                        burn!();
                        // Looked at again, so that no other instruction keeps its number at hand.
                        let tail = matches!(black_box(op), Op::TailCallValue(..));
                        let function = &r!(callee);
                        let first = usize::from(callee) + 1;
                        let known = match *function {
                            Value::Function(number) => Some((number, &[][..])),
                            Value::Closure(index) => {
                                let closure = &self.heap.closures[index];
                                Some((closure.code, &*closure.captured))
                            }
                            _ => None,
                        };
                        if let Some((number, captured)) = known
                            && let callee = &*program.codes[number as usize]
                            && callee.exact_count == u16::from(count)
                            && self.limits.allow(self.scratch.frames.len(), base)
                        {
                            let count = usize::from(count);
                            let tail = tail && callee.kind != CodeKind::Plan;
                            let start = if tail { 0 } else { first };
                            if tail {
                                r.copy_within(first..first + count, 0);
                            } else {
                                self.scratch.frames.push(Frame { code: code_number, pc: pc as u32, base: base as u32 });
                            }
                            clear!(callee, start, count);
                            for (register, &value) in r[start + count..].iter_mut().zip(captured) {
                                *register = value;
                            }
                            (code, code_number, pc, base) = (callee, number, 0, base + start);
                            continue 'frame;
                        }
                        let function = *function;
                        let arguments = r[first..first + usize::from(count)].to_vec();
                        save!();
                        match self.call_value(around, place, function, &arguments, first, tail, first as Reg)? {
                            Some(exit) => return Ok(exit),
                            None => {
                                go_on!();
                                continue 'frame;
                            }
                        }
                    }
                    Op::CallCode(first, number) => {
                        burn!();
                        self.scratch.frames.push(Frame { code: code_number, pc: pc as u32, base: base as u32 });
                        base += usize::from(first);
                        (code, code_number, pc) = (&program.codes[number as usize], number, 0);
                        self.clear_frame(code, base);
                        continue 'frame;
                    }
                    Op::CallNative(to, first, count, native) => {
                        save!();
                        let first = usize::from(first);
                        let reply = match count {
                            0 => self.call_native(around, native, &[]),
                            1 => {
                                let arguments = [r[first]];
                                self.call_native(around, native, &arguments)
                            }
                            2 => {
                                let arguments = [r[first], r[first + 1]];
                                self.call_native(around, native, &arguments)
                            }
                            3 => {
                                let arguments = [r[first], r[first + 1], r[first + 2]];
                                self.call_native(around, native, &arguments)
                            }
                            _ => {
                                let arguments = r[first..first + usize::from(count)].to_vec();
                                self.call_native(around, native, &arguments)
                            }
                        };
                        spend!();
                        let reply = match reply {
                            Ok(reply) => reply,
                            Err(raise) => {
                                let arguments = base + first..base + first + usize::from(count);
                                let arguments = self.scratch.stack[arguments].to_vec();
                                attempt!(self.call_with_room(around, native, &arguments, raise))
                            }
                        };
                        match reply {
                            Reply::Value(value) => {
                                self.scratch.stack[base + usize::from(to)] = value;
                                collect_if_full!();
                                if self.scratch.switch || around.natives[usize::from(native)].effect.acts() {
                                    check_leaving!();
                                    check_switch!();
                                }
                            }
                            Reply::Wait => block!(to),
                            Reply::Leave => {
                                self.scratch.stack[base + usize::from(to)] = Value::Nil;
                                check_leaving!();
                                check_switch!();
                            }
                            Reply::Execute(datum) => return Ok(Exit::Execute(datum, to)),
                            Reply::Call(function, arguments) => {
                                match self.call_value(
                                    around,
                                    place,
                                    function,
                                    &arguments,
                                    usize::from(to),
                                    false,
                                    to,
                                )? {
                                    Some(exit) => return Ok(exit),
                                    None => {
                                        go_on!();
                                    }
                                }
                            }
                        }
                        continue 'frame;
                    }
                    Op::Closure(a, number) => {
                        let inner = &program.codes[number as usize];
                        r!(a) = if inner.captures.is_empty() {
                            Value::Function(number)
                        } else {
                            let captured = inner.captures.iter().map(|&register| r!(register)).collect();
                            self.heap.closure(number, captured)
                        };
                        collect_if_full!();
                        continue 'frame;
                    }
                    Op::Return(a) => {
                        if self.scratch.frames.len() == entry {
                            let value = r!(a);
                            save!();
                            if self.current != SCRATCH_TASK && self.must_wait_for_spawned(around) {
                                // The instruction runs again when they are dead.
                                place.frame.pc -= 1;
                                let task = self.current;
                                self.tasks[task].wake_register = NO_REG;
                                return Ok(Exit::Blocked);
                            }
                            return Ok(Exit::Returned(value));
                        }
                        copy!(0u8, a);
                        if let Some(frame) = self.scratch.frames.pop() {
                            (code_number, pc, base) = (frame.code, frame.pc as usize, frame.base as usize);
                            code = &program.codes[code_number as usize];
                        }
                        continue 'frame;
                    }
                    Op::EnterPlan => {
                        attempt!(self.refuse_in_network("a plan cannot be called"));
                        let task = self.current;
                        let span = self.scratch.frames.last().and_then(|frame| {
                            program.codes[frame.code as usize].spans.get((frame.pc as usize).saturating_sub(1)).copied()
                        });
                        let call = task::Call {
                            name: code.name,
                            occurrence: self.count_use(task, code.name),
                            span,
                            counters: BTreeMap::new(),
                            spawned: 0,
                            tags: Vec::new(),
                            most_tags: 0,
                            failure: None,
                        };
                        self.push_scope(ScopeKind::Call(Box::new(call)));
                        self.trace_call(task);
                        collect_if_full!();
                        continue 'frame;
                    }
                    Op::LeavePlan(a) => {
                        let value = r!(a);
                        save!();
                        if self.must_wait_for_spawned(around) {
                            place.frame.pc -= 1;
                            let task = self.current;
                            self.tasks[task].wake_register = NO_REG;
                            return Ok(Exit::Blocked);
                        }
                        let task = self.current;
                        self.trace_return(program, task, value);
                        if let Some(Scope { kind: ScopeKind::Call(call), .. }) = self.tasks[task].scopes.pop() {
                            self.end_call(around, &call.tags);
                        }
                        check_switch!();
                        continue 'frame;
                    }
                    Op::TagNew(a, constant) => {
                        if let Value::Symbol(name) = self.constants[constant as usize] {
                            let tag = self.new_tag(name);
                            self.scratch.stack[base + usize::from(a)] = tag;
                        }
                        collect_if_full!();
                        continue 'frame;
                    }
                    Op::Parallel(a, number) => {
                        attempt!(self.refuse_in_network("a task cannot be started"));
                        save!();
                        let construct = &code.constructs[number as usize];
                        let top = self.scratch.top;
                        attempt!(self.make_room(top, construct.children.len() * memory::TASK));
                        collect_if_full!();
                        match self.start_construct(around, construct, None, a, base)? {
                            Some(value) => self.scratch.stack[base + usize::from(a)] = value,
                            None => {
                                let task = self.current;
                                self.tasks[task].waiting = Waiting::Children;
                                block!(a);
                            }
                        }
                        continue 'frame;
                    }
                    Op::ParallelMap(a, list, number) => {
                        let list = r!(list);
                        attempt!(self.refuse_in_network("a task cannot be started"));
                        save!();
                        let count = match self.heap.length(list) {
                            Ok(count) => count,
                            Err(_) => fail!(self.wrong_type("what is mapped over", Kind::List.noun(), list)),
                        };
                        let top = self.scratch.top;
                        attempt!(self.make_room(top, count * memory::TASK));
                        collect_if_full!();
                        let construct = &code.constructs[number as usize];
                        match self.start_construct(around, construct, Some(list), a, base)? {
                            Some(value) => self.scratch.stack[base + usize::from(a)] = value,
                            None => {
                                let task = self.current;
                                self.tasks[task].waiting = Waiting::Children;
                                block!(a);
                            }
                        }
                        continue 'frame;
                    }
                    Op::Spawn(a, number) => {
                        attempt!(self.refuse_in_network("a task cannot be started"));
                        save!();
                        collect_if_full!();
                        let value = self.start_spawned(around, &code.constructs[number as usize], base)?;
                        self.scratch.stack[base + usize::from(a)] = value;
                        check_switch!();
                        continue 'frame;
                    }
                    Op::PushBlock(a, result, distance) => {
                        let identity = self.next_identity;
                        self.next_identity += 1;
                        r!(a) = Value::Int(identity as i64);
                        let target = (pc as i64 + i64::from(distance)) as u32;
                        self.push_scope(ScopeKind::Block { identity, result, target });
                        collect_if_full!();
                        continue 'frame;
                    }
                    Op::ReturnFrom(a, b) => {
                        let (identity, value) = (r!(a), r!(b));
                        save!();
                        let identity = if let Value::Int(identity) = identity { identity as u64 } else { u64::MAX };
                        let task = self.current;
                        let is_here = self.tasks[task].scopes.iter().rev().any(
                            |scope| matches!(scope.kind, ScopeKind::Block { identity: known, .. } if known == identity),
                        );
                        if !is_here {
                            return Err(Raise::new(
                                "control-error",
                                "the block to return from is not around this any more, or belongs to another task",
                            ));
                        }
                        self.tasks[task].leave(Leaving::Block { identity, value });
                        return Ok(Exit::Blocked);
                    }
                    Op::PushHandler(failure, index, distance) => {
                        let target = (pc as i64 + i64::from(distance)) as u32;
                        self.push_scope(ScopeKind::Handler {
                            code: code_number,
                            index: u32::from(index),
                            failure,
                            target,
                        });
                        collect_if_full!();
                        continue 'frame;
                    }
                    Op::PushCleanup(distance) => {
                        let target = (pc as i64 + i64::from(distance)) as u32;
                        self.push_scope(ScopeKind::Cleanup { target });
                        collect_if_full!();
                        continue 'frame;
                    }
                    Op::BeginCleanup => {
                        let task = self.current;
                        self.tasks[task].scopes.pop();
                        self.push_scope(ScopeKind::InCleanup(Box::new(Then::Continue)));
                        self.refresh_boost(task);
                        continue 'frame;
                    }
                    Op::EndCleanup => {
                        let task = self.current;
                        if let Some(Scope { kind: ScopeKind::InCleanup(then), .. }) = self.tasks[task].scopes.pop() {
                            if let Then::Leave(leaving) = *then {
                                self.tasks[task].leave(leaving);
                                save!();
                                return Ok(Exit::Blocked);
                            }
                            save!();
                            if self.take_up_pending(around, task) {
                                return Ok(Exit::Blocked);
                            }
                            check_switch!();
                        }
                        continue 'frame;
                    }
                    Op::PushValve(a) => {
                        let value = r!(a);
                        attempt!(self.refuse_in_network("a valve cannot be requested"));
                        let Value::Valve(valve) = value else {
                            fail!(self.wrong_type("what is held", Kind::Valve.noun(), value));
                        };
                        save!();
                        let task = self.current;
                        let granted = self.request_valve(around, task, valve)?;
                        // The scope is entered when the valve is there: it is pushed now, and a
                        // release of what is not held does nothing.
                        self.push_scope(ScopeKind::Valve(valve));
                        if !granted {
                            block!(NO_REG);
                        }
                        check_switch!();
                        continue 'frame;
                    }
                    Op::PushOnInterrupt(a) => {
                        let hook = r!(a);
                        self.push_scope(ScopeKind::OnInterrupt(hook));
                        collect_if_full!();
                        continue 'frame;
                    }
                    Op::PushOnResume(a) => {
                        let hook = r!(a);
                        self.push_scope(ScopeKind::OnResume(hook));
                        collect_if_full!();
                        continue 'frame;
                    }
                    Op::PushSuspended(a) => {
                        let value = r!(a);
                        attempt!(self.refuse_in_network("a task cannot be suspended"));
                        let Value::Task(other) = value else {
                            fail!(self.wrong_type("what is suspended", Kind::Task.noun(), value));
                        };
                        save!();
                        self.push_scope(ScopeKind::Suspended(other));
                        if let Some(other) = self.tasks.find_alive(other) {
                            self.hold_for(around, other, self.current);
                            if self.wait_for_rest(other) {
                                block!(NO_REG);
                            }
                        }
                        check_switch!();
                        continue 'frame;
                    }
                    Op::PushWatch(a, missed, owned) => {
                        let value = r!(a);
                        attempt!(self.refuse_in_network("a fluent cannot be watched"));
                        let Value::Fluent(fluent) = value else {
                            fail!(self.wrong_type("the condition of `whenever`", Kind::Fluent.noun(), value));
                        };
                        let task = self.current;
                        if owned {
                            // It dies with the watch; nothing names it then.
                            self.scratch.stack[base + usize::from(a)] = Value::Nil;
                        }
                        let watch = self.start_watch(task, fluent, missed, owned);
                        self.push_scope(ScopeKind::Watch(watch));
                        collect_if_full!();
                        continue 'frame;
                    }
                    Op::WatchWait => {
                        let task = self.current;
                        let watch = self.innermost_watch(task);
                        save!();
                        if !self.next_event(watch)? {
                            place.frame.pc -= 1;
                            pc -= 1;
                            block!(NO_REG);
                        }
                        continue 'frame;
                    }
                    Op::WatchDone => {
                        let task = self.current;
                        let watch = self.innermost_watch(task);
                        self.event_served(watch);
                        continue 'frame;
                    }
                    Op::PopScopes(count) => {
                        save!();
                        for _ in 0..count {
                            self.pop_ended_scope(around);
                        }
                        check_leaving!();
                        check_switch!();
                        continue 'frame;
                    }
                    Op::LeaveScopes(count, distance) => {
                        let target = (pc as i64 + i64::from(distance)) as u32;
                        save!();
                        let task = self.current;
                        let scopes = self.tasks[task].scopes.len() as u32 - u32::from(count);
                        let depth = self.scratch.frames.len() as u32;
                        self.tasks[task].leave(Leaving::Jump { scopes, target, depth });
                        return Ok(Exit::Blocked);
                    }
                    Op::Network(a, number) => {
                        let inner = &program.codes[number as usize];
                        let captured = inner.captures.iter().map(|&register| r!(register)).collect();
                        save!();
                        let fluent = self.create_network(around, number, captured);
                        spend!();
                        self.scratch.stack[base + usize::from(a)] = fluent;
                        collect_if_full!();
                        continue 'frame;
                    }
                    Op::WaitFor(a, condition, seconds, owned) => {
                        // The condition and the time are of no use to anybody else: a task that
                        // waits keeps fewer registers without them.
                        let fluent = match &r!(condition) {
                            Value::Fluent(fluent) => *fluent,
                            other => {
                                let other = *other;
                                attempt!(self.refuse_in_network("nothing can be waited for"));
                                fail!(self.wrong_type("the condition of `wait-for`", Kind::Fluent.noun(), other));
                            }
                        };
                        r!(condition) = Value::Nil;
                        let timeout = if seconds == NO_REG { None } else { Some(std::mem::take(&mut r!(seconds))) };
                        attempt!(self.refuse_in_network("nothing can be waited for"));
                        save!();
                        match self.wait_for(fluent, timeout, owned)? {
                            Some(value) => self.scratch.stack[base + usize::from(a)] = value,
                            None => block!(a),
                        }
                        continue 'frame;
                    }
                    Op::Deref(a, b) => {
                        let value = r!(b);
                        if let Value::Fluent(fluent) = value {
                            let value = attempt!(self.read_fluent(fluent));
                            self.scratch.stack[base + usize::from(a)] = value;
                            continue 'frame;
                        }
                        r!(a) = value;
                    }
                    Op::Assign(a, fluent, value) => {
                        // `nil` and `t` to a fluent nothing is computed from: the common signal.
                        let truth = match &r!(value) {
                            Value::Nil => Some(Value::Nil),
                            Value::True => Some(Value::True),
                            _ => None,
                        };
                        if let (Some(truth), &Value::Fluent(fluent)) = (truth, &r!(fluent))
                            && self.current != SCRATCH_TASK
                            && !self.trace.enabled
                            && let Some(entry) = self.fluents.get_mut(fluent)
                            && entry.is_plain()
                        {
                            r!(a) = truth;
                            if entry.value.is_true() == truth.is_true()
                                && matches!(entry.value, Value::Nil | Value::True)
                            {
                                continue;
                            }
                            entry.value = truth;
                            if truth.is_true() && entry.waiters.first != NONE {
                                self.wake_waiters(fluent, Wake::Value(Value::True));
                                check_switch!();
                                continue 'frame;
                            }
                            continue;
                        }
                        let (fluent, value) = (r!(fluent), r!(value));
                        r!(a) = value;
                        save!();
                        attempt!(self.refuse_in_network("a fluent cannot be assigned"));
                        attempt!(self.assign_fluent(around, fluent, value));
                        spend!();
                        collect_if_full!();
                        check_switch!();
                        continue 'frame;
                    }
                    Op::Refail(a) => {
                        let failure = r!(a);
                        fail!(Raise::Again(failure));
                    }
                }
            }
        }
    }

    /// Collects garbage while registers below `top` are in use.
    #[cold]
    #[inline(never)]
    fn collect_here(&mut self, top: usize) -> Result<(), Raise> {
        self.scratch.top = top;
        // A network under evaluation is not named by anything yet, nor is what it was called for.
        if self.current != SCRATCH_TASK {
            self.collect();
        }
        if self.has_room(0) { Ok(()) } else { Err(self.out_of_memory()) }
    }

    /// Whether the running task must give way: something more important is ready, or it is
    /// suspended itself.
    fn must_switch(&self) -> bool {
        let record = &self.tasks[self.current];
        record.is_held() || self.is_output_full() || self.priorities.has_higher(self.effective_priority(self.current))
    }

    /// The place of a task that has spent its budget and gets it once more. What is evaluated without
    /// a task is not cut.
    fn budget_anew(&self, around: &Surroundings<'_>, frame: Frame) -> Place {
        let slice = if self.current == SCRATCH_TASK { u32::MAX } else { around.slice_steps };
        Place::new(frame, self.limits.steps, slice)
    }

    /// The running task has spent its budget, and begins a new one.
    #[cold]
    #[inline(never)]
    fn runaway(&mut self) -> Raise {
        if self.current == SCRATCH_TASK {
            self.scratch.burned = self.scratch.burned.saturating_add(self.limits.steps / 10);
        }
        let task = self.current;
        let strikes = self.tasks[task].strikes.saturating_add(1);
        self.strike(task, strikes);
        Raise::new(
            "runaway",
            format!(
                "{} steps in one instant without blocking; let it wait, as with `(wait-time 0.1)`, or end it, as with `until`",
                self.limits.steps
            ),
        )
    }

    #[cold]
    #[inline(never)]
    fn too_deep(&self) -> Raise {
        Raise::new("stack-overflow", format!("{} calls inside one another", self.limits.frames))
    }

    #[cold]
    #[inline(never)]
    fn grow_stack(&mut self, base: usize) {
        // By a little only: what is grown is filled, and so taken from the system.
        self.scratch.stack.resize((base + REACH) / 8 * 9, Value::Nil);
    }

    fn clear_frame(&mut self, code: &Code, base: usize) {
        let (from, to) = (code.parameters.registers(), usize::from(code.registers));
        if self.scratch.stack.len() < base + REACH {
            self.grow_stack(base);
        }
        self.scratch.stack[base + from..base + to].fill(Value::Nil);
    }

    fn call_native(&mut self, around: &mut Surroundings<'_>, native: u16, arguments: &[Value]) -> Result<Reply, Raise> {
        let natives = around.natives;
        let entry = &natives[usize::from(native)];
        if entry.effect.acts() && self.current == SCRATCH_TASK {
            self.refuse_in_network(&format!("`{}` cannot be called", entry.name))?;
        }
        (entry.code)(&mut NativeCall { machine: self, around, native: entry, arguments })
    }

    /// Calls a native that has found no room once more, when what nobody needs is gone.
    #[cold]
    #[inline(never)]
    fn call_with_room(
        &mut self,
        around: &mut Surroundings<'_>,
        native: u16,
        arguments: &[Value],
        raise: Raise,
    ) -> Result<Reply, Raise> {
        let Raise::NoRoom(bytes) = raise else { return Err(raise) };
        // Not all arguments need to stand in registers.
        let (top, above) = (self.scratch.top, self.scratch.top + arguments.len());
        if self.scratch.stack.len() < above {
            self.scratch.stack.resize(above, Value::Nil);
        }
        self.scratch.stack[top..above].copy_from_slice(arguments);
        let room = self.make_room(above, bytes);
        self.scratch.top = top;
        room?;
        self.call_native(around, native, arguments)
    }

    /// Calls any function value. On return `place` tells where to go on; an exit if the task stops.
    #[allow(clippy::too_many_arguments, reason = "the calling convention in full")]
    fn call_value(
        &mut self,
        around: &mut Surroundings<'_>,
        place: &mut Place,
        mut function: Value,
        arguments: &[Value],
        mut first: usize,
        mut tail: bool,
        result: Reg,
    ) -> Result<Option<Exit>, Raise> {
        let mut arguments = Cow::Borrowed(arguments);
        // A native may go on in a function, and that be a native again: as far as data reach.
        while let Value::Native(native) = function {
            match self.call_native_value(around, native, &arguments)? {
                Reply::Value(value) => {
                    self.scratch.stack[place.frame.base as usize + usize::from(result)] = value;
                    return Ok(None);
                }
                Reply::Wait => {
                    let task = self.current;
                    self.tasks[task].wake_register = result;
                    return Ok(Some(Exit::Blocked));
                }
                Reply::Leave => return Ok(None),
                Reply::Execute(datum) => return Ok(Some(Exit::Execute(datum, result))),
                Reply::Call(next, further) => {
                    (function, arguments) = (next, Cow::Owned(further));
                    (first, tail) = (usize::from(result), false);
                    self.scratch.burned = self.scratch.burned.saturating_add(1);
                    if self.scratch.burned >= place.steps() {
                        self.scratch.burned = 0;
                        *place = self.budget_anew(around, place.frame);
                        return Err(self.runaway());
                    }
                }
            }
        }
        self.enter_function(around, place, function, &arguments, first, tail)
    }

    /// Begins a function that is no native.
    fn enter_function(
        &mut self,
        around: &Surroundings<'_>,
        place: &mut Place,
        function: Value,
        arguments: &[Value],
        first: usize,
        tail: bool,
    ) -> Result<Option<Exit>, Raise> {
        let (number, captured) = match function {
            Value::Function(number) => (number, None),
            Value::Closure(index) => (self.heap.closures[index].code, Some(self.heap.closures[index].captured.clone())),
            other => return Err(self.not_a_function(other)),
        };
        let callee = &around.program.codes[number as usize];
        let tail = tail && callee.kind != CodeKind::Plan;
        let base = place.frame.base as usize + if tail { 0 } else { first };
        let needed = base + WINDOW.max(arguments.len());
        if self.scratch.stack.len() < needed {
            self.grow_stack(needed);
        }
        self.scratch.stack[base..base + arguments.len()].copy_from_slice(arguments);
        self.arrange(callee, base, arguments.len())?;
        if !tail {
            if !self.limits.allow(self.scratch.frames.len(), base) {
                return Err(self.too_deep());
            }
            self.scratch.frames.push(place.frame);
        }
        self.clear_frame(callee, base);
        if let Some(captured) = captured {
            let at = base + callee.parameters.registers();
            self.scratch.stack[at..at + captured.len()].copy_from_slice(&captured);
        }
        place.frame = Frame { code: number, pc: 0, base: base as u32 };
        Ok(None)
    }

    /// Calls a native that is known only by its value.
    fn call_native_value(
        &mut self,
        around: &mut Surroundings<'_>,
        native: u16,
        arguments: &[Value],
    ) -> Result<Reply, Raise> {
        let NativeSignature { min, max, .. } = around.signatures[usize::from(native)];
        let count = arguments.len();
        if count < usize::from(min) || max.is_some_and(|max| count > usize::from(max)) {
            let name = around.natives[usize::from(native)].name;
            return Err(Raise::new("arity-error", format!("`{name}` cannot take {count} arguments")));
        }
        match self.call_native(around, native, arguments) {
            Ok(reply) => Ok(reply),
            Err(raise) => self.call_with_room(around, native, arguments, raise),
        }
    }

    fn new_tag(&mut self, name: rpl_lang::symbol::Symbol) -> Value {
        let task = self.current;
        let priority = self.tasks[task].priority;
        self.heap.allocated += memory::TASK;
        let index = self.tasks.insert(Task::new(0, Registers::default(), name, priority));
        let value = self.expose(index);
        let reference = self.tasks.reference(index);
        if let Some((owner, call)) = self.plan_call_around(task) {
            self.note_tag(owner, call, reference);
        }
        value
    }

    /// Notes a tag of a plan call. Those that were reached need nothing at its end and are dropped.
    fn note_tag(&mut self, task: u32, scope: usize, tag: TaskRef) {
        let ScopeKind::Call(call) = &mut self.tasks[task].scopes[scope].kind else { return };
        let (mut tags, mut most) = (std::mem::take(&mut call.tags), call.most_tags);
        if tags.len() >= most as usize {
            let tasks = &self.tasks;
            tags.retain(|&tag| tasks.find(tag).is_some_and(|tag| tasks[tag].state == State::Created));
            most = (2 * tags.len() as u32).max(4);
        }
        tags.push(tag);
        if let ScopeKind::Call(call) = &mut self.tasks[task].scopes[scope].kind {
            (call.tags, call.most_tags) = (tags, most);
        }
    }

    /// Evaporates what the innermost plan call spawned; tells whether some of it still lives.
    fn must_wait_for_spawned(&mut self, around: &mut Surroundings<'_>) -> bool {
        let task = self.current;
        let Some(index) = self.tasks[task].scopes.call_within(usize::MAX) else { return false };
        let waits = self.evaporate_children(around, task, index as u32) > 0;
        if waits {
            self.tasks[task].waiting = Waiting::Spawned;
        }
        waits
    }

    fn innermost_watch(&self, task: u32) -> u32 {
        self.tasks[task]
            .scopes
            .iter()
            .rev()
            .find_map(|scope| match scope.kind {
                ScopeKind::Watch(watch) => Some(watch),
                _ => None,
            })
            .unwrap_or_else(|| unreachable!("the compiler opens a watch around its waits"))
    }

    /// Leaves the innermost scope, whose body has ended by itself.
    fn pop_ended_scope(&mut self, around: &mut Surroundings<'_>) {
        let task = self.current;
        match self.tasks[task].scopes.pop().map(|scope| scope.kind) {
            Some(ScopeKind::Valve(valve)) => self.release_valve(around, task, valve),
            Some(ScopeKind::Suspended(other)) => {
                if let Some(other) = self.tasks.find_alive(other) {
                    self.unhold(around, other);
                }
            }
            Some(ScopeKind::Watch(watch)) => self.end_watch(watch),
            _ => {}
        }
    }

    /// Waits for a fluent to be true: the value at once, or none if the task waits now.
    fn wait_for(&mut self, fluent: u32, timeout: Option<Value>, owned: bool) -> Result<Option<Value>, Raise> {
        let due_us =
            timeout.map(|seconds| self.instant_after(seconds, || "`:timeout` of `wait-for`".into())).transpose()?;
        let task = self.current;
        let entry = &mut self.fluents[fluent];
        if let Some(failure) = entry.failure {
            return Err(Raise::Again(failure));
        }
        if entry.is_true() {
            let value = entry.reading();
            if owned {
                self.free_network(fluent);
            }
            return Ok(Some(value));
        }
        self.number_wait(task);
        self.tasks[task].waiting = Waiting::Fluent { fluent, owned, timed: due_us.is_some() };
        let entry = &mut self.fluents[fluent];
        entry.waiters.push_back(&mut self.tasks, task);
        if let Some(due_us) = due_us {
            self.set_wake_timer(task, due_us);
        }
        Ok(None)
    }

    /// Sets the timer that ends the current wait of a task.
    pub(crate) fn set_wake_timer(&mut self, task: u32, due_us: u64) {
        let number = self.tasks[task].wait_number;
        let reference = self.tasks.reference(task);
        // A wait for time worked that goes on has been told before.
        if self.trace.enabled && task == self.current {
            self.scratch.wake_at = Some(due_us);
        }
        self.heap.allocated += memory::TIMER;
        self.timers.set(due_us, reference, crate::scheduler::Alarm::Wake(number));
    }
}
