//! Natives that have an instruction of their own where their arguments allow it. Unlike those of
//! [`intrinsics`](crate::compile::intrinsics) they stay calls up to here, for what looks at effects.

use super::emitter::Emitter;
use crate::code::{Op, Reg};
use crate::compile::ir::{Ir, IrKind};

impl Emitter<'_, '_> {
    /// Emits the instruction for a call of a native, if there is one.
    pub(super) fn native_instruction(&mut self, native: u16, arguments: &[Ir], into: Reg) -> bool {
        match (self.compiler.natives[usize::from(native)].name.as_str(), arguments) {
            ("%set-value", [fluent, value]) => {
                let fluent = self.operand(fluent, &[value]);
                let value = self.operand(value, &[]);
                self.push(Op::Assign(into, fluent, value));
            }
            ("%slot", [record, kind, place]) => {
                let (Some(kind), Some(place)) = (constant(kind), byte(place)) else { return false };
                let record = self.operand(record, &[]);
                self.push(Op::Slot(into, record, place, kind));
            }
            ("%assign-slot", [record, kind, place, value]) => {
                let (Some(kind), Some(place)) = (constant(kind), byte(place)) else { return false };
                let record = self.operand(record, &[value]);
                let value = self.operand(value, &[]);
                self.push(Op::SetSlot(record, value, place, kind));
                self.take(value, into);
            }
            _ => return false,
        }
        true
    }
}

fn constant(ir: &Ir) -> Option<u32> {
    match ir.kind {
        IrKind::Const(constant) => Some(constant),
        _ => None,
    }
}

fn byte(ir: &Ir) -> Option<u8> {
    match ir.kind {
        IrKind::Int(value) => u8::try_from(value).ok(),
        _ => None,
    }
}
