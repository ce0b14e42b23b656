//! What can be seen of a form without running it.

use crate::compile::ir::{Binary, Callee, Ir, IrKind, Unary};
use crate::stack::deep;

/// Whether emitting the form writes its target only with its last instruction.
pub(super) fn writes_once(ir: &Ir) -> bool {
    matches!(
        ir.kind,
        IrKind::Nil
            | IrKind::True
            | IrKind::Int(_)
            | IrKind::Const(_)
            | IrKind::Local(_)
            | IrKind::Global(_)
            | IrKind::Binary(..)
            | IrKind::Unary(..)
            | IrKind::Lambda(_)
            | IrKind::Call(..)
    )
}

/// Whether the form has nothing to run when nobody wants its value.
pub(super) fn has_no_code(ir: &Ir) -> bool {
    matches!(ir.kind, IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_) | IrKind::Local(_))
}

/// Whether evaluating the form can change no variable.
pub(super) fn has_no_effect(ir: &Ir) -> bool {
    deep(|| match &ir.kind {
        IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_) | IrKind::Local(_) | IrKind::Global(_) => true,
        IrKind::Binary(_, left, right) => has_no_effect(left) && has_no_effect(right),
        IrKind::Unary(_, operand) => has_no_effect(operand),
        // A call cannot assign a variable that lives in a register: captured ones live in cells.
        IrKind::Call(Callee::Value(function), arguments) => {
            has_no_effect(function) && arguments.iter().all(has_no_effect)
        }
        IrKind::Call(_, arguments) => arguments.iter().all(has_no_effect),
        _ => false,
    })
}

/// Whether the form is a test of variables and numbers only, nested no deeper than `depth`, that can as well be made to
/// jump where it holds.
pub(super) fn is_cheap_test(ir: &Ir, depth: usize) -> bool {
    match &ir.kind {
        IrKind::And(items) => {
            depth > 0 && items.len() <= depth && items.iter().all(|item| is_cheap_test(item, depth - 1))
        }
        IrKind::Local(_) => true,
        IrKind::Unary(Unary::Not, inner) => matches!(inner.kind, IrKind::Local(_)),
        IrKind::Binary(operation, left, right) if operation.is_order() => {
            is_cheap_number(left, depth) && is_cheap_number(right, depth)
        }
        _ => false,
    }
}

/// Whether the form is a test that can be made to jump where it fails, and says by itself whether it holds: its value is `t`
/// or nil.
pub(super) fn is_test(ir: &Ir) -> bool {
    match &ir.kind {
        IrKind::Unary(Unary::Not, _) => true,
        IrKind::Binary(operation, ..) => operation.is_test(),
        _ => false,
    }
}

/// A constant of the text that is an operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Literal {
    Int(i64),
    Const(u32),
}

impl Literal {
    /// The form, if it is one.
    pub(super) fn of(ir: &Ir) -> Option<Self> {
        match ir.kind {
            IrKind::Int(value) => Some(Self::Int(value)),
            IrKind::Const(constant) => Some(Self::Const(constant)),
            _ => None,
        }
    }
}

/// Adds the constants that are operands of arithmetic in a form and would be loaded each time. What is inside other
/// functions is theirs, and what is about tasks takes longer than that.
pub(super) fn add_literals(ir: &Ir, literals: &mut Vec<Literal>) {
    deep(|| match &ir.kind {
        IrKind::Binary(operation, left, right) => {
            let is_loaded = |literal: &Literal| match literal {
                Literal::Int(_) => matches!(operation, Binary::Mul | Binary::Div),
                Literal::Const(_) => !matches!(operation, Binary::Cons),
            };
            for operand in [left, right] {
                literals.extend(Literal::of(operand).filter(is_loaded));
                add_literals(operand, literals);
            }
        }
        IrKind::SetLocal(_, value)
        | IrKind::SetGlobal(_, value)
        | IrKind::Unary(_, value)
        | IrKind::Leave(_, value)
        | IrKind::Loop(value)
        | IrKind::Block { body: value, .. } => add_literals(value, literals),
        IrKind::If(condition, then, otherwise) => {
            [condition, then, otherwise].into_iter().for_each(|part| add_literals(part, literals));
        }
        IrKind::And(items) | IrKind::Or(items) | IrKind::Seq(items) | IrKind::Call(_, items) => {
            items.iter().for_each(|item| add_literals(item, literals));
        }
        IrKind::Let(bindings, body) => {
            bindings.iter().for_each(|(_, value)| add_literals(value, literals));
            add_literals(body, literals);
        }
        _ => {}
    });
}

fn is_cheap_number(ir: &Ir, depth: usize) -> bool {
    match &ir.kind {
        IrKind::Int(_) | IrKind::Const(_) | IrKind::Local(_) | IrKind::Global(_) => true,
        IrKind::Binary(Binary::Add | Binary::Sub | Binary::Mul, left, right) => {
            depth > 0 && is_cheap_number(left, depth - 1) && is_cheap_number(right, depth - 1)
        }
        _ => false,
    }
}
