//! Tasks that suspend themselves by a form that only its own end lifts.

use super::known::Check;
use super::walk::{FormPart, parts};
use crate::compile::ir::{ConstructIr, Function, Ir, IrKind, ScopeIr, VarId};
use crate::diagnostic::Diagnostic;
use crate::stack::deep;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    for root in check.roots() {
        look_at(check, &root.body, &mut Vec::new(), found);
    }
}

/// `around` are the tags whose task a form runs in or below.
fn look_at(check: &Check<'_>, ir: &Ir, around: &mut Vec<VarId>, found: &mut Vec<Diagnostic>) {
    deep(|| {
        if let IrKind::Scope(ScopeIr::Suspended(task), _) = &ir.kind {
            let is_own = match task.kind {
                IrKind::Local(name) => around.contains(&name),
                _ => check.native_call(task).is_some_and(|(name, _)| name == "this-task"),
            };
            found.extend(is_own.then(|| warning(check, task)));
        }
        match &ir.kind {
            IrKind::Construct(construct) | IrKind::Spawn(construct) | IrKind::ConstructMap(construct, _) => {
                look_at_children(check, construct, around, found);
            }
            _ => parts(ir, &mut |part| match part {
                FormPart::Form(form) => look_at(check, form, around, found),
                FormPart::Function(function) => look_elsewhere(check, function, found),
            }),
        }
    });
}

fn look_at_children(check: &Check<'_>, construct: &ConstructIr, around: &mut Vec<VarId>, found: &mut Vec<Diagnostic>) {
    for child in &construct.children {
        let outer = around.len();
        around.extend(child.tag);
        look_at(check, &child.body.body, around, found);
        around.truncate(outer);
    }
}

/// What is no task of its own may run in any task.
fn look_elsewhere(check: &Check<'_>, function: &Function, found: &mut Vec<Diagnostic>) {
    look_at(check, &function.body, &mut Vec::new(), found);
}

fn warning(check: &Check<'_>, task: &Ir) -> Diagnostic {
    let message = "`with-task-suspended` suspends the task it runs in, and nothing but its own end can lift that";
    check
        .warning("suspends-itself", task.span, message, "never goes on")
        .help("suspend another task, or use `(suspend (this-task))`, which another task can take back by `resume`")
}
