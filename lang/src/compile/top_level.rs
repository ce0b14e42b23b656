//! Top-level forms, one after the other: what they define, and what runs.

use super::compilation::Purpose;
use super::compiler::{Compiler, thunk};
use super::emit;
use super::expansion::Expansion;
use super::forms::{Role, Written};
use super::ir::Function;
use super::resolved::{Compiled, Resolved, Test, TopLevel};
use crate::code::{Atom, CodeKind};
use crate::source::Span;
use crate::symbol::Symbol;
use crate::syntax::NodeId;

impl Compiler<'_> {
    pub(super) fn run(mut self, forms: &[NodeId], span: Span) -> Compiled {
        let name = self.symbols.intern("main");
        self.predeclare(forms);
        self.note_goals(forms);
        let mut bodies = Vec::new();
        let mut defined = None;
        for &form in forms {
            let before = (bodies.len(), self.definitions.len());
            self.top_level(form, &mut bodies);
            defined = self.only_defined(form, before, &bodies);
        }
        let (main, tests) = self.emit_main(name, bodies, defined, span);
        self.check_undefined();
        self.check_classes();
        self.check_calls();
        if self.purpose == Purpose::Library {
            self.program.library_globals = self.program.globals.len() as u32;
        }
        let resolved = Resolved {
            definitions: self.definitions,
            forms: self.forms,
            tests: self.test_bodies,
            variables: self.variables,
        };
        let (codes, constants) = (self.codes, self.constants);
        let Expansion { made: expanded, lacks_room, .. } = self.expansion;
        Compiled { main, tests, diagnostics: self.diagnostics, resolved, codes, constants, expanded, lacks_room }
    }

    /// The name a top-level form defines if there is nothing to run in it: that is its value.
    /// `before` counts the bodies and definitions before it.
    fn only_defined(&self, form: NodeId, before: (usize, usize), bodies: &[TopLevel]) -> Option<Symbol> {
        let (bodies, definitions) = (&bodies[before.0..], &self.definitions[before.1..]);
        let is_test = |body: &TopLevel| matches!(body, TopLevel::Test(..));
        if !bodies.iter().all(is_test) || bodies.is_empty() && definitions.is_empty() {
            return None;
        }
        let named = self.tree.items(form).get(1).and_then(|&name| self.tree.symbol(name));
        named.or_else(|| definitions.last().map(|definition| definition.name))
    }

    /// One code that runs each form's code in turn: a form is a plan body of its own. Its value is
    /// that of the last, or what the last one `defined`. One more for each test, which runs the
    /// definitions and then the test.
    fn emit_main(
        &mut self,
        name: Symbol,
        bodies: Vec<TopLevel>,
        defined: Option<Symbol>,
        span: Span,
    ) -> (u32, Vec<Test>) {
        let (mut calls, mut definitions, mut forms) = (Vec::new(), Vec::new(), Vec::new());
        for body in bodies {
            match body {
                TopLevel::Definition(body) => {
                    let call = self.emit_call(&body);
                    definitions.push(call);
                    calls.push(call);
                    self.forms.push(body);
                }
                TopLevel::Form(body) => {
                    calls.push(self.emit_call(&body));
                    self.forms.push(body);
                }
                TopLevel::Test(form, body) => {
                    forms.push((form, self.emit_call(&body)));
                    self.test_bodies.push(body);
                }
            }
        }
        let defined = defined.map(|name| self.constant(Atom::Symbol(name)));
        let main = self.add_code(emit::sequence(name, span, &calls, defined));
        let tests = forms
            .into_iter()
            .map(|(form, call)| {
                let calls = [definitions.as_slice(), &[call]].concat();
                form.with_code(self.add_code(emit::sequence(name, span, &calls, None)))
            })
            .collect();
        (main, tests)
    }

    fn emit_call(&mut self, body: &Function) -> (u32, Span) {
        (emit::emit(self, body, &[]), body.span)
    }

    /// Notes the names a file defines, so that a name of the library that is defined again means
    /// the file's own from the first line on.
    pub(super) fn predeclare(&mut self, forms: &[NodeId]) {
        for &form in forms {
            let special = self.tree.head(form).and_then(|head| self.special_form(head));
            let Some(name) = self.tree.items(form).get(1).and_then(|&name| self.tree.symbol(name)) else { continue };
            if self.purpose == Purpose::Library {
                self.own_names.extend(special.is_some_and(|special| special.role.is_definition()).then_some(name));
                continue;
            }
            let defines_value = special.is_some_and(|special| matches!(special.role, Role::Naming(_)));
            let is_macro = self.library.is_some_and(|library| library.macros.contains_key(&name));
            let shadows = self.program.names.get(&name).is_some_and(|&global| self.is_library(global))
                || is_macro && self.program.macros.contains_key(&name)
                || self.native_numbers.contains_key(&name);
            if defines_value && shadows && !self.is_robot_name(name) {
                let span = self.tree.span(form);
                self.program.macros.remove(&name);
                self.program.names.remove(&name);
                self.meaning(None, name, span);
            }
        }
    }

    /// Whether the name is the robot's and there is a robot; without one it is free.
    pub(super) fn is_robot_name(&self, name: Symbol) -> bool {
        let is_defined = self.program.names.get(&name).is_some_and(|&global| self.is_library(global));
        is_defined && self.robot_names.iter().any(|known| known == self.symbols.name(name))
    }

    pub(super) fn top_level(&mut self, node: NodeId, bodies: &mut Vec<TopLevel>) {
        self.nested(node, |compiler| compiler.top_level_here(node, bodies));
    }

    fn top_level_here(&mut self, node: NodeId, bodies: &mut Vec<TopLevel>) {
        let span = self.tree.span(node);
        let items = self.tree.items(node).to_vec();
        let head = self.tree.proper_list(node).and_then(|items| items.first());
        let Some((qualifier, head)) = head.and_then(|&head| self.tree.name(head)) else {
            return self.form_that_runs(node, bodies);
        };
        if self.is_broken_macro(qualifier, head) {
            return self.note_unexpanded(&items);
        }
        if let Some(code) = self.macro_code(qualifier, head) {
            let expanded = self.expanded(code, node, |compiler, expansion| compiler.top_level(expansion, bodies));
            if expanded.is_none() {
                self.note_unexpanded(&items);
            }
            return;
        }
        let Some(form) = self.special_form(head) else {
            return self.form_that_runs(node, bodies);
        };
        match form.role {
            Role::Sequence(_) if items[1..].iter().any(|&item| self.is_definition_form(item)) => {
                for &item in &items[1..] {
                    self.top_level(item, bodies);
                }
            }
            Role::Naming(define) | Role::Definition(define) => {
                define(self, &Written { form, items: &items, span }, bodies);
            }
            Role::Plain(_) | Role::Sequence(_) | Role::Effect(_) => {
                self.form_that_runs(node, bodies);
            }
        }
    }

    fn note_unexpanded(&mut self, items: &[NodeId]) {
        self.unexpanded.extend(items[1..].iter().filter_map(|&item| self.tree.symbol(item)));
    }

    /// Nothing of a library runs by itself.
    fn form_that_runs(&mut self, node: NodeId, bodies: &mut Vec<TopLevel>) {
        if self.purpose == Purpose::Library {
            let span = self.tree.span(node);
            let label = "this would never run: put it into a `def-plan`";
            self.error("library-form", span, "a library consists of definitions", label);
            return;
        }
        bodies.push(TopLevel::Form(self.top_level_form(node)));
    }

    fn is_definition_form(&self, node: NodeId) -> bool {
        self.tree
            .head(node)
            .is_some_and(|head| self.special_form(head).is_some_and(|special| special.role.is_definition()))
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
}
