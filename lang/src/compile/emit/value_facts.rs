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
        IrKind::Binary(Binary::Less | Binary::LessEq, left, right) => {
            is_cheap_number(left, depth) && is_cheap_number(right, depth)
        }
        _ => false,
    }
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
