//! Bindings nobody reads, and values nobody uses.

use super::bindings::BoundBy;
use super::infix::stray_operator;
use super::known::Check;
use super::places;
use super::walk::each_form;
use crate::compile::ir::{Ir, IrKind, ScopeIr, Unary, VarId};
use crate::diagnostic::Diagnostic;
use crate::source::{Span, lies_in};

/// Natives that do nothing but give a value, and so do nothing where it is not used.
const PURE: &[&str] = &[
    "+",
    "-",
    "*",
    "/",
    "<",
    "<=",
    ">",
    ">=",
    "=",
    "/=",
    "1+",
    "1-",
    "abs",
    "min",
    "max",
    "mod",
    "floor",
    "ceiling",
    "round",
    "truncate",
    "sqrt",
    "sin",
    "cos",
    "not",
    "null",
    "eq",
    "equal",
    "list",
    "cons",
    "car",
    "cdr",
    "first",
    "second",
    "third",
    "rest",
    "nth",
    "length",
    "append",
    "reverse",
    "list-length",
    "member",
    "assoc",
    "format",
    "%format",
    "string-append",
    "value",
    "now",
    "status",
    "result",
    "begin-task",
    "end-task",
    "create-fluent",
    "this-task",
    "holds-valve?",
    "failure-class",
    "failure-message",
];

/// A number directly behind the head of a form that takes none, and the form that takes it.
const SHAPES: &[(&[&str], &str)] = &[
    (&["loop", "seq", "forever"], "so many times: `(n-times N FORM...)`"),
    (&["whenever"], "again and again, after so many seconds: `(loop (wait-time N) FORM...)`"),
    (
        &["try-in-order", "try-all", "par", "pursue"],
        "a number is no form: so many times is `(n-times N FORM...)`, for so long `(with-timeout SECONDS FORM...)`",
    ),
];

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let empty = without_forms(check);
    for number in 0..check.subject.text.variables.len() as u32 {
        found.extend(unused_binding(check, VarId(number), &empty));
    }
    for root in check.roots() {
        each_form(root, &mut |ir| {
            unused_values(check, ir, found);
            found.extend(without_clean_up(check, ir));
            found.extend(holds_nothing(check, ir));
        });
    }
    for test in &check.subject.text.tests {
        found.extend(value_of_test(check, &test.body));
    }
}

/// `(unwind-protect FORM)` and `(evap-protect FORM)`: nothing is cleaned up.
fn without_clean_up(check: &Check<'_>, ir: &Ir) -> Option<Diagnostic> {
    let IrKind::Cleanup { cleanup, always, .. } = &ir.kind else { return None };
    let name = if *always { "unwind-protect" } else { "evap-protect" };
    let warning =
        || check.warning("unused-value", ir.span, format!("this `{name}` has no clean-up"), "protects nothing");
    matches!(cleanup.kind, IrKind::Nil).then(|| warning().help(format!("write `({name} FORM CLEAN-UP...)`")))
}

/// `(with-valve V)`: nothing is done with it.
fn holds_nothing(check: &Check<'_>, ir: &Ir) -> Option<Diagnostic> {
    let IrKind::Scope(ScopeIr::Valve { .. }, body) = &ir.kind else { return None };
    let warning = || check.warning("unused-value", ir.span, "nothing is done while the valve is held", "no forms");
    matches!(body.kind, IrKind::Nil).then(|| warning().help("write `(with-valve VALVE FORM...)`"))
}

/// A test that ends with a value: only an `assert` or a failure tells whether it has succeeded.
fn value_of_test(check: &Check<'_>, body: &Ir) -> Option<Diagnostic> {
    let last = match &body.kind {
        IrKind::Seq(items) => items.last()?,
        _ => body,
    };
    let is_truth = check.native_call(last).is_some_and(|(name, _)| matches!(name, "eq" | "equal" | "not" | "null"))
        || matches!(last.kind, IrKind::Binary(..));
    let warning = || check.warning("unused-value", last.span, "the value of a test does not count", "not looked at");
    is_truth.then(|| warning().help(format!("write `(assert {})`", check.shown(last))))
}

fn unused_binding(check: &Check<'_>, variable: VarId, empty: &[Span]) -> Option<Diagnostic> {
    let binding = check.bindings().get(variable);
    let span = check.subject.text.variables[variable.0 as usize].span;
    let name = check.variable_name(variable);
    if binding.reads > 0 || binding.place == BoundBy::Elsewhere || name.starts_with(['_', '%', '#']) {
        return None;
    }
    // What a macro binds has no place of its own in the text.
    let place = places::binding_name(&check.subject.program.sources, span, name)?;
    let before =
        empty.partition_point(|definition| (definition.source, definition.start) <= (place.source, place.start));
    let is_of_empty = before.checked_sub(1).is_some_and(|before| lies_in(place, empty[before]));
    let is_function = matches!(binding.value.map(|value| &value.kind), Some(IrKind::Lambda(_)));
    let (message, help) = match (binding.place, binding.assignments > 0) {
        (_, true) => (format!("`{name}` is assigned and never read"), "remove it and its assignments".to_string()),
        (BoundBy::Parameter, _) if is_of_empty => {
            let help = "its definition has no forms: perhaps a `)` closes it too early";
            (format!("the parameter `{name}` is never used"), help.to_string())
        }
        (BoundBy::Parameter, _) => {
            (format!("the parameter `{name}` is never used"), format!("if it must be there, call it `_{name}`"))
        }
        _ if is_function => (format!("the local function `{name}` is never called"), "remove it".to_string()),
        _ => (format!("`{name}` is never used"), format!("remove it, or call it `_{name}` if it must be there")),
    };
    Some(check.warning("unused-binding", place, message, "never read").help(help))
}

