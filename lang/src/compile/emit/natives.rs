//! Natives that have an instruction of their own where their arguments allow it. Unlike those of
//! [`intrinsics`](crate::compile::intrinsics) they stay calls up to here, for what looks at effects.

use super::emitter::Emitter;
use crate::code::{NO_REG, Op, Reg};
use crate::compile::ir::{Ir, IrKind};

impl Emitter<'_, '_> {
    /// Emits the instruction for a call of a native, if there is one.
    pub(super) fn native_instruction(&mut self, native: u16, arguments: &[Ir], into: Reg, tail: bool) -> bool {
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
            ("vref", [vector, position]) => {
                let vector = self.operand(vector, &[position]);
                let position = self.operand(position, &[]);
                self.push(Op::VectorRef(into, vector, position));
            }
            ("mod", [number, divisor]) => {
                let number = self.operand(number, &[divisor]);
                let divisor = self.operand(divisor, &[]);
                self.push(Op::Mod(into, number, divisor));
            }
            ("gethash", [key, table, default @ ..]) => {
                let behind: Vec<&Ir> = default.iter().collect();
                let key = self.operand(key, &[&[table][..], &behind].concat());
                let table = self.operand(table, &behind);
                let default = default.first().map_or(NO_REG, |default| self.operand(default, &[]));
                self.push(Op::TableRef(into, key, table, default));
            }
            ("funcall", [function, arguments @ ..]) => self.call_value(function, arguments, into, tail),
            ("%extend", [end, value]) => {
                let end = self.operand(end, &[value]);
                let value = self.operand(value, &[]);
                self.push(Op::Extend(into, end, value));
            }
            ("%each", [function, list, value, body, element @ ..]) => {
                self.each(function, list, value, body, element.first());
            }
            ("%sort-merge", [state, predicate]) => self.sort(state, predicate),
            _ => {
                let Some(value) = self.store(native, arguments) else { return false };
                self.take(value, into);
            }
        }
        true
    }

    /// Emits the instruction for a native that stores a value in a place, if there is one; gives the register of the
    /// value.
    pub(super) fn store(&mut self, native: u16, arguments: &[Ir]) -> Option<Reg> {
        match (self.compiler.natives[usize::from(native)].name.as_str(), arguments) {
            ("%assign-slot", [record, kind, place, value]) => {
                let (kind, place) = (constant(kind)?, byte(place)?);
                let record = self.operand(record, &[value]);
                let value = self.operand(value, &[]);
                self.push(Op::SetSlot(record, value, place, kind));
                Some(value)
            }
            ("%set-vref", [vector, position, value]) => {
                let vector = self.operand(vector, &[position, value]);
                let position = self.operand(position, &[value]);
                let value = self.operand(value, &[]);
                self.push(Op::SetVectorRef(vector, position, value));
                Some(value)
            }
            ("%set-gethash", [key, table, default @ .., value]) => {
                let behind: Vec<&Ir> = default.iter().chain([value]).collect();
                let key = self.operand(key, &[&[table][..], &behind].concat());
                let table = self.operand(table, &behind);
                // A default, as in `(incf (gethash k h 0))`, is passed over.
                default.iter().for_each(|default| self.effect(default));
                let value = self.operand(value, &[]);
                self.push(Op::SetTableRef(key, table, value));
                Some(value)
            }
            _ => None,
        }
    }

    /// Emits a loop that calls a function with each element of a list. In the body one variable stands for what that has
    /// given, and perhaps another for the element.
    fn each(&mut self, function: &Ir, list: &Ir, value: &Ir, body: &Ir, element: Option<&Ir>) {
        let kept = element.and_then(|element| self.rename(element));
        // The argument becomes what the function gives.
        let list = self.kept(list);
        let function = self.kept(function);
        let Some(argument) = self.rename(value) else { return };
        self.push(Op::NextElement(list, argument, 1));
        let exit = self.push(Op::Jump(0));
        let start = self.ops.len();
        if let Some(kept) = kept {
            self.push(Op::Move(kept, argument));
        }
        self.push(Op::CallValue(argument, function, 1));
        self.effect(body);
        let again = self.push(Op::NextElement(list, argument, 0));
        self.land_at(again, start);
        self.land(exit);
    }

    /// Gives a variable a fresh register from here on; none if it is no variable.
    fn rename(&mut self, variable: &Ir) -> Option<Reg> {
        let IrKind::Local(variable) = variable.kind else { return None };
        let register = self.fresh();
        self.place(variable, register);
        Some(register)
    }

    /// Emits the loop of a sort: the predicate is asked until all is in order.
    fn sort(&mut self, state: &Ir, predicate: &Ir) {
        // In a row: a question stands behind its function, and that behind the state.
        let state = self.kept(state);
        let function = self.kept(predicate);
        let question = self.fresh();
        self.fresh();
        let first = self.push(Op::Jump(0));
        let ask = self.push(Op::CallValue(question, function, 2));
        self.land(first);
        let step = self.push(Op::MergeStep(state, 0));
        self.land_at(step, ask);
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
