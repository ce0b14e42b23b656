//! Data written out, and templates.

use super::special_form::{Role, SpecialForm, Written};
use crate::code::{Atom, Constant};
use crate::compile::compilation::Purpose;
use crate::compile::compiler::Compiler;
use crate::compile::ir::{Ir, IrKind};
use crate::source::Span;
use crate::symbol::{Qualifier, Symbol};
use crate::syntax::{NodeId, NodeKind, mark_of};

/// What a template makes.
#[derive(Clone, Copy, PartialEq)]
enum Template {
    /// Forms that a macro of the library writes: what their heads name of the library they name wherever they stand.
    Code,
    /// What is taken as it is written.
    Data,
}

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
            [template] => {
                let writes_forms = self.in_macro && self.purpose == Purpose::Library;
                self.quasiquote(*template, 1, if writes_forms { Template::Code } else { Template::Data })
            }
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
    fn quasiquote(&mut self, node: NodeId, depth: usize, template: Template) -> Ir {
        self.nested(node, |compiler| compiler.quasiquote_here(node, depth, template))
            .unwrap_or_else(|| self.nil(self.tree.span(node)))
    }

    fn quasiquote_here(&mut self, node: NodeId, depth: usize, template: Template) -> Ir {
        let span = self.tree.span(node);
        if self.tree.items(node).is_empty() && self.tree.elements(node).is_empty() {
            let constant = self.datum(node);
            return self.constant_ir(constant, span);
        }
        if let NodeKind::Vector { .. } = self.tree.get(node).kind {
            let items = self.tree.elements(node).to_vec();
            let items = self.tree.list(&items, span);
            let elements = self.quasiquote(items, depth, Template::Data);
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
        let template = if head.as_deref() == Some("quote") { Template::Data } else { template };
        let dotted = matches!(self.tree.get(node).kind, NodeKind::List { dotted: true, .. });
        let (elements, mut tail) = match (dotted, items.split_last()) {
            (true, Some((last, elements))) => (elements.to_vec(), self.quasiquote(*last, depth, template)),
            _ => (items, self.nil(span)),
        };
        for (at, element) in elements.into_iter().enumerate().rev() {
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
                    let head = if at == 0 { self.head_of_library(element, template) } else { None };
                    let item = match head {
                        Some(head) => self.constant_ir(Constant::Atom(Atom::Symbol(head)), place),
                        None => self.quasiquote(element, depth, template),
                    };
                    self.native_ir("cons", vec![item, tail], place)
                }
            };
        }
        tail
    }

    /// The head of a form that a macro of the library writes, with the qualifier that lets it mean what it means
    /// here, if it names something of the library.
    fn head_of_library(&mut self, head: NodeId, template: Template) -> Option<Symbol> {
        let name = self.tree.plain_symbol(head).filter(|_| template == Template::Code)?;
        let is_known = self.own_names.contains(&name)
            || self.specials.contains_key(&name)
            || self.native_numbers.contains_key(&name)
            || self.program.names.contains_key(&name)
            || self.program.macros.contains_key(&name);
        let is_mark = mark_of(self.symbols.name(name)).is_some();
        (is_known && !is_mark).then(|| self.symbols.qualified(Qualifier::Library, name))
    }

    fn rebuilt_mark(&mut self, mark: &str, inner: NodeId, depth: usize, span: Span) -> Ir {
        let symbol = self.symbols.intern(mark);
        let mark = self.constant(Atom::Symbol(symbol));
        let mark = Ir { span, kind: IrKind::Const(mark) };
        let inner = self.quasiquote(inner, depth, Template::Data);
        self.native_ir("list", vec![mark, inner], span)
    }
}
