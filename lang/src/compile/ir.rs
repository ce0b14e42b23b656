//! Resolved forms: what expansion and resolution leave of the text, before registers.

use crate::code::{CodeKind, Missed, Parameters, Quorum, Successes};
use crate::source::Span;
use crate::stack::deep;
use crate::symbol::Symbol;
use std::sync::Arc;

/// Number of a lexical variable among the compiler's `variables`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct VarId(pub(crate) u32);

/// A lexical variable.
#[derive(Clone, Debug)]
pub(crate) struct Variable {
    pub(crate) name: Symbol,
    /// Where it is bound.
    pub(crate) span: Span,
    /// Depth of the function that binds it.
    pub(crate) function: usize,
    /// Whether an inner function refers to it.
    pub(crate) captured: bool,
    /// Whether it is assigned after its binding.
    pub(crate) assigned: bool,
}

impl Variable {
    /// Closures copy what they capture, so a captured variable that changes lives in a cell.
    pub(crate) fn in_cell(&self) -> bool {
        self.captured && self.assigned
    }
}

/// Number of a block, unique in one compilation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct BlockId(pub(crate) u32);

/// A resolved form and its place.
#[derive(Clone, Debug)]
pub(crate) struct Ir {
    pub(crate) span: Span,
    pub(crate) kind: IrKind,
}

/// Forms nest deeper than a stack is.
impl Drop for Ir {
    fn drop(&mut self) {
        deep(|| drop(std::mem::replace(&mut self.kind, IrKind::Nil)));
    }
}

/// Two-operand operations with an instruction of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Less,
    LessEq,
    Greater,
    GreaterEq,
    NumEq,
    NumDiffer,
    Eq,
    Cons,
}

impl Binary {
    /// Whether it is a test, which gives `t` or nil.
    pub(crate) fn is_test(self) -> bool {
        match self {
            Self::Less | Self::LessEq | Self::Greater | Self::GreaterEq | Self::NumEq | Self::NumDiffer | Self::Eq => {
                true
            }
            Self::Add | Self::Sub | Self::Mul | Self::Div | Self::Cons => false,
        }
    }

    /// Whether it tells how numbers are ordered.
    pub(crate) fn is_order(self) -> bool {
        matches!(self, Self::Less | Self::LessEq | Self::Greater | Self::GreaterEq)
    }

    /// The operation that is the same with its operands exchanged, if it is a comparison.
    pub(crate) fn mirrored(self) -> Self {
        match self {
            Self::Less => Self::Greater,
            Self::LessEq => Self::GreaterEq,
            Self::Greater => Self::Less,
            Self::GreaterEq => Self::LessEq,
            other => other,
        }
    }
}

/// One-operand operations with an instruction of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unary {
    Not,
    Car,
    Cdr,
    /// The value of a fluent, in fluent position.
    Deref,
}

/// What is called.
#[derive(Clone, Debug)]
pub(crate) enum Callee {
    Global(u32),
    Native(u16),
    Value(Box<Ir>),
}

/// A function body with its parameters.
#[derive(Clone, Debug)]
pub(crate) struct Function {
    pub(crate) name: Symbol,
    pub(crate) kind: CodeKind,
    pub(crate) parameters: Parameters,
    /// Variables of the parameters in register order; optional and key parameters with their
    /// default and, if asked for, a variable that says whether they were given.
    pub(crate) bindings: Vec<ParameterBinding>,
    pub(crate) captures: Vec<VarId>,
    pub(crate) tags: Vec<(Symbol, VarId)>,
    pub(crate) body: Box<Ir>,
    pub(crate) doc: Option<Arc<str>>,
    pub(crate) span: Span,
}

#[derive(Clone, Debug)]
pub(crate) struct ParameterBinding {
    pub(crate) variable: VarId,
    pub(crate) default: Option<Ir>,
    pub(crate) given: Option<VarId>,
    /// Whether the caller may leave it out.
    pub(crate) omissible: bool,
    /// What is bound to the parts of the parameter, in order, if it is a list that is taken apart.
    pub(crate) parts: Vec<(VarId, Ir)>,
}

impl ParameterBinding {
    /// The forms that are evaluated when the function is entered.
    pub(crate) fn evaluated(&self) -> impl Iterator<Item = &Ir> {
        self.default.iter().chain(self.parts.iter().map(|(_, value)| value))
    }
}

