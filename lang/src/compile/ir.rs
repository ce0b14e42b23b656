//! Resolved forms: what expansion and resolution leave of the text, before registers.

use crate::code::{CodeKind, Missed, Parameters, Rule};
use crate::source::Span;
use crate::stack::deep;
use crate::symbol::Symbol;
use std::sync::Arc;

/// Number of a lexical variable in [`Variables`].
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

/// What a text was resolved to, before registers: what [`crate::check`] looks at.
#[derive(Clone, Debug, Default)]
pub struct Resolved {
    /// In the order of the text, loaded files in their place.
    pub(crate) definitions: Vec<Definition>,
    /// What runs, in order: forms, and the values of definitions.
    pub(crate) forms: Vec<Function>,
    /// Bodies of tests.
    pub(crate) tests: Vec<Function>,
    /// By number.
    pub(crate) variables: Vec<Variable>,
}

/// A definition of the text.
#[derive(Clone, Debug)]
pub(crate) struct Definition {
    pub(crate) name: Symbol,
    /// The whole form.
    pub(crate) span: Span,
    pub(crate) defined: Defined,
}

/// What a definition defines.
#[derive(Clone, Debug)]
pub(crate) enum Defined {
    /// A function or plan, and its global.
    Function(u32, Function),
    Macro(Function),
    /// A variable, constant, fluent or valve.
    Value,
    /// A class of failure, with a namespace of its own.
    Failure,
}

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
    Less,
    LessEq,
    NumEq,
    Eq,
    Cons,
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
}

#[derive(Clone, Debug)]
pub(crate) struct ChildIr {
    pub(crate) body: Function,
    pub(crate) tag: Option<VarId>,
    pub(crate) name: Option<Symbol>,
}

#[derive(Clone, Debug)]
pub(crate) struct ConstructIr {
    pub(crate) rule: Rule,
    pub(crate) name: Symbol,
    pub(crate) children: Vec<ChildIr>,
    pub(crate) order: Vec<(u16, u16)>,
    pub(crate) argument: Option<Box<Ir>>,
    pub(crate) with_priority: bool,
    pub(crate) active: bool,
}

/// The kinds of scope a body can run in, on its own task.
#[derive(Clone, Debug)]
pub(crate) enum ScopeIr {
    Valve(Box<Ir>),
    OnInterrupt(Box<Function>),
    OnResume(Box<Function>),
    Suspended(Box<Ir>),
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
