//! Names bound around forms: variables, and the parameters of functions.

use super::special_form::{Role, SpecialForm, Written};
use crate::code::CodeKind;
use crate::compile::compiler::{Compiler, thunk};
use crate::compile::ir::{Function, Ir, IrKind, VarId};
use crate::compile::lambda_list::Lists;
use crate::layout::ItemShape::{Bindings, Data};
use crate::layout::Layout;
use crate::layout::Style::Body;
use crate::source::Span;
use crate::symbol::Symbol;
use crate::syntax::NodeId;

pub(super) const FORMS: &[SpecialForm] = &[
    SpecialForm {
        names: &["let"],
        form: "(let ((NAME VALUE)...) FORM...)",
        doc: "Runs the forms with the names bound; the values do not see the names.",
        example: "(let ((a 1) (b 2))\n  (print (+ a b)))",
        layout: Some(Layout::with(Body(1), &[Bindings])),
        role: Role::Plain(|compiler, written| compiler.let_form(written.rest(), written.span, false)),
    },
    SpecialForm {
        names: &["let*"],
        form: "(let* ((NAME VALUE)...) FORM...)",
        doc: "Runs the forms with the names bound one after the other.",
        example: "",
        layout: Some(Layout::with(Body(1), &[Bindings])),
        role: Role::Plain(|compiler, written| compiler.let_form(written.rest(), written.span, true)),
    },
    SpecialForm {
        names: &["letrec"],
        form: "(letrec ((NAME FUNCTION)...) FORM...)",
        doc: "Runs the forms with functions bound that may call each other.",
        example: "",
        layout: Some(Layout::with(Body(1), &[Bindings])),
        role: Role::Plain(|compiler, written| compiler.letrec(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["destructuring-bind"],
        form: "(destructuring-bind (PARAMETER...) LIST FORM...)",
        doc: "Binds the names of a parameter list to the elements of a list and runs the forms. A parameter may be such a list itself.",
        example: "(destructuring-bind (item (from to) &key (due 9)) '(cup (kitchen hall) :due 7)\n  (print (list item from to due)))",
        layout: Some(Layout::with(Body(2), &[Data])),
        role: Role::Plain(|compiler, written| compiler.destructuring_bind(written)),
    },
    SpecialForm {
        names: &["lambda", "fn"],
        form: "(lambda (PARAMETER...) FORM...)",
        doc: "A function that remembers the variables around it.",
        example: "(map (lambda (n) (* n n)) '(1 2 3))",
        layout: Some(Layout::with(Body(1), &[Data])),
        role: Role::Plain(|compiler, written| compiler.lambda(written.rest(), written.span)),
    },
];

impl Compiler<'_> {
    fn let_form(&mut self, rest: &[NodeId], span: Span, sequential: bool) -> Ir {
        let bindings = rest.first().and_then(|&list| self.list_items(list));
        let Some(bindings) = bindings else {
            return self.malformed(span, "`(let ((NAME VALUE)...) FORM...)`");
        };
        let before = self.locals.count();
        let mut bound = Vec::new();
        let mut waiting = Vec::new();
        for binding in bindings {
            let place = self.tree.span(binding);
            let items = match self.tree.proper_list(binding) {
                Some(items) => items.to_vec(),
                None => vec![binding],
            };
            if items.first().is_some_and(|&name| self.refuses_to_bind(name)) {
                continue;
            }
            let name = items.first().and_then(|&name| self.tree.symbol(name));
            let Some(name) = name.filter(|&name| self.is_bindable(name) && items.len() <= 2) else {
                self.malformed(place, "`(NAME VALUE)`");
                continue;
            };
            let value = match items.get(1) {
                Some(&value) => self.resolve(value),
                None => self.nil(place),
            };
            let variable = self.new_variable(name, place);
            bound.push((variable, value));
            if sequential {
                self.locals.bind(name, variable);
            } else {
                waiting.push((name, variable));
            }
        }
        for (name, variable) in waiting {
            self.locals.bind(name, variable);
        }
        let body = self.body(&rest[1..], span);
        self.locals.leave(before);
        Ir { span, kind: IrKind::Let(bound, Box::new(body)) }
    }

    /// All names are bound before any value is computed. Functions that nobody assigns anew are the values of their
    /// variables from the first on; others are assigned in the order of binding.
    fn letrec(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let bindings = rest.first().and_then(|&list| self.list_items(list));
        let Some(bindings) = bindings else {
            return self.malformed(span, "`(letrec ((NAME VALUE)...) FORM...)`");
        };
        let before = self.locals.count();
        let mut written = Vec::new();
        for binding in bindings {
            let place = self.tree.span(binding);
            let items = self.tree.proper_list(binding).map(<[NodeId]>::to_vec).unwrap_or_default();
            if items.first().is_some_and(|&name| self.refuses_to_bind(name)) {
                continue;
            }
            let name = items.first().and_then(|&name| self.tree.symbol(name));
            let (Some(name), 2) = (name.filter(|&name| self.is_bindable(name)), items.len()) else {
                self.malformed(place, "`(NAME VALUE)`");
                continue;
            };
            let variable = self.bind(name, place);
            written.push((variable, place, items[1]));
        }
        let mut bound = Vec::new();
        for &(variable, _, value) in &written {
            bound.push((variable, self.resolve(value)));
        }
        let body = self.body(&rest[1..], span);
        self.locals.leave(before);
        let is_constant = |(variable, value): &(VarId, Ir)| {
            matches!(value.kind, IrKind::Lambda(_)) && !self.variables[variable.0 as usize].assigned
        };
        if bound.iter().all(is_constant) {
            return Ir { span, kind: IrKind::Let(bound, Box::new(body)) };
        }
        let mut forms = Vec::new();
        for (variable, value) in bound {
            self.variables[variable.0 as usize].assigned = true;
            forms.push(Ir { span: value.span, kind: IrKind::SetLocal(variable, Box::new(value)) });
        }
        forms.push(body);
        let bound = written.into_iter().map(|(variable, place, _)| (variable, self.nil(place))).collect();
        Ir { span, kind: IrKind::Let(bound, Box::new(Ir { span, kind: IrKind::Seq(forms) })) }
    }

    /// `(destructuring-bind (PARAMETER...) LIST FORM...)`
    fn destructuring_bind(&mut self, written: &Written<'_>) -> Ir {
        let span = written.span;
        let [parameters, value, body @ ..] = written.rest() else {
            return self.malformed(span, "`(destructuring-bind (PARAMETER...) LIST FORM...)`");
        };
        let value = self.resolve(*value);
        let before = self.locals.count();
        let list = self.new_list(span);
        let mut bound = vec![(list, value)];
        bound.extend(self.taken_apart(*parameters, list));
        let body = self.body(body, span);
        self.locals.leave(before);
        Ir { span, kind: IrKind::Let(bound, Box::new(body)) }
    }

    fn lambda(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let Some((&parameters, body)) = rest.split_first() else {
            return self.malformed(span, "`(lambda (PARAMETER...) FORM...)`");
        };
        let name = self.symbols.intern("lambda");
        let function = self.function(name, CodeKind::Function, parameters, Lists::Refused, body, span);
        Ir { span, kind: IrKind::Lambda(Box::new(function)) }
    }

    /// A function with parameters and a body. The root of a definition has tags of its own.
    #[allow(clippy::too_many_arguments, reason = "what a function is made of")]
    pub(super) fn function(
        &mut self,
        name: Symbol,
        kind: CodeKind,
        parameters: NodeId,
        lists: Lists,
        body: &[NodeId],
        span: Span,
    ) -> Function {
        let root = self.functions.is_empty();
        let ((parameters, bindings, body), scope) = self.in_function(kind, root, |compiler| {
            if root {
                compiler.find_tags(body);
            }
            let (parameters, bindings) = compiler.lambda_list(parameters, lists);
            let body = compiler.body(body, span);
            (parameters, bindings, body)
        });
        Function {
            name,
            kind,
            parameters,
            bindings,
            tags: scope.tags_in_order(),
            captures: scope.captures,
            body: Box::new(body),
            doc: None,
            span,
        }
    }

    /// A function without parameters around forms, in the current surroundings.
    pub(super) fn thunk(&mut self, name: &str, kind: CodeKind, forms: &[NodeId], span: Span) -> Function {
        let name = self.symbols.intern(name);
        let (body, scope) = self.in_function(kind, false, |compiler| compiler.body(forms, span));
        thunk(name, kind, body, scope, span)
    }
}
