//! Failures handled: clauses, trying again, passing on.

use super::special_form::{Role, SpecialForm};
use crate::compile::compiler::{Compiler, HandlerScope};
use crate::compile::ir::{BlockId, ClauseIr, Ir, IrKind, VarId};
use crate::layout::ItemShape::Handlers;
use crate::layout::Layout;
use crate::layout::Style::Body;
use crate::source::Span;
use crate::symbol::Symbol;
use crate::syntax::NodeId;

pub(super) const FORMS: &[SpecialForm] = &[
    SpecialForm {
        names: &["with-failure-handling"],
        form: "(with-failure-handling ((CLASS (NAME) FORM...)...) FORM...)",
        doc: "Runs the forms; the first clause whose class fits takes their failure, after they have been cleaned up.",
        example: "(with-failure-handling\n    ((arithmetic-error (f) (print (failure-message f))))\n  (/ 1 0))",
        layout: Some(Layout::with(Body(1), &[Handlers])),
        role: Role::Plain(|compiler, written| compiler.with_failure_handling(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["retry"],
        form: "(retry)",
        doc: "In a clause of `with-failure-handling`: starts the forms again.",
        example: "",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.retry(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["refail"],
        form: "(refail)",
        doc: "In a clause of `with-failure-handling`: passes the failure on.",
        example: "",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.refail(written.rest(), written.span)),
    },
];

impl Compiler<'_> {
    fn with_failure_handling(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let clauses = rest.first().and_then(|&list| self.list_items(list));
        let Some(clauses) = clauses else {
            return self.malformed(span, "`(with-failure-handling ((CLASS (F) FORM...)...) FORM...)`");
        };
        if let Some(&class) = clauses.first().filter(|&&first| self.tree.symbol(first).is_some()) {
            let (class, list) = (self.tree.span(class), self.tree.span(rest[0]));
            let class = self.program.sources.text_of(class).to_string();
            let help = format!("one more pair of parentheses, around all clauses: `(({class} (f) FORM...))`");
            let message = format!("the clause of `{class}` stands in no list of clauses");
            self.error("malformed", list, message, "a list of clauses").help = Some(help);
            return self.nil(span);
        }
        let body_forms = rest[1..].to_vec();
        // Leaving the inner block starts the body again; leaving the outer one gives the value.
        self.in_block(None, span, |compiler, _| {
            let done = compiler.blocks.len() - 1;
            let mut retried = false;
            let attempt = compiler.in_block(None, span, |compiler, retry| {
                let failure_name = compiler.symbols.uninterned("failure");
                let failure = compiler.new_variable(failure_name, span);
                let body = Box::new(compiler.body(&body_forms, span));
                compiler.handlers.push(HandlerScope { retry, failure });
                let clauses = clauses.iter().filter_map(|&clause| compiler.clause(clause, failure)).collect();
                compiler.handlers.pop();
                retried = compiler.blocks.last().is_some_and(|block| block.used);
                let handler = Ir { span, kind: IrKind::Handler { body, failure, clauses } };
                if retried { compiler.leave(done, handler, span) } else { handler }
            });
            if retried { Ir { span, kind: IrKind::Loop(Box::new(attempt)) } } else { attempt }
        })
    }

    /// `(CLASS (F) FORM...)`; CLASS may be a list of classes, F may be left out.
    fn clause(&mut self, node: NodeId, failure: VarId) -> Option<ClauseIr> {
        let span = self.tree.span(node);
        let items = self.tree.items(node).to_vec();
        let form = "`(CLASS (F) FORM...)`";
        if items.len() < 2 {
            self.malformed(span, form);
            return None;
        }
        let class_nodes = match self.tree.proper_list(items[0]) {
            // A form where the class is missing: what stands in it is no class either.
            Some(&[form, ..]) if self.tree.symbol(form).is_some_and(|name| self.is_form(name)) => vec![form],
            Some(list) => list.to_vec(),
            None => vec![items[0]],
        };
        let classes: Vec<Symbol> = class_nodes.into_iter().filter_map(|class| self.handled_class(class)).collect();
        let parameter = self.list_items(items[1]);
        let name = match parameter.as_deref() {
            Some([]) => None,
            Some([name]) if self.refuses_to_bind(*name) => return None,
            Some([name]) if self.tree.symbol(*name).is_some() => self.tree.symbol(*name),
            _ => {
                self.malformed(span, form);
                return None;
            }
        };
        let before = self.locals.count();
        if let Some(name) = name {
            self.locals.bind(name, failure);
        }
        let body = self.body(&items[2..], span);
        self.locals.leave(before);
        Some(ClauseIr { span, classes, body })
    }

    /// The name of a failure class; whether there is one is checked when all definitions are known.
    fn handled_class(&mut self, node: NodeId) -> Option<Symbol> {
        let span = self.tree.span(node);
        let Some(name) = self.tree.symbol(node) else {
            self.malformed(span, "the name of a failure class");
            return None;
        };
        self.note_class(name, span);
        Some(name)
    }

    fn retry(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let Some((retry, _)) = self.handler_around(rest, span) else { return self.nil(span) };
        match self.blocks.iter().position(|block| block.id == retry) {
            Some(block) => {
                let nothing = self.nil(span);
                self.leave(block, nothing, span)
            }
            None => self.nil(span),
        }
    }

    fn refail(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let Some((_, failure)) = self.handler_around(rest, span) else { return self.nil(span) };
        self.capture(failure);
        Ir { span, kind: IrKind::Refail(failure) }
    }

    /// What starts the body of the handler around a clause again, and the failure of the clause.
    fn handler_around(&mut self, rest: &[NodeId], span: Span) -> Option<(BlockId, VarId)> {
        if !rest.is_empty() {
            self.malformed(span, "`(retry)` or `(refail)`");
            return None;
        }
        let around = self.handlers.last().map(|handler| (handler.retry, handler.failure));
        if around.is_none() {
            self.error(
                "no-handler",
                span,
                "this stands in no clause of `with-failure-handling`",
                "no failure to handle here",
            );
        }
        around
    }
}
