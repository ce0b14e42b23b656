//! Branches, loops, and blocks that are left.

use super::emitter::{BlockState, Emitter};
use super::value_facts::{add_literals, has_no_code, is_cheap_test, is_test};
use crate::code::{CodeKind, NO_REG, Op, Reg};
use crate::compile::ir::{Binary, BlockId, Ir, IrKind, Unary, VarId};
use crate::stack::deep;

/// Conditions that nest no deeper than this may be emitted twice.
const MOST_REPEATED: usize = 5;

/// The most constants that have registers while a function is in a loop.
const MOST_LITERALS: usize = 8;

impl Emitter<'_, '_> {
    /// Emits a jump that is taken when the condition is nil; gives the jumps to land.
    pub(super) fn jump_unless(&mut self, condition: &Ir) -> Vec<usize> {
        let outer = std::mem::replace(&mut self.span, condition.span);
        let jumps = deep(|| self.temporarily(|emitter| emitter.jump_unless_here(condition)));
        self.span = outer;
        jumps
    }

    fn jump_unless_here(&mut self, condition: &Ir) -> Vec<usize> {
        match &condition.kind {
            IrKind::And(items) => items.iter().flat_map(|item| self.jump_unless(item)).collect(),
            IrKind::Unary(Unary::Not, inner) => {
                let reg = self.operand(inner, &[]);
                vec![self.push(Op::JumpIfTrue(reg, 0))]
            }
            // In networks sameness is what a plain one can do.
            IrKind::Binary(Binary::Eq, ..) if self.kind == CodeKind::Network => {
                let reg = self.operand(condition, &[]);
                vec![self.push(Op::JumpIfNil(reg, 0))]
            }
            IrKind::Binary(operation, left, right) if operation.is_test() => {
                vec![self.compare_and_jump(false, *operation, left, right)]
            }
            _ => {
                let reg = self.operand(condition, &[]);
                vec![self.push(Op::JumpIfNil(reg, 0))]
            }
        }
    }

    pub(super) fn conditional(&mut self, condition: &Ir, then: &Ir, otherwise: &Ir, into: Reg, tail: bool) {
        let skips = self.jump_unless(condition);
        if tail {
            self.returned(then, into);
            for skip in skips {
                self.land(skip);
            }
            self.value(otherwise, into, true);
            return;
        }
        self.value(then, into, false);
        let exit = self.push(Op::Jump(0));
        for skip in skips {
            self.land(skip);
        }
        self.value(otherwise, into, false);
        self.land(exit);
    }

    /// Emits a form whose value ends the function.
    fn returned(&mut self, ir: &Ir, into: Reg) {
        let mut from = into;
        match ir.kind {
            IrKind::Local(variable) if !self.compiler.variables[variable.0 as usize].in_cell() => {
                from = self.registers.get(&variable).copied().unwrap_or(NO_REG);
            }
            _ => self.value(ir, into, true),
        }
        self.push(Op::Return(from));
    }

    /// Emits an endless loop. What leaves it at a condition stands behind it, out of the way. A condition at its
    /// beginning that takes little stands at its end as well: the jump back is the test.
    pub(super) fn loop_form(&mut self, body: &Ir) {
        let items = match &body.kind {
            IrKind::Seq(items) => items.as_slice(),
            _ => std::slice::from_ref(body),
        };
        let outer = self.literals.clone();
        self.load_literals(items);
        let (mut exits, mut again) = (Vec::new(), None);
        let start = self.ops.len();
        for (position, item) in items.iter().enumerate() {
            let IrKind::If(condition, then, otherwise) = &item.kind else {
                self.effect(item);
                continue;
            };
            if !has_no_code(then) || !matches!(otherwise.kind, IrKind::Leave(..)) {
                self.effect(item);
                continue;
            }
            exits.push((self.jump_unless(condition), otherwise));
            if position == 0 && is_cheap_test(condition, MOST_REPEATED) {
                again = Some((condition, self.ops.len()));
            }
        }
        match (again, exits.first_mut()) {
            (Some((condition, entered)), Some((skips, _))) => skips.extend(self.jump_back_if(condition, entered)),
            _ => self.jump_back(start),
        }
        for (skips, leave) in exits {
            for skip in skips {
                self.land(skip);
            }
            self.effect(leave);
        }
        self.literals = outer;
    }

    /// Loads constants before a loop in which they are operands.
    fn load_literals(&mut self, body: &[Ir]) {
        let mut literals = Vec::new();
        body.iter().for_each(|item| add_literals(item, &mut literals));
        for literal in literals {
            if self.literals.len() == MOST_LITERALS {
                break;
            }
            if !self.literals.contains_key(&literal) {
                let register = self.fresh();
                self.literal(literal, register);
                self.literals.insert(literal, register);
            }
        }
    }

