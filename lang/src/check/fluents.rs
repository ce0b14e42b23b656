//! Fluents taken for their values, and what is asked of a task's state.

use super::kinds::kind_of_parameter;
use super::known::Check;
use super::walk::each_form;
use crate::code::GlobalKind;
use crate::compile::ir::{Binary, Callee, Ir, IrKind, Unary};
use crate::diagnostic::Diagnostic;
use crate::kind::Kind;
use crate::stack::deep;
use crate::suggest::suggest;

/// Natives that give a fluent where they do not stand in a network.
const GIVE_FLUENTS: &[&str] =
    &["create-fluent", "status", "result", "begin-task", "end-task", "pulsed", "changed", "count-pulses"];

/// States of tasks.
const STATES: &[&str] = &["created", "ready", "running", "blocked", "suspended", "succeeded", "failed", "evaporated"];

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    for root in check.roots() {
        each_form(root, &mut |ir| look_at(check, ir, found));
    }
}

fn look_at(check: &Check<'_>, ir: &Ir, found: &mut Vec<Diagnostic>) {
    match &ir.kind {
        IrKind::Binary(Binary::Eq, left, right) => {
            compared(check, left, right, found);
            compared(check, right, left, found);
        }
        IrKind::Binary(Binary::Cons, ..) => {}
        IrKind::Binary(_, left, right) => computed_with(check, ir, [&**left, &**right].into_iter(), found),
        IrKind::Call(Callee::Native(native), arguments) => {
            let name = check.native_call(ir).map_or("", |(name, _)| name);
            let signature = &check.subject.natives[usize::from(*native)];
            let wants_number = |at| is_number(signature.kind(at));
            let numbers = arguments.iter().enumerate().filter(|&(at, _)| wants_number(at));
            computed_with(check, ir, numbers.map(|(_, argument)| argument), found);
            if let ("equal", [left, right]) = (name, arguments.as_slice()) {
                compared(check, left, right, found);
                compared(check, right, left, found);
            }
        }
        IrKind::Call(Callee::Global(global), arguments) => {
            let wants_number = |at| is_number(kind_of_parameter(check, *global, at));
            let numbers = arguments.iter().enumerate().filter(|&(at, _)| wants_number(at));
            computed_with(check, ir, numbers.map(|(_, argument)| argument), found);
        }
        IrKind::If(condition, ..) | IrKind::Unary(Unary::Not, condition) => tested(check, ir, condition, found),
        IrKind::And(items) | IrKind::Or(items) => {
            let tests = items.split_last().map_or(&[][..], |(_, tests)| tests);
            tests.iter().for_each(|test| tested(check, ir, test, found));
        }
        _ => {}
    }
}

fn is_number(kind: Kind) -> bool {
    matches!(kind, Kind::Number | Kind::Integer | Kind::Seconds | Kind::Angle)
}

fn computed_with<'i>(
    check: &Check<'_>,
    around: &Ir,
    operands: impl Iterator<Item = &'i Ir>,
    found: &mut Vec<Diagnostic>,
) {
    for operand in operands.filter(|operand| gives_fluent(check, operand)) {
        found.push(fluent_as_value(check, around, operand, "a number is needed here"));
    }
}

fn tested(check: &Check<'_>, around: &Ir, condition: &Ir, found: &mut Vec<Diagnostic>) {
    if gives_fluent(check, condition) {
        found.push(fluent_as_value(check, around, condition, "always true"));
    }
}

fn compared(check: &Check<'_>, operand: &Ir, other: &Ir, found: &mut Vec<Diagnostic>) {
    let is_datum = matches!(other.kind, IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_));
    if is_datum && gives_fluent(check, operand) {
        found.push(fluent_as_value(check, operand, operand, "never equal to this"));
    }
    if let (true, Some(state)) = (reads_status(check, operand), check.quoted(other)) {
        let name = check.name(state);
        if !STATES.contains(&name) {
            let message = format!("no task is ever in a state `{name}`");
            let near = suggest(name, STATES.iter().copied());
            let help = near.map_or_else(
                || format!("the states are {}", STATES.join(", ")),
                |near| format!("did you mean `{near}`?"),
            );
            found.push(check.warning("unknown-state", other.span, message, "unknown state").help(help));
        }
    }
}

fn reads_status(check: &Check<'_>, ir: &Ir) -> bool {
    match &ir.kind {
        IrKind::Unary(Unary::Deref, inner) => reads_status(check, inner),
        _ => check.native_call(ir).is_some_and(|(name, arguments)| match (name, arguments) {
            ("status", _) => true,
            ("value", [inner]) => reads_status(check, inner),
            _ => false,
        }),
    }
}

fn fluent_as_value(check: &Check<'_>, around: &Ir, operand: &Ir, label: &str) -> Diagnostic {
    let shown = check.shown(operand);
    let place = check.narrowed(around.span, operand);
    let message = format!("`{shown}` is a fluent: here it stands for itself, not for its value");
    check.warning("fluent-as-value", place, message, label).help(format!("write `(value {shown})`"))
}

/// Whether a form's value is visibly a fluent itself.
fn gives_fluent(check: &Check<'_>, ir: &Ir) -> bool {
    deep(|| match &ir.kind {
        IrKind::Global(global) => *check.kind(*global) == GlobalKind::Fluent,
        IrKind::Network(_) => true,
        IrKind::Local(variable) => check.bindings().constant(*variable).is_some_and(|value| gives_fluent(check, value)),
        IrKind::Let(_, body) => matches!(body.kind, IrKind::Network(_)),
        _ => check.native_call(ir).is_some_and(|(name, _)| GIVE_FLUENTS.contains(&name)),
    })
}
