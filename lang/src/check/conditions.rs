//! Conditions that can never change.

use super::bindings::is_plain;
use super::known::Check;
use super::walk::each_form;
use crate::code::GlobalKind;
use crate::compile::ir::{Callee, Ir, IrKind};
use crate::diagnostic::Diagnostic;
use crate::source::lies_in;
use crate::stack::deep;
use std::collections::BTreeMap;

/// Natives that read no fluent and give none; the kinds of their arguments are their own business.
const STEADY: &[&str] = &[
    "+", "-", "*", "/", "<", "<=", ">", ">=", "=", "/=", "1+", "1-", "abs", "min", "max", "mod", "floor", "ceiling",
    "round", "truncate", "sqrt", "sin", "cos", "not", "null", "eq", "equal", "length", "numberp", "symbolp", "now",
];

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let globals = Globals::of(check);
    for root in check.roots() {
        each_form(root, &mut |ir| {
            let (IrKind::WaitFor { fluent, .. } | IrKind::Whenever { fluent, .. }) = &ir.kind else { return };
            let condition = match &fluent.kind {
                IrKind::Network(network) => &network.body,
                IrKind::Global(_) => fluent,
                _ => return,
            };
            let place = check.narrowed(ir.span, fluent);
            if lies_in(place, ir.span) && !globals.can_change(check, condition) {
                let asks_for_time = mentions_now(check, condition);
                let message = "this condition reads no fluent: a task that waits for it is never woken";
                let warning = check.warning("condition-never-changes", place, message, "never changes");
                found.push(warning.help(match asks_for_time {
                    true => "to wait for a time, write `(at-time SECONDS)` or `(wait-time SECONDS)`",
                    false => {
                        "hold what changes in a fluent: `(def-fluent NAME VALUE)`, assigned by `(setf (value NAME) …)`"
                    }
                }));
            }
        });
    }
}

fn mentions_now(check: &Check<'_>, ir: &Ir) -> bool {
    let mut found = false;
    super::walk::each_form_within(ir, &mut |form| {
        found |= check.native_call(form).is_some_and(|(name, _)| name == "now");
    });
    found
}

/// What is assigned to global variables, as far as the text shows.
struct Globals<'a> {
    assigned: BTreeMap<u32, Vec<&'a Ir>>,
}

impl<'a> Globals<'a> {
    fn of(check: &Check<'a>) -> Self {
        let mut assigned: BTreeMap<u32, Vec<&'a Ir>> = BTreeMap::new();
        for root in check.roots() {
            each_form(root, &mut |ir| {
                if let IrKind::SetGlobal(global, value) = &ir.kind {
                    assigned.entry(*global).or_default().push(value);
                }
            });
        }
        Self { assigned }
    }

    /// Whether the value can be another one later, or whether that cannot be seen.
    fn can_change(&self, check: &Check<'_>, ir: &Ir) -> bool {
        deep(|| match &ir.kind {
            IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_) => false,
            IrKind::Local(variable) => {
                !check.bindings().constant(*variable).is_some_and(|value| is_plain(check.bindings(), value))
            }
            IrKind::Global(global) => self.is_open(check, *global),
            IrKind::Unary(_, inner) => self.can_change(check, inner),
            IrKind::Binary(_, left, right) => self.can_change(check, left) || self.can_change(check, right),
            IrKind::If(condition, then, otherwise) => {
                [condition, then, otherwise].into_iter().any(|part| self.can_change(check, part))
            }
            IrKind::And(items) | IrKind::Or(items) | IrKind::Seq(items) => {
                items.iter().any(|item| self.can_change(check, item))
            }
            IrKind::Call(Callee::Native(_), arguments) => {
                let is_steady = check.native_call(ir).is_some_and(|(name, _)| STEADY.contains(&name));
                !is_steady || arguments.iter().any(|argument| self.can_change(check, argument))
            }
            _ => true,
        })
    }

    /// Whether the global may hold a fluent.
    fn is_open(&self, check: &Check<'_>, global: u32) -> bool {
        match check.kind(global) {
            GlobalKind::Variable | GlobalKind::Constant => match self.assigned.get(&global) {
                Some(values) => !values.iter().all(|value| is_plain(check.bindings(), value)),
                None => true,
            },
            GlobalKind::Function(_) => false,
            GlobalKind::Fluent | GlobalKind::Valve { .. } | GlobalKind::Behaviour(_) => true,
        }
    }
}
