//! Code that is made without a form of the text.

use crate::code::{Code, CodeKind, Op, Parameters};
use crate::source::Span;
use crate::symbol::Symbol;

/// Code that runs codes without parameters one after the other, with the last one's value or a
/// constant's.
pub(in crate::compile) fn sequence(name: Symbol, span: Span, calls: &[(u32, Span)], value: Option<u32>) -> Code {
    let mut ops = vec![Op::Nil(0)];
    let mut spans = vec![span];
    for &(code, place) in calls {
        ops.push(Op::CallCode(0, code));
        spans.push(place);
    }
    if let Some(constant) = value {
        ops.push(Op::Const(0, constant));
        spans.push(span);
    }
    ops.push(Op::Return(0));
    spans.push(span);
    Code {
        name,
        kind: CodeKind::Task,
        exact_count: 0,
        framed_count: 0,
        slot: None,
        is_plain: false,
        parameters: Parameters::default(),
        registers: 1,
        captures: Vec::new(),
        ops,
        spans,
        constructs: Vec::new(),
        handlers: Vec::new(),
        locals: Vec::new(),
        doc: None,
        span,
    }
}
