//! Networks and macros, evaluated in the scratch task above whatever runs.

use crate::state::failure::Raise;
use crate::state::machine::{Machine, SCRATCH_TASK};
use crate::state::scratch::Cursor;
use crate::state::slab::NONE;
use crate::state::task::{Frame, Leaving};
use crate::state::value::Value;
use crate::step::exec::arithmetic::{arithmetic, compare};
use crate::step::exec::{Exit, WINDOW};
use crate::step::native::Surroundings;
use rpl_lang::code::{Op, PLAIN_REGISTERS, Program};

/// Evaluations of networks inside one another; each takes some Rust stack.
pub(super) const MAX_EVALUATIONS_DEEP: u32 = 64;

/// Nothing fails here: the loop over instructions is to say how.
macro_rules! fail {
    ($raise:expr) => {
        return None
    };
}

/// Each instruction ends where the next is taken.
macro_rules! next {
    () => {};
}

impl Machine {
    /// The value of a network that is plain, as most conditions are: computed in a few registers of its own, without a frame
    /// and a budget, of which it would take nothing. None where it is not plain, something in it fails, or `read` gives up
    /// on a fluent; then nothing has happened but what `read` did.
    #[expect(unused_variables, reason = "operands that only a failure would name")]
    #[inline(always)]
    pub(crate) fn evaluate_plainly<'m>(
        &'m self,
        program: &Program,
        code: u32,
        captured: &[Value],
        mut read: impl FnMut(u32) -> Option<&'m Value>,
    ) -> Option<Value> {
        let code = &*program.codes[code as usize];
        if !code.is_plain || self.scratch.stepping.is_on || self.scratch.evaluations == MAX_EVALUATIONS_DEEP {
            return None;
        }
        let mut registers = [Value::Nil; PLAIN_REGISTERS];
        // What has lain in memory for a while is copied as a whole.
        for (register, &value) in registers.iter_mut().zip(captured) {
            *register = value;
        }
        macro_rules! r {
            ($register:expr) => {
                registers[usize::from($register) % PLAIN_REGISTERS]
            };
        }
        let mut rest = &code.ops[..];
        while let Some((op, behind)) = rest.split_first() {
            rest = behind;
            match *op {
                Op::Nil(a) => r!(a) = Value::Nil,
                Op::True(a) => r!(a) = Value::True,
                Op::Int(a, value) => r!(a) = Value::Int(i64::from(value)),
                Op::Const(a, constant) => r!(a) = self.constants[constant as usize],
                Op::Global(a, global) => match &self.globals[global as usize] {
                    Value::Unbound => return None,
                    &value => r!(a) = value,
                },
                Op::Move(a, b) => r!(a) = r!(b).copied(),
                Op::CellGet(a, b) => {
                    let Value::Cell(cell) = r!(b) else { return None };
                    r!(a) = self.heap.cells[cell];
                }
                Op::Deref(a, b) => match r!(b) {
                    Value::Fluent(fluent) => r!(a) = *read(fluent)?,
                    value => r!(a) = value,
                },
                Op::Add(a, b, c) => arithmetic!(self, r!(a), r!(b), r!(c), "+", checked_add, +),
                Op::Sub(a, b, c) => arithmetic!(self, r!(a), r!(b), r!(c), "-", checked_sub, -),
                Op::Mul(a, b, c) => arithmetic!(self, r!(a), r!(b), r!(c), "*", checked_mul, *),
                Op::AddInt(a, b, value) => {
                    arithmetic!(self, r!(a), r!(b), Value::Int(i64::from(value)), "+", checked_add, +)
                }
                Op::Less(a, b, c) => r!(a) = Value::truth(compare!(self, r!(b), r!(c), "a comparison", <)),
                Op::LessEq(a, b, c) => r!(a) = Value::truth(compare!(self, r!(b), r!(c), "a comparison", <=)),
                Op::NumEq(a, b, c) => r!(a) = Value::truth(compare!(self, r!(b), r!(c), "`=`", ==)),
                Op::NumDiffer(a, b, c) => r!(a) = Value::truth(compare!(self, r!(b), r!(c), "`/=`", !=)),
                Op::Eq(a, b, c) => r!(a) = Value::truth(r!(b) == r!(c)),
                Op::Not(a, b) => r!(a) = Value::truth(matches!(r!(b), Value::Nil)),
                Op::Jump(distance) => rest = &rest[distance as usize..],
                Op::JumpIfNil(a, distance) if !r!(a).is_true() => rest = &rest[distance as usize..],
                Op::JumpIfTrue(a, distance) if r!(a).is_true() => rest = &rest[distance as usize..],
                Op::JumpIfNil(..) | Op::JumpIfTrue(..) => {}
                Op::Return(a) => return Some(r!(a)),
                _ => return None,
            }
        }
        None
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
        let is_inner = self.scratch.evaluations > 1;
        if !is_inner {
            self.scratch.overdrawn = 0;
        }
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
