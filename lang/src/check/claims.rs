//! Fluents that are waited for and then counted down by hand: `(wait-for (> free 0)) (decf (value free))`.
//! All tasks that wait there go on at once, each before another has taken.

use super::known::Check;
use super::places::brief;
use super::valve_order::requests_by_hand;
use super::walk::{FormPart, each_form, each_form_within, parts};
use crate::code::GlobalKind;
use crate::compile::ir::{Callee, ConstructIr, Function, Ir, IrKind, ScopeIr, VarId};
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
    for (root, function) in check.roots().enumerate() {
        let mut search = Search::new(check, root);
        search.form(&function.body);
        for claim in search.finish() {
            let condition = check.subject.program.sources.text_of(claim.condition.span);
            claims.entry((claim.fluent, condition)).or_default().push(claim);
        }
    }
    if claims.is_empty() {
        return;
    }
    let calls = Calls::new(check);
    for claims in claims.values().take(MAX_CONDITIONS) {
        if are_made_side_by_side(check, &calls, claims) {
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
    /// In which of the text's functions.
    root: usize,
    wait: &'i Ir,
    condition: &'i Ir,
    take: Span,
}

/// Where a fluent was waited for on the way to a form.
#[derive(Clone, Copy)]
struct Waited<'i> {
    wait: &'i Ir,
    condition: &'i Ir,
}

/// Where fluents were waited for last, and what was known of them before: a branch is left as it was entered, at the
/// cost of what has changed in it.
#[derive(Default)]
struct Waits<'i> {
    last: BTreeMap<u32, Waited<'i>>,
    changes: Vec<(u32, Option<Waited<'i>>)>,
}

impl<'i> Waits<'i> {
    fn insert(&mut self, fluent: u32, waited: Waited<'i>) {
        let before = self.last.insert(fluent, waited);
        self.changes.push((fluent, before));
    }

    fn remove(&mut self, fluent: u32) -> Option<Waited<'i>> {
        let before = self.last.remove(&fluent)?;
        self.changes.push((fluent, Some(before)));
        Some(before)
    }

    fn go_back_to(&mut self, changes: usize) {
        for (fluent, before) in self.changes.drain(changes..).rev() {
            match before {
                Some(before) => self.last.insert(fluent, before),
                None => self.last.remove(&fluent),
            };
        }
    }
}

/// A walk through one function, in the order of evaluation.
struct Search<'c, 'a, 'i> {
    check: &'c Check<'a>,
    root: usize,
    waited: Waits<'i>,
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
    fn new(check: &'c Check<'a>, root: usize) -> Self {
        Self {
            check,
            root,
            waited: Waits::default(),
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
                for read in self.fluents_in(fluent) {
                    self.waited.insert(read, Waited { wait: ir, condition: fluent });
                }
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
                let before = self.waited.changes.len();
                for asked in self.values_in(condition) {
                    self.waited.remove(asked);
                }
                let kept = self.waited.changes.len();
                for branch in [then, otherwise] {
                    self.form(branch);
                    self.waited.go_back_to(kept);
                }
                self.waited.go_back_to(before);
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
        let before = self.waited.changes.len();
        self.form(ir);
        self.waited.go_back_to(before);
    }

    fn assignment(&mut self, ir: &'i Ir) {
        let Some(("%set-value", [target, value])) = self.check.native_call(ir) else { return };
        let Some(fluent) = fluent(self.check, target) else { return };
        let is_constant = matches!(value.kind, IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_));
        if is_constant {
            let assigned = if matches!(value.kind, IrKind::Nil) { &mut self.emptied } else { &mut self.filled };
            assigned.insert(fluent);
        }
        let Some(Waited { wait, condition }) = self.waited.remove(fluent) else { return };
        let claim = Claim { fluent, root: self.root, wait, condition, take: ir.span };
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

/// Who calls whom in a text.
struct Calls<'a> {
    /// The functions of the text; their numbers as globals, if they have any.
    roots: Vec<(Option<u32>, &'a Function)>,
    /// Functions that call a function, by its number, where no valve is held.
    callers: BTreeMap<u32, Vec<u32>>,
    /// Where a function is called, by its number, valves or not: places in `roots`.
    called_in: BTreeMap<u32, BTreeSet<usize>>,
}

impl<'a> Calls<'a> {
    fn new(check: &Check<'a>) -> Self {
        let definitions = check.subject.text.definitions.iter();
        let numbers: BTreeMap<*const Function, u32> = definitions
            .filter_map(|definition| match &definition.defined {
                Defined::Function(global, function) => Some((std::ptr::from_ref(function), *global)),
                Defined::Macro(_) | Defined::Value | Defined::Failure => None,
            })
            .collect();
        let numbered = |function: &'a Function| (numbers.get(&std::ptr::from_ref(function)).copied(), function);
        let roots: Vec<_> = check.roots().map(numbered).collect();
        let (mut callers, mut called_in) = (BTreeMap::<u32, Vec<u32>>::new(), BTreeMap::<u32, BTreeSet<usize>>::new());
        for (root, &(number, function)) in roots.iter().enumerate() {
            each_form(function, &mut |ir| {
                if let IrKind::Call(Callee::Global(called), _) = ir.kind {
                    called_in.entry(called).or_default().insert(root);
                }
            });
            if let Some(number) = number {
                unguarded(check, &function.body, &mut |ir| {
                    if let IrKind::Call(Callee::Global(called), _) = ir.kind {
                        callers.entry(called).or_default().push(number);
                    }
                });
            }
        }
        Self { roots, callers, called_in }
    }

    /// Functions that lead to a wait: those with one, those that call them, and so on.
    fn leading(&self, check: &Check<'_>, claims: &[Claim<'_>], waits: &BTreeSet<*const Ir>) -> BTreeSet<u32> {
        let (mut leading, mut open) = (BTreeSet::new(), Vec::new());
        let roots: BTreeSet<usize> = claims.iter().map(|claim| claim.root).collect();
        for (number, function) in roots.into_iter().map(|root| self.roots[root]) {
            unguarded(check, &function.body, &mut |ir| {
                if waits.contains(&std::ptr::from_ref(ir)) {
                    open.extend(number);
                }
            });
        }
        while let Some(number) = open.pop() {
            if leading.insert(number) {
                open.extend(self.callers.get(&number).into_iter().flatten());
            }
        }
        leading
    }
}

/// Whether two tasks may wait at these places at once, as far as can be seen, where no valve keeps
/// them apart. Cost: the functions in which somebody comes to one of them.
fn are_made_side_by_side(check: &Check<'_>, calls: &Calls<'_>, claims: &[Claim<'_>]) -> bool {
    let waits: BTreeSet<*const Ir> = claims.iter().map(|claim| std::ptr::from_ref(claim.wait)).collect();
    let leading = calls.leading(check, claims, &waits);
    let others = leading.iter().filter_map(|number| calls.called_in.get(number)).flatten();
    let roots: BTreeSet<usize> = claims.iter().map(|claim| claim.root).chain(others.copied()).collect();
    let mut tasks = Tasks { check, waits, leading, side_by_side: false };
    roots.into_iter().any(|root| {
        tasks.form(&calls.roots[root].1.body);
        tasks.side_by_side
    })
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
