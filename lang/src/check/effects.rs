//! What functions may do: wait, fail, act on the world. For networks, which may only look; for
//! loops and policies, which must wait.

use super::flow::Flow;
use super::known::{Check, Effects};
use super::walk::{FormPart, each_form, parts};
use crate::code::{CodeKind, GlobalKind};
use crate::compile::ir::{Callee, Function, Ir, IrKind, ParameterBinding};
use crate::diagnostic::Diagnostic;
use crate::source::{Span, lies_in};
use crate::stack::deep;
use std::collections::BTreeSet;
use std::rc::Rc;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let mut policies = Vec::new();
    for root in check.roots() {
        each_form(root, &mut |ir| match &ir.kind {
            IrKind::Network(network) => network_effects(check, network, found),
            IrKind::Construct(construct) => {
                if let Some(policy) = construct.policy()
                    && let Some(warning) = policy_never_waits(check, &policy.body)
                {
                    policies.push(policy.body.span);
                    found.push(warning);
                }
            }
            _ => {}
        });
    }
    let mut loops = Vec::new();
    for root in check.roots() {
        each_form(root, &mut |ir| loops.extend(is_endless(check, ir).then_some(ir.span)));
    }
    found.extend(check.own_functions().filter_map(|(global, function)| endless_recursion(check, global, function)));
    // A loop around an endless one has no fault of its own, nor has one the policy is told for.
    let is_outer = |span: Span| loops.iter().any(|&inner| inner != span && lies_in(inner, span));
    let is_told = |span: Span| policies.iter().any(|&policy| lies_in(span, policy));
    found
        .extend(loops.iter().filter(|&&span| !is_outer(span) && !is_told(span)).map(|&span| endless_loop(check, span)));
}

/// Calls in a network of functions that do what a network may not.
fn network_effects(check: &Check<'_>, network: &Function, found: &mut Vec<Diagnostic>) {
    each_form(network, &mut |ir| {
        let IrKind::Call(Callee::Global(global), _) = ir.kind else { return };
        let Some((place, what)) = first_act(check, global) else { return };
        let name = check.global_name(global);
        let message = format!("`{name}` cannot be called in a fluent network: it {what}");
        let warning = check
            .warning("network-effect", ir.span, message, "a network may only look")
            .help("do it in the body, after the condition");
        found.push(match check.is_own(place) {
            true => warning.related(super::places::brief(&check.subject.program.sources, place), "here"),
            false => warning,
        });
    });
}

/// What the function, or one it calls, does that a network may not.
fn first_act(check: &Check<'_>, global: u32) -> Option<(Span, &'static str)> {
    let mut found = None;
    visit(check, vec![global], &mut |function, effects| {
        let plan = (function.kind == CodeKind::Plan).then_some((function.span, "is a plan"));
        found = plan.or(effects.acts);
        found.is_none()
    });
    found
}

/// Shows functions and all they call, until `go_on` says no.
fn visit<'a>(check: &Check<'a>, mut waiting: Vec<u32>, go_on: &mut dyn FnMut(&'a Function, &Effects) -> bool) {
    let mut seen = BTreeSet::new();
    waiting.reverse();
    while let Some(global) = waiting.pop() {
        let Some(&(function, _)) = check.functions.get(&global) else { continue };
        if !seen.insert(global) {
            continue;
        }
        let effects = effects_of(check, global, function);
        if !go_on(function, &effects) {
            return;
        }
        waiting.extend(effects.calls.iter().rev());
    }
}

fn effects_of(check: &Check<'_>, global: u32, function: &Function) -> Rc<Effects> {
    if let Some(known) = check.effects.borrow().get(&global) {
        return known.clone();
    }
    let mut effects = Effects::default();
    let bindings = check.known(global).map(|known| known.bindings);
    let mut collector = Collector { check, bindings, effects: &mut effects };
    collector.form(&function.body, true);
    function.bindings.iter().flat_map(ParameterBinding::evaluated).for_each(|ir| collector.form(ir, true));
    let effects = Rc::new(effects);
    check.effects.borrow_mut().insert(global, effects.clone());
    effects
}

struct Collector<'c, 'a> {
    check: &'c Check<'a>,
    bindings: Option<&'c super::bindings::Bindings<'a>>,
    effects: &'c mut Effects,
}

impl Collector<'_, '_> {
    /// `runs`: whether the form runs when the function is called, as far as can be seen.
    fn form(&mut self, ir: &Ir, runs: bool) {
        deep(|| self.form_here(ir, runs));
    }

