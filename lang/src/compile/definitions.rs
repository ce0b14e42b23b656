//! Top-level forms: definitions, loaded files, and forms that run.

use super::ir::{Defined, Function, Ir, IrKind};
use super::special::Special;
use super::{Compiler, Purpose, TopLevel, emit, thunk};
use crate::code::{CodeKind, FailureClass, GlobalKind};
use crate::source::Span;
use crate::symbol::Symbol;
use crate::syntax::{Kind, NodeId};
use std::sync::Arc;

impl Compiler<'_> {
    /// Notes the names a file defines, so that a name of the library that is defined again means
    /// the file's own from the first line on.
    pub(super) fn predeclare(&mut self, forms: &[NodeId]) {
        if self.purpose == Purpose::Library {
            return;
        }
        for &form in forms {
            let special = self.tree.head(form).and_then(|head| self.specials.get(&head).copied());
            let Some(name) = self.tree.items(form).get(1).and_then(|&name| self.tree.symbol(name)) else { continue };
            let defines_value = special.is_some_and(|special| {
                special.is_definition()
                    && !matches!(special, Special::Defmacro | Special::DefFailure | Special::Load | Special::Deftest)
            });
            let shadows = self.program.names.get(&name).is_some_and(|&global| self.is_library(global))
                || self.native_numbers.contains_key(&name);
            if defines_value && shadows && !self.is_robot_name(name) {
                let span = self.tree.span(form);
                self.program.names.remove(&name);
                self.meaning(name, span);
            }
        }
    }

    /// Whether the name is the robot's and there is a robot; without one it is free.
    fn is_robot_name(&self, name: Symbol) -> bool {
        let is_defined = self.program.names.get(&name).is_some_and(|&global| self.is_library(global));
        is_defined && self.robot_names.iter().any(|known| known == self.symbols.name(name))
    }

    pub(super) fn top_level(&mut self, node: NodeId, bodies: &mut Vec<TopLevel>) {
        self.nested(node, |compiler| compiler.top_level_here(node, bodies));
    }

    fn top_level_here(&mut self, node: NodeId, bodies: &mut Vec<TopLevel>) {
        let span = self.tree.span(node);
        let items = self.tree.items(node).to_vec();
        let Some(head) = self.tree.head(node) else {
            return bodies.push(TopLevel::Form(self.top_level_form(node)));
        };
        if let Some(&code) = self.program.macros.get(&head) {
            if let Some(expansion) = self.expand(code, node) {
                self.top_level(expansion, bodies);
                self.expansions -= 1;
            }
            return;
        }
        match self.specials.get(&head).copied() {
            Some(Special::Progn) => {
                // Definitions may stand in a top-level `progn`, so that a macro can make several.
                let holds_definition = items[1..].iter().any(|&item| self.is_definition_form(item));
                if !holds_definition {
                    return bodies.push(TopLevel::Form(self.top_level_form(node)));
                }
                for &item in &items[1..] {
                    self.top_level(item, bodies);
                }
            }
            Some(special) if special.is_definition() => self.definition(special, &items, span, bodies),
            _ => bodies.push(TopLevel::Form(self.top_level_form(node))),
        }
    }

    fn is_definition_form(&self, node: NodeId) -> bool {
        self.tree.head(node).is_some_and(|head| self.specials.get(&head).is_some_and(|special| special.is_definition()))
    }

    /// A form that runs: a plan body of its own.
    fn top_level_form(&mut self, node: NodeId) -> Function {
        let span = self.tree.span(node);
        let name = self.symbols.intern("form");
        let (body, scope) = self.in_function(CodeKind::Function, true, |compiler| {
            compiler.find_tags(&[node]);
            compiler.resolve(node)
        });
        thunk(name, CodeKind::Function, body, scope, span)
    }

    fn definition(&mut self, special: Special, items: &[NodeId], span: Span, bodies: &mut Vec<TopLevel>) {
        let rest = &items[1..];
        match special {
            Special::Defun | Special::DefPlan => self.define_function(special, rest, span),
            Special::DefGoal => self.define_goal(rest, span),
            Special::Defmacro => self.define_macro(rest, span),
            Special::Defvar | Special::Defconstant | Special::DefFluent => {
                bodies.extend(self.define_value(special, rest, span).map(TopLevel::Definition));
            }
            Special::DefValve => self.define_valve(rest, span),
            Special::DefFailure => self.define_failure(rest, span),
            Special::Load => self.load(rest, span, bodies),
            Special::Deftest => bodies.extend(self.define_test(rest, span)),
            _ => unreachable!("only definitions come here"),
        }
    }

    /// The name a definition gives, unless it is one that cannot be defined.
    fn defined_name(&mut self, node: Option<&NodeId>, form: &str, span: Span) -> Option<Symbol> {
        let Some(name) = node.and_then(|&node| self.tree.symbol(node)) else {
            self.malformed(span, form);
            return None;
        };
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
            Some(Kind::Str(text)) if body.len() > 1 => (Some(text.clone()), 1),
            _ => (None, 0),
        }
    }

    pub(super) fn define_function(&mut self, special: Special, rest: &[NodeId], span: Span) {
        let (form, kind) = match special {
            Special::Defun => ("`(defun NAME (PARAMETER...) FORM...)`", CodeKind::Function),
            _ => ("`(def-plan NAME (PARAMETER...) FORM...)`", CodeKind::Plan),
        };
        let Some(name) = self.defined_name(rest.first(), form, span) else { return };
        let Some(&parameters) = rest.get(1) else {
            self.malformed(span, form);
            return;
        };
        let (doc, skip) = self.documentation(&rest[2..]);
        // The name is known inside the body, so that a function can call itself.
        let global = self.define_global(name, GlobalKind::Function(u32::MAX), doc.clone(), Some(span));
        self.program.macros.remove(&name);
        let mut function = self.function(name, kind, parameters, &rest[2 + skip..], span);
        function.doc = doc;
        let code = emit::emit(self, &function, &[]);
        self.program.globals[global as usize].kind = GlobalKind::Function(code);
        self.note_definition(name, span, Defined::Function(global, function));
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
        let mut function = self.function(name, CodeKind::Function, parameters, &rest[2 + skip..], span);
        function.doc = doc;
        let code = emit::emit(self, &function, &[]);
        if self.diagnostics.len() == errors {
            self.program.macros.insert(name, code);
        }
        self.note_definition(name, span, Defined::Macro(function));
    }

    fn define_value(&mut self, special: Special, rest: &[NodeId], span: Span) -> Option<Function> {
        let form = match special {
            Special::Defvar => "`(defvar NAME VALUE \"documentation\")`",
            Special::Defconstant => "`(defconstant NAME VALUE \"documentation\")`",
            _ => "`(def-fluent NAME VALUE \"documentation\")`",
        };
        let name = self.defined_name(rest.first(), form, span)?;
        if rest.len() > 3 {
            self.malformed(span, form);
            return None;
        }
        let doc = rest.get(2).and_then(|&doc| match &self.tree.get(doc).kind {
            Kind::Str(text) => Some(text.clone()),
            _ => None,
        });
        let kind = match special {
            Special::Defvar => GlobalKind::Variable,
            Special::Defconstant => GlobalKind::Constant,
            _ => GlobalKind::Fluent,
        };
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
        let value = Box::new(value);
        let kind = match special {
            Special::DefFluent => IrKind::DefFluent(global, value),
            _ => IrKind::SetGlobal(global, value),
        };
        Some(thunk(body_name, CodeKind::Function, Ir { span, kind }, scope, span))
    }

    fn define_valve(&mut self, rest: &[NodeId], span: Span) {
        let Some(name) = self.defined_name(rest.first(), "`(def-valve NAME)`", span) else { return };
        let doc = rest.get(1).and_then(|&doc| match &self.tree.get(doc).kind {
            Kind::Str(text) => Some(text.clone()),
            _ => None,
        });
        self.define_global(name, GlobalKind::Valve, doc, Some(span));
        self.note_definition(name, span, Defined::Value);
    }

    /// `(def-failure NAME (PARENT) (SLOT...))`
    fn define_failure(&mut self, rest: &[NodeId], span: Span) {
        let form = "`(def-failure NAME (PARENT) (SLOT...))`";
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
                Kind::Str(path) => path.clone(),
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
            Ok((name, text)) => {
                let source = self.program.sources.add(&name, &text);
                let (forms, diagnostics) = crate::reader::read(&text, source, self.symbols, &mut self.tree);
                self.diagnostics.extend(diagnostics);
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
