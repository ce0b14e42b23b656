//! Data written out, and templates.

use super::special_form::{Role, SpecialForm, Written};
use crate::code::{Atom, Constant};
use crate::compile::compiler::Compiler;
use crate::compile::ir::{Ir, IrKind};
use crate::source::Span;
use crate::syntax::{NodeId, NodeKind};

pub(super) const FORMS: &[SpecialForm] = &[
    SpecialForm {
        names: &["quote"],
        form: "(quote DATUM), 'DATUM",
        doc: "The datum itself.",
        example: "",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.quote(written)),
    },
    SpecialForm {
        names: &["quasiquote"],
        form: "`DATUM",
        doc: "The datum with the values of its ,EXPR and the elements of its ,@LIST.",
        example: "(let ((room 'hall)) `(go-to ,room))",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.quasiquote_form(written)),
    },
];

impl Compiler<'_> {
    fn quote(&mut self, written: &Written<'_>) -> Ir {
        let [datum] = written.rest() else { return self.malformed(written.span, "`(quote DATUM)`") };
        let constant = self.datum(*datum);
        self.constant_ir(constant, written.span)
    }

    fn quasiquote_form(&mut self, written: &Written<'_>) -> Ir {
        match written.rest() {
            [template] => self.quasiquote(*template, 1),
            _ => self.malformed(written.span, "`(quasiquote DATUM)`"),
        }
    }

    fn constant_ir(&mut self, constant: Constant, span: Span) -> Ir {
        let kind = match constant {
            Constant::Atom(Atom::Nil) => IrKind::Nil,
            Constant::Atom(Atom::True) => IrKind::True,
            Constant::Atom(Atom::Int(value)) => IrKind::Int(value),
            other => IrKind::Const(self.constant(other)),
        };
        Ir { span, kind }
    }

    /// `` `(a ,b ,@c) `` as calls of `cons` and `append`; nested templates keep their inner marks.
    fn quasiquote(&mut self, node: NodeId, depth: usize) -> Ir {
        self.nested(node, |compiler| compiler.quasiquote_here(node, depth))
            .unwrap_or_else(|| self.nil(self.tree.span(node)))
    }

    fn quasiquote_here(&mut self, node: NodeId, depth: usize) -> Ir {
        let span = self.tree.span(node);
        if self.tree.items(node).is_empty() && self.tree.elements(node).is_empty() {
            let constant = self.datum(node);
            return self.constant_ir(constant, span);
        }
        if let NodeKind::Vector { .. } = self.tree.get(node).kind {
            let items = self.tree.elements(node).to_vec();
            let items = self.tree.list(&items, span);
            let elements = self.quasiquote(items, depth);
            return self.native_ir("list->vector", vec![elements], span);
        }
        let head = self.tree.head(node).map(|head| self.symbols.name(head).to_string());
        let items = self.tree.items(node).to_vec();
        match head.as_deref() {
            Some("unquote") if items.len() == 2 => {
                if depth == 1 {
                    return self.resolve(items[1]);
                }
                return self.rebuilt_mark("unquote", items[1], depth - 1, span);
            }
            Some("quasiquote") if items.len() == 2 => {
                return self.rebuilt_mark("quasiquote", items[1], depth + 1, span);
            }
            _ => {}
        }
        let dotted = matches!(self.tree.get(node).kind, NodeKind::List { dotted: true, .. });
        let (elements, mut tail) = match (dotted, items.split_last()) {
            (true, Some((last, elements))) => (elements.to_vec(), self.quasiquote(*last, depth)),
            _ => (items, self.nil(span)),
        };
        for element in elements.into_iter().rev() {
            let place = self.tree.span(element);
            let spliced = match self.tree.head(element) {
                Some(mark) if depth == 1 && self.symbols.name(mark) == "unquote-splicing" => {
                    self.tree.items(element).get(1).copied()
                }
                _ => None,
            };
            tail = match spliced {
                Some(list) => {
                    let list = self.resolve(list);
                    if matches!(tail.kind, IrKind::Nil) {
                        list
                    } else {
                        self.native_ir("append", vec![list, tail], place)
                    }
                }
                None => {
                    let item = self.quasiquote(element, depth);
                    self.native_ir("cons", vec![item, tail], place)
                }
            };
        }
        tail
    }

    fn rebuilt_mark(&mut self, mark: &str, inner: NodeId, depth: usize, span: Span) -> Ir {
        let symbol = self.symbols.intern(mark);
        let mark = self.constant(Atom::Symbol(symbol));
        let mark = Ir { span, kind: IrKind::Const(mark) };
        let inner = self.quasiquote(inner, depth);
        self.native_ir("list", vec![mark, inner], span)
    }
}
