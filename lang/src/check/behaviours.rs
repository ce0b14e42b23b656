//! What belongs to a behaviour, a fluent of the robot or a class of failure.

use super::calls::unknown_keywords;
use super::kinds::{Found, found_in};
use super::known::Check;
use super::walk::each_form;
use crate::code::GlobalKind;
use crate::compile::ir::{Ir, IrKind};
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::suggest::suggest;
use crate::symbol::Symbol;
use std::collections::BTreeSet;

/// Slots that a misspelt one is compared with, at most.
const MOST_COMPARED: usize = 1_000;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let classes = check.subject.program.failure_classes.values();
    let slots: BTreeSet<Symbol> = classes.flat_map(|class| class.slots.iter().copied()).collect();
    for root in check.roots() {
        each_form(root, &mut |ir| look_at(check, ir, &slots, found));
    }
}

fn look_at(check: &Check<'_>, ir: &Ir, known_slots: &BTreeSet<Symbol>, found: &mut Vec<Diagnostic>) {
    let Some((name, [first, rest @ ..])) = check.native_call(ir) else { return };
    match name {
        "activate" => parameters(check, first, rest, ir.span, found),
        "pulse" | "%set-value" => robot_fluent(check, first, ir.span, found),
        "%setf-together" => {
            let fluents = std::iter::once(first).chain(rest.iter().skip(1).step_by(2));
            fluents.for_each(|fluent| robot_fluent(check, fluent, ir.span, found));
        }
        "%fail" => slots(check, first, rest, ir.span, found),
        "failure-slot" => asked_slot(check, rest, known_slots, found),
        _ => {}
    }
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
        let Some(slot) = check.keyword(&pair[0]).map(|slot| check.name(slot)) else {
            if found_in(check, &pair[0]) == Some(Found::Text) {
                let shown = check.shown(&pair[0]);
                let message = format!("a slot of a failure is a keyword with a value, and `{shown}` is a string");
                let warning = check.warning("wrong-kind", pair[0].span, message, "not a slot");
                found.push(warning.help("the message comes before the slots: `(fail CLASS \"message\" :slot VALUE)`"));
            }
            return;
        };
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

/// A slot that no class of failures has.
fn asked_slot(check: &Check<'_>, rest: &[Ir], known: &BTreeSet<Symbol>, found: &mut Vec<Diagnostic>) {
    let Some(asked) = rest.first() else { return };
    let Some(symbol) = check.quoted(asked).or_else(|| check.keyword(asked)).filter(|slot| !known.contains(slot)) else {
        return;
    };
    let slot = check.name(symbol);
    let message = format!("no class of failures has a slot `{slot}`: this is always nil");
    let warning = check.warning("unknown-slot", asked.span, message, "unknown slot");
    found.push(match suggest(slot, known.iter().take(MOST_COMPARED).map(|&slot| check.name(slot))) {
        Some(near) => warning.help(format!("did you mean `{near}`?")),
        None => warning.help("`rpl doc failures` has the classes and their slots"),
    });
}
