//! Networks and macros, evaluated in the scratch task above whatever runs.

use crate::state::failure::Raise;
use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::scratch::Cursor;
use crate::state::slab::NONE;
use crate::state::task::{Frame, Leaving};
use crate::state::value::Value;
use crate::step::exec::{Exit, WINDOW};
use crate::step::native::Surroundings;

/// Evaluations of networks inside one another; each takes some Rust stack.
pub(super) const MAX_EVALUATIONS_DEEP: u32 = 64;

impl Machine {
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
        let is_inner = self.scratch.evaluations > 1;
        let outer_scopes = is_inner.then(|| std::mem::take(&mut self.tasks[SCRATCH_TASK].scopes));
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
        let above = &mut self.scratch.stack[base..base + registers.max(arguments.len())];
        let (given, others) = above.split_at_mut(arguments.len());
        for (register, argument) in given.iter_mut().zip(arguments) {
            register.set(argument);
        }
        for register in others {
            *register = Value::Nil;
        }
        let entry = self.scratch.frames.len();
        let frame = Frame { code, pc: 0, base: base as u32 };
        let budget = self.budget();
        let mut place = Cursor::new(frame, budget, u32::MAX);
        let exit = self.execute(around, &mut place, entry);
        self.scratch.burned = self.scratch.burned.saturating_add(budget.saturating_sub(place.steps()));
        self.scratch.evaluations -= 1;
        self.scratch.frames.truncate(entry);
        self.scratch.top = outer_top;
        self.scratch.switch |= outer_switch;
        self.current = outer_task;
        let record = &mut self.tasks[SCRATCH_TASK];
        if is_inner || !record.scopes.is_empty() {
            record.scopes = outer_scopes.unwrap_or_default();
        }
        let leaving = record.take_leaving();
        if let Exit::Returned(value) = exit {
            return Ok(value);
        }
        match leaving {
            Some(Leaving::Fail(failure)) => Err(failure),
            _ => Err(self.failure_from(Raise::new(
                "network-error",
                "this cannot be done while a fluent network or a macro is evaluated",
            ))),
        }
    }
}
