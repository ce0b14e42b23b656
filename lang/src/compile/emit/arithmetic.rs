//! Operations of two operands, and comparisons that decide a jump.

use super::emitter::Emitter;
use crate::code::{Op, Reg};
use crate::compile::ir::{Binary, Ir, IrKind};

impl Emitter<'_, '_> {
    pub(super) fn binary(&mut self, operation: Binary, left: &Ir, right: &Ir, into: Reg) {
        let immediate = |ir: &Ir| match ir.kind {
            IrKind::Int(value) => i16::try_from(value).ok().filter(|value| *value != i16::MIN),
            _ => None,
        };
        match (operation, immediate(left), immediate(right)) {
            (Binary::Add, _, Some(value)) => {
                let left = self.operand(left, &[]);
                self.push(Op::AddInt(into, left, value));
                return;
            }
            (Binary::Add, Some(value), _) => {
                let right = self.operand(right, &[]);
                self.push(Op::AddInt(into, right, value));
                return;
            }
            (Binary::Sub, _, Some(value)) => {
                let left = self.operand(left, &[]);
                self.push(Op::AddInt(into, left, -value));
                return;
            }
            _ => {}
        }
        let left_reg = self.operand(left, &[right]);
        let right_reg = self.operand(right, &[]);
        self.push(match operation {
            Binary::Add => Op::Add(into, left_reg, right_reg),
            Binary::Sub => Op::Sub(into, left_reg, right_reg),
            Binary::Mul => Op::Mul(into, left_reg, right_reg),
            Binary::Div => Op::Div(into, left_reg, right_reg),
            Binary::Less => Op::Less(into, left_reg, right_reg),
            Binary::LessEq => Op::LessEq(into, left_reg, right_reg),
            Binary::NumEq => Op::NumEq(into, left_reg, right_reg),
            Binary::NumDiffer => Op::NumDiffer(into, left_reg, right_reg),
            Binary::Eq => Op::Eq(into, left_reg, right_reg),
            Binary::Cons => Op::Cons(into, left_reg, right_reg),
        });
    }

    pub(super) fn compare_and_jump(&mut self, operation: Binary, left: &Ir, right: &Ir) -> usize {
        let immediate = |ir: &Ir| match ir.kind {
            IrKind::Int(value) => i16::try_from(value).ok(),
            _ => None,
        };
        if let Some(value) = immediate(right) {
            let left = self.operand(left, &[]);
            return self.push(match operation {
                Binary::Less => Op::JumpUnlessLessInt(left, value, 0),
                Binary::LessEq => Op::JumpUnlessLessEqInt(left, value, 0),
                Binary::NumDiffer => Op::JumpUnlessNumDifferInt(left, value, 0),
                _ => Op::JumpUnlessNumEqInt(left, value, 0),
            });
        }
        if let Some(value) = immediate(left) {
            let right = self.operand(right, &[]);
            return self.push(match operation {
                Binary::Less => Op::JumpUnlessGreaterInt(right, value, 0),
                Binary::LessEq => Op::JumpUnlessGreaterEqInt(right, value, 0),
                Binary::NumDiffer => Op::JumpUnlessNumDifferInt(right, value, 0),
                _ => Op::JumpUnlessNumEqInt(right, value, 0),
            });
        }
        let left_reg = self.operand(left, &[right]);
        let right_reg = self.operand(right, &[]);
        self.push(match operation {
            Binary::Less => Op::JumpUnlessLess(left_reg, right_reg, 0),
            Binary::LessEq => Op::JumpUnlessLessEq(left_reg, right_reg, 0),
            Binary::NumDiffer => Op::JumpUnlessNumDiffer(left_reg, right_reg, 0),
            _ => Op::JumpUnlessNumEq(left_reg, right_reg, 0),
        })
    }
}
