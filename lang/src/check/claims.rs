//! Fluents that are waited for and then counted down by hand: `(wait-for (> free 0)) (decf (value free))`.
//! All tasks that wait there go on at once, each before another has taken.

use super::known::Check;
use super::places::brief;
use super::valve_order::requests_by_hand;
use super::walk::{FormPart, each_form_within, parts};
use crate::code::GlobalKind;
use crate::compile::ir::{Callee, ConstructIr, Ir, IrKind, ScopeIr, VarId};
use crate::compile::resolved::Defined;
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::stack::deep;
use std::collections::{BTreeMap, BTreeSet};

/// More conditions than this are not followed: each is looked for in the whole text.
const MAX_CONDITIONS: usize = 64;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    if requests_by_hand(check) {
        return;
    }
    let mut claims: BTreeMap<(u32, &str), Vec<Claim<'_>>> = BTreeMap::new();
    for root in check.roots() {
        let mut search = Search::new(check);
        search.form(&root.body);
        for claim in search.finish() {
            let condition = check.subject.program.sources.text_of(claim.condition.span);
            claims.entry((claim.fluent, condition)).or_default().push(claim);
        }
    }
    for claims in claims.values().take(MAX_CONDITIONS) {
        if are_made_side_by_side(check, claims) {
            found.extend(claims.iter().map(|claim| warning(check, claim)));
        }
    }
}

fn warning(check: &Check<'_>, claim: &Claim<'_>) -> Diagnostic {
    let name = check.global_name(claim.fluent);
    let message = format!("tasks that wait for `{name}` here go on together, before one of them changes it");
    let wait = brief(&check.subject.program.sources, claim.wait.span);
    check
        .warning("wait-then-take", claim.take, message, "changed too late for the others")
        .related(wait, "several tasks can wait here")
        .help("let one task at a time wait and take: `(with-valve NAME (wait-for …) …)`, with a `(def-valve NAME)`")
}

/// A fluent that is waited for and then changed by hand.
#[derive(Clone, Copy)]
struct Claim<'i> {
    fluent: u32,
    wait: &'i Ir,
    condition: &'i Ir,
    take: Span,
}

/// A fluent that was waited for on the way to a form.
#[derive(Clone, Copy)]
struct Waited<'i> {
    fluent: u32,
    wait: &'i Ir,
    condition: &'i Ir,
}

/// A walk through one function, in the order of evaluation.
struct Search<'c, 'a, 'i> {
    check: &'c Check<'a>,
    waited: Vec<Waited<'i>>,
    /// Variables that hold the value of a fluent.
    values: BTreeMap<VarId, u32>,
    found: Vec<Claim<'i>>,
    /// Claims that are a lock if the fluent is given another value elsewhere.
    locks: Vec<Claim<'i>>,
    /// Fluents that are assigned nil, and those that are assigned something else.
    emptied: BTreeSet<u32>,
    filled: BTreeSet<u32>,
}

impl<'c, 'a, 'i> Search<'c, 'a, 'i> {
    fn new(check: &'c Check<'a>) -> Self {
        Self {
            check,
            waited: Vec::new(),
            values: BTreeMap::new(),
            found: Vec::new(),
            locks: Vec::new(),
            emptied: BTreeSet::new(),
            filled: BTreeSet::new(),
        }
    }