/// The definitions in which nothing stands, in order of place.
fn without_forms(check: &Check<'_>) -> Vec<Span> {
    let empty = check.own_functions().filter(|(_, function)| matches!(function.body.kind, IrKind::Nil));
    let mut places: Vec<Span> = empty.map(|(_, function)| function.span).collect();
    places.sort();
    places
}

/// Forms of which the value is lost and that do nothing else.
fn unused_values(check: &Check<'_>, ir: &Ir, found: &mut Vec<Diagnostic>) {
    match &ir.kind {
        // What stands around an operator is told as that.
        IrKind::Seq(items) if stray_operator(check, items).is_some() => {}
        IrKind::Seq(items) => {
            let lost = items.split_last().map_or(&[][..], |(_, lost)| lost);
            lost.iter().for_each(|item| found.extend(unused_value(check, ir.span, item)));
        }
        IrKind::Loop(body) => match &body.kind {
            IrKind::Seq(items) if stray_operator(check, items).is_some() => {}
            IrKind::Seq(items) => {
                found.extend(items.last().and_then(|last| unused_value(check, ir.span, last)));
            }
            _ => found.extend(unused_value(check, ir.span, body)),
        },
        IrKind::Whenever { body, .. } => found.extend(unused_value(check, ir.span, body)),
        // A part of a construct that is a number.
        IrKind::Construct(construct) if construct.argument.is_none() && construct.policy().is_none() => {
            let parts = construct.children.iter().map(|child| &*child.body.body);
            let numbers = parts.filter(|part| check.number(part).is_some());
            numbers.for_each(|part| found.extend(unused_value(check, ir.span, part)));
        }
        _ => {}
    }
}

fn unused_value(check: &Check<'_>, around: Span, ir: &Ir) -> Option<Diagnostic> {
    // What a macro adds has the place of the macro's call.
    if ir.span == around || !is_idle(check, ir) || super::joined::touches(check, ir.span) {
        return None;
    }
    let text = check.subject.program.sources.text_of(ir.span);
    let warning =
        check.warning("unused-value", ir.span, "this does nothing: its value is not used", "the value is lost");
    let is_format = check.native_call(ir).is_some_and(|(name, _)| matches!(name, "format" | "%format"));
    let is_word = matches!(ir.kind, IrKind::Local(_) | IrKind::Global(_) | IrKind::Const(_));
    if is_word && text.starts_with('(') && !text.starts_with("(quote") {
        return None;
    }
    let head = places::head(&check.subject.program.sources, around);
    let is_count = check.number(ir).is_some() && is_first(check, around, head, ir.span);
    let shape = SHAPES.iter().find(|(heads, _)| is_count && heads.contains(&head)).map(|(_, help)| *help);
    Some(match shape.or(is_format.then_some("`format` gives a text; to write it, `(print (format …))`")) {
        Some(help) => warning.help(help),
        None => warning,
    })
}

/// Whether a form is the first one behind the head of another.
fn is_first(check: &Check<'_>, around: Span, head: &str, form: Span) -> bool {
    let start = around.start + 1 + head.len() as u32;
    let between = Span { start, end: form.start.max(start), ..around };
    check.subject.program.sources.text_of(between).trim().is_empty()
}

/// Whether evaluating a form can only give its value or fail.
pub(super) fn is_idle(check: &Check<'_>, ir: &Ir) -> bool {
    match &ir.kind {
        IrKind::Int(_) | IrKind::Const(_) | IrKind::Local(_) | IrKind::Global(_) | IrKind::Lambda(_) => true,
        IrKind::Binary(_, left, right) => is_idle(check, left) && is_idle(check, right),
        IrKind::Unary(operation, operand) => *operation != Unary::Deref && is_idle_or_nil(check, operand),
        IrKind::Call(..) => check.native_call(ir).is_some_and(|(name, arguments)| {
            PURE.contains(&name) && arguments.iter().all(|argument| is_idle_or_nil(check, argument))
        }),
        _ => false,
    }
}

fn is_idle_or_nil(check: &Check<'_>, ir: &Ir) -> bool {
    matches!(ir.kind, IrKind::Nil | IrKind::True) || is_idle(check, ir)
}
