//! Operations of the library that have an instruction of their own.

use super::ir::{Binary, Ir, IrKind, Unary};
use crate::source::Span;

/// The instruction for a library function, if it has one for these arguments.
pub(super) fn intrinsic(name: &str, mut arguments: Vec<Ir>, span: Span) -> Result<Ir, Vec<Ir>> {
    let binary = match name {
        "+" => Some(Binary::Add),
        "-" => Some(Binary::Sub),
        "*" => Some(Binary::Mul),
        "/" => Some(Binary::Div),
        "<" => Some(Binary::Less),
        "<=" => Some(Binary::LessEq),
        ">" => Some(Binary::Greater),
        ">=" => Some(Binary::GreaterEq),
        "=" => Some(Binary::NumEq),
        "/=" => Some(Binary::NumDiffer),
        "eq" => Some(Binary::Eq),
        "cons" => Some(Binary::Cons),
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
        (_, Some(operation), _, 2) => {
            let left = Box::new(arguments.remove(0));
            let right = Box::new(arguments.remove(0));
            Ok(Ir { span, kind: IrKind::Binary(operation, left, right) })
        }
        ("+" | "*", Some(operation), _, count) if count > 2 => {
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