    fn finish(mut self) -> Vec<Claim<'i>> {
        let both: BTreeSet<u32> = self.emptied.intersection(&self.filled).copied().collect();
        self.found.extend(self.locks.into_iter().filter(|claim| both.contains(&claim.fluent)));
        self.found
    }

    fn form(&mut self, ir: &'i Ir) {
        deep(|| self.form_here(ir));
    }

    fn form_here(&mut self, ir: &'i Ir) {
        match &ir.kind {
            IrKind::WaitFor { fluent, .. } => {
                let read = self.fluents_in(fluent);
                self.waited.extend(read.into_iter().map(|name| Waited { fluent: name, wait: ir, condition: fluent }));
            }
            IrKind::Let(bound, body) => {
                for (variable, value) in bound {
                    self.form(value);
                    let fluent = value_of(self.check, value);
                    self.values.extend(fluent.map(|fluent| (*variable, fluent)));
                }
                self.form(body);
            }
            // Who asks once more takes nothing that is not there.
            IrKind::If(condition, then, otherwise) => {
                self.form(condition);
                let waited = self.waited.clone();
                let asked = self.values_in(condition);
                self.waited.retain(|waited| !asked.contains(&waited.fluent));
                let kept = self.waited.clone();
                for branch in [then, otherwise] {
                    self.form(branch);
                    self.waited.clone_from(&kept);
                }
                self.waited = waited;
            }
            // What stands in a loop may never run, and a function runs at other times.
            IrKind::Loop(body) => self.apart(body),
            IrKind::Call(..) => {
                self.parts(ir);
                self.assignment(ir);
            }
            _ => self.parts(ir),
        }
    }

    fn parts(&mut self, ir: &'i Ir) {
        parts(ir, &mut |part| match part {
            FormPart::Form(form) => self.form(form),
            FormPart::Function(function) => self.apart(&function.body),
        });
    }

    fn apart(&mut self, ir: &'i Ir) {
        let waited = self.waited.clone();
        self.form(ir);
        self.waited = waited;
    }

    fn assignment(&mut self, ir: &'i Ir) {
        let Some(("%set-value", [target, value])) = self.check.native_call(ir) else { return };
        let Some(fluent) = fluent(self.check, target) else { return };
        let is_constant = matches!(value.kind, IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_));
        if is_constant {
            let assigned = if matches!(value.kind, IrKind::Nil) { &mut self.emptied } else { &mut self.filled };
            assigned.insert(fluent);
        }
        let Some(at) = self.waited.iter().rposition(|waited| waited.fluent == fluent) else { return };
        let Waited { wait, condition, .. } = self.waited[at];
        self.waited.retain(|waited| waited.fluent != fluent);
        let claim = Claim { fluent, wait, condition, take: ir.span };
        if is_constant {
            self.locks.push(claim);
        } else if self.values_in(value).contains(&fluent) {
            self.found.push(claim);
        }
    }

    /// Fluents of the text that a condition reads.
    fn fluents_in(&self, condition: &Ir) -> BTreeSet<u32> {
        let mut read = BTreeSet::new();
        each_form_within(condition, &mut |form| read.extend(fluent(self.check, form)));
        read
    }

    /// Fluents whose values a form is computed from.
    fn values_in(&self, ir: &Ir) -> BTreeSet<u32> {
        let mut read = BTreeSet::new();
        each_form_within(ir, &mut |form| {
            read.extend(value_of(self.check, form));
            if let IrKind::Local(variable) = form.kind {
                read.extend(self.values.get(&variable));
            }
        });
        read
    }
}

fn fluent(check: &Check<'_>, ir: &Ir) -> Option<u32> {
    match ir.kind {
        IrKind::Global(global) if *check.kind(global) == GlobalKind::Fluent => Some(global),
        _ => None,
    }
}

fn value_of(check: &Check<'_>, ir: &Ir) -> Option<u32> {
    match check.native_call(ir) {
        Some(("value", [of])) => fluent(check, of),
        _ => None,
    }
}

/// Whether two tasks may wait at these places at once, as far as can be seen, where no valve keeps
/// them apart.
fn are_made_side_by_side(check: &Check<'_>, claims: &[Claim<'_>]) -> bool {
    let waits = claims.iter().map(|claim| std::ptr::from_ref(claim.wait)).collect();
    let mut tasks = Tasks { check, waits, leading: BTreeSet::new(), side_by_side: false };
    tasks.find_leading();
    for root in check.roots() {
        tasks.form(&root.body);
    }
    tasks.side_by_side
}

struct Tasks<'c, 'a> {
    check: &'c Check<'a>,
    waits: BTreeSet<*const Ir>,
    /// Functions that lead to a wait.
    leading: BTreeSet<u32>,
    side_by_side: bool,
}

/// Who comes to a wait: the task that runs a form, or tasks that it leaves behind.
#[derive(Clone, Copy, Default)]
struct Comes {
    itself: bool,
    spawned: bool,
}

