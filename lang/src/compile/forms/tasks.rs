//! Tasks with names: tags, processes; and spawned tasks.

use super::special_form::{Role, SpecialForm};
use crate::code::{CodeKind, Quorum};
use crate::compile::compiler::Compiler;
use crate::compile::ir::{ChildIr, ConstructIr, Ir, IrKind, VarId, Variable};
use crate::layout::Layout;
use crate::layout::Style::Body;
use crate::source::Span;
use crate::symbol::Symbol;
use crate::syntax::{NodeId, NodeKind};

pub(super) const FORMS: &[SpecialForm] = &[
    SpecialForm {
        names: &["process", ":tag"],
        form: "(process NAME FORM...), (:tag NAME FORM...)",
        doc: "Runs the forms as a task of that name, bound in the whole plan.",
        example: "(par (process worker (wait-time 5))\n     (wait-for (end-task worker)))",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Effect(|compiler, written| compiler.tagged(written.items, written.span)),
    },
    SpecialForm {
        names: &["spawn"],
        form: "(spawn FORM...)",
        doc: "Starts a task and gives it at once; it lives at most as long as the plan call around it.",
        example: "(let ((task (spawn (wait-time 5))))\n  (wait-for (end-task task)))",
        layout: Some(Layout::plain(Body(0))),
        role: Role::Effect(|compiler, written| compiler.spawn(written.rest(), written.span)),
    },
];

impl Compiler<'_> {
    pub(in crate::compile) fn tagged(&mut self, items: &[NodeId], span: Span) -> Ir {
        if self.is_network() {
            self.error(
                "network-effect",
                span,
                "a task cannot be started in a fluent network",
                "a network may only look",
            );
            return self.nil(span);
        }
        let Some((name, variable, body)) = self.tag_parts(items) else {
            return self.malformed(span, "`(:tag NAME FORM...)` or `(process NAME FORM...)`");
        };
        let text = self.symbols.name(name).to_string();
        let body = self.thunk(&text, CodeKind::Task, &body, span);
        self.capture(variable);
        let child = ChildIr { body, tag: Some(variable), name: Some(name) };
        self.single(&text, child, None, span)
    }

    /// Name, variable and body of `(:tag NAME FORM...)` or `(process NAME FORM...)`.
    pub(super) fn tag_parts(&mut self, items: &[NodeId]) -> Option<(Symbol, VarId, Vec<NodeId>)> {
        let &head = items.first()?;
        let is_tag = match (&self.tree.get(head).kind, self.tree.name(head)) {
            (&NodeKind::Keyword(word), _) => self.symbols.name(word) == "tag",
            (_, Some((qualifier, word))) => {
                self.symbols.name(word) == "process" && !self.is_lexically_bound(qualifier, word)
            }
            _ => false,
        };
        let name = self.tree.plain_symbol(*items.get(1)?)?;
        if !is_tag || !self.is_bindable(name) {
            return None;
        }
        let root = self.functions.iter().rposition(|function| function.tags.is_some())?;
        let known = self.functions[root].tags.as_ref().and_then(|tags| tags.get(&name)).copied();
        let variable = match known {
            Some(variable) => variable,
            None => self.new_tag(root, name, self.tree.span(items[1])),
        };
        self.variables[variable.0 as usize].assigned = true;
        Some((name, variable, items[2..].to_vec()))
    }

    fn new_tag(&mut self, root: usize, name: Symbol, span: Span) -> VarId {
        self.variables.push(Variable { name, span, function: root, captured: false, assigned: true });
        let variable = VarId(self.variables.len() as u32 - 1);
        if let Some(tags) = &mut self.functions[root].tags {
            tags.insert(name, variable);
        }
        variable
    }

    /// Notes every tag in the text of a plan, so that it is bound before it is reached.
    pub(in crate::compile) fn find_tags(&mut self, forms: &[NodeId]) {
        let root = self.functions.len() - 1;
        let mut waiting: Vec<NodeId> = forms.iter().rev().copied().collect();
        while let Some(node) = waiting.pop() {
            if self.tree.head(node).is_some_and(|head| matches!(self.symbols.name(head), "quote" | "quasiquote")) {
                continue;
            }
            let items = self.tree.items(node).to_vec();
            // `tag_parts` notes a tag it does not know yet.
            debug_assert_eq!(root, self.functions.len() - 1);
            self.tag_parts(&items);
            waiting.extend(items.into_iter().rev());
        }
    }

    fn spawn(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let child = match rest {
            [one] => self.child(*one),
            many => ChildIr { body: self.thunk("spawn", CodeKind::Task, many, span), tag: None, name: None },
        };
        let name = self.symbols.intern("spawn");
        let construct =
            ConstructIr { quorum: Quorum::LAST, name, children: vec![child], order: Vec::new(), argument: None };
        Ir { span, kind: IrKind::Spawn(Box::new(construct)) }
    }
}
