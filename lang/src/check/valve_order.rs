//! Valves that concurrent parts take in opposite orders, and behaviours that drive without theirs.

use super::known::{Check, KnownFunction};
use super::places;
use super::valves::{SeenValve, Summaries, ValveConflict, ValveNeed, ValveRequest, summarize, summarize_forms};
use super::walk::each_form;
use crate::compile::resolved::Defined;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use std::collections::BTreeSet;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let mut summaries = Summaries::default();
    let mut conflicts = Vec::new();
    for definition in &check.subject.text.definitions {
        if let Defined::Function(_, function) = &definition.defined {
            summarize(check, &mut summaries, KnownFunction { function, bindings: check.bindings() }, &mut conflicts);
        }
    }
    let main = summarize_forms(check, &mut summaries, &check.subject.text.forms, &mut conflicts);
    let mut told = BTreeSet::new();
    for conflict in conflicts {
        let key = (conflict.first.valve, conflict.second.valve);
        let places = (conflict.first.span.min(conflict.second.span), conflict.first.span.max(conflict.second.span));
        if told.insert((key.0.min(key.1), key.0.max(key.1), places)) {
            found.push(opposite_orders(check, &conflict));
        }
    }
    if !requests_by_hand(check) {
        found.extend(main.needs.iter().map(|need| needs_valve(check, need)));
    }
}

/// Whether the text asks for valves by a call, so that what it holds where is not visible.
pub(super) fn requests_by_hand(check: &Check<'_>) -> bool {
    let mut found = false;
    for root in check.roots() {
        each_form(root, &mut |ir| {
            found |= check.native_call(ir).is_some_and(|(name, _)| name == "request-valve");
        });
    }
    found
}

fn opposite_orders(check: &Check<'_>, conflict: &ValveConflict) -> Diagnostic {
    let (early, late) = match conflict.first.span <= conflict.second.span {
        true => (&conflict.first, &conflict.second),
        false => (&conflict.second, &conflict.first),
    };
    let (mine, theirs) = (valve_name(check, late.valve), valve_name(check, early.valve));
    let message = format!(
        "`{mine}` and `{theirs}` are taken in opposite orders by parts that run side by side, so each may wait for the other"
    );
    // Where one function is called twice, the calls tell the parts apart.
    let (place, other) = match (own_place(check, late), own_place(check, early)) {
        (place, other) if place == other => (late.span, early.span),
        places => places,
    };
    let mut warning = check
        .warning("valve-order", place, message, format!("wants `{mine}` and has `{theirs}`"))
        .help("take them in one order everywhere, or guard both with a third valve");
    if other != place {
        warning = warning.related(
            places::brief(&check.subject.program.sources, other),
            format!("wants `{theirs}` and has `{mine}`"),
        );
    }
    warning
}

/// The place of the request itself if it is in the text, else of the call that leads there.
fn own_place(check: &Check<'_>, request: &ValveRequest) -> Span {
    request.within.filter(|&within| check.is_own(within)).unwrap_or(request.span)
}

fn valve_name(check: &Check<'_>, valve: SeenValve) -> String {
    match valve {
        SeenValve::Global(global) => check.global_name(global).to_string(),
        SeenValve::Parameter(position) => format!("argument {}", position + 1),
    }
}

fn needs_valve(check: &Check<'_>, need: &ValveNeed) -> Diagnostic {
    let (behaviour, valve) = (check.global_name(need.behaviour), check.global_name(need.valve));
    let message = format!("`{behaviour}` drives with the valve `{valve}`, which nothing holds here");
    let place = need.within.filter(|&within| check.is_own(within)).unwrap_or(need.span);
    let warning = check
        .warning("needs-valve", place, message, format!("fails without `{valve}`"))
        .help(format!("wrap it: `(with-valve {valve} …)`"));
    match place == need.span {
        true => warning,
        false => warning.related(places::brief(&check.subject.program.sources, need.span), "called here"),
    }
}