impl Tasks<'_, '_> {
    /// From the functions with a wait to those that call them, and so on.
    fn find_leading(&mut self) {
        let mut callers: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        let mut open = Vec::new();
        for definition in &self.check.subject.text.definitions {
            let Defined::Function(global, function) = &definition.defined else { continue };
            unguarded(self.check, &function.body, &mut |ir| match &ir.kind {
                IrKind::Call(Callee::Global(called), _) => callers.entry(*called).or_default().push(*global),
                _ if self.waits.contains(&std::ptr::from_ref(ir)) => open.push(*global),
                _ => {}
            });
        }
        while let Some(global) = open.pop() {
            if self.leading.insert(global) {
                open.extend(callers.get(&global).into_iter().flatten());
            }
        }
    }

    fn form(&mut self, ir: &Ir) -> Comes {
        deep(|| self.form_here(ir))
    }

    fn form_here(&mut self, ir: &Ir) -> Comes {
        match &ir.kind {
            IrKind::Scope(ScopeIr::Valve { valve, .. }, body) if keeps_apart(self.check, valve) => {
                // What it starts is looked at by itself.
                self.form(body);
                Comes::default()
            }
            IrKind::Construct(construct) => {
                let coming = self.children(construct);
                self.side_by_side |= coming > 1 && construct.order.is_empty();
                Comes { itself: coming > 0, spawned: false }
            }
            IrKind::ConstructMap(construct, list) => {
                self.form(list);
                let coming = self.children(construct);
                self.side_by_side |= coming > 0;
                Comes { itself: coming > 0, spawned: false }
            }
            IrKind::Spawn(construct) => Comes { itself: false, spawned: self.children(construct) > 0 },
            IrKind::Loop(body) => {
                let comes = self.form(body);
                self.side_by_side |= comes.spawned;
                comes
            }
            IrKind::If(condition, then, otherwise) => {
                let before = self.form(condition);
                let branches = [self.form(then), self.form(otherwise)];
                let branch = branches.into_iter().fold(Comes::default(), either);
                self.after(before, branch)
            }
            kind => {
                let is_wait = self.waits.contains(&std::ptr::from_ref(ir));
                let is_call = matches!(kind, IrKind::Call(Callee::Global(called), _) if self.leading.contains(called));
                let mut comes = Comes::default();
                parts(ir, &mut |part| {
                    let next = match part {
                        FormPart::Form(form) => self.form(form),
                        FormPart::Function(function) => self.form(&function.body),
                    };
                    comes = self.after(comes, next);
                });
                self.after(comes, Comes { itself: is_wait || is_call, spawned: false })
            }
        }
    }

    /// What comes of two forms that run one after the other.
    fn after(&mut self, before: Comes, next: Comes) -> Comes {
        self.side_by_side |= before.spawned && (next.spawned || next.itself);
        either(before, next)
    }

    /// How many of the children come to a wait.
    fn children(&mut self, construct: &ConstructIr) -> usize {
        construct.children.iter().filter(|child| self.form(&child.body.body).itself).count()
    }
}

fn either(one: Comes, other: Comes) -> Comes {
    Comes { itself: one.itself || other.itself, spawned: one.spawned || other.spawned }
}

/// Whether only one task at a time can have a valve, as far as can be seen.
fn keeps_apart(check: &Check<'_>, valve: &Ir) -> bool {
    match valve.kind {
        IrKind::Global(global) => !matches!(check.kind(global), GlobalKind::Valve { places: 2.. }),
        _ => true,
    }
}

/// Shows every form that is not held apart by a valve, itself first.
fn unguarded<'i>(check: &Check<'_>, ir: &'i Ir, see: &mut dyn FnMut(&'i Ir)) {
    deep(|| {
        if matches!(&ir.kind, IrKind::Scope(ScopeIr::Valve { valve, .. }, _) if keeps_apart(check, valve)) {
            return;
        }
        see(ir);
        parts(ir, &mut |part| match part {
            FormPart::Form(form) => unguarded(check, form, see),
            FormPart::Function(function) => unguarded(check, &function.body, see),
        });
    });
}
