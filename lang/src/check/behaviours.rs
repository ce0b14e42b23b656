//! What belongs where a behaviour, a valve, a fluent or a class of failure stands.

use super::Check;
use super::calls::unknown_keywords;
use super::walk::each_form;
use crate::code::{Atom, Constant, GlobalKind};
use crate::compile::ir::{Ir, IrKind, ScopeIr};
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::suggest::suggest;

/// What a place wants.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Behaviour,
    Valve,
    Fluent,
    Task,
}

impl Wanted {
    fn noun(self) -> &'static str {
        match self {
            Wanted::Behaviour => "a behaviour",
            Wanted::Valve => "a valve",
            Wanted::Fluent => "a fluent",
            Wanted::Task => "a task",
        }
    }

    /// What the first argument of a native must be.
    fn by(native: &str) -> Option<Self> {
        Some(match native {
            "activate" | "deactivate" | "await-signal" => Wanted::Behaviour,
            "request-valve" | "release-valve" | "holds-valve?" => Wanted::Valve,
            "value" | "%set-value" | "pulse" | "pulsed" | "changed" | "count-pulses" => Wanted::Fluent,
            "status" | "result" | "begin-task" | "end-task" | "evaporate" | "suspend" | "resume" | "task-path" => {
                Wanted::Task
            }
            _ => return None,
        })
    }
}

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    for root in check.roots() {
        each_form(root, &mut |ir| look_at(check, ir, found));
    }
}

fn look_at(check: &Check<'_>, ir: &Ir, found: &mut Vec<Diagnostic>) {
    match &ir.kind {
        IrKind::Scope(ScopeIr::Valve(valve), _) => {
            wrong_kind(check, "with-valve", Wanted::Valve, ir.span, valve, found)
        }
        IrKind::Scope(ScopeIr::Suspended(task), _) => {
            wrong_kind(check, "with-task-suspended", Wanted::Task, ir.span, task, found);
        }
        IrKind::WaitFor { fluent, .. } => wrong_kind(check, "wait-for", Wanted::Fluent, ir.span, fluent, found),
        IrKind::Whenever { fluent, .. } => wrong_kind(check, "whenever", Wanted::Fluent, ir.span, fluent, found),
        IrKind::Call(..) => {
            let Some((name, [first, rest @ ..])) = check.native_call(ir) else { return };
            if let Some(wanted) = Wanted::by(name) {
                let shown = if name == "%set-value" { "setf (value …)" } else { name };
                wrong_kind(check, shown, wanted, ir.span, first, found);
            }
            match name {
                "activate" => parameters(check, first, rest, ir.span, found),
                "pulse" | "%set-value" => robot_fluent(check, first, ir.span, found),
                "%fail" => slots(check, first, rest, ir.span, found),
                _ => {}
            }
        }
        _ => {}
    }
}

/// What a form visibly stands for, if that is never a task, nor anything a variable may hold.
fn noun(check: &Check<'_>, ir: &Ir) -> Option<(&'static str, Option<Wanted>)> {
    match ir.kind {
        IrKind::Global(global) => match check.kind(global) {
            GlobalKind::Function(_) => Some(("a function", None)),
            GlobalKind::Fluent => Some(("a fluent", Some(Wanted::Fluent))),
            GlobalKind::Valve => Some(("a valve", Some(Wanted::Valve))),
            GlobalKind::Behaviour(_) => Some(("a behaviour", Some(Wanted::Behaviour))),
            GlobalKind::Variable | GlobalKind::Constant => None,
        },
        IrKind::Int(_) => Some(("a number", None)),
        IrKind::Const(constant) => match check.constant(constant) {
            Constant::Atom(Atom::Symbol(_)) => Some(("a symbol", None)),
            Constant::Atom(Atom::Str(_)) => Some(("a string", None)),
            Constant::Atom(Atom::Float(_) | Atom::Int(_)) => Some(("a number", None)),
            Constant::Atom(Atom::Keyword(_)) => Some(("a keyword", None)),
            Constant::Atom(Atom::Native(_)) => Some(("a function", None)),
            Constant::List(_) | Constant::Atom(Atom::Nil | Atom::True | Atom::Object(_)) => None,
        },
        _ => None,
    }
}

fn wrong_kind(check: &Check<'_>, form: &str, wanted: Wanted, around: Span, ir: &Ir, found: &mut Vec<Diagnostic>) {
    let Some((noun, is)) = noun(check, ir) else { return };
    if is == Some(wanted) {
        return;
    }
    let place = super::places::narrowed(check, around, ir);
    let shown = match check.quoted(ir) {
        Some(symbol) => format!("'{}", check.name(symbol)),
        None => check.shown(ir),
    };
    let message = format!("`{form}` wants {}, and `{shown}` is {noun}", wanted.noun());
    let warning = check.warning("wrong-kind", place, message, format!("not {}", wanted.noun()));
    let named = check.quoted(ir).map(|symbol| check.name(symbol));
    let is_defined = named
        .and_then(|name| check.subject.symbols.find(name))
        .is_some_and(|name| check.subject.program.names.contains_key(&name));
    found.push(match named.filter(|_| is_defined) {
        Some(name) => warning.help(format!("without the quote `{name}` is the thing itself")),
        None => warning,
    });
}

fn parameters(check: &Check<'_>, behaviour: &Ir, pairs: &[Ir], span: Span, found: &mut Vec<Diagnostic>) {
    let IrKind::Global(global) = behaviour.kind else { return };
    let GlobalKind::Behaviour(number) = *check.kind(global) else { return };
    let Some(signature) = check.subject.behaviours.get(usize::from(number)) else { return };
    let known: Vec<&str> = signature.parameters.iter().map(String::as_str).collect();
    unknown_keywords(check, check.global_name(global), &known, pairs, span, found);
}

/// Fluents of the robot are the robot's to assign.
fn robot_fluent(check: &Check<'_>, fluent: &Ir, span: Span, found: &mut Vec<Diagnostic>) {
    let IrKind::Global(global) = fluent.kind else { return };
    let known = &check.subject.program.globals[global as usize];
    if known.kind != GlobalKind::Fluent || known.span.is_some() {
        return;
    }
    let name = check.global_name(global);
    let message = format!("`{name}` is a fluent of the robot, which a plan cannot assign");
    found.push(check.warning("wrong-kind", span, message, "only the robot sets it"));
}

/// Slots a class of failures does not have.
fn slots(check: &Check<'_>, class: &Ir, rest: &[Ir], span: Span, found: &mut Vec<Diagnostic>) {
    let Some(class) = check.quoted(class) else { return };
    let program = check.subject.program;
    if !program.failure_classes.contains_key(&class) {
        return;
    }
    let known: Vec<&str> = program.failure_slots(class).into_iter().map(|slot| check.name(slot)).collect();
    for pair in rest.get(1..).unwrap_or_default().chunks(2) {
        let Some(slot) = check.keyword(&pair[0]).map(|slot| check.name(slot)) else { return };
        if known.contains(&slot) {
            continue;
        }
        let class = check.name(class);
        let place = super::places::keyword(&program.sources, span, pair[0].span, slot);
        let message = format!("failures of class `{class}` have no slot `{slot}`");
        let warning = check.warning("unknown-slot", place, message, "unknown slot");
        found.push(match suggest(slot, known.iter().copied()) {
            Some(near) => warning.help(format!("did you mean `:{near}`?")),
            None => warning.help(format!("add it where the class is defined: `(def-failure {class} (…) ({slot}))`")),
        });
    }
}
