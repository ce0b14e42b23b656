//! Operators between their operands: `(battery < 20)` calls `battery`, and `(when n < 3 …)` asks for `n`.

use super::known::Check;
use super::walk::each_form;
use crate::code::{Atom, Constant, GlobalKind};
use crate::compile::ir::{Callee, Ir, IrKind, Unary, VarId};
use crate::diagnostic::Diagnostic;
use crate::infix::{Infix, infix_at, is_operator};
use crate::source::{Span, lies_in};

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    for root in check.roots() {
        each_form(root, &mut |ir| found.extend(look_at(check, ir)));
    }
}

fn look_at(check: &Check<'_>, ir: &Ir) -> Option<Diagnostic> {
    match &ir.kind {
        IrKind::Call(..) => called_operand(check, ir),
        IrKind::Seq(items) | IrKind::And(items) | IrKind::Or(items) => {
            let operator = stray_operator(check, items)?;
            let infix = infix_of(check, ir.span, operator)?;
            let message = format!("`{operator}` stands behind its first operand, so nothing calls it");
            Some(check.warning("infix-operator", infix.span, message, "not called").help(infix.advice()))
        }
        _ => None,
    }
}

/// The first operator among forms whose values are lost, or only tested.
pub(super) fn stray_operator<'a>(check: &Check<'a>, items: &[Ir]) -> Option<&'a str> {
    items.split_last()?.1.iter().find_map(|item| operator(check, item))
}

/// A call with an operator behind what is called and one operand behind that, where what is called is
/// no function, as far as can be seen.
pub(super) fn called_operand(check: &Check<'_>, ir: &Ir) -> Option<Diagnostic> {
    let IrKind::Call(callee, arguments) = &ir.kind else { return None };
    let [between, right] = arguments.as_slice() else { return None };
    let name = operator(check, between)?;
    // A function that takes an operator takes a list, a vector or a function with it.
    let is_operand = match right.kind {
        IrKind::Int(_) | IrKind::Binary(..) => true,
        IrKind::Const(constant) => {
            matches!(check.constant(constant), Constant::Atom(Atom::Float(_) | Atom::Str(_) | Atom::Symbol(_)))
        }
        _ => false,
    };
    let is_infix = match callee {
        Callee::Native(_) => false,
        Callee::Global(global) => match check.kind(*global) {
            GlobalKind::Function(_) => false,
            GlobalKind::Fluent | GlobalKind::Valve { .. } | GlobalKind::Behaviour(_) => true,
            GlobalKind::Variable | GlobalKind::Constant => is_operand,
        },
        Callee::Value(value) => match &value.kind {
            IrKind::Lambda(_) => false,
            IrKind::Local(variable) => {
                check.bindings().function(*variable).is_none() && (is_operand || is_data(check, *variable))
            }
            _ => is_operand,
        },
    };
    let infix = infix_of(check, ir.span, name).filter(|_| is_infix)?;
    let message = format!("`{name}` is an argument here, and what stands before it is called");
    Some(check.warning("infix-operator", infix.span, message, "not called").help(infix.advice()))
}

fn is_data(check: &Check<'_>, variable: VarId) -> bool {
    check
        .bindings()
        .constant(variable)
        .is_some_and(|value| matches!(value.kind, IrKind::Int(_) | IrKind::True | IrKind::Binary(..)))
}

fn operator<'a>(check: &Check<'a>, ir: &Ir) -> Option<&'a str> {
    // In a condition the value of a fluent is asked for.
    if let IrKind::Unary(Unary::Deref, inner) = &ir.kind {
        return operator(check, inner);
    }
    let IrKind::Const(constant) = ir.kind else { return None };
    let Constant::Atom(Atom::Native(native)) = check.constant(constant) else { return None };
    let name = check.subject.natives[usize::from(*native)].name.as_str();
    is_operator(name).then_some(name)
}

/// The first place in a form where the operator stands between two operands.
fn infix_of(check: &Check<'_>, form: Span, operator: &str) -> Option<Infix> {
    let sources = &check.subject.program.sources;
    let tokens = check.tokens(form.source);
    let first = tokens.partition_point(|(_, span)| span.start < form.start);
    let within = (first..tokens.len()).take_while(|&at| lies_in(tokens[at].1, form));
    within.filter_map(|at| infix_at(sources, &tokens, at)).find(|infix| infix.operator == operator)
}
