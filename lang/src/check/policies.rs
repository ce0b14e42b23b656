//! Policies that soon end and keep nothing: they only wait, or ask their condition once.

use super::effects::policy_never_waits;
use super::flow::{Flow, is_whenever};
use super::known::Check;
use super::places::brief;
use super::unused::is_idle;
use super::walk::{each_form, each_form_within};
use crate::compile::ir::{Callee, ConstructIr, Function, Ir, IrKind};
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::stack::deep;
use std::collections::BTreeSet;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    for root in check.roots() {
        each_form(root, &mut |ir| {
            let IrKind::Construct(construct) = &ir.kind else { return };
            let policy = construct.policy().map(|policy| &policy.body);
            let ends = || policy.and_then(|policy| policy_that_ends(check, policy));
            found.extend(in_the_wrong_order(check, construct).or_else(ends));
        });
    }
}

/// A policy that ends, around a body that never does: the two were meant the other way round.
fn in_the_wrong_order(check: &Check<'_>, construct: &ConstructIr) -> Option<Diagnostic> {
    let policy = &construct.policy()?.body;
    let body = &construct.children.last()?.body;
    let acts = matches!(policy.body.kind, IrKind::Call(..) | IrKind::Construct(_));
    if !acts || !is_whenever(&body.body) || !Flow::new(check).completes(&policy.body) {
        return None;
    }
    let warning =
        check.warning("policy-ends", policy.span, "this policy ends, and the body never does", "keeps nothing");
    Some(warning.help("the policy comes first: `(with-policy (whenever CONDITION FORM...) FORM...)`"))
}

fn policy_that_ends(check: &Check<'_>, policy: &Function) -> Option<Diagnostic> {
    if policy_never_waits(check, policy).is_some() {
        return None;
    }
    if only_waits(check, &policy.body, &mut BTreeSet::new()) == Some(Waiting::Some) {
        let message = "this policy waits and then does nothing";
        return Some(
            check
                .warning("policy-ends", policy.span, message, "keeps nothing")
                .help("say what is to be done: `(whenever CONDITION FORM...)`; to wait first, put the `wait-for` before the `with-policy`"),
        );
    }
    let asked = asks_once(check, &policy.body, &mut BTreeSet::new())?;
    let message = "this policy asks its condition once, before the body begins, and never again";
    let warning = check.warning("policy-ends", policy.span, message, "asked once").help(
        "`(whenever CONDITION FORM...)` acts each time the condition becomes true; fluents stand in it without `value`",
    );
    Some(match asked == policy.span {
        true => warning,
        false => warning.related(brief(&check.subject.program.sources, asked), "asked here"),
    })
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Waiting {
    None,
    Some,
}

/// Whether a form waits and does nothing else; none if it does.
fn only_waits(check: &Check<'_>, ir: &Ir, seen: &mut BTreeSet<u32>) -> Option<Waiting> {
    deep(|| match &ir.kind {
        IrKind::WaitFor { .. } => Some(Waiting::Some),
        IrKind::Seq(items) => {
            let mut waiting = Waiting::None;
            for item in items {
                if only_waits(check, item, seen)? == Waiting::Some {
                    waiting = Waiting::Some;
                }
            }
            Some(waiting)
        }
        IrKind::Let(bound, body) if bound.iter().all(|(_, value)| is_quiet(check, value)) => {
            only_waits(check, body, seen)
        }
        IrKind::Call(Callee::Global(_), _) => only_waits(check, called(check, ir, seen)?, seen),
        _ if check.native_call(ir).is_some_and(|(name, _)| matches!(name, "wait-time" | "at-time")) => {
            Some(Waiting::Some)
        }
        _ => is_quiet(check, ir).then_some(Waiting::None),
    })
}

fn is_quiet(check: &Check<'_>, ir: &Ir) -> bool {
    matches!(ir.kind, IrKind::Nil | IrKind::True) || is_idle(check, ir)
}

/// Where a policy asks for the value of a fluent, to do something once or not at all.
fn asks_once(check: &Check<'_>, ir: &Ir, seen: &mut BTreeSet<u32>) -> Option<Span> {
    deep(|| match &ir.kind {
        IrKind::If(condition, then, otherwise) => {
            let acts = match (&then.kind, &otherwise.kind) {
                (IrKind::Nil, _) => otherwise,
                (_, IrKind::Nil) => then,
                _ => return None,
            };
            // To fail at once is what only the beginning asks for.
            let acts_once = Flow::new(check).completes(acts) && !goes_on(check, acts, &mut BTreeSet::new());
            (reads_fluent(check, condition) && acts_once).then_some(ir.span)
        }
        IrKind::Let(_, body) | IrKind::Block { body, .. } => asks_once(check, body, seen),
        IrKind::Call(Callee::Global(_), _) => asks_once(check, called(check, ir, seen)?, seen),
        _ => None,
    })
}

fn reads_fluent(check: &Check<'_>, ir: &Ir) -> bool {
    let mut reads = false;
    each_form_within(ir, &mut |form| reads |= check.native_call(form).is_some_and(|(name, _)| name == "value"));
    reads
}

/// Whether a form, or what it calls, may wait for something again and again.
fn goes_on(check: &Check<'_>, ir: &Ir, seen: &mut BTreeSet<u32>) -> bool {
    let (mut again, mut calls) = (false, Vec::new());
    each_form_within(ir, &mut |form| match &form.kind {
        IrKind::Loop(_) | IrKind::Whenever { .. } => again = true,
        IrKind::Call(Callee::Value(_), _) => again = true,
        IrKind::Call(Callee::Global(global), _) if *global >= check.subject.program.library_globals => {
            calls.push(*global);
        }
        _ => {}
    });
    again
        || calls.into_iter().any(|global| {
            let known = check.known(global).filter(|_| seen.insert(global));
            known.is_some_and(|known| deep(|| goes_on(check, &known.function.body, seen)))
        })
}

/// The body of a function of the text that a form calls, if it was not looked at before.
fn called<'c>(check: &'c Check<'_>, ir: &Ir, seen: &mut BTreeSet<u32>) -> Option<&'c Ir> {
    let IrKind::Call(Callee::Global(global), _) = ir.kind else { return None };
    let is_own = global >= check.subject.program.library_globals && seen.insert(global);
    check.known(global).filter(|_| is_own).map(|known| &*known.function.body)
}
