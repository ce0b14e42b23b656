//! Calls.

use super::emitter::{Emitter, MAX_REGISTERS};
use crate::code::{GlobalKind, Op, Reg, SlotAccess};
use crate::compile::ir::{Callee, Ir};

impl Emitter<'_, '_> {
    /// The register where a row of arguments begins: `into` itself, if that is the topmost register and no variable's.
    fn first_argument(&mut self, into: Reg) -> Reg {
        let is_free = usize::from(into) + 1 == self.next && !self.registers.values().any(|&reg| reg == into);
        if is_free { into } else { self.fresh() }
    }

    /// What a function is known to do with a slot, given `count` arguments. A program can still define it anew.
    fn slot_access(&self, global: u32, count: u8) -> Option<SlotAccess> {
        let program = &self.compiler.program;
        let GlobalKind::Function(code) = program.globals[global as usize].kind else { return None };
        let code = program.codes.get(code as usize)?;
        code.slot.filter(|_| code.exact_count == u16::from(count))
    }

    /// Calls a function by its name. A variable whose slot is read or assigned is not moved before.
    fn call_global(&mut self, global: u32, arguments: &[Ir], into: Reg, tail: bool) {
        let (count, first) = (arguments.len() as u8, self.first_argument(into));
        let Some((argument, others)) = arguments.split_first() else {
            self.push(if tail { Op::TailCall(first, count, global) } else { Op::Call(first, count, global) });
            return self.take(first, into);
        };
        let slot = if tail { None } else { self.slot_access(global, count) };
        let own = slot.and_then(|_| self.own_register(argument, others.iter()));
        if own.is_none() {
            self.value(argument, first, false);
        }
        if !others.is_empty() {
            self.arguments(others);
        }
        self.push(match slot {
            Some(slot) if slot.assigns => Op::CallSetSlot(first, own.unwrap_or(first), global),
            Some(_) => Op::CallSlot(first, own.unwrap_or(first), global),
            None if tail => Op::TailCall(first, count, global),
            None => Op::Call(first, count, global),
        });
        // Also behind a tail call: what turns out to be no function of the plan's own comes back.
        self.take(first, into);
    }

    /// Puts arguments into fresh registers in a row and gives the first.
    pub(super) fn arguments(&mut self, arguments: &[Ir]) -> Reg {
        let first = self.next;
        for argument in arguments {
            let reg = self.fresh();
            self.value(argument, reg, false);
        }
        if arguments.is_empty() {
            self.fresh();
        }
        first.min(MAX_REGISTERS) as Reg
    }

    /// Puts arguments into a register that is the topmost, and into fresh ones behind it.
    fn arguments_from(&mut self, first: Reg, arguments: &[Ir]) {
        let Some((argument, others)) = arguments.split_first() else { return };
        self.value(argument, first, false);
        if !others.is_empty() {
            self.arguments(others);
        }
    }

    pub(super) fn call(&mut self, callee: &Callee, arguments: &[Ir], into: Reg, tail: bool) {
        if arguments.len() > MAX_REGISTERS {
            let count = arguments.len();
            let span = self.span;
            self.compiler
                .error(
                    "too-large",
                    span,
                    format!("this call has {count} arguments, and {MAX_REGISTERS} is the most"),
                    "too many",
                )
                .help = Some("pass a list: `(apply f list)`".into());
            return;
        }
        let count = arguments.len() as u8;
        match callee {
            Callee::Native(native) if self.native_instruction(*native, arguments, into, tail) => {}
            Callee::Native(native) => {
                let first = self.arguments(arguments);
                if self.compiler.natives[usize::from(*native)].calls {
                    self.push(Op::CallNative(first, first, count, *native));
                    self.take(first, into);
                } else {
                    self.push(Op::CallNative(into, first, count, *native));
                }
            }
            Callee::Global(global) => self.call_global(*global, arguments, into, tail),
            Callee::Value(function) => self.call_value(function, arguments, into, tail),
        }
    }

    /// Calls the function that is the value of a form.
    pub(super) fn call_value(&mut self, function: &Ir, arguments: &[Ir], into: Reg, tail: bool) {
        let behind: Vec<&Ir> = arguments.iter().collect();
        let function = self.operand(function, &behind);
        let (count, first) = (arguments.len() as u8, self.first_argument(into));
        self.arguments_from(first, arguments);
        self.push(match tail {
            true => Op::TailCallValue(first, function, count),
            false => Op::CallValue(first, function, count),
        });
        self.take(first, into);
    }
}
