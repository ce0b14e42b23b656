//! Calls.

use super::emitter::{Emitter, MAX_REGISTERS};
use crate::code::{Op, Reg};
use crate::compile::ir::{Callee, Ir};

impl Emitter<'_, '_> {
    /// Puts arguments into registers in a row and gives the first: `into` itself, if that is the
    /// topmost register and no variable's.
    fn arguments_from(&mut self, arguments: &[Ir], into: Reg) -> Reg {
        let is_free = usize::from(into) + 1 == self.next && !self.registers.values().any(|&reg| reg == into);
        match arguments.split_first() {
            Some((first, rest)) if is_free => {
                self.value(first, into, false);
                if !rest.is_empty() {
                    self.arguments(rest);
                }
                into
            }
            None if is_free => into,
            _ => self.arguments(arguments),
        }
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
            Callee::Native(native) if self.native_instruction(*native, arguments, into) => {}
            Callee::Native(native) => {
                let first = self.arguments(arguments);
                if self.compiler.natives[usize::from(*native)].calls {
                    self.push(Op::CallNative(first, first, count, *native));
                    self.take(first, into);
                } else {
                    self.push(Op::CallNative(into, first, count, *native));
                }
            }
            Callee::Global(global) => {
                let first = self.arguments_from(arguments, into);
                if tail {
                    self.push(Op::TailCall(first, count, *global));
                } else {
                    self.push(Op::Call(first, count, *global));
                }
                // Also behind a tail call: what turns out to be no function of the plan's own
                // comes back.
                self.take(first, into);
            }
            Callee::Value(function) => {
                let function_reg = self.fresh();
                self.value(function, function_reg, false);
                let first = self.arguments(arguments);
                if tail {
                    self.push(Op::TailCallValue(function_reg, count));
                } else {
                    self.push(Op::CallValue(function_reg, count));
                }
                self.take(first, into);
            }
        }
    }
}
