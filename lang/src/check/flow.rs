//! Which forms come to an end by themselves, and what therefore never runs.

use super::known::Check;
use super::walk::{FormPart, parts};
use crate::code::{Failures, Quorum, Successes};
use crate::compile::ir::{BlockId, Callee, ChildIr, ClauseIr, Ir, IrKind, VarId};
use crate::diagnostic::Diagnostic;
use crate::source::{Span, lies_in};
use crate::stack::deep;
use std::collections::{BTreeMap, BTreeSet};

pub(super) fn find(check: &Check<'_>, found: &mut Vec<Diagnostic>) {
    let mut flow = Flow::new(check);
    let mut before: Option<&Ir> = None;
    for root in check.roots() {
        flow.completes(&root.body);
    }
    for form in &check.subject.text.forms {
        if let Some(ended) = before {
            flow.unreachable.push((ended, &form.body));
            break;
        }
        before = (!flow.completes(&form.body)).then_some(&*form.body);
    }
    let unreachable = std::mem::take(&mut flow.unreachable);
    found.extend(unreachable.into_iter().filter_map(|(ended, next)| unreachable_code(check, ended, next)));
    let beside = std::mem::take(&mut flow.beside);
    found.extend(beside.into_iter().map(|(all, reaction)| never_ends(check, all, reaction)));
    let covered = std::mem::take(&mut flow.covered);
    found.extend(covered.into_iter().map(|(class, by, clause)| unreachable_clause(check, class, by, clause)));
}

fn unreachable_code(check: &Check<'_>, ended: &Ir, next: &Ir) -> Option<Diagnostic> {
    // What a macro adds stands at the macro's call, not behind the form.
    if next.span.source != ended.span.source || next.span.start < ended.span.end {
        return None;
    }
    let reason = match &ended.kind {
        IrKind::Loop(_) => "this loop never ends",
        IrKind::Whenever { .. } => "this ends only by `(return)`",
        IrKind::Leave(..) | IrKind::LeaveDynamic(..) => "this leaves",
        IrKind::Refail(_) => "this fails",
        IrKind::Call(Callee::Native(_), _) => "this fails",
        _ => "this never comes to an end by itself",
    };
    let reason_place = super::places::brief(&check.subject.program.sources, ended.span);
    Some(
        check
            .warning("unreachable-code", next.span, "this is never reached", "never runs")
            .related(reason_place, reason),
    )
}

/// A reaction beside work that ends, in a form that waits for both.
fn never_ends(check: &Check<'_>, all: &Ir, reaction: &Ir) -> Diagnostic {
    let IrKind::Construct(construct) = &all.kind else { unreachable!("only constructs are noted") };
    let name = check.name(construct.name);
    let message = format!("this `{name}` never ends: it waits for all its parts, and `whenever` goes on for ever");
    let warning = check.warning("never-ends", reaction.span, message, "goes on for ever");
    let around = super::places::brief(&check.subject.program.sources, all.span);
    warning.related(around, "waits for all parts").help(
        "to react for as long as something else is done, write `(with-policy (whenever CONDITION FORM...) FORM...)`",
    )
}

fn unreachable_clause(check: &Check<'_>, class: &str, by: (&str, Span), clause: Span) -> Diagnostic {
    let message = match class == by.0 {
        true => format!("this clause is never chosen: `{class}` is handled above"),
        false => format!("this clause is never chosen: `{}`, handled above, takes every `{class}`", by.0),
    };
    check
        .warning("unreachable-clause", clause, message, "never chosen")
        .related(super::places::brief(&check.subject.program.sources, by.1), "handled here")
        .help("put the narrower class first")
}

/// A walk in the order of evaluation.
pub(super) struct Flow<'c, 'a> {
    check: &'c Check<'a>,
    /// Blocks a form that is reached leaves.
    reached: BTreeSet<BlockId>,
    /// Blocks that were looked at.
    entered: BTreeSet<BlockId>,
    /// Blocks that are left from inside closures.
    tokens: BTreeMap<VarId, BlockId>,
    /// Forms that never come to an end, each with the one behind it.
    unreachable: Vec<(&'c Ir, &'c Ir)>,
    /// Clauses no failure comes to: class, what takes it and where, place.
    covered: Vec<(&'a str, (&'a str, Span), Span)>,
    /// Forms that wait for all their parts, one of which is a reaction and another ends: the form, the reaction.
    beside: Vec<(&'c Ir, &'c Ir)>,
    /// A function whose calls are taken not to come to an end.
    without: Option<u32>,
}

