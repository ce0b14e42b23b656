//! Plans that have no value, as tests: whether one has succeeded is told by whether it fails.

use super::flow::Flow;
use super::known::Check;
use super::walk::{each_form, each_form_within};
use crate::code::CodeKind;
use crate::compile::ir::{BlockId, Callee, Ir, IrKind, Unary, VarId};
use crate::diagnostic::Diagnostic;
use crate::source::lies_in;
use crate::stack::deep;
use std::collections::BTreeMap;

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let mut values = Values { check, known: BTreeMap::new() };
    for root in check.roots() {
        each_form(root, &mut |ir| match &ir.kind {
            IrKind::If(test, ..) | IrKind::Unary(Unary::Not, test) => found.extend(values.tested(ir, test, FAILS)),
            IrKind::And(items) => {
                let tests = items.split_last().map_or(&[][..], |(_, tests)| tests);
                found.extend(tests.iter().find_map(|test| values.tested(ir, test, IN_ORDER)));
            }
            IrKind::Or(items) => {
                let tests = items.split_last().map_or(&[][..], |(_, tests)| tests);
                found.extend(tests.iter().find_map(|test| values.tested(ir, test, OTHERWISE)));
            }
            _ => {}
        });
    }
}

const FAILS: &str =
    "a plan that does not succeed fails: `(with-failure-handling ((plan-failure (f) FORM...)) FORM...)`";
const IN_ORDER: &str = "`(seq FORM...)` does one after the other, and goes no further when one fails";
const OTHERWISE: &str = "`(try-in-order FORM...)` goes on with the next one when one fails";

/// Which functions never have a value but nil.
struct Values<'c, 'a> {
    check: &'c Check<'a>,
    /// By global; none while that is being found out.
    known: BTreeMap<u32, Option<bool>>,
}

impl Values<'_, '_> {
    fn tested(&mut self, around: &Ir, test: &Ir, help: &str) -> Option<Diagnostic> {
        let IrKind::Call(Callee::Global(global), _) = test.kind else { return None };
        let function = self.check.known(global)?.function;
        // What a macro tests is its own business.
        let is_written = lies_in(test.span, around.span) && test.span != around.span && self.check.is_own(test.span);
        if function.kind != CodeKind::Plan || !is_written || !self.is_function_nil(global) {
            return None;
        }
        let name = self.check.global_name(global);
        let message = format!("`{name}` has no value: as a test it is always nil");
        Some(self.check.warning("no-value", test.span, message, "always nil").help(help))
    }

    /// Whether calls of a function come to an end, and only with nil.
    fn is_function_nil(&mut self, global: u32) -> bool {
        if let Some(known) = self.known.get(&global) {
            return known.unwrap_or(false);
        }
        let check = self.check;
        let Some(&(function, _)) = check.functions.get(&global) else { return false };
        self.known.insert(global, None);
        let is_nil = Flow::new(check).completes(&function.body) && self.is_nil(&function.body);
        self.known.insert(global, Some(is_nil));
        is_nil
    }

    /// Whether a form has no value but nil, if it has one at all.
    fn is_nil(&mut self, ir: &Ir) -> bool {
        deep(|| match &ir.kind {
            IrKind::Nil | IrKind::Loop(_) | IrKind::Refail(_) | IrKind::Leave(..) | IrKind::LeaveDynamic(..) => true,
            IrKind::Seq(items) | IrKind::And(items) => items.last().is_none_or(|last| self.is_nil(last)),
            IrKind::Or(items) => items.iter().all(|item| self.is_nil(item)),
            IrKind::If(_, then, otherwise) => self.is_nil(then) && self.is_nil(otherwise),
            IrKind::Let(_, body) | IrKind::Scope(_, body) | IrKind::Cleanup { body, .. } => self.is_nil(body),
            IrKind::Handler { body, clauses, .. } => {
                self.is_nil(body) && clauses.iter().all(|clause| self.is_nil(&clause.body))
            }
            IrKind::Block { id, token, body } => self.is_nil(body) && self.is_left_with_nil(*id, *token, body),
            IrKind::Construct(construct) if construct.policy().is_some() || construct.is_single() => {
                construct.children.last().is_some_and(|child| self.is_nil(&child.body.body))
            }
            IrKind::Call(Callee::Global(global), _) => self.is_function_nil(*global),
            IrKind::Call(Callee::Native(native), _) => self.check.subject.natives[usize::from(*native)].name == "%fail",
            _ => false,
        })
    }

    fn is_left_with_nil(&mut self, block: BlockId, token: Option<VarId>, body: &Ir) -> bool {
        let mut values = Vec::new();
        each_form_within(body, &mut |form| match &form.kind {
            IrKind::Leave(left, value) if *left == block => values.push(&**value),
            IrKind::LeaveDynamic(left, value) if Some(*left) == token => values.push(&**value),
            _ => {}
        });
        values.into_iter().all(|value| self.is_nil(value))
    }
}
