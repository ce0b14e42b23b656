//! Walks over resolved forms.

use crate::compile::ir::{Callee, Function, Ir, IrKind, ParameterBinding, ScopeIr};
use crate::stack::deep;

/// What stands directly inside a form.
pub(super) enum FormPart<'a> {
    Form(&'a Ir),
    Function(&'a Function),
}

/// Shows the parts of a form in the order of evaluation.
pub(super) fn parts<'a>(ir: &'a Ir, see: &mut dyn FnMut(FormPart<'a>)) {
    match &ir.kind {
        IrKind::Nil
        | IrKind::True
        | IrKind::Int(_)
        | IrKind::Const(_)
        | IrKind::Local(_)
        | IrKind::Global(_)
        | IrKind::Refail(_) => {}
        IrKind::SetLocal(_, value)
        | IrKind::SetGlobal(_, value)
        | IrKind::DefFluent(_, value)
        | IrKind::Unary(_, value)
        | IrKind::Leave(_, value)
        | IrKind::LeaveDynamic(_, value)
        | IrKind::Loop(value) => see(FormPart::Form(value)),
        IrKind::Block { body, .. } => see(FormPart::Form(body)),
        IrKind::If(condition, then, otherwise) => {
            [condition, then, otherwise].into_iter().for_each(|part| see(FormPart::Form(part)));
        }
        IrKind::Binary(_, left, right) => [left, right].into_iter().for_each(|part| see(FormPart::Form(part))),
        IrKind::And(items) | IrKind::Or(items) | IrKind::Seq(items) => {
            items.iter().for_each(|item| see(FormPart::Form(item)));
        }
        IrKind::Let(bindings, body) => {
            bindings.iter().for_each(|(_, value)| see(FormPart::Form(value)));
            see(FormPart::Form(body));
        }
        IrKind::Lambda(function) | IrKind::Network(function) => see(FormPart::Function(function)),
        IrKind::Call(callee, arguments) => {
            if let Callee::Value(value) = callee {
                see(FormPart::Form(value));
            }
            arguments.iter().for_each(|argument| see(FormPart::Form(argument)));
        }
        IrKind::Construct(construct) | IrKind::Spawn(construct) => {
            construct.evaluated().for_each(|argument| see(FormPart::Form(argument)));
            construct.children.iter().for_each(|child| see(FormPart::Function(&child.body)));
        }
        IrKind::ConstructMap(construct, list) => {
            see(FormPart::Form(list));
            construct.evaluated().for_each(|argument| see(FormPart::Form(argument)));
            construct.children.iter().for_each(|child| see(FormPart::Function(&child.body)));
        }
        IrKind::Handler { body, clauses, .. } => {
            see(FormPart::Form(body));
            clauses.iter().for_each(|clause| see(FormPart::Form(&clause.body)));
        }
        IrKind::Cleanup { body, cleanup, .. } => [body, cleanup].into_iter().for_each(|part| see(FormPart::Form(part))),
        IrKind::Scope(scope, body) => {
            match scope {
                ScopeIr::Valve { valve, seconds } => {
                    std::iter::once(valve).chain(seconds).for_each(|value| see(FormPart::Form(value)));
                }
                ScopeIr::Suspended(value) => see(FormPart::Form(value)),
                ScopeIr::OnInterrupt(hook) | ScopeIr::OnResume(hook) => see(FormPart::Function(hook)),
                ScopeIr::Fence => {}
            }
            see(FormPart::Form(body));
        }
        IrKind::WaitFor { fluent, timeout, .. } => {
            see(FormPart::Form(fluent));
            timeout.iter().for_each(|timeout| see(FormPart::Form(timeout)));
        }
        IrKind::Whenever { fluent, body, .. } => [fluent, body].into_iter().for_each(|part| see(FormPart::Form(part))),
    }
}

/// Shows every form in a function, inner functions included, each before its parts.
pub(super) fn each_form<'a>(function: &'a Function, see: &mut dyn FnMut(&'a Ir)) {
    each_function_form(function, &mut |_, ir| see(ir));
}

/// The same, each with the function it stands in.
pub(crate) fn each_function_form<'a>(function: &'a Function, see: &mut dyn FnMut(&'a Function, &'a Ir)) {
    for evaluated in function.bindings.iter().flat_map(ParameterBinding::evaluated) {
        descend(function, evaluated, see);
    }
    descend(function, &function.body, see);
}

/// Shows every form in a form, itself first.
pub(super) fn each_form_within<'a>(ir: &'a Ir, see: &mut dyn FnMut(&'a Ir)) {
    deep(|| {
        see(ir);
        parts(ir, &mut |part| match part {
            FormPart::Form(inner) => each_form_within(inner, see),
            FormPart::Function(function) => each_form(function, see),
        });
    });
}

fn descend<'a>(function: &'a Function, ir: &'a Ir, see: &mut dyn FnMut(&'a Function, &'a Ir)) {
    deep(|| {
        see(function, ir);
        parts(ir, &mut |part| match part {
            FormPart::Form(inner) => descend(function, inner, see),
            FormPart::Function(function) => each_function_form(function, see),
        });
    });
}