impl<'c, 'a> Flow<'c, 'a> {
    pub(super) fn new(check: &'c Check<'a>) -> Self {
        Self {
            check,
            reached: BTreeSet::new(),
            entered: BTreeSet::new(),
            tokens: BTreeMap::new(),
            unreachable: Vec::new(),
            covered: Vec::new(),
            beside: Vec::new(),
            without: None,
        }
    }

    /// One that takes calls of a function not to come to an end.
    pub(super) fn without(check: &'c Check<'a>, function: u32) -> Self {
        Self { without: Some(function), ..Self::new(check) }
    }

    /// Whether a form that was looked at leaves a block around it.
    pub(super) fn leaves(&self) -> bool {
        self.reached.difference(&self.entered).next().is_some()
    }

    /// Whether a form can come to an end with a value: a loop that nothing leaves cannot, nor can
    /// what always fails. Notes the blocks it leaves.
    pub(super) fn completes(&mut self, ir: &'c Ir) -> bool {
        deep(|| self.completes_here(ir))
    }

    fn completes_here(&mut self, ir: &'c Ir) -> bool {
        match &ir.kind {
            IrKind::Seq(items) => self.sequence(items),
            IrKind::If(condition, then, otherwise) => self.conditional(condition, then, otherwise),
            IrKind::And(items) | IrKind::Or(items) => match items.split_first() {
                Some((first, rest)) => {
                    let completes = self.completes(first);
                    for item in rest {
                        self.completes(item);
                    }
                    completes
                }
                None => true,
            },
            IrKind::Loop(body) => {
                self.completes(body);
                false
            }
            IrKind::Whenever { fluent, body, .. } => {
                self.completes(fluent);
                self.completes(body);
                false
            }
            IrKind::Block { id, token, body } => {
                self.entered.insert(*id);
                self.tokens.extend(token.map(|token| (token, *id)));
                self.completes(body) | self.reached.contains(id)
            }
            IrKind::Leave(block, value) => {
                if self.completes(value) {
                    self.reached.insert(*block);
                }
                false
            }
            IrKind::LeaveDynamic(token, value) => {
                if self.completes(value) {
                    self.reached.extend(self.tokens.get(token));
                }
                false
            }
            IrKind::Refail(_) => false,
            IrKind::Handler { body, clauses, .. } => self.handler(body, clauses),
            IrKind::Construct(construct) => {
                let mut starts = true;
                construct.evaluated().for_each(|argument| starts &= self.completes(argument));
                let ends = self.ends_of(&construct.children);
                if construct.policy().is_none()
                    && construct.quorum.successes == Successes::All
                    // What has a tag may be ended by its name.
                    && construct.children.iter().all(|child| child.tag.is_none())
                    && ends.contains(&true)
                    && let Some(reaction) = construct.children.iter().find(|child| is_whenever(&child.body.body))
                {
                    self.beside.push((ir, &reaction.body.body));
                }
                starts & whole_ends(construct.quorum, &ends)
            }
            IrKind::ConstructMap(construct, list) => {
                // Without elements there is no child.
                let mut starts = self.completes(list);
                construct.evaluated().for_each(|argument| starts &= self.completes(argument));
                starts
                    & (whole_ends(construct.quorum, &self.ends_of(&construct.children))
                        | (construct.quorum.successes == Successes::All))
            }
            IrKind::Call(callee, _) => self.all_parts(ir) & self.call_completes(callee),
            IrKind::Lambda(_) | IrKind::Spawn(_) => {
                self.all_parts(ir);
                true
            }
            IrKind::Network(_) => true,
            IrKind::Nil
            | IrKind::True
            | IrKind::Int(_)
            | IrKind::Const(_)
            | IrKind::Local(_)
            | IrKind::Global(_)
            | IrKind::SetLocal(..)
            | IrKind::SetGlobal(..)
            | IrKind::DefFluent(..)
            | IrKind::Let(..)
            | IrKind::Binary(..)
            | IrKind::Unary(..)
            | IrKind::Cleanup { .. }
            | IrKind::Scope(..)
            | IrKind::WaitFor { .. } => self.all_parts(ir),
        }
    }

