//! Operations of the library that have an instruction of their own.

use super::ir::{Binary, Ir, IrKind, Unary};
use crate::source::Span;

/// The instruction for a library function, if it has one for these arguments.
pub(super) fn intrinsic(name: &str, mut arguments: Vec<Ir>, span: Span) -> Result<Ir, Vec<Ir>> {
    let binary = match name {
        "+" => Some((Binary::Add, false)),
        "-" => Some((Binary::Sub, false)),
        "*" => Some((Binary::Mul, false)),
        "/" => Some((Binary::Div, false)),
        "<" => Some((Binary::Less, false)),
        "<=" => Some((Binary::LessEq, false)),
        ">" => Some((Binary::Less, true)),
        ">=" => Some((Binary::LessEq, true)),
        "=" => Some((Binary::NumEq, false)),
        "/=" => Some((Binary::NumDiffer, false)),
        "eq" => Some((Binary::Eq, false)),
        "cons" => Some((Binary::Cons, false)),
        _ => None,
    };
    let unary = match name {
        "not" | "null" => Some(Unary::Not),
        "car" | "first" => Some(Unary::Car),
        "cdr" | "rest" => Some(Unary::Cdr),
        _ => None,
    };
    let one = |value| Box::new(Ir { span, kind: IrKind::Int(value) });
    match (name, binary, unary, arguments.len()) {
        ("1+", _, _, 1) => {
            let operand = Box::new(arguments.remove(0));
            Ok(Ir { span, kind: IrKind::Binary(Binary::Add, operand, one(1)) })
        }
        ("1-", _, _, 1) => {
            let operand = Box::new(arguments.remove(0));
            Ok(Ir { span, kind: IrKind::Binary(Binary::Sub, operand, one(1)) })
        }
        (_, Some((operation, swapped)), _, 2) => {
            let first = Box::new(arguments.remove(0));
            let second = Box::new(arguments.remove(0));
            // `a > b` is `b < a`; the operands keep their order of evaluation unless one of them
            // can be seen to have no effect.
            if swapped && !(is_plain(&first) || is_plain(&second)) {
                return Err(vec![*first, *second]);
            }
            let (left, right) = if swapped { (second, first) } else { (first, second) };
            Ok(Ir { span, kind: IrKind::Binary(operation, left, right) })
        }
        ("+" | "*", Some((operation, _)), _, count) if count > 2 => {
            let mut arguments = arguments.into_iter();
            let first = arguments.next().unwrap_or_else(|| unreachable!("there are more than two"));
            Ok(arguments.fold(first, |left, right| Ir {
                span,
                kind: IrKind::Binary(operation, Box::new(left), Box::new(right)),
            }))
        }
        (_, _, Some(operation), 1) => Ok(Ir { span, kind: IrKind::Unary(operation, Box::new(arguments.remove(0))) }),
        _ => Err(arguments),
    }
}

fn is_plain(ir: &Ir) -> bool {
    match &ir.kind {
        IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_) => true,
        IrKind::Local(_) | IrKind::Global(_) => false,
        IrKind::Unary(Unary::Deref, inner) => matches!(inner.kind, IrKind::Local(_) | IrKind::Global(_)),
        _ => false,
    }
}