    fn form_here(&mut self, ir: &Ir, runs: bool) {
        match &ir.kind {
            IrKind::Call(callee, arguments) => self.call(ir.span, callee, arguments, runs),
            IrKind::Lambda(function) => return self.form(&function.body, false),
            IrKind::Network(_) => return,
            IrKind::Refail(_) | IrKind::LeaveDynamic(..) => self.effects.fails = true,
            IrKind::SetGlobal(..) | IrKind::DefFluent(..) => self.act(ir.span, "assigns a variable", runs),
            IrKind::Construct(_) | IrKind::ConstructMap(..) | IrKind::Spawn(_) => {
                // The tasks may wait, and this one waits for them.
                self.effects.waits = true;
                self.act(ir.span, "starts tasks", runs);
            }
            IrKind::Scope(..) => {
                self.effects.waits = true;
                self.act(ir.span, "takes a valve or suspends a task", runs);
            }
            IrKind::WaitFor { .. } | IrKind::Whenever { .. } => {
                self.effects.waits = true;
                self.act(ir.span, "waits", runs);
            }
            _ => {}
        }
        parts(ir, &mut |part| match part {
            FormPart::Form(form) => self.form(form, runs),
            FormPart::Function(function) => self.form(&function.body, runs),
        });
    }

    fn act(&mut self, span: Span, what: &'static str, runs: bool) {
        if runs && self.effects.acts.is_none() {
            self.effects.acts = Some((span, what));
        }
    }

    fn call(&mut self, span: Span, callee: &Callee, arguments: &[Ir], runs: bool) {
        match callee {
            Callee::Global(global) => match self.check.kind(*global) {
                GlobalKind::Function(_) if runs => self.effects.calls.push(*global),
                // Closures may be called at any time, by anybody.
                _ => self.effects.waits = true,
            },
            Callee::Native(native) => {
                let signature = &self.check.subject.natives[usize::from(*native)];
                self.effects.waits |= signature.waits || signature.calls;
                self.effects.fails |= matches!(signature.name.as_str(), "%fail" | "fail-composite");
                if signature.effect {
                    self.act(span, if signature.waits { "waits" } else { "assigns or acts" }, runs);
                }
            }
            Callee::Value(value) => {
                let is_seen = match &value.kind {
                    IrKind::Lambda(_) => true,
                    IrKind::Local(variable) => {
                        self.bindings.is_some_and(|bindings| bindings.function(*variable).is_some())
                    }
                    _ => false,
                };
                self.effects.waits |= !is_seen;
            }
        }
        for argument in arguments {
            match &argument.kind {
                IrKind::Lambda(function) => self.form(&function.body, runs),
                IrKind::Global(global) if matches!(self.check.kind(*global), GlobalKind::Function(_)) => {
                    self.effects.calls.push(*global);
                }
                _ => {}
            }
        }
    }
}

/// Whether a form may wait or fail, itself or in what it calls.
fn may_wait_or_fail(check: &Check<'_>, ir: &Ir) -> bool {
    let mut effects = Effects::default();
    Collector { check, bindings: Some(check.bindings()), effects: &mut effects }.form(ir, true);
    if effects.waits || effects.fails {
        return true;
    }
    let mut waits = false;
    visit(check, effects.calls, &mut |_, effects| {
        waits |= effects.waits || effects.fails;
        !waits
    });
    waits
}

pub(super) fn policy_never_waits(check: &Check<'_>, policy: &Function) -> Option<Diagnostic> {
    if matches!(policy.body.kind, IrKind::Nil) || may_wait_or_fail(check, &policy.body) {
        return None;
    }
    let (message, label) = match Flow::new(check).completes(&policy.body) {
        true => ("this policy never waits, so it is over before the body begins", "keeps nothing"),
        false => ("this policy never waits, so the body never begins", "runs for ever"),
    };
    Some(
        check
            .warning("policy-never-waits", policy.span, message, label)
            .help("a policy waits for what it reacts to: `(whenever CONDITION …)`"),
    )
}

fn is_endless(check: &Check<'_>, ir: &Ir) -> bool {
    let IrKind::Loop(body) = &ir.kind else { return false };
    let mut flow = Flow::new(check);
    flow.completes(body);
    !flow.leaves() && !may_wait_or_fail(check, body)
}

fn endless_loop(check: &Check<'_>, span: Span) -> Diagnostic {
    check
        .warning("endless-loop", span, "this loop never waits and never ends", "runs until it fails with `runaway`")
        .help("wait in it (`wait-for`, `wait-time`), or leave it (`until`, `while`, `return`)")
}

/// A function that comes to an end only by calls of itself, and waits for nothing.
fn endless_recursion(check: &Check<'_>, global: u32, function: &Function) -> Option<Diagnostic> {
    let ends_alone = Flow::without(check, global).completes(&function.body);
    if ends_alone || !Flow::new(check).completes(&function.body) || may_wait_or_fail(check, &function.body) {
        return None;
    }
    let message = format!("`{}` always calls itself, and never waits", check.global_name(global));
    let warning = check.warning("endless-loop", function.span, message, "runs until it fails with `runaway`");
    Some(warning.help("one way through it has to end without a call of it: `(if TEST VALUE (…))`"))
}