    /// Emits a jump back that is taken when the condition is not nil; gives the jumps to land that are taken when it is.
    fn jump_back_if(&mut self, condition: &Ir, target: usize) -> Vec<usize> {
        let outer = std::mem::replace(&mut self.span, condition.span);
        let skips = self.temporarily(|emitter| emitter.jump_back_if_here(condition, target));
        self.span = outer;
        skips
    }

    fn jump_back_if_here(&mut self, condition: &Ir, target: usize) -> Vec<usize> {
        let (mut skips, mut last) = (Vec::new(), condition);
        while let IrKind::And(items) = &last.kind {
            let Some((end, before)) = items.split_last() else { break };
            skips.extend(before.iter().flat_map(|item| self.jump_unless(item)).collect::<Vec<usize>>());
            last = end;
        }
        let jump = match &last.kind {
            IrKind::Unary(Unary::Not, inner) => {
                let reg = self.operand(inner, &[]);
                self.push(Op::JumpIfNil(reg, 0))
            }
            IrKind::Binary(operation, left, right) if operation.is_order() => {
                self.compare_and_jump(true, *operation, left, right)
            }
            _ => {
                let reg = self.operand(last, &[]);
                self.push(Op::JumpIfTrue(reg, 0))
            }
        };
        self.land_at(jump, target);
        skips
    }

    /// Emits a form whose value is that of its last item, or nil. At the end of a function tests need no value for that.
    pub(super) fn and(&mut self, items: &[Ir], into: Reg, tail: bool) {
        let Some((last, before)) = items.split_last() else { return };
        if self.is_end(tail) && before.iter().any(is_test) {
            let skips: Vec<usize> = before.iter().flat_map(|item| self.jump_unless(item)).collect();
            self.returned(last, into);
            skips.into_iter().for_each(|skip| self.land(skip));
            self.push(Op::Nil(into));
            return;
        }
        let mut exits = Vec::new();
        for item in before {
            self.value(item, into, false);
            exits.push(self.push(Op::JumpIfNil(into, 0)));
        }
        self.value(last, into, tail);
        exits.into_iter().for_each(|exit| self.land(exit));
    }

    /// The same for the value of its first item that is not nil.
    pub(super) fn or(&mut self, items: &[Ir], into: Reg, tail: bool) {
        let Some((last, before)) = items.split_last() else { return };
        let mut exits = Vec::new();
        for item in before {
            if self.is_end(tail) && is_test(item) {
                let skips = self.jump_unless(item);
                self.push(Op::True(into));
                self.push(Op::Return(into));
                skips.into_iter().for_each(|skip| self.land(skip));
            } else {
                self.value(item, into, false);
                exits.push(self.push(Op::JumpIfTrue(into, 0)));
            }
        }
        self.value(last, into, tail);
        exits.into_iter().for_each(|exit| self.land(exit));
    }

    /// Whether a form in tail position can return by itself: networks stay as plain as they are.
    pub(super) fn is_end(&self, tail: bool) -> bool {
        tail && self.kind != CodeKind::Network
    }

    pub(super) fn block(&mut self, id: BlockId, token: Option<VarId>, body: &Ir, into: Reg) {
        // Jumps out of the block carry their value in a register of its own: `into` may be read
        // by the body.
        let result = self.fresh();
        let dynamic = token.map(|token| {
            let identity = self.fresh();
            self.registers.insert(token, identity);
            self.push(Op::PushBlock(identity, result, 0))
        });
        self.blocks.push(BlockState { id, result, scopes: self.scopes, exits: Vec::new() });
        self.scopes += usize::from(dynamic.is_some());
        self.value(body, result, false);
        if let Some(push) = dynamic {
            self.push(Op::PopScopes(1));
            self.scopes -= 1;
            self.land(push);
        }
        if let Some(block) = self.blocks.pop() {
            for exit in block.exits {
                self.land(exit);
            }
        }
        self.take(result, into);
    }

    pub(super) fn leave(&mut self, id: BlockId, value: &Ir) {
        let Some(block) = self.blocks.iter().rposition(|block| block.id == id) else { return };
        let (result, scopes) = (self.blocks[block].result, self.blocks[block].scopes);
        self.value(value, result, false);
        let open = self.scopes - scopes;
        let exit = if open == 0 { self.push(Op::Jump(0)) } else { self.push(Op::LeaveScopes(open.min(255) as u8, 0)) };
        self.blocks[block].exits.push(exit);
    }
}
