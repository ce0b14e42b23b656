//! Goals: `(def-goal (achieve (NAME PARAMETER...)) FORM...)` defines the plan `achieve-NAME`. Each
//! further definition of the same goal is one more method, and the plan tries them in their order.
//!
//! Where a parameter begins with `?` and another name does not, that one is a word of the goal:
//! `(achieve (the ?object on ?place))` defines the plan `achieve-(the ? on ?)`. By these names, which no
//! text can have, the goals with words are found again.

use super::special_form::{Role, SpecialForm, Written};
use crate::code::{CodeKind, GlobalKind};
use crate::compile::compiler::Compiler;
use crate::compile::goals::{GOAL_PREFIX, GoalPattern, Goals, Methods, UndefinedGoal, note_goal};
use crate::compile::ir::Ir;
use crate::source::Span;
use crate::suggest::suggest;
use crate::symbol::{Qualifier, Symbol};
use crate::syntax::{NodeId, NodeKind};
use std::collections::BTreeMap;
use std::sync::Arc;

const FORM: &str =
    "`(def-goal (achieve (NAME PARAMETER...)) FORM...)`, where names are words among parameters that begin with `?`";

pub(super) const FORMS: &[SpecialForm] = &[SpecialForm {
    names: &["achieve"],
    form: "(achieve (NAME ARGUMENT...))",
    doc: "Runs the plan that `def-goal` gave for such goals: its methods, tried in the order of their definition. Words of a goal are written as they are, the other elements are arguments.",
    example: "(def-goal (achieve (the ?object on ?place))\n  (print (list ?object ?place)))\n(achieve (the 'cup on 'table))",
    layout: None,
    role: Role::Plain(|compiler, written| compiler.achieve(written)),
}];

