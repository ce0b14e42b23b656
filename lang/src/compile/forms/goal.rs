//! Goals: `(def-goal (achieve (NAME PARAMETER...)) FORM...)` defines the plan `achieve-NAME`. Each
//! further definition of the same goal is one more method, and the plan tries them in their order.

use crate::code::{CodeKind, GlobalKind};
use crate::compile::compiler::{Compiler, Methods};
use crate::source::Span;
use crate::symbol::{Qualifier, Symbol};
use crate::syntax::{NodeId, NodeKind};
use std::sync::Arc;

const FORM: &str = "`(def-goal (achieve (NAME PARAMETER...)) FORM...)`";

/// With the goal's name it makes the name of its plan.
pub(in crate::compile) const PREFIX: &str = "achieve-";

impl Compiler<'_> {
    pub(super) fn define_goal(&mut self, rest: &[NodeId], span: Span) {
        let Some((plan, parameters)) = rest.first().and_then(|&goal| self.goal_plan(goal)) else {
            self.malformed(span, FORM);
            return;
        };
        let body = &rest[1..];
        let Some(mut methods) = self.methods.remove(&plan) else {
            self.define_plan(plan, parameters, body, span);
            self.methods.insert(plan, Methods { plans: Vec::new(), parameters });
            return;
        };
        match self.plain_parameters(methods.parameters, parameters) {
            Some(names) => {
                if methods.plans.is_empty() {
                    methods.plans.push(self.first_method(plan));
                }
                let method = self.method_name(plan, methods.plans.len() + 1);
                self.define_plan(method, parameters, body, span);
                methods.plans.push(method);
                self.define_trying(plan, &methods, &names, span);
            }
            None => {
                let first = self.tree.span(methods.parameters);
                let message = "all methods of a goal take as many parameters, and none that is optional";
                let help = "write one `def-goal` with `&optional` or `&key`, and `try-in-order` in it";
                let error =
                    self.error("goal-parameters", self.tree.span(parameters), message, "not those of the first");
                error.related.push((first, "the first method".into()));
                error.help = Some(help.into());
            }
        }
        self.methods.insert(plan, methods);
    }

    /// The name of the plan and its parameter list in `(achieve (NAME PARAMETER...))`.
    fn goal_plan(&mut self, goal: NodeId) -> Option<(Symbol, NodeId)> {
        let is_achieve = self.tree.head(goal).is_some_and(|head| self.symbols.name(head) == "achieve");
        let &[_, head] = self.tree.items(goal) else { return None };
        let name = self.tree.head(head).filter(|_| is_achieve)?;
        let parameters = self.tree.items(head)[1..].to_vec();
        let parameters = self.tree.list(&parameters, self.tree.span(head));
        let plan = format!("{PREFIX}{}", self.symbols.name(name));
        Some((self.symbols.intern(&plan), parameters))
    }

    fn define_plan(&mut self, name: Symbol, parameters: NodeId, body: &[NodeId], span: Span) {
        let name = self.tree.atom(NodeKind::Symbol(name), span);
        let rest = [&[name, parameters], body].concat();
        self.define_function(CodeKind::Plan, "def-plan", &rest, span);
    }

    /// A name no text can have.
    fn method_name(&mut self, plan: Symbol, number: usize) -> Symbol {
        let name = format!("{}#{number}", self.symbols.name(plan));
        self.symbols.intern(&name)
    }

    /// Gives the plan of the first definition the name of a method.
    fn first_method(&mut self, plan: Symbol) -> Symbol {
        let name = self.method_name(plan, 1);
        if let Some(&global) = self.program.names.get(&plan) {
            let first = self.program.globals[global as usize].clone();
            if let GlobalKind::Function(code) = first.kind
                && let Some(code) = self.program.codes.get_mut(code as usize)
            {
                Arc::make_mut(code).name = name;
            }
            self.define_global(name, first.kind, first.doc, first.span);
        }
        name
    }

    /// The names of the parameters, if both lists have only names, and as many.
    fn plain_parameters(&self, first: NodeId, other: NodeId) -> Option<Vec<NodeId>> {
        let is_plain =
            |&node: &NodeId| self.tree.symbol(node).is_some_and(|name| !self.symbols.name(name).starts_with('&'));
        let (first, other) = (self.tree.items(first), self.tree.items(other));
        let fits = first.len() == other.len() && first.iter().chain(other).all(is_plain);
        fits.then(|| first.to_vec())
    }

    /// `(def-plan achieve-NAME (P...) (try-in-order (METHOD P...) ...))`
    fn define_trying(&mut self, plan: Symbol, methods: &Methods, parameters: &[NodeId], span: Span) {
        let mut tries = vec![self.library_node("try-in-order", span)];
        for &method in &methods.plans {
            let method = self.tree.atom(NodeKind::Symbol(method), span);
            let call = [&[method], parameters].concat();
            tries.push(self.tree.list(&call, span));
        }
        let body = self.tree.list(&tries, span);
        self.define_plan(plan, methods.parameters, &[body], span);
    }

    fn library_node(&mut self, name: &str, span: Span) -> NodeId {
        let name = self.symbols.intern(name);
        let written = self.symbols.qualified(Qualifier::Library, name);
        self.tree.atom(NodeKind::Qualified { written, qualifier: Qualifier::Library, name }, span)
    }
}