#[derive(Clone, Debug)]
pub(crate) struct ChildIr {
    pub(crate) body: Function,
    pub(crate) tag: Option<VarId>,
    pub(crate) name: Option<Symbol>,
}

/// What a construct is told when it starts.
#[derive(Clone, Debug)]
pub(crate) enum ArgumentIr {
    Priority(Box<Ir>),
    Deadline { seconds: Box<Ir>, active: bool },
    Quorum { successes: Box<Ir>, failures: Box<Ir> },
    Most(Box<Ir>),
}

#[derive(Clone, Debug)]
pub(crate) struct ConstructIr {
    pub(crate) quorum: Quorum,
    pub(crate) name: Symbol,
    pub(crate) children: Vec<ChildIr>,
    pub(crate) order: Vec<(u16, u16)>,
    pub(crate) argument: Option<ArgumentIr>,
}

impl ConstructIr {
    /// The forms that are evaluated before it starts.
    pub(crate) fn evaluated(&self) -> impl Iterator<Item = &Ir> {
        let (first, second) = match &self.argument {
            Some(
                ArgumentIr::Priority(value) | ArgumentIr::Deadline { seconds: value, .. } | ArgumentIr::Most(value),
            ) => (Some(value), None),
            Some(ArgumentIr::Quorum { successes, failures }) => (Some(successes), Some(failures)),
            None => (None, None),
        };
        first.into_iter().chain(second).map(|value| &**value)
    }

    /// Its policy, if it has one.
    pub(crate) fn policy(&self) -> Option<&ChildIr> {
        match (self.quorum.successes, self.children.as_slice()) {
            (Successes::Last, [policy, _]) => Some(policy),
            _ => None,
        }
    }

    /// Whether its one child is all there is to it.
    pub(crate) fn is_single(&self) -> bool {
        self.quorum.successes == Successes::Last && self.children.len() == 1
    }
}

/// The kinds of scope a body can run in, on its own task.
#[derive(Clone, Debug)]
pub(crate) enum ScopeIr {
    /// `seconds` is how long to wait for it at most.
    Valve {
        valve: Box<Ir>,
        seconds: Option<Box<Ir>>,
    },
    OnInterrupt(Box<Function>),
    OnResume(Box<Function>),
    Suspended(Box<Ir>),
    Fence,
}

#[derive(Clone, Debug)]
pub(crate) struct ClauseIr {
    pub(crate) span: Span,
    pub(crate) classes: Vec<Symbol>,
    pub(crate) body: Ir,
}

#[derive(Clone, Debug)]
pub(crate) enum IrKind {
    Nil,
    True,
    Int(i64),
    Const(u32),
    Local(VarId),
    Global(u32),
    SetLocal(VarId, Box<Ir>),
    SetGlobal(u32, Box<Ir>),
    DefFluent(u32, Box<Ir>),
    If(Box<Ir>, Box<Ir>, Box<Ir>),
    And(Vec<Ir>),
    Or(Vec<Ir>),
    Seq(Vec<Ir>),
    Let(Vec<(VarId, Ir)>, Box<Ir>),
    Lambda(Box<Function>),
    Call(Callee, Vec<Ir>),
    Binary(Binary, Box<Ir>, Box<Ir>),
    Unary(Unary, Box<Ir>),
    /// `token` is set if the block is left from inside a closure.
    Block {
        id: BlockId,
        token: Option<VarId>,
        body: Box<Ir>,
    },
    Leave(BlockId, Box<Ir>),
    LeaveDynamic(VarId, Box<Ir>),
    Loop(Box<Ir>),
    Construct(Box<ConstructIr>),
    ConstructMap(Box<ConstructIr>, Box<Ir>),
    Spawn(Box<ConstructIr>),
    Handler {
        body: Box<Ir>,
        failure: VarId,
        clauses: Vec<ClauseIr>,
    },
    Refail(VarId),
    Cleanup {
        always: bool,
        body: Box<Ir>,
        cleanup: Box<Ir>,
    },
    Scope(ScopeIr, Box<Ir>),
    Network(Box<Function>),
    WaitFor {
        fluent: Box<Ir>,
        timeout: Option<Box<Ir>>,
        owned: bool,
    },
    Whenever {
        fluent: Box<Ir>,
        missed: Missed,
        owned: bool,
        body: Box<Ir>,
    },
}
