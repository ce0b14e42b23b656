//! Expressions: special forms go to what compiles them, macros are expanded, everything else is a name,
//! a call or data.

use super::compilation::{call_of_native, describe_arity};
use super::compiler::Compiler;
use super::intrinsics::intrinsic;
use super::ir::{Callee, Ir, IrKind};
use super::meaning::Meaning;
use crate::code::GlobalKind;
use crate::infix::infix_in;
use crate::kind::Kind;
use crate::source::Span;
use crate::stack::deep;
use crate::syntax::{NodeId, NodeKind};

/// Forms nest at most so deep: each level takes about 1 KB of stack while it is compiled.
const MAX_FORMS_DEEP: u32 = 10_000;

/// Natives whose arguments are fluents themselves, also in fluent position.
const TAKES_FLUENTS: &[&str] =
    &["value", "pulsed", "changed", "count-pulses", "status", "result", "begin-task", "end-task"];

impl Compiler<'_> {
    /// Resolves one form.
    pub(super) fn resolve(&mut self, node: NodeId) -> Ir {
        self.nested(node, |compiler| compiler.resolve_here(node)).unwrap_or_else(|| self.nil(self.tree.span(node)))
    }

    /// Does something with a form inside those that are under way; refuses to go deeper than
    /// [`MAX_FORMS_DEEP`]. The reader bounds the nesting of a text; data and macros can nest further.
    pub(super) fn nested<T>(&mut self, node: NodeId, inside: impl FnOnce(&mut Self) -> T) -> Option<T> {
        if self.depth == MAX_FORMS_DEEP {
            self.too_deep(self.tree.span(node));
            return None;
        }
        self.depth += 1;
        let result = deep(|| inside(self));
        self.depth -= 1;
        Some(result)
    }

    fn too_deep(&mut self, span: Span) {
        // Every form beside this one is as deep: one is told.
        if self.diagnostics.iter().all(|found| found.code != "too-deep") {
            let message = format!("these forms are nested more than {MAX_FORMS_DEEP} levels deep");
            let label = format!("level {}", MAX_FORMS_DEEP + 1);
            self.error("too-deep", span, message, label).help =
                Some("data may nest deeper: quote it, or call a function that works on it".into());
        }
    }

    fn resolve_here(&mut self, node: NodeId) -> Ir {
        let span = self.tree.span(node);
        match self.tree.get(node).kind.clone() {
            NodeKind::Int(value) => Ir { span, kind: IrKind::Int(value) },
            NodeKind::Symbol(name) => self.name(None, name, span),
            NodeKind::Qualified { qualifier, name, .. } => self.name(Some(qualifier), name, span),
            NodeKind::List { len: 0, .. } => self.nil(span),
            NodeKind::List { dotted: true, .. } => {
                self.error("dotted-call", span, "a form cannot have a dot", "this is data: quote it").help =
                    Some("write `'(…)`".into());
                self.nil(span)
            }
            NodeKind::List { .. } => self.form(node, span),
            _ => {
                let constant = self.constant(self.datum(node));
                Ir { span, kind: IrKind::Const(constant) }
            }
        }
    }

    /// Resolves forms in order; the last one gives the value.
    pub(super) fn body(&mut self, forms: &[NodeId], span: Span) -> Ir {
        match forms {
            [] => self.nil(span),
            [one] => self.resolve(*one),
            many => {
                let items = many.iter().map(|&form| self.resolve(form)).collect();
                Ir { span, kind: IrKind::Seq(items) }
            }
        }
    }

    fn form(&mut self, node: NodeId, span: Span) -> Ir {
        let items = self.tree.items(node).to_vec();
        let head = items[0];
        if let Some((qualifier, name)) = self.tree.name(head) {
            if self.is_lexically_bound(qualifier, name) {
                return self.call_value(head, &items[1..], span);
            }
            if let Some(special) = self.special_form(name) {
                return self.special(special, &items, span);
            }
            if self.is_broken_macro(qualifier, name) {
                return self.nil(span);
            }
            if let Some(code) = self.macro_code(qualifier, name) {
                return self.expand_and_resolve(code, node);
            }
            let meaning = self.meaning(qualifier, name, span);
            return self.named_call(meaning, head, &items[1..], span);
        }
        match self.tree.get(head).kind.clone() {
            NodeKind::Keyword(name) if self.symbols.name(name) == "tag" => self.tagged(&items, span),
            NodeKind::List { .. } | NodeKind::Object(_) | NodeKind::Hole => self.call_value(head, &items[1..], span),
            _ => {
                let place = self.tree.span(head);
                let infix = infix_in(&self.program.sources, span, 1);
                let help = infix.map_or("quote the list if it is data: `'(…)`".to_string(), |infix| infix.advice());
                self.error("not-callable", place, "this cannot be called", "expected the name of a function").help =
                    Some(help);
                self.nil(span)
            }
        }
    }

    fn call_value(&mut self, head: NodeId, arguments: &[NodeId], span: Span) -> Ir {
        let callee = self.outside_fluent_position(|compiler| compiler.resolve(head));
        let arguments = self.arguments(arguments);
        self.dereferenced(Ir { span, kind: IrKind::Call(Callee::Value(Box::new(callee)), arguments) })
    }

    pub(super) fn arguments(&mut self, nodes: &[NodeId]) -> Vec<Ir> {
        nodes.iter().map(|&node| self.resolve(node)).collect()
    }

    /// Whether the reader found nothing where a datum has to be, and has told so.
    fn is_hole(&self, node: NodeId) -> bool {
        let last = self.tree.items(node).last().copied().unwrap_or(node);
        self.tree.get(last).kind == NodeKind::Hole
    }

    fn named_call(&mut self, meaning: Meaning, head: NodeId, nodes: &[NodeId], span: Span) -> Ir {
        if nodes.iter().any(|&node| self.is_hole(node)) {
            // How many arguments are meant is not known.
            self.arguments(nodes);
            return self.nil(span);
        }
        if let Some(&list) = nodes.iter().find(|&&node| self.is_no_call(node)) {
            let told = self.diagnostics.len();
            self.arguments(nodes);
            self.advise_on_list(&meaning, head, nodes, list, told);
            return self.nil(span);
        }
        match meaning {
            // A tag of the plan.
            Meaning::Local(_) => self.call_value(head, nodes, span),
            Meaning::Global(global) => {
                let arguments = self.arguments(nodes);
                self.calls.push((global, arguments.len(), span));
                self.dereferenced(Ir { span, kind: IrKind::Call(Callee::Global(global), arguments) })
            }
            Meaning::Native(native) => self.native_call(native, nodes, span),
        }
    }

    /// Whether a form is a list that begins with a number, a text or a keyword: no arguments fit it.
    fn is_no_call(&self, node: NodeId) -> bool {
        let head = self.tree.proper_list(node).and_then(|items| items.first());
        head.is_some_and(|&head| match self.tree.get(head).kind {
            NodeKind::Int(_) | NodeKind::Float(_) | NodeKind::Str(_) => true,
            NodeKind::Keyword(name) => self.symbols.name(name) != "tag",
            _ => false,
        })
    }

    /// If the call takes what stands in the list in its place, and not the list, the parentheses are too many.
    fn advise_on_list(&mut self, meaning: &Meaning, head: NodeId, nodes: &[NodeId], list: NodeId, told: usize) {
        let items = self.tree.items(list);
        let accepts = |count: usize| match *meaning {
            Meaning::Local(_) => false,
            Meaning::Native(native) => {
                let native = &self.natives[usize::from(native)];
                count >= usize::from(native.min) && native.max.is_none_or(|max| count <= usize::from(max))
            }
            Meaning::Global(global) => match self.program.globals[global as usize].kind {
                GlobalKind::Function(code) => {
                    self.program.codes.get(code as usize).is_some_and(|code| code.parameters.accepts(count))
                }
                _ => false,
            },
        };
        if accepts(nodes.len()) || !accepts(nodes.len() - 1 + items.len()) {
            return;
        }
        let text_of = |node: NodeId| self.program.sources.text_of(self.tree.span(node));
        let flat =
            nodes.iter().flat_map(|&node| if node == list { items } else { std::slice::from_ref(&node) }.to_vec());
        let words: Vec<&str> = std::iter::once(head).chain(flat).map(text_of).collect();
        let help = format!("without these parentheses: `({})`", words.join(" "));
        let place = self.tree.span(items[0]);
        let mut new = self.diagnostics[told..].iter_mut();
        if let Some(error) = new.find(|error| error.code == "not-callable" && error.span == place)
            && error.help.as_ref().is_none_or(|help| help.starts_with("quote"))
        {
            error.help = Some(help);
        }
    }

    fn native_call(&mut self, native: u16, nodes: &[NodeId], span: Span) -> Ir {
        let natives = self.natives;
        let signature = &natives[usize::from(native)];
        let count = nodes.len();
        let takes_time = signature.kinds.first() == Some(&Kind::Seconds);
        if takes_time && self.refuse_unit_apart(nodes, &["ms", "s", "min", "h"]) {
            return self.nil(span);
        }
        if count < usize::from(signature.min) || signature.max.is_some_and(|max| count > usize::from(max)) {
            let expected = describe_arity(signature.min, signature.max);
            let is_format = signature.name == "print"
                && matches!(nodes.first().map(|&first| &self.tree.get(first).kind), Some(NodeKind::Str(_)));
            let error = self.arity_error(&signature.name, count, &expected, span);
            let is_bare = error.help.is_none() && !signature.name.starts_with('%');
            if is_format {
                error.help = Some("`print` shows one value: write `(print (format \"…\" VALUE...))`".into());
            } else if is_bare {
                error.help = Some(call_of_native(signature));
            }
            return self.nil(span);
        }
        if self.is_network() && signature.effect {
            let message = format!("`{}` cannot stand in a fluent network", signature.name);
            self.error("network-effect", span, message, "a network may only look").help =
                Some("do it in the body, after the condition".into());
        }
        if signature.name == "%fail" {
            self.note_failed_class(nodes[0], span);
        }
        if TAKES_FLUENTS.contains(&signature.name.as_str()) {
            return self.fluent_native(native, nodes, span);
        }
        let arguments = self.arguments(nodes);
        match intrinsic(&signature.name, arguments, span) {
            Ok(ir) => ir,
            Err(arguments) => self.dereferenced(Ir { span, kind: IrKind::Call(Callee::Native(native), arguments) }),
        }
    }

    /// The class a `fail` names, if it is written out.
    fn note_failed_class(&mut self, node: NodeId, span: Span) {
        let quote = self.tree.head(node).is_some_and(|head| self.symbols.name(head) == "quote");
        if let (true, [_, class]) = (quote, self.tree.items(node))
            && let Some(name) = self.tree.symbol(*class)
        {
            self.note_class(name, span);
        }
    }
}
