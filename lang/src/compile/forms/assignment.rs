//! Assignment of variables and places.

use super::special_form::{Role, SpecialForm};
use crate::code::{Atom, GlobalKind};
use crate::compile::compilation::describe_arity;
use crate::compile::compiler::Compiler;
use crate::compile::ir::{Callee, Ir, IrKind};
use crate::compile::meaning::Meaning;
use crate::source::Span;
use crate::symbol::Qualifier;
use crate::syntax::NodeId;

pub(super) const FORMS: &[SpecialForm] = &[
    SpecialForm {
        names: &["setq"],
        form: "(setq NAME VALUE...)",
        doc: "Assigns variables; gives the last value.",
        example: "",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.setq(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["setf"],
        form: "(setf PLACE VALUE...)",
        doc: "Assigns places: a variable, (value F), (nth I LIST), (vref VECTOR I), (gethash KEY TABLE), a slot of a `defstruct`; gives the last value.",
        example: "",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.setf(written.rest(), written.span)),
    },
];

/// One accessor of a place, and its argument beside what it accesses.
#[derive(Clone, Copy)]
struct Access {
    accessor: NodeId,
    argument: Option<NodeId>,
}

impl Compiler<'_> {
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
        let name = self.tree.name(place).filter(|&(_, name)| self.is_bindable(name));
        let Some((qualifier, name)) = name else {
            let place = self.tree.span(place);
            return self.malformed(place, "a name that can be assigned");
        };
        let value = Box::new(self.resolve(value));
        match self.meaning(qualifier, name, self.tree.span(place)) {
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
                let is_constant = matches!(self.program.globals[global as usize].kind, GlobalKind::Constant);
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
                        let message = format!("`{text}` cannot be assigned");
                        let help = match is_constant {
                            true => "what `defvar` defines can be assigned".to_string(),
                            false => format!("call the variable something else: `{text}` means something already"),
                        };
                        self.error("assigns-constant", span, message, "not a variable").help = Some(help);
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
        if let Some((fluent, steps)) = self.way_from_value(place) {
            return self.set_within(fluent, &steps, value, span);
        }
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
            let expected = describe_arity(signature.min - 1, signature.max.map(|max| max - 1));
            self.arity_error(&accessor, arguments.len() - 1, &expected, span);
        }
        Ir { span, kind: IrKind::Call(Callee::Native(number as u16), arguments) }
    }

    /// For a place within `(value FLUENT)`: the fluent, and the accessors that lead to it from the place.
    fn way_from_value(&self, place: NodeId) -> Option<(NodeId, Vec<Access>)> {
        let (mut steps, mut at) = (Vec::new(), place);
        loop {
            let items = self.tree.proper_list(at)?;
            let (qualifier, name) = self.tree.name(*items.first()?)?;
            if self.is_lexically_bound(qualifier, name) {
                return None;
            }
            let (within, argument) = match (self.symbols.name(name), items) {
                ("value", &[_, fluent]) => return (!steps.is_empty()).then_some((fluent, steps)),
                ("nth" | "gethash", &[_, argument, within]) | ("elt" | "vref", &[_, within, argument]) => {
                    (within, Some(argument))
                }
                (_, &[_, within]) => (within, None),
                _ => return None,
            };
            steps.push(Access { accessor: items[0], argument });
            at = within;
        }
    }

    /// What a fluent has never changes: it is assigned a copy that differs at the place.
    fn set_within(&mut self, fluent: NodeId, steps: &[Access], value: NodeId, span: Span) -> Ir {
        let mut arguments = vec![self.resolve(fluent), self.resolve(value)];
        for &Access { accessor, argument } in steps {
            let at = self.tree.span(accessor);
            let Some((_, name)) = self.tree.name(accessor) else { continue };
            let setter = format!("%set-{}", self.symbols.name(name));
            let is_native = self.natives.iter().any(|native| native.name == setter);
            arguments.push(match is_native {
                true => {
                    let name = self.constant(Atom::Symbol(name));
                    Ir { span: at, kind: IrKind::Const(name) }
                }
                false => {
                    let setter = self.symbols.intern(&setter);
                    match self.meaning(Some(Qualifier::Global), setter, at) {
                        Meaning::Global(global) => Ir { span: at, kind: IrKind::Global(global) },
                        Meaning::Local(_) | Meaning::Native(_) => self.nil(at),
                    }
                }
            });
            arguments.push(match argument {
                Some(argument) => self.resolve(argument),
                None => self.nil(at),
            });
        }
        self.native_ir("%set-within", arguments, span)
    }

    /// A slot of what `defstruct` defined, perhaps further down: whether there is one is known when
    /// the whole text is.
    fn set_slot(&mut self, setter: &str, place: NodeId, value: NodeId, span: Span) -> Ir {
        let setter = self.symbols.intern(setter);
        let at = self.tree.span(place);
        let Meaning::Global(global) = self.meaning(Some(Qualifier::Global), setter, at) else {
            self.not_a_place(at, "this is not a place that can be assigned".to_string());
            return self.nil(span);
        };
        let nodes = self.tree.items(place)[1..].to_vec();
        let mut arguments = self.arguments(&nodes);
        arguments.push(self.resolve(value));
        self.calls.push((global, arguments.len(), span));
        Ir { span, kind: IrKind::Call(Callee::Global(global), arguments) }
    }

    pub(in crate::compile) fn not_a_place(&mut self, at: Span, message: String) {
        self.error("not-a-place", at, message, "not a place").help = Some(
            "places are names, `(value F)`, `(nth I LIST)`, `(vref VECTOR I)`, `(gethash KEY TABLE)`, `(car X)`, `(cdr X)`, and slots of a `defstruct`"
                .into(),
        );
    }
}
