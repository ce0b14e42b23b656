//! A turn of a ready task: taken up, run, and laid aside.

use crate::state::failure::Raise;
use crate::state::limits::Spent;
use crate::state::machine::Machine;
use crate::state::projected::{Answered, Asked};
use crate::state::registers::Registers;
use crate::state::scratch::Cursor;
use crate::state::slab::NONE;
use crate::state::task::{Frame, Raises, ScopeKind, State, Waiting, Wake};
use crate::state::value::Value;
use crate::step::exec::{Exit, WINDOW};
use crate::step::native::Surroundings;
use rpl_lang::code::{NO_REG, Program};

/// Registers that are kept from a task that needed them for one that does not.
const MAX_SPARE_REGISTERS: usize = 1 << 16;

/// What came of a turn of the scheduler.
pub(crate) enum Ran {
    /// No task is ready.
    Nothing,
    /// A task ran.
    Task,
    /// A task ran and has not come to its end: the next turn is its own.
    Slice,
    /// The task that runs asks something of the whole run.
    Asked(Asked),
}

impl Machine {
    /// Runs the next ready task until it blocks, ends or is switched out. If there is none, garbage that is due is
    /// collected now: what happens next does not wait for it.
    pub(crate) fn run_next(&mut self, around: &mut Surroundings<'_>) -> Ran {
        let next = match self.schedule {
            None => self.priorities.pop(&mut self.tasks),
            Some(_) => self.take_scheduled(),
        };
        match next {
            None => {
                self.collect_at_rest();
                Ran::Nothing
            }
            Some(task) => self.run_ready(around, task),
        }
    }

    /// Runs a task of the run queue, whatever stands before it.
    pub(crate) fn run_ahead(&mut self, around: &mut Surroundings<'_>, task: u32) -> Ran {
        self.unqueue(task);
        self.run_ready(around, task)
    }

    #[inline]
    fn run_ready(&mut self, around: &mut Surroundings<'_>, task: u32) -> Ran {
        if around.outside.next_event_us(self.now_us).is_some() {
            self.note_progress(task);
        }
        self.run_task(around, task)
    }

    /// Runs a ready task until it blocks, ends, is switched out or has taken a slice of steps. A datum
    /// to compile is answered; the task then goes on with [`Machine::enter`], before anything else runs.
    fn run_task(&mut self, around: &mut Surroundings<'_>, task: u32) -> Ran {
        self.current = task;
        self.scratch.switch = false;
        self.scratch.wake_at = None;
        self.scratch.burned = 0;
        let record = &mut self.tasks[task];
        record.enter(State::Running);
        // What follows changes neither.
        let registers = record.registers;
        self.spent.steps = self.spent.steps.saturating_add(Spent::A_TURN);
        let steps = self.limits.steps.saturating_sub(self.spent.steps);
        let mut place = Cursor::new(record.frame, steps, around.slice_steps);
        let has_frames = !record.frames.is_empty();
        if record.rare.is_some() {
            self.note_status(task);
        }
        self.flush_status(around);
        self.scratch.frames.clear();
        if has_frames {
            self.scratch.frames.extend_from_slice(&self.tasks[task].frames);
        }
        self.restore_registers(around.program, registers, place.frame);
        let exit = match self.take_up(around, task, &mut place) {
            Some(exit) => exit,
            None => self.execute(around, &mut place, 0),
        };
        self.steps += 1;
        self.leave_off(around, task, place, exit, steps)
    }

    /// Lays aside what ran and had `steps` steps left at first, as far as its exit asks for.
    #[inline]
    fn leave_off(&mut self, around: &mut Surroundings<'_>, task: u32, place: Cursor, exit: Exit, steps: u32) -> Ran {
        // One that ran out of its limit has got it anew.
        self.steps += u64::from(steps.checked_sub(place.steps()).unwrap_or(self.limits.steps));
        self.spent.steps = self.limits.steps.saturating_sub(place.steps());
        if let Exit::Ask(asked, register) = exit {
            self.scratch.asked = Some((place, register));
            return Ran::Asked(asked);
        }
        if matches!(exit, Exit::Blocked) && self.pause(around, task, place) {
            return Ran::Task;
        }
        self.after_exit(around, task, place, exit)
    }