impl Compiler<'_> {
    /// Notes the goals that the program has, and those that forms define, so that each can be achieved above its
    /// definition.
    pub(in crate::compile) fn note_goals(&mut self, forms: &[NodeId]) {
        let mut known: Vec<(u32, Symbol)> = self.program.names.iter().map(|(&name, &global)| (global, name)).collect();
        known.retain(|&(_, name)| self.symbols.name(name).starts_with(GOAL_PREFIX));
        known.sort_unstable();
        let defined = forms.iter().filter_map(|&form| {
            let is_goal = self.tree.head(form).is_some_and(|head| self.symbols.name(head) == "def-goal");
            self.tree.items(form).get(1).copied().filter(|_| is_goal)
        });
        let defined: Vec<NodeId> = defined.collect();
        let mut goals = BTreeMap::new();
        known.into_iter().for_each(|(_, plan)| note_goal(&mut goals, self.symbols, plan));
        for goal in defined {
            if let Some((plan, _)) = self.goal_plan(goal) {
                note_goal(&mut goals, self.symbols, plan);
            }
        }
        self.goals = goals;
    }

    /// `(achieve (NAME ARGUMENT...))`
    fn achieve(&mut self, written: &Written<'_>) -> Ir {
        let form = "`(achieve (NAME ARGUMENT...))`";
        let &[goal] = written.rest() else { return self.malformed(written.span, form) };
        let Some(name) = self.tree.head(goal) else { return self.malformed(written.span, form) };
        let elements = self.tree.items(goal)[1..].to_vec();
        let symbols: Vec<Option<Symbol>> = elements.iter().map(|&element| self.tree.symbol(element)).collect();
        let fits = |pattern: &&GoalPattern| {
            let mut pairs = pattern.elements.iter().zip(&symbols);
            pattern.elements.len() == symbols.len() && pairs.all(|(word, symbol)| word.is_none() || word == symbol)
        };
        let words = |pattern: &GoalPattern| pattern.elements.iter().flatten().count();
        let goals = self.goals.get(&name);
        let fitting = goals.iter().flat_map(|goals| &goals.patterns).filter(fits);
        // The one with most words, of several the first.
        let fitting = fitting.reduce(|best, other| if words(other) > words(best) { other } else { best });
        let (plan, arguments) = match (fitting, goals) {
            (Some(pattern), _) => {
                let arguments = pattern.elements.iter().zip(&elements).filter(|(word, _)| word.is_none());
                (pattern.plan, arguments.map(|(_, &argument)| argument).collect())
            }
            (None, Some(goals)) if !goals.has_plain => {
                let known =
                    goals.patterns.iter().filter_map(|goal| self.symbols.name(goal.plan).strip_prefix(GOAL_PREFIX));
                let known = known.map(|goal| format!("`{goal}`")).collect::<Vec<_>>().join(", ");
                let meant = self.meant_word(goals, &symbols);
                let meant =
                    meant.map_or(String::new(), |(word, found)| format!("did you mean `{word}` for `{found}`? "));
                let help = format!("{meant}there is {known}: words stand as they are, and something for each `?`");
                self.unlike_goals(self.tree.span(goal), help);
                return self.nil(written.span);
            }
            (None, goals) => {
                let is_undefined = goals.is_none();
                let plan = format!("{GOAL_PREFIX}{}", self.symbols.name(name));
                let plan = self.symbols.intern(&plan);
                if is_undefined {
                    let span = self.tree.span(goal);
                    let names = elements.iter().filter(|&&element| self.tree.symbol(element).is_some());
                    let places = names.map(|&element| self.tree.span(element));
                    // What a macro has made has the place of its call.
                    let elements = places.filter(|place| *place != span && *place != written.span).collect();
                    self.undefined_goals.entry(plan).or_insert(UndefinedGoal { name, span, elements });
                }
                (plan, elements)
            }
        };
        let plan = self.tree.atom(NodeKind::Symbol(plan), written.span);
        let call = self.tree.list(&[&[plan], arguments.as_slice()].concat(), written.span);
        self.resolve(call)
    }

    /// The word of a goal that one of these names was probably meant for, with that name.
    fn meant_word(&self, goals: &Goals, names: &[Option<Symbol>]) -> Option<(&str, &str)> {
        let as_long = goals.patterns.iter().filter(|pattern| pattern.elements.len() == names.len());
        let mut pairs = as_long.flat_map(|pattern| pattern.elements.iter().zip(names));
        pairs.find_map(|(word, name)| {
            let (word, name) = (self.symbols.name((*word)?), self.symbols.name((*name)?));
            Some((suggest(name, std::iter::once(word))?, name))
        })
    }

    fn unlike_goals(&mut self, place: Span, help: String) {
        let text = self.program.sources.text_of(place).split_whitespace().collect::<Vec<_>>().join(" ");
        self.error("unknown-goal", place, format!("no goal is like `{text}`"), "fits none").help = Some(help);
    }

    /// Tells of a goal that nothing in the whole text defines.
    pub(in crate::compile) fn tell_undefined_goal(&mut self, goal: &UndefinedGoal) {
        let name = self.symbols.name(goal.name);
        let known = self.goals.keys().map(|&goal| self.symbols.name(goal));
        let help = match suggest(name, known) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!(
                "say how to achieve it: `(def-goal (achieve ({name} PARAMETER...)) FORM...)`, where names are words among parameters that begin with `?`"
            ),
        };
        self.unlike_goals(goal.span, help);
    }

    pub(super) fn define_goal(&mut self, rest: &[NodeId], span: Span) {
        let Some((plan, parameters)) = rest.first().and_then(|&goal| self.goal_plan(goal)) else {
            self.malformed(span, FORM);
            return;
        };
        note_goal(&mut self.goals, self.symbols, plan);
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
        let elements = self.tree.items(head)[1..].to_vec();
        let names: Vec<&str> =
            elements.iter().map(|&node| self.tree.symbol(node).map_or("", |name| self.symbols.name(name))).collect();
        let is_parameter = |name: &str| name.starts_with('?');
        let (name, span) = (self.symbols.name(name), self.tree.span(head));
        if !names.iter().any(|name| is_parameter(name)) || names.iter().all(|name| is_parameter(name)) {
            let plan = format!("{GOAL_PREFIX}{name}");
            return Some((self.symbols.intern(&plan), self.tree.list(&elements, span)));
        }
        // Among words there is no other form of parameter; and the name of the plan tells where one ends.
        let is_apart = |name: &str| name.contains([' ', '(', ')']);
        if is_apart(name) || names.iter().any(|name| name.is_empty() || name.starts_with('&') || is_apart(name)) {
            return None;
        }
        let shown: Vec<&str> = names.iter().map(|name| if is_parameter(name) { "?" } else { name }).collect();
        let plan = format!("{GOAL_PREFIX}({name} {})", shown.join(" "));
        let parameters: Vec<NodeId> =
            elements.iter().zip(&names).filter(|(_, name)| is_parameter(name)).map(|(&node, _)| node).collect();
        Some((self.symbols.intern(&plan), self.tree.list(&parameters, span)))
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
        if let Some(first) = self.definitions.iter_mut().rfind(|definition| definition.name == plan) {
            first.name = name;
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