    /// Hooks and closures run at other times: whether they come to an end does not matter here.
    fn all_parts(&mut self, ir: &'c Ir) -> bool {
        let mut completes = true;
        parts(ir, &mut |part| match part {
            FormPart::Form(form) => completes &= self.completes(form),
            FormPart::Function(function) => {
                self.completes(&function.body);
            }
        });
        completes
    }

    fn sequence(&mut self, items: &'c [Ir]) -> bool {
        for (at, item) in items.iter().enumerate() {
            if !self.completes(item) {
                self.unreachable.extend(items.get(at + 1).map(|next| (item, next)));
                return false;
            }
        }
        true
    }

    fn conditional(&mut self, condition: &'c Ir, then: &'c Ir, otherwise: &'c Ir) -> bool {
        let reached = self.completes(condition);
        let branches = match condition.kind {
            IrKind::True | IrKind::Int(_) => self.completes(then),
            IrKind::Nil => self.completes(otherwise),
            _ => self.completes(then) | self.completes(otherwise),
        };
        reached && branches
    }

    fn handler(&mut self, body: &'c Ir, clauses: &'c [ClauseIr]) -> bool {
        let mut completes = self.completes(body);
        let mut above: Vec<&'c ClauseIr> = Vec::new();
        for clause in clauses {
            self.cover(&above, clause);
            completes |= self.completes(&clause.body);
            above.push(clause);
        }
        completes
    }

    /// Notes a clause all classes of which are taken above it.
    fn cover(&mut self, above: &[&'c ClauseIr], clause: &'c ClauseIr) {
        let program = self.check.subject.program;
        let taken = |class| {
            above.iter().find_map(|earlier| {
                let by = earlier.classes.iter().find(|&&wider| program.is_failure_subclass(class, wider))?;
                Some((self.check.name(*by), earlier.span))
            })
        };
        let Some(&first) = clause.classes.first() else { return };
        if let Some(by) = taken(first)
            && clause.classes.iter().all(|&class| taken(class).is_some())
            && !above.iter().any(|earlier| lies_in(clause.span, earlier.span))
        {
            self.covered.push((self.check.name(first), by, clause.span));
        }
    }

    /// Which children come to an end. An evaporated child counts as done, and what has a tag can be evaporated.
    fn ends_of(&mut self, children: &'c [ChildIr]) -> Vec<bool> {
        children.iter().map(|child| self.completes(&child.body.body) | child.tag.is_some()).collect()
    }

    fn call_completes(&mut self, callee: &'c Callee) -> bool {
        match callee {
            Callee::Native(native) => {
                !matches!(self.check.subject.natives[usize::from(*native)].name.as_str(), "%fail" | "fail-composite")
            }
            Callee::Global(global) => self.without != Some(*global) && self.function_completes(*global),
            Callee::Value(_) => true,
        }
    }

    /// Whether a call of the function can come to an end; a recursion on the way is taken to do so.
    fn function_completes(&self, global: u32) -> bool {
        if let Some(&known) = self.check.ends.borrow().get(&global) {
            return known.unwrap_or(true);
        }
        let Some(&(function, _)) = self.check.functions.get(&global) else { return true };
        self.check.ends.borrow_mut().insert(global, None);
        let completes = Flow::new(self.check).completes(&function.body);
        self.check.ends.borrow_mut().insert(global, Some(completes));
        completes
    }
}

/// Whether a form comes to an end, by its children that do.
fn whole_ends(quorum: Quorum, ends: &[bool]) -> bool {
    match quorum.successes {
        // A failure is an end, too.
        Successes::All if quorum.failures == Failures::Settled => true,
        Successes::All => ends.iter().all(|&ends| ends),
        Successes::Count(_) => ends.iter().any(|&ends| ends),
        Successes::Last => ends.last().copied().unwrap_or(true),
    }
}

/// Whether a form reacts for ever.
pub(super) fn is_whenever(ir: &Ir) -> bool {
    match &ir.kind {
        IrKind::Seq(items) => items.last().is_some_and(|last| matches!(last.kind, IrKind::Whenever { .. })),
        kind => matches!(kind, IrKind::Whenever { .. }),
    }
}
