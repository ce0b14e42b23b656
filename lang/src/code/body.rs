//! A compiled body.

use super::{Atom, Constant, Construct, Op, Parameters, Reg};
use crate::source::Span;
use crate::symbol::Symbol;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What kind of body a code is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CodeKind {
    /// A function or closure.
    Function,
    /// A plan: its calls are nodes of the task tree.
    Plan,
    /// The body of a task.
    Task,
    /// The expression of a network.
    Network,
}

/// A variable of the text and where it is found while code runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Local {
    /// Its name in the text.
    pub name: Symbol,
    /// Its register, or that of the cell that holds it.
    pub register: Reg,
    /// The first instruction at which it has its value.
    pub from: u32,
    /// One past the last instruction of its scope.
    pub to: u32,
}

/// What a function does that reads or assigns a slot of a record, and nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SlotAccess {
    /// The kind of record.
    pub kind: Symbol,
    /// The place of the slot, counted behind the kind from 1.
    pub place: u8,
    /// Whether its second argument is assigned to the slot.
    pub assigns: bool,
}

impl SlotAccess {
    /// Of a body with these constants, if it does nothing else.
    pub(crate) fn of(ops: &[Op], constants: &[Constant]) -> Option<Self> {
        let (place, kind, assigns) = match *ops {
            [Op::Slot(to, 0, place, kind), Op::Return(from)] if to == from => (place, kind, false),
            [Op::SetSlot(0, 1, place, kind), Op::Return(1)] => (place, kind, true),
            [Op::SetSlot(0, 1, place, kind), Op::Move(to, 1), Op::Return(from)] if to == from => (place, kind, true),
            _ => return None,
        };
        match constants.get(kind as usize) {
            Some(&Constant::Atom(Atom::Symbol(kind))) => Some(Self { kind, place, assigns }),
            _ => None,
        }
    }
}

/// A compiled body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Code {
    /// The name it has in the text, or what it is.
    pub name: Symbol,
    /// What kind of body it is.
    pub kind: CodeKind,
    /// Its parameters.
    pub parameters: Parameters,
    /// The frame's size, parameters and captured values included.
    pub registers: u8,
    /// A call with this many arguments needs nothing checked or arranged; [`ARRANGES`](super::ARRANGES) if none does.
    pub exact_count: u16,
    /// The same for a call by name, in which a slot is read or assigned at once, without a frame.
    pub framed_count: u16,
    /// The slot of a record that it reads or assigns, if it does nothing else.
    pub slot: Option<SlotAccess>,
    /// Whether it is a network that only reads, adds and compares, with few registers and no way back.
    pub is_plain: bool,
    /// Registers of the frame that makes the closure, in the order of the captured values.
    pub captures: Vec<Reg>,
    /// The instructions.
    pub ops: Vec<Op>,
    /// The place of each instruction.
    pub spans: Vec<Span>,
    /// Constructs that [`Op::Parallel`], [`Op::ParallelMap`] and [`Op::Spawn`] name.
    pub constructs: Vec<Construct>,
    /// Classes of failure that [`Op::PushHandler`] names, one list of classes a clause.
    pub handlers: Vec<Vec<Vec<Symbol>>>,
    /// Variables, in the order of their binding.
    pub locals: Vec<Local>,
    /// Documentation string.
    pub doc: Option<Arc<str>>,
    /// The whole definition.
    pub span: Span,
}

/// Registers of a network that is plain, at most.
pub const PLAIN_REGISTERS: usize = 16;

/// Whether instructions only read, add and compare, and never go back.
pub(crate) fn are_plain(ops: &[Op]) -> bool {
    ops.iter().all(|op| match *op {
        Op::Jump(distance) | Op::JumpIfNil(_, distance) | Op::JumpIfTrue(_, distance) => distance >= 0,
        _ => matches!(
            op,
            Op::Nil(_)
                | Op::True(_)
                | Op::Int(..)
                | Op::Const(..)
                | Op::Global(..)
                | Op::Move(..)
                | Op::CellGet(..)
                | Op::Deref(..)
                | Op::Add(..)
                | Op::Sub(..)
                | Op::Mul(..)
                | Op::AddInt(..)
                | Op::Less(..)
                | Op::LessEq(..)
                | Op::NumEq(..)
                | Op::NumDiffer(..)
                | Op::Eq(..)
                | Op::Not(..)
                | Op::Return(_)
        ),
    })
}

/// What an allocator adds to the tables of a code.
const BLOCKS_OF_CODE: usize = 160;

impl Code {
    /// Bytes it takes.
    pub fn bytes(&self) -> usize {
        let children = self.constructs.iter().map(|construct| size_of_val(construct.children.as_slice()));
        size_of::<Self>()
            + BLOCKS_OF_CODE
            + size_of_val(self.captures.as_slice())
            + size_of_val(self.ops.as_slice())
            + size_of_val(self.spans.as_slice())
            + size_of_val(self.locals.as_slice())
            + self.constructs.len() * size_of::<Construct>()
            + children.sum::<usize>()
            + self.handlers.len() * size_of::<Vec<Vec<Symbol>>>()
    }

    /// What stands in a place that was given back.
    pub(super) fn none(code: &Code) -> Self {
        let (name, span) = (code.name, code.span);
        Self {
            name,
            kind: CodeKind::Function,
            parameters: Parameters::default(),
            registers: 1,
            exact_count: 0,
            framed_count: 0,
            slot: None,
            is_plain: false,
            captures: Vec::new(),
            ops: vec![Op::Return(0)],
            spans: vec![span],
            constructs: Vec::new(),
            handlers: Vec::new(),
            locals: Vec::new(),
            doc: None,
            span,
        }
    }
}
