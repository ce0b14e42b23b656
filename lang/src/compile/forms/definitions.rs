//! Definitions, which stand at top level, and loaded files.

use super::special_form::{Role, SpecialForm, Written};
use crate::code::{Atom, CodeKind, FailureClass, GlobalKind};
use crate::compile::compilation::Purpose;
use crate::compile::compiler::{Compiler, thunk};
use crate::compile::emit;
use crate::compile::ir::{Ir, IrKind};
use crate::compile::lambda_list::Lists;
use crate::compile::resolved::{Defined, TopLevel};
use crate::layout::ItemShape::{Data, Form};
use crate::layout::Layout;
use crate::layout::Style::Body;
use crate::reader::read;
use crate::source::Span;
use crate::symbol::Symbol;
use crate::syntax::{NodeId, NodeKind};
use std::sync::Arc;

/// More places than this a valve does not have: to find the next one looks at all of them.
const MAX_PLACES: u32 = 100;

pub(super) const FORMS: &[SpecialForm] = &[
    SpecialForm {
        names: &["defvar"],
        form: "(defvar NAME [VALUE [\"DOC\"]])",
        doc: "Defines a variable.",
        example: "",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Naming(|compiler, written, bodies| compiler.define_value(GlobalKind::Variable, written, bodies)),
    },
    SpecialForm {
        names: &["defconstant"],
        form: "(defconstant NAME VALUE [\"DOC\"])",
        doc: "Defines a name that is never assigned.",
        example: "",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Naming(|compiler, written, bodies| compiler.define_value(GlobalKind::Constant, written, bodies)),
    },
    SpecialForm {
        names: &["defun"],
        form: "(defun NAME (PARAMETER...) [\"DOC\"] FORM...)",
        doc: "Defines a function.",
        example: "",
        layout: Some(Layout::with(Body(2), &[Form, Data])),
        role: Role::Naming(|compiler, written, _| {
            compiler.define_function(CodeKind::Function, written.form.name(), written.rest(), written.span)
        }),
    },
    SpecialForm {
        names: &["defmacro"],
        form: "(defmacro NAME (PARAMETER...) [\"DOC\"] FORM...)",
        doc: "Defines a form that is replaced by what its body returns.",
        example: "",
        layout: Some(Layout::with(Body(2), &[Form, Data])),
        role: Role::Definition(|compiler, written, _| compiler.define_macro(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["def-plan", "def-interp-proc"],
        form: "(def-plan NAME (PARAMETER...) [\"DOC\"] FORM...)",
        doc: "Defines a plan: called like a function, and each call is a node of the task tree.",
        example: "(def-plan wash (number)\n  \"Washes cups, one after the other.\"\n  (n-times number (wait-time 20)))",
        layout: Some(Layout::with(Body(2), &[Form, Data])),
        role: Role::Naming(|compiler, written, _| {
            compiler.define_function(CodeKind::Plan, written.form.name(), written.rest(), written.span)
        }),
    },
    SpecialForm {
        names: &["def-goal"],
        form: "(def-goal (achieve (NAME PARAMETER...)) FORM...)",
        doc: "Defines how goals of this name are achieved, by `(achieve (NAME ARGUMENT...))`. Several definitions of one goal are methods, tried in their order. Among parameters that begin with `?`, other names are words of the goal: `(achieve (the ?object on ?place))`.",
        example: "(def-goal (achieve (clean room))\n  (print room))\n(achieve (clean 'hall))",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Naming(|compiler, written, _| compiler.define_goal(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["def-resume"],
        form: "(def-resume NAME [\"DOC\"] FORM...)",
        doc: "Defines a plan without parameters that runs by itself, before all else, when a run with a host or a module in another process goes on after a crash (`rpl resume`): the world has not waited, and the plan may look at it first.",
        example: "(def-fluent cup-in-hand nil)\n(def-resume look-at-hand\n  \"Nobody knows what became of the cup.\"\n  (setf (value cup-in-hand) nil))",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Naming(|compiler, written, _| compiler.define_resumption(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["def-fluent", "global-fluent"],
        form: "(def-fluent NAME VALUE [\"DOC\"])",
        doc: "Defines a fluent: a value that changes over time and wakes tasks.",
        example: "(def-fluent cups 0 \"How many cups are washed.\")\n(par (wait-for (>= cups 1))\n     (setf (value cups) 1))",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Naming(|compiler, written, bodies| compiler.define_value(GlobalKind::Fluent, written, bodies)),
    },
    SpecialForm {
        names: &["def-valve"],
        form: "(def-valve NAME [PLACES] [\"DOC\"])",
        doc: "Defines a valve: a pre-emptible semaphore that guards an effector. So many tasks as it has places can have it at a time; without a number, one.",
        example: "(def-valve docks 2)\n(par (with-valve docks (wait-time 1))\n     (with-valve docks (wait-time 1)))",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Naming(|compiler, written, _| compiler.define_valve(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["def-failure"],
        form: "(def-failure NAME (PARENT) (SLOT...))",
        doc: "Defines a class of failure with slots.",
        example: "(def-failure slipped (plan-failure) (object))\n(ignore-failures (slipped)\n  (fail slipped \"the cup slipped\" :object 'cup))",
        layout: Some(Layout::with(Body(2), &[Form, Data, Data])),
        role: Role::Definition(|compiler, written, _| compiler.define_failure(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["load"],
        form: "(load \"FILE\")",
        doc: "Reads another file, relative to this one and within the main file's folder tree.",
        example: "",
        layout: None,
        role: Role::Definition(|compiler, written, bodies| compiler.load(written.rest(), written.span, bodies)),
    },
    SpecialForm {
        names: &["deftest"],
        form: "(deftest NAME [\"DOC\"] [:world \"NAME\"] [:scenario \"FILE\"] [:seed N] [:until TIME] FORM...)",
        doc: "Defines a test, run by `rpl test` after the definitions of its text in a system of its own. It passes if its forms succeed.",
        example: "(deftest adding\n  \"Numbers are added.\"\n  (assert (= (+ 1 2) 3)))",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Definition(|compiler, written, bodies| {
            bodies.extend(compiler.define_test(written.rest(), written.span))
        }),
    },
];

impl Compiler<'_> {
    /// The name a definition gives, unless it is one that cannot be defined.
    fn defined_name(&mut self, node: Option<&NodeId>, form: &str, span: Span) -> Option<Symbol> {
        let Some((&node, name)) = node.and_then(|node| Some((node, self.tree.symbol(*node)?))) else {
            self.malformed(span, form);
            return None;
        };
        if self.refuses_to_bind(node) {
            return None;
        }
        let text = self.symbols.name(name).to_string();
        if !self.is_bindable(name) || self.specials.contains_key(&name) {
            self.error(
                "reserved-name",
                span,
                format!("`{text}` belongs to the language and cannot be defined"),
                "reserved name",
            );
            return None;
        }
        if self.purpose == Purpose::User && self.is_robot_name(name) {
            self.error(
                "reserved-name",
                span,
                format!("`{text}` belongs to the robot and cannot be defined"),
                "reserved name",
            );
            return None;
        }
        Some(name)
    }

    /// Splits the documentation string from a body that has more than it.
    fn documentation(&self, body: &[NodeId]) -> (Option<Arc<str>>, usize) {
        match body.first().map(|&first| &self.tree.get(first).kind) {
            Some(NodeKind::Str(text)) if body.len() > 1 => (Some(text.clone()), 1),
            _ => (None, 0),
        }
    }

    pub(super) fn define_function(&mut self, kind: CodeKind, word: &str, rest: &[NodeId], span: Span) {
        let form = &format!("`({word} NAME (PARAMETER...) FORM...)`");
        let Some(name) = self.defined_name(rest.first(), form, span) else { return };
        let Some(&parameters) = rest.get(1) else {
            self.malformed(span, form);
            return;
        };
        let (doc, skip) = self.documentation(&rest[2..]);
        // The name is known inside the body, so that a function can call itself.
        let global = self.define_global(name, GlobalKind::Function(u32::MAX), doc.clone(), Some(span));
        self.program.resumptions.retain(|&known| known != name);
        let mut function = self.function(name, kind, parameters, Lists::Refused, &rest[2 + skip..], span);
        function.doc = doc;
        let code = emit::emit(self, &function, &[]);
        self.program.globals[global as usize].kind = GlobalKind::Function(code);
        self.macros.defined(global);
        self.note_definition(name, span, Defined::Function(global, function));
    }

    /// `(def-resume NAME FORM...)`: a plan without parameters; defined again, it keeps its turn.
    fn define_resumption(&mut self, rest: &[NodeId], span: Span) {
        let Some((&node, body)) = rest.split_first() else {
            self.malformed(span, "`(def-resume NAME FORM...)`");
            return;
        };
        let Some(name) = self.defined_name(Some(&node), "`(def-resume NAME FORM...)`", span) else { return };
        let turn = self.program.resumptions.iter().position(|&known| known == name);
        let no_parameters = self.tree.list(&[], span);
        self.define_function(CodeKind::Plan, "def-plan", &[&[node, no_parameters], body].concat(), span);
        let resumptions = &mut self.program.resumptions;
        resumptions.insert(turn.unwrap_or(resumptions.len()), name);
    }

    fn define_macro(&mut self, rest: &[NodeId], span: Span) {
        let form = "`(defmacro NAME (PARAMETER...) FORM...)`";
        let Some(name) = self.defined_name(rest.first(), form, span) else { return };
        let Some(&parameters) = rest.get(1) else {
            self.malformed(span, form);
            return;
        };
        let (doc, skip) = self.documentation(&rest[2..]);
        let errors = self.diagnostics.len();
        self.in_macro = true;
        let mut function = self.function(name, CodeKind::Function, parameters, Lists::Taken, &rest[2 + skip..], span);
        self.in_macro = false;
        function.doc = doc;
        let code = emit::emit(self, &function, &[]);
        if self.diagnostics.len() == errors {
            self.program.macros.insert(name, code);
            self.broken_macros.remove(&name);
        } else {
            self.broken_macros.insert(name);
        }
        self.note_definition(name, span, Defined::Macro(function));
    }

    /// `(defvar NAME VALUE "DOC")` and its like: the name, and its value as something to run.
    fn define_value(&mut self, kind: GlobalKind, written: &Written<'_>, bodies: &mut Vec<TopLevel>) {
        let (rest, span) = (written.rest(), written.span);
        let form = &format!("`({} NAME VALUE \"documentation\")`", written.form.name());
        let Some(name) = self.defined_name(rest.first(), form, span) else { return };
        if rest.len() > 3 {
            self.malformed(span, form);
            return;
        }
        let doc = rest.get(2).and_then(|&doc| match &self.tree.get(doc).kind {
            NodeKind::Str(text) => Some(text.clone()),
            _ => None,
        });
        let is_fluent = kind == GlobalKind::Fluent;
        let global = self.define_global(name, kind, doc, Some(span));
        self.note_definition(name, span, Defined::Value);
        let value = rest.get(1).copied();
        let body_name = self.symbols.intern("form");
        let (value, scope) = self.in_function(CodeKind::Function, true, |compiler| match value {
            Some(value) => {
                compiler.find_tags(&[value]);
                compiler.resolve(value)
            }
            None => compiler.nil(span),
        });
        if self.purpose == Purpose::Library {
            self.begins_as(global, &value);
            return;
        }
        let value = Box::new(value);
        let kind = match is_fluent {
            true => IrKind::DefFluent(global, value),
            false => IrKind::SetGlobal(global, value),
        };
        let body = thunk(body_name, CodeKind::Function, Ir { span, kind }, scope, span);
        bodies.push(TopLevel::Definition(body));
    }

    /// The constant that a variable or fluent of the library is when a run begins: no code of a library runs then.
    fn begins_as(&mut self, global: u32, value: &Ir) {
        let constant = match value.kind {
            IrKind::Nil => self.constant(Atom::Nil),
            IrKind::True => self.constant(Atom::True),
            IrKind::Int(number) => self.constant(Atom::Int(number)),
            IrKind::Const(constant) => constant,
            _ => {
                let label = "a number, a text, a symbol or a quoted list is expected";
                self.error("library-form", value.span, "what a library defines begins as a constant", label);
                return;
            }
        };
        self.program.globals[global as usize].initial = Some(constant);
        self.macros.defined(global);
    }

    fn define_valve(&mut self, rest: &[NodeId], span: Span) {
        let form = "`(def-valve NAME [PLACES] [\"DOC\"])`";
        let Some(name) = self.defined_name(rest.first(), form, span) else { return };
        let number = rest.get(1).filter(|&&node| !matches!(self.tree.get(node).kind, NodeKind::Str(_)));
        let (places, rest) = match number {
            Some(&number) => (self.places(number), &rest[2..]),
            None => (Some(1), &rest[1..]),
        };
        let doc = match rest {
            [] => None,
            [doc] => match &self.tree.get(*doc).kind {
                NodeKind::Str(text) => Some(text.clone()),
                _ => {
                    self.malformed(span, form);
                    return;
                }
            },
            _ => {
                self.malformed(span, form);
                return;
            }
        };
        if places.is_some_and(|places| self.has_other_places(name, places, span)) {
            return;
        }
        // What is wrong about a number is told once, and not of each use of the name.
        self.define_global(name, GlobalKind::Valve { places: places.unwrap_or(1) }, doc, Some(span));
        self.note_definition(name, span, Defined::Value);
    }

    fn places(&mut self, number: NodeId) -> Option<u32> {
        let node = self.tree.get(number);
        let (span, text) = match node.kind {
            NodeKind::Int(number) => {
                let places = u32::try_from(number).ok().filter(|places| (1..=MAX_PLACES).contains(places));
                if places.is_some() {
                    return places;
                }
                (node.span, format!("a valve has from 1 to {MAX_PLACES} places, and {number} are asked for"))
            }
            _ => (node.span, "the places of a valve are a whole number, written out".to_string()),
        };
        self.error("valve-places", span, text, format!("a number from 1 to {MAX_PLACES}"));
        None
    }

    /// Refuses a valve that is defined already with another number of places: tasks may have them.
    fn has_other_places(&mut self, name: Symbol, places: u32, span: Span) -> bool {
        let known = self.program.names.get(&name).map(|&global| &self.program.globals[global as usize].kind);
        let Some(&GlobalKind::Valve { places: known }) = known else { return false };
        if known == places {
            return false;
        }
        let name = self.symbols.name(name);
        let text = format!("`{name}` is a valve with {known} places, and it keeps them as long as the run goes on");
        let help = format!("write {known}, or give the valve another name");
        self.error("valve-places", span, text, format!("asks for {places}")).help = Some(help);
        true
    }

    /// `(def-failure NAME (PARENT) (SLOT...))`
    fn define_failure(&mut self, rest: &[NodeId], span: Span) {
        let form = "`(def-failure NAME (PARENT) (SLOT...))`";
        if rest.first().is_some_and(|&name| self.refuses_to_bind(name)) {
            return;
        }
        let Some(name) = rest.first().and_then(|&name| self.tree.symbol(name)) else {
            self.malformed(span, form);
            return;
        };
        let parents = rest.get(1).map(|&list| self.tree.items(list).to_vec()).unwrap_or_default();
        let parent = match parents.as_slice() {
            [] => Some(self.symbols.intern("plan-failure")),
            [parent] => self.parent_class(*parent),
            _ => {
                self.malformed(span, form);
                return;
            }
        };
        let Some(parent) = parent else { return };
        if self.program.is_failure_subclass(parent, name) {
            self.error("failure-cycle", span, "a failure class cannot be below itself", "circular");
            return;
        }
        let slots = rest.get(2).map(|&list| self.tree.items(list).to_vec()).unwrap_or_default();
        let slots = slots.into_iter().filter_map(|slot| self.tree.symbol(slot)).collect();
        self.program.failure_classes.insert(name, FailureClass { parent: Some(parent), slots });
        self.note_definition(name, span, Defined::Failure);
    }

    /// The class above another: it must stand above it in the text, too.
    fn parent_class(&mut self, node: NodeId) -> Option<Symbol> {
        let span = self.tree.span(node);
        let Some(name) = self.tree.symbol(node) else {
            self.malformed(span, "the name of a failure class");
            return None;
        };
        if !self.program.failure_classes.contains_key(&name) {
            self.unknown_class(name, span, false);
            return None;
        }
        Some(name)
    }

    fn load(&mut self, rest: &[NodeId], span: Span, bodies: &mut Vec<TopLevel>) {
        let path = match rest {
            [path] => match &self.tree.get(*path).kind {
                NodeKind::Str(path) => path.clone(),
                _ => return drop(self.malformed(span, "`(load \"FILE\")`")),
            },
            _ => return drop(self.malformed(span, "`(load \"FILE\")`")),
        };
        let from = self.program.sources.get(span.source).name.clone();
        match self.loader.load(&from, &path) {
            Err(reason) => {
                self.error("load", span, format!("cannot load `{path}`: {reason}"), "loaded here");
            }
            Ok((name, _)) if self.loading.contains(&name) => {
                self.error("load", span, format!("`{name}` loads itself"), "loaded here");
            }
            Ok(_) if self.expansion.is_over => {}
            Ok((name, text)) => {
                let source = self.program.sources.add(&name, &text);
                let before = self.tree.nodes.len();
                let (forms, diagnostics) = read(&text, source, self.symbols, &mut self.tree);
                self.diagnostics.extend(diagnostics);
                self.note_holes(before);
                let parts = self.tree.nodes.len() - before;
                if self.loaded.insert(name.clone()) {
                    self.expansion.has_read(parts);
                } else if !self.expansion.has_read_again(parts) {
                    let message = format!(
                        "with `{name}` loaded once more, files that were loaded before and expansions have more than {} parts",
                        self.expansion.most
                    );
                    return self.no_more(span, message, "load each file once, above its first use".into());
                }
                self.loading.push(name);
                self.predeclare(&forms);
                for form in forms {
                    self.top_level(form, bodies);
                }
                self.loading.pop();
            }
        }
    }
}
