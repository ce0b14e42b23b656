//! A function on its way to code: its registers, which are given out like a stack, its instructions and jumps.

use super::value_facts::Literal;
use crate::code::{CodeKind, Construct, Local, Op, Reg};
use crate::compile::compiler::Compiler;
use crate::compile::ir::{BlockId, VarId};
use crate::source::Span;
use crate::symbol::Symbol;
use std::collections::BTreeMap;

/// Registers a function can have; two are kept free for calls at the edge of the window.
pub(super) const MAX_REGISTERS: usize = 250;

pub(super) struct BlockState {
    pub(super) id: BlockId,
    pub(super) result: Reg,
    pub(super) scopes: usize,
    /// Jumps to the block's end that wait for its place.
    pub(super) exits: Vec<usize>,
}

pub(super) struct Emitter<'c, 'a> {
    pub(super) compiler: &'c mut Compiler<'a>,
    pub(super) ops: Vec<Op>,
    pub(super) spans: Vec<Span>,
    pub(super) span: Span,
    pub(super) registers: BTreeMap<VarId, Reg>,
    pub(super) next: usize,
    pub(super) most: usize,
    pub(super) blocks: Vec<BlockState>,
    /// Scopes this function has open at this place.
    pub(super) scopes: usize,
    pub(super) constructs: Vec<Construct>,
    pub(super) handlers: Vec<Vec<Vec<Symbol>>>,
    pub(super) locals: Vec<Local>,
    /// Those that are there at this place, by their positions.
    pub(super) open_locals: Vec<usize>,
    pub(super) kind: CodeKind,
    /// Registers that hold numbers of the text, in the loops where they are operands.
    pub(super) literals: BTreeMap<Literal, Reg>,
}

impl Emitter<'_, '_> {
    /// Gives a variable its register. Its value is there from the next instruction on.
    pub(super) fn place(&mut self, variable: VarId, register: Reg) {
        self.registers.insert(variable, register);
        let name = self.compiler.variables[variable.0 as usize].name;
        // What macros bind for themselves is no variable of the text.
        if !self.compiler.symbols.name(name).starts_with(['%', '#']) {
            self.open_locals.push(self.locals.len());
            self.locals.push(Local { name, register, from: self.ops.len() as u32, to: u32::MAX });
        }
    }

    pub(super) fn put_in_cell(&mut self, variable: VarId, reg: Reg) {
        if self.compiler.variables[variable.0 as usize].in_cell() {
            self.push(Op::CellNew(reg, reg));
        }
    }

    pub(super) fn push(&mut self, op: Op) -> usize {
        self.ops.push(op);
        self.spans.push(self.span);
        self.ops.len() - 1
    }

    pub(super) fn fresh(&mut self) -> Reg {
        let reg = self.next;
        self.next += 1;
        self.most = self.most.max(self.next + 1);
        reg.min(MAX_REGISTERS) as Reg
    }

    /// Runs `inside` and gives its temporaries back.
    pub(super) fn temporarily<T>(&mut self, inside: impl FnOnce(&mut Self) -> T) -> T {
        let before = self.next;
        let result = inside(self);
        self.next = before;
        self.registers.retain(|_, register| usize::from(*register) < before);
        let end = self.ops.len() as u32;
        let locals = &mut self.locals;
        self.open_locals.retain(|&at| {
            let stays = usize::from(locals[at].register) < before;
            if !stays {
                locals[at].to = end;
            }
            stays
        });
        result
    }

    /// Points the jump at this index to the next instruction.
    pub(super) fn land(&mut self, jump: usize) {
        let distance = (self.ops.len() - jump - 1) as i32;
        self.set_distance(jump, distance);
    }

    fn set_distance(&mut self, jump: usize, distance: i32) {
        match &mut self.ops[jump] {
            Op::Jump(to)
            | Op::JumpIfNil(_, to)
            | Op::JumpIfTrue(_, to)
            | Op::JumpIfGiven(_, to)
            | Op::JumpUnlessLess(_, _, to)
            | Op::JumpUnlessLessEq(_, _, to)
            | Op::JumpUnlessNumEq(_, _, to)
            | Op::JumpUnlessNumDiffer(_, _, to)
            | Op::JumpUnlessEq(_, _, to)
            | Op::JumpUnlessLessInt(_, _, to)
            | Op::JumpUnlessLessEqInt(_, _, to)
            | Op::JumpUnlessGreaterInt(_, _, to)
            | Op::JumpUnlessGreaterEqInt(_, _, to)
            | Op::JumpUnlessNumEqInt(_, _, to)
            | Op::JumpUnlessNumDifferInt(_, _, to)
            | Op::JumpIfLess(_, _, to)
            | Op::JumpIfLessEq(_, _, to)
            | Op::JumpIfLessInt(_, _, to)
            | Op::JumpIfLessEqInt(_, _, to)
            | Op::JumpIfGreaterInt(_, _, to)
            | Op::JumpIfGreaterEqInt(_, _, to)
            | Op::NextElement(_, _, to)
            | Op::MergeStep(_, to)
            | Op::PushBlock(_, _, to)
            | Op::PushHandler(_, _, to)
            | Op::PushCleanup(to)
            | Op::LeaveScopes(_, to) => *to = distance,
            other => unreachable!("{other:?} is no jump"),
        }
    }

    pub(super) fn jump_back(&mut self, target: usize) {
        let jump = self.push(Op::Jump(0));
        self.land_at(jump, target);
    }

    /// Points the jump at this index to an instruction that is there already.
    pub(super) fn land_at(&mut self, jump: usize, target: usize) {
        self.set_distance(jump, target as i32 - jump as i32 - 1);
    }

    pub(super) fn take(&mut self, from: Reg, into: Reg) {
        if from != into {
            self.push(Op::Move(into, from));
        }
    }
}