    /// Lets the running task, which asked something of the whole run, go on with the answer, or fail
    /// instead. It may ask again.
    pub(crate) fn enter(
        &mut self,
        around: &mut Surroundings<'_>,
        answer: Result<Answered, Raise>,
        steps: usize,
    ) -> Ran {
        let Some((mut place, register)) = self.scratch.asked.take() else { return Ran::Task };
        let (task, left) = (self.current, place.steps());
        place.spend(steps);
        let base = place.frame.base as usize + usize::from(register);
        let answer = answer.and_then(|answer| match answer {
            Answered::Code(_) if !self.limits.allow(self.scratch.frames.len(), base) => Err(self.too_deep()),
            answer => Ok(answer),
        });
        let exit = match answer {
            Ok(Answered::Value(value)) => {
                self.scratch.stack[base] = value;
                None
            }
            Ok(Answered::Code(code)) => {
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

    /// Lets the running task, which asked something of the whole run, wait for the answer.
    pub(crate) fn await_answer(&mut self, around: &mut Surroundings<'_>) -> Ran {
        let Some((place, register)) = self.scratch.asked.take() else { return Ran::Task };
        let (task, left) = (self.current, place.steps());
        self.number_wait(task);
        let record = &mut self.tasks[task];
        record.wait(Waiting::Answer);
        record.wake_register = register;
        self.leave_off(around, task, place, Exit::Blocked, left)
    }

    /// Gives a task that goes on what it was woken with; answers how it left, if it did.
    #[inline]
    fn take_up(&mut self, around: &mut Surroundings<'_>, task: u32, place: &mut Cursor) -> Option<Exit> {
        let record = &mut self.tasks[task];
        if record.raises != Raises::Nothing || record.rare.is_some() {
            return self.take_up_slowly(around, task, place);
        }
        let register = record.wake_register;
        let at = place.frame.base as usize + usize::from(register);
        match record.value() {
            Value::Unbound => return None,
            Value::True if register != NO_REG => self.scratch.stack[at] = Value::True,
            value if register != NO_REG => self.scratch.stack[at] = *value,
            _ => {}
        }
        record.set_wake(Wake::Nothing);
        None
    }

    #[inline(never)]
    fn take_up_slowly(&mut self, around: &mut Surroundings<'_>, task: u32, place: &mut Cursor) -> Option<Exit> {
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
    fn pause(&mut self, around: &mut Surroundings<'_>, task: u32, place: Cursor) -> bool {
        let Some(record) = self.tasks.get_mut(task) else { return false };
        if record.state() != State::Running || record.rare.is_some() || self.scratch.gives_way.is_some() {
            return false;
        }
        record.enter(State::Blocked);
        let registers = usize::from(around.program.codes[place.frame.code as usize].registers);
        self.store(task, place.frame, registers);
        self.trace_blocked(around.program, task);
        self.current = NONE;
        self.flush_status(around);
        true
    }

    /// Puts a task's registers on the stack. What its record does not keep is nil.
    fn restore_registers(&mut self, program: &Program, registers: Registers, frame: Frame) {
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
        let values = self.tasks.registers.get(registers);
        let kept = values.len().min(top);
        self.scratch.work += kept as u64;
        for (register, &value) in stack.iter_mut().zip(values) {
            *register = value;
        }
        stack[kept..].fill(Value::Nil);
    }

    fn after_exit(&mut self, around: &mut Surroundings<'_>, task: u32, place: Cursor, exit: Exit) -> Ran {
        let mut ran = Ran::Task;
        let alive = self.tasks.get(task).is_some_and(|record| !record.state().is_dead());
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
                        self.spent.steps = self.spent.steps.saturating_sub(Spent::A_TURN);
                        self.steps -= 1;
                        self.set_aside(task);
                        ran = Ran::Slice;
                    }
                    _ => {
                        let gives_way = self.scratch.gives_way.take();
                        if self.tasks[task].state() == State::Running {
                            self.set_state(task, State::Blocked);
                            if gives_way.is_none() {
                                self.trace_blocked(around.program, task);
                            }
                        }
                        if let Some(value) = gives_way {
                            self.note_given_way(task);
                            self.tasks[task].set_wake(Wake::Value(value));
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
    #[inline]
    fn finish(&mut self, around: &mut Surroundings<'_>, task: u32, value: Value) {
        while let Some(scope) = self.tasks[task].scopes.pop() {
            if let ScopeKind::Call(call) = scope.kind {
                self.end_call(around, &call.tags);
            }
        }
        self.die(around, task, State::Succeeded, value);
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
}
