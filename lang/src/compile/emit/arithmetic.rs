//! Operations of two operands, and comparisons that decide a jump.

use super::emitter::Emitter;
use crate::code::{CodeKind, Op, Reg};
use crate::compile::ir::{Binary, Ir, IrKind};

impl Emitter<'_, '_> {
    /// Emits an operation; in tail position with an instruction before it that returns its value at once.
    pub(super) fn binary(&mut self, operation: Binary, left: &Ir, right: &Ir, into: Reg, tail: bool) {
        let immediate = |ir: &Ir| match ir.kind {
            IrKind::Int(value) => i16::try_from(value).ok().filter(|value| *value != i16::MIN),
            _ => None,
        };
        let sum = match (operation, immediate(left), immediate(right)) {
            (Binary::Add, _, Some(value)) => Some((left, value)),
            (Binary::Add, Some(value), _) => Some((right, value)),
            (Binary::Sub, _, Some(value)) => Some((left, -value)),
            _ => None,
        };
        if let Some((other, value)) = sum {
            let other = self.operand(other, &[]);
            if self.is_end(tail) {
                self.push(Op::ReturnAddInt(other, value));
            }
            self.push(Op::AddInt(into, other, value));
            return;
        }
        if self.with_product(operation, left, right, into) {
            return;
        }
        let (operation, left_reg, right_reg) = self.operands(operation, left, right);
        let returning = match operation {
            Binary::Add => Some(Op::ReturnAdd(left_reg, right_reg)),
            Binary::Sub => Some(Op::ReturnSub(left_reg, right_reg)),
            Binary::Mul => Some(Op::ReturnMul(left_reg, right_reg)),
            Binary::Less => Some(Op::ReturnLess(left_reg, right_reg)),
            Binary::LessEq => Some(Op::ReturnLessEq(left_reg, right_reg)),
            Binary::NumEq => Some(Op::ReturnNumEq(left_reg, right_reg)),
            _ => None,
        };
        if let Some(op) = returning.filter(|_| self.is_end(tail)) {
            self.push(op);
        }
        self.push(match operation {
            Binary::Add => Op::Add(into, left_reg, right_reg),
            Binary::Sub => Op::Sub(into, left_reg, right_reg),
            Binary::Mul => Op::Mul(into, left_reg, right_reg),
            Binary::Div => Op::Div(into, left_reg, right_reg),
            Binary::Less | Binary::Greater => Op::Less(into, left_reg, right_reg),
            Binary::LessEq | Binary::GreaterEq => Op::LessEq(into, left_reg, right_reg),
            Binary::NumEq => Op::NumEq(into, left_reg, right_reg),
            Binary::NumDiffer => Op::NumDiffer(into, left_reg, right_reg),
            Binary::Eq => Op::Eq(into, left_reg, right_reg),
            Binary::Cons => Op::Cons(into, left_reg, right_reg),
        });
    }

    /// Evaluates both operands in their order; gives the operation and the registers of its operands.
    fn operands(&mut self, operation: Binary, left: &Ir, right: &Ir) -> (Binary, Reg, Reg) {
        let left_reg = self.operand(left, &[right]);
        let right_reg = self.operand(right, &[]);
        match operation {
            Binary::Greater | Binary::GreaterEq => (operation.mirrored(), right_reg, left_reg),
            _ => (operation, left_reg, right_reg),
        }
    }

    /// Emits a sum or difference with a product, if it is one; tells so. In networks it would not be plain.
    fn with_product(&mut self, operation: Binary, left: &Ir, right: &Ir, into: Reg) -> bool {
        if self.kind == CodeKind::Network {
            return false;
        }
        let is_sum = match operation {
            Binary::Add => true,
            Binary::Sub => false,
            _ => return false,
        };
        let (other, product) = match (&left.kind, &right.kind) {
            (_, IrKind::Binary(Binary::Mul, ..)) => (self.operand(left, &[right]), right),
            // What stands in a register is read behind the product.
            (IrKind::Binary(Binary::Mul, ..), _) if is_sum => match self.own_register(right, [].into_iter()) {
                Some(other) => (other, left),
                None => return false,
            },
            _ => return false,
        };
        let IrKind::Binary(_, x, y) = &product.kind else { return false };
        let (x, y) = (self.operand(x, &[y]), self.operand(y, &[]));
        self.push(if is_sum { Op::AddProduct(into, other, x, y) } else { Op::SubProduct(into, other, x, y) });
        let value = self.fresh();
        let outer = std::mem::replace(&mut self.span, product.span);
        self.push(Op::Mul(value, x, y));
        self.span = outer;
        self.push(if is_sum { Op::Add(into, other, value) } else { Op::Sub(into, other, value) });
        true
    }

    /// Emits a jump that is taken where a comparison does not hold; or where it `holds`, if it is of order: there is none
    /// for the opposite of equality.
    pub(super) fn compare_and_jump(&mut self, holds: bool, operation: Binary, left: &Ir, right: &Ir) -> usize {
        let immediate = |ir: &Ir| match ir.kind {
            IrKind::Int(value) if operation != Binary::Eq => i16::try_from(value).ok(),
            _ => None,
        };
        let (number, value, operation) = match (immediate(left), immediate(right)) {
            (_, Some(value)) => (left, value, operation),
            (Some(value), None) => (right, value, operation.mirrored()),
            (None, None) => return self.compare_registers_and_jump(holds, operation, left, right),
        };
        let number = self.operand(number, &[]);
        self.push(match (operation, holds) {
            (Binary::Less, false) => Op::JumpUnlessLessInt(number, value, 0),
            (Binary::Less, true) => Op::JumpIfLessInt(number, value, 0),
            (Binary::LessEq, false) => Op::JumpUnlessLessEqInt(number, value, 0),
            (Binary::LessEq, true) => Op::JumpIfLessEqInt(number, value, 0),
            (Binary::Greater, false) => Op::JumpUnlessGreaterInt(number, value, 0),
            (Binary::Greater, true) => Op::JumpIfGreaterInt(number, value, 0),
            (Binary::GreaterEq, false) => Op::JumpUnlessGreaterEqInt(number, value, 0),
            (Binary::GreaterEq, true) => Op::JumpIfGreaterEqInt(number, value, 0),
            (Binary::NumDiffer, _) => Op::JumpUnlessNumDifferInt(number, value, 0),
            _ => Op::JumpUnlessNumEqInt(number, value, 0),
        })
    }

    fn compare_registers_and_jump(&mut self, holds: bool, operation: Binary, left: &Ir, right: &Ir) -> usize {
        let (operation, left_reg, right_reg) = self.operands(operation, left, right);
        self.push(match (operation, holds) {
            (Binary::Less, false) => Op::JumpUnlessLess(left_reg, right_reg, 0),
            (Binary::Less, true) => Op::JumpIfLess(left_reg, right_reg, 0),
            (Binary::LessEq, true) => Op::JumpIfLessEq(left_reg, right_reg, 0),
            (Binary::LessEq, false) => Op::JumpUnlessLessEq(left_reg, right_reg, 0),
            (Binary::NumDiffer, _) => Op::JumpUnlessNumDiffer(left_reg, right_reg, 0),
            (Binary::Eq, _) => Op::JumpUnlessEq(left_reg, right_reg, 0),
            _ => Op::JumpUnlessNumEq(left_reg, right_reg, 0),
        })
    }
}
