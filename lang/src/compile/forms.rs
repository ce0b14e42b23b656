//! Special forms of the sequential language.

use super::ir::{Callee, Function, Ir, IrKind};
use super::resolve::Meaning;
use super::special::Special;
use super::{Compiler, thunk};
use crate::code::{Atom, CodeKind, Constant, GlobalKind};
use crate::source::Span;
use crate::symbol::Symbol;
use crate::syntax::{Kind, NodeId};

impl Compiler<'_> {
    pub(super) fn special(&mut self, special: Special, node: NodeId, items: &[NodeId], span: Span) -> Ir {
        if special.is_definition() {
            let name = self.symbols.name(self.tree.symbol(items[0]).unwrap_or(Symbol(0))).to_string();
            self.error(
                "definition-inside",
                span,
                format!("`{name}` can only stand at top level"),
                "inside another form",
            )
            .help = Some("move it out; inside, use `let` or a `lambda`".into());
            return self.nil(span);
        }
        if special.is_effect() && self.is_network() {
            let name = self.tree.symbol(items[0]).map_or("this", |name| self.symbols.name(name)).to_string();
            self.error(
                "network-effect",
                span,
                format!("`{name}` cannot stand in a fluent network"),
                "a network may only look, not wait or act",
            );
            return self.nil(span);
        }
        let rest = &items[1..];
        match special {
            Special::Quote => self.quote(node, rest, span),
            Special::Quasiquote => match rest {
                [template] => self.quasiquote(*template, 1),
                _ => self.malformed(span, "`(quasiquote DATUM)`"),
            },
            Special::If => match rest {
                [condition, then] => self.conditional(*condition, *then, None, span),
                [condition, then, otherwise] => self.conditional(*condition, *then, Some(*otherwise), span),
                _ => self.malformed(span, "`(if CONDITION THEN ELSE)`"),
            },
            Special::And => match rest {
                [] => Ir { span, kind: IrKind::True },
                _ => Ir { span, kind: IrKind::And(self.arguments(rest)) },
            },
            Special::Or => match rest {
                [] => self.nil(span),
                _ => Ir { span, kind: IrKind::Or(self.arguments(rest)) },
            },
            Special::Let => self.let_form(rest, span, false),
            Special::LetStar => self.let_form(rest, span, true),
            Special::Letrec => self.letrec(rest, span),
            Special::Lambda => self.lambda(rest, span),
            Special::Setq => self.setq(rest, span),
            Special::Setf => self.setf(rest, span),
            Special::Progn => self.body(rest, span),
            Special::Block => self.block(rest, span),
            Special::ReturnFrom => self.return_from(rest, span),
            Special::Return => self.return_nil_block(rest, span),
            Special::Loop => self.loop_form(rest, span),
            Special::Retry | Special::Refail => self.retry_or_refail(special, rest, span),
            _ => self.plan_form(special, items, span),
        }
    }

    pub(super) fn malformed(&mut self, span: Span, form: &str) -> Ir {
        self.error("malformed", span, format!("this is not of the form {form}"), format!("expected {form}"));
        self.nil(span)
    }

    fn quote(&mut self, _node: NodeId, rest: &[NodeId], span: Span) -> Ir {
        let [datum] = rest else { return self.malformed(span, "`(quote DATUM)`") };
        let constant = self.datum(*datum);
        self.constant_ir(constant, span)
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

    fn native_ir(&mut self, name: &str, arguments: Vec<Ir>, span: Span) -> Ir {
        match self.natives.iter().position(|native| native.name == name) {
            Some(number) => Ir { span, kind: IrKind::Call(Callee::Native(number as u16), arguments) },
            None => self.malformed(span, "a form the library supports"),
        }
    }

    /// `` `(a ,b ,@c) `` as calls of `cons` and `append`; nested templates keep their inner marks.
    fn quasiquote(&mut self, node: NodeId, depth: usize) -> Ir {
        self.nested(node, |compiler| compiler.quasiquote_here(node, depth))
            .unwrap_or_else(|| self.nil(self.tree.span(node)))
    }

    fn quasiquote_here(&mut self, node: NodeId, depth: usize) -> Ir {
        let span = self.tree.span(node);
        if self.tree.items(node).is_empty() {
            let constant = self.datum(node);
            return self.constant_ir(constant, span);
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
        let dotted = matches!(self.tree.get(node).kind, Kind::List { dotted: true, .. });
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

    fn conditional(&mut self, condition: NodeId, then: NodeId, otherwise: Option<NodeId>, span: Span) -> Ir {
        let condition = Box::new(self.resolve(condition));
        let then = Box::new(self.resolve(then));
        let otherwise = Box::new(match otherwise {
            Some(otherwise) => self.resolve(otherwise),
            None => self.nil(span),
        });
        Ir { span, kind: IrKind::If(condition, then, otherwise) }
    }

    fn let_form(&mut self, rest: &[NodeId], span: Span, sequential: bool) -> Ir {
        let bindings = rest.first().and_then(|&list| self.list_items(list));
        let Some(bindings) = bindings else {
            return self.malformed(span, "`(let ((NAME VALUE)...) FORM...)`");
        };
        let before = self.bindings.len();
        let mut bound = Vec::new();
        let mut waiting = Vec::new();
        for binding in bindings {
            let place = self.tree.span(binding);
            let items = match self.tree.proper_list(binding) {
                Some(items) => items.to_vec(),
                None => vec![binding],
            };
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
                self.bindings.push((name, variable));
            } else {
                waiting.push((name, variable));
            }
        }
        self.bindings.extend(waiting);
        let body = self.body(&rest[1..], span);
        self.bindings.truncate(before);
        Ir { span, kind: IrKind::Let(bound, Box::new(body)) }
    }

    /// All names are bound before any value is computed.
    fn letrec(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let bindings = rest.first().and_then(|&list| self.list_items(list));
        let Some(bindings) = bindings else {
            return self.malformed(span, "`(letrec ((NAME VALUE)...) FORM...)`");
        };
        let before = self.bindings.len();
        let mut bound = Vec::new();
        let mut values = Vec::new();
        for binding in bindings {
            let place = self.tree.span(binding);
            let items = self.tree.proper_list(binding).map(<[NodeId]>::to_vec).unwrap_or_default();
            let name = items.first().and_then(|&name| self.tree.symbol(name));
            let (Some(name), 2) = (name.filter(|&name| self.is_bindable(name)), items.len()) else {
                self.malformed(place, "`(NAME VALUE)`");
                continue;
            };
            let variable = self.bind(name, place);
            bound.push((variable, self.nil(place)));
            values.push((variable, items[1]));
        }
        let mut forms = Vec::new();
        for (variable, value) in values {
            let value = self.resolve(value);
            self.variables[variable.0 as usize].assigned = true;
            forms.push(Ir { span: value.span, kind: IrKind::SetLocal(variable, Box::new(value)) });
        }
        forms.push(self.body(&rest[1..], span));
        self.bindings.truncate(before);
        Ir { span, kind: IrKind::Let(bound, Box::new(Ir { span, kind: IrKind::Seq(forms) })) }
    }

    fn lambda(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let Some((&parameters, body)) = rest.split_first() else {
            return self.malformed(span, "`(lambda (PARAMETER...) FORM...)`");
        };
        let name = self.symbols.intern("lambda");
        let function = self.function(name, CodeKind::Function, parameters, body, span);
        Ir { span, kind: IrKind::Lambda(Box::new(function)) }
    }

    /// A function with parameters and a body. The root of a definition has tags of its own.
    pub(super) fn function(
        &mut self,
        name: Symbol,
        kind: CodeKind,
        parameters: NodeId,
        body: &[NodeId],
        span: Span,
    ) -> Function {
        let root = self.functions.is_empty();
        let ((parameters, bindings, body), scope) = self.in_function(kind, root, |compiler| {
            if root {
                compiler.find_tags(body);
            }
            let (parameters, bindings) = compiler.lambda_list(parameters);
            let body = compiler.body(body, span);
            (parameters, bindings, body)
        });
        Function {
            name,
            kind,
            parameters,
            bindings,
            captures: scope.captures,
            tags: scope.tags.unwrap_or_default(),
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

    fn setq(&mut self, rest: &[NodeId], span: Span) -> Ir {
        if rest.is_empty() || !rest.len().is_multiple_of(2) {
            return self.malformed(span, "`(setq NAME VALUE)`");
        }
        let mut forms: Vec<Ir> = rest.chunks(2).map(|pair| self.assign(pair[0], pair[1], span)).collect();
        match forms.pop() {
            Some(only) if forms.is_empty() => only,
            Some(last) => {
                forms.push(last);
                Ir { span, kind: IrKind::Seq(forms) }
            }
            None => self.nil(span),
        }
    }

    fn assign(&mut self, place: NodeId, value: NodeId, span: Span) -> Ir {
        let Some(name) = self.tree.symbol(place).filter(|&name| self.is_bindable(name)) else {
            let place = self.tree.span(place);
            return self.malformed(place, "a name that can be assigned");
        };
        let value = Box::new(self.resolve(value));
        match self.meaning(name, self.tree.span(place)) {
            Meaning::Local(variable) => {
                self.variables[variable.0 as usize].assigned = true;
                if self.is_network() {
                    self.network_assignment(span);
                }
                Ir { span, kind: IrKind::SetLocal(variable, value) }
            }
            Meaning::Global(global) => {
                if self.is_network() {
                    self.network_assignment(span);
                }
                let text = self.symbols.name(name).to_string();
                match self.program.globals[global as usize].kind {
                    GlobalKind::Variable => {}
                    GlobalKind::Fluent => {
                        let is_robots = self.program.globals[global as usize].span.is_none();
                        self.error(
                            "assigns-fluent",
                            span,
                            format!("`{text}` is a fluent; `setq` would replace the fluent itself"),
                            "assigned here",
                        )
                        .help = Some(match is_robots {
                            true => format!("`{text}` is set by the robot; a plan can only read it: `(value {text})`"),
                            false => format!("write `(setf (value {text}) …)`"),
                        });
                    }
                    _ => {
                        self.error("assigns-constant", span, format!("`{text}` cannot be assigned"), "not a variable");
                    }
                }
                Ir { span, kind: IrKind::SetGlobal(global, value) }
            }
            Meaning::Native(_) => {
                let text = self.symbols.name(name).to_string();
                self.error(
                    "assigns-constant",
                    span,
                    format!("`{text}` is a library function and cannot be assigned"),
                    "not a variable",
                );
                self.nil(span)
            }
        }
    }

    fn network_assignment(&mut self, span: Span) {
        self.error("network-effect", span, "a fluent network cannot assign", "a network may only look");
    }

    fn setf(&mut self, rest: &[NodeId], span: Span) -> Ir {
        if rest.is_empty() || !rest.len().is_multiple_of(2) {
            return self.malformed(span, "`(setf PLACE VALUE)`");
        }
        let mut forms: Vec<Ir> = rest.chunks(2).map(|pair| self.set_place(pair[0], pair[1], span)).collect();
        match forms.len() {
            1 => forms.remove(0),
            _ => Ir { span, kind: IrKind::Seq(forms) },
        }
    }

    /// `(setf (accessor ARG...) VALUE)` calls `%set-accessor`, a native or what `defstruct` made,
    /// with the arguments and the value.
    fn set_place(&mut self, place: NodeId, value: NodeId, span: Span) -> Ir {
        if self.tree.symbol(place).is_some() {
            return self.assign(place, value, span);
        }
        if self.is_network() {
            self.network_assignment(span);
        }
        let accessor = self.tree.head(place).map(|head| self.symbols.name(head).to_string());
        let Some(accessor) = accessor else {
            let at = self.tree.span(place);
            self.not_a_place(at, "this is not a place that can be assigned".to_string());
            return self.nil(span);
        };
        let setter = format!("%set-{accessor}");
        let Some(number) = self.natives.iter().position(|native| native.name == setter) else {
            return self.set_slot(&setter, place, value, span);
        };
        let nodes = self.tree.items(place)[1..].to_vec();
        let mut arguments = self.arguments(&nodes);
        arguments.push(self.resolve(value));
        let signature = &self.natives[number];
        if arguments.len() < usize::from(signature.min)
            || signature.max.is_some_and(|max| arguments.len() > usize::from(max))
        {
            let expected = super::resolve::describe_arity(signature.min - 1, signature.max.map(|max| max - 1));
            self.arity_error(&accessor, arguments.len() - 1, &expected, span);
        }
        Ir { span, kind: IrKind::Call(Callee::Native(number as u16), arguments) }
    }

    /// A slot of what `defstruct` defined, perhaps further down: whether there is one is known when
    /// the whole text is.
    fn set_slot(&mut self, setter: &str, place: NodeId, value: NodeId, span: Span) -> Ir {
        let setter = self.symbols.intern(setter);
        let at = self.tree.span(place);
        let Meaning::Global(global) = self.meaning(setter, at) else {
            self.not_a_place(at, "this is not a place that can be assigned".to_string());
            return self.nil(span);
        };
        let nodes = self.tree.items(place)[1..].to_vec();
        let mut arguments = self.arguments(&nodes);
        arguments.push(self.resolve(value));
        self.calls.push((global, arguments.len(), span));
        Ir { span, kind: IrKind::Call(Callee::Global(global), arguments) }
    }

    pub(super) fn not_a_place(&mut self, at: Span, message: String) {
        self.error("not-a-place", at, message, "not a place").help = Some(
            "places are names, `(value F)`, `(nth I LIST)`, `(gethash KEY TABLE)`, `(car X)`, `(cdr X)`, and slots of a `defstruct`"
                .into(),
        );
    }

    fn block(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let Some(name) = rest.first().and_then(|&name| self.tree.symbol(name)) else {
            return self.malformed(span, "`(block NAME FORM...)`");
        };
        self.in_block(Some(name), span, |compiler, _| compiler.body(&rest[1..], span))
    }

    fn return_from(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let (Some(name), true) = (rest.first().and_then(|&name| self.tree.symbol(name)), rest.len() <= 2) else {
            return self.malformed(span, "`(return-from NAME VALUE)`");
        };
        self.leave_named(name, rest.get(1).copied(), span)
    }

    fn return_nil_block(&mut self, rest: &[NodeId], span: Span) -> Ir {
        if rest.len() > 1 {
            return self.malformed(span, "`(return VALUE)`");
        }
        let name = self.symbols.intern("nil");
        self.leave_named(name, rest.first().copied(), span)
    }

    fn leave_named(&mut self, name: Symbol, value: Option<NodeId>, span: Span) -> Ir {
        let value = match value {
            Some(value) => self.resolve(value),
            None => self.nil(span),
        };
        match self.blocks.iter().rposition(|block| block.name == Some(name)) {
            Some(block) => self.leave(block, value, span),
            None => {
                let text = self.symbols.name(name).to_string();
                let message = match text.as_str() {
                    "nil" => "`return` stands in no loop".to_string(),
                    _ => format!("no block `{text}` is around this"),
                };
                self.error("no-block", span, message, "nothing to leave").help =
                    Some("`loop`, `dolist`, `dotimes` and `whenever` can be left by `(return V)`, `(block NAME …)` by `(return-from NAME V)`".into());
                value
            }
        }
    }

    /// RPL's loop: forms, with the bare words `until` and `while` between them.
    fn loop_form(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let nil = self.symbols.intern("nil");
        let rest = rest.to_vec();
        self.in_block(Some(nil), span, |compiler, _| {
            let block = compiler.blocks.len() - 1;
            let mut forms = Vec::new();
            let mut items = rest.into_iter();
            while let Some(item) = items.next() {
                let word = compiler.tree.symbol(item).map(|word| compiler.symbols.name(word).to_string());
                let until = match word.as_deref() {
                    Some("until") => true,
                    Some("while") => false,
                    _ => {
                        forms.push(compiler.resolve(item));
                        continue;
                    }
                };
                let place = compiler.tree.span(item);
                let Some(condition) = items.next() else {
                    compiler.malformed(place, "`until CONDITION` or `while CONDITION`");
                    break;
                };
                let condition = Box::new(compiler.resolve(condition));
                let nothing = compiler.nil(place);
                let leave = Box::new(compiler.leave(block, nothing, place));
                let stay = Box::new(compiler.nil(place));
                let (then, otherwise) = if until { (leave, stay) } else { (stay, leave) };
                forms.push(Ir { span: place, kind: IrKind::If(condition, then, otherwise) });
            }
            Ir { span, kind: IrKind::Loop(Box::new(Ir { span, kind: IrKind::Seq(forms) })) }
        })
    }

    fn retry_or_refail(&mut self, special: Special, rest: &[NodeId], span: Span) -> Ir {
        if !rest.is_empty() {
            return self.malformed(span, "`(retry)` or `(refail)`");
        }
        let Some((retry, failure)) = self.handlers.last().map(|handler| (handler.retry, handler.failure)) else {
            self.error(
                "no-handler",
                span,
                "this stands in no clause of `with-failure-handling`",
                "no failure to handle here",
            );
            return self.nil(span);
        };
        if special == Special::Refail {
            self.capture(failure);
            return Ir { span, kind: IrKind::Refail(failure) };
        }
        match self.blocks.iter().position(|block| block.id == retry) {
            Some(block) => {
                let nothing = self.nil(span);
                self.leave(block, nothing, span)
            }
            None => self.nil(span),
        }
    }
}
