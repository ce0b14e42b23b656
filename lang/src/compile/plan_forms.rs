//! Special forms of concurrent plans.

use super::ir::{ChildIr, ClauseIr, ConstructIr, Function, Ir, IrKind, ParameterBinding, ScopeIr, VarId};
use super::special::Special;
use super::{Compiler, HandlerScope, thunk};
use crate::code::{CodeKind, Missed, Parameters, Rule};
use crate::source::Span;
use crate::stack::deep;
use crate::symbol::Symbol;
use crate::syntax::{Kind, NodeId};

impl Compiler<'_> {
    pub(super) fn plan_form(&mut self, special: Special, items: &[NodeId], span: Span) -> Ir {
        let rest = &items[1..];
        match special {
            Special::Par => self.children(Rule::Par, rest, span),
            Special::Pursue => self.children(Rule::Pursue, rest, span),
            Special::TryAll => self.children(Rule::TryAll, rest, span),
            Special::Plan => self.partial_order(rest, span),
            Special::ParMap => self.map_children(Rule::Par, "par-map", rest, span),
            Special::PursueMap => self.map_children(Rule::Pursue, "pursue-map", rest, span),
            Special::TryAllMap => self.map_children(Rule::TryAll, "try-all-map", rest, span),
            Special::WithPolicy => self.with_policy(rest, span),
            Special::WithPriority => self.with_argument(Rule::Single, "with-priority", rest, span),
            Special::WithTimeout => self.with_argument(Rule::Timeout, "with-timeout", rest, span),
            Special::Process => self.tagged(items, span),
            Special::Spawn => self.spawn(rest, span),
            Special::WithFailureHandling => self.with_failure_handling(rest, span),
            Special::EvapProtect => self.protect(false, rest, span),
            Special::UnwindProtect => self.protect(true, rest, span),
            Special::WithValve => self.with_value_scope(ScopeIr::Valve, "`(with-valve VALVE FORM...)`", rest, span),
            Special::WithTaskSuspended => self.with_task_suspended(rest, span),
            Special::OnInterrupt => self.with_hook(ScopeIr::OnInterrupt, "on-interrupt", rest, span),
            Special::OnResume => self.with_hook(ScopeIr::OnResume, "on-resume", rest, span),
            Special::WaitFor => self.wait_for(rest, span),
            Special::Whenever => self.whenever(rest, span),
            Special::Fluent => match rest {
                [expression] => self.network(*expression, span),
                _ => self.malformed(span, "`(fluent EXPRESSION)`"),
            },
            _ => unreachable!("sequential forms and definitions are handled before"),
        }
    }

    /// A construct with one child.
    fn single(&mut self, rule: Rule, name: &str, child: ChildIr, argument: Option<Ir>, span: Span) -> Ir {
        let name = self.symbols.intern(name);
        let construct = ConstructIr {
            rule,
            name,
            children: vec![child],
            order: Vec::new(),
            argument: argument.map(Box::new),
            with_priority: false,
            active: false,
        };
        Ir { span, kind: IrKind::Construct(Box::new(construct)) }
    }

    /// A child: a tag or process *is* the child, anything else is its body.
    fn child(&mut self, node: NodeId) -> ChildIr {
        let span = self.tree.span(node);
        let items = self.tree.items(node).to_vec();
        if let Some((name, variable, body)) = self.tag_parts(&items) {
            let text = self.symbols.name(name).to_string();
            let body = self.thunk(&text, CodeKind::Task, &body, span);
            // The tag's task is written by the task that makes the child.
            self.capture(variable);
            return ChildIr { body, tag: Some(variable), name: Some(name) };
        }
        let name = self.tree.head(node).map_or("task", |head| self.symbols.name(head)).to_string();
        ChildIr { body: self.thunk(&name, CodeKind::Task, &[node], span), tag: None, name: None }
    }

    /// Name, variable and body of `(:tag NAME FORM...)` or `(process NAME FORM...)`.
    fn tag_parts(&mut self, items: &[NodeId]) -> Option<(Symbol, VarId, Vec<NodeId>)> {
        let is_tag = match self.tree.get(*items.first()?).kind {
            Kind::Keyword(word) => self.symbols.name(word) == "tag",
            Kind::Symbol(word) => self.symbols.name(word) == "process",
            _ => false,
        };
        let name = self.tree.symbol(*items.get(1)?)?;
        if !is_tag || !self.is_bindable(name) {
            return None;
        }
        let root = self.functions.iter().rposition(|function| function.tags.is_some())?;
        let known = self.functions[root].tags.iter().flatten().find(|(tag, _)| *tag == name).map(|&(_, tag)| tag);
        let variable = match known {
            Some(variable) => variable,
            None => self.new_tag(root, name, self.tree.span(items[1])),
        };
        self.variables[variable.0 as usize].assigned = true;
        Some((name, variable, items[2..].to_vec()))
    }

    fn new_tag(&mut self, root: usize, name: Symbol, span: Span) -> VarId {
        self.variables.push(super::Variable { name, span, function: root, captured: false, assigned: true });
        let variable = VarId(self.variables.len() as u32 - 1);
        if let Some(tags) = &mut self.functions[root].tags {
            tags.push((name, variable));
        }
        variable
    }

    /// Notes every tag in the text of a plan, so that it is bound before it is reached.
    pub(super) fn find_tags(&mut self, forms: &[NodeId]) {
        let root = self.functions.len() - 1;
        let mut waiting: Vec<NodeId> = forms.iter().rev().copied().collect();
        while let Some(node) = waiting.pop() {
            if self.tree.head(node).is_some_and(|head| matches!(self.symbols.name(head), "quote" | "quasiquote")) {
                continue;
            }
            let items = self.tree.items(node).to_vec();
            // `tag_parts` notes a tag it does not know yet.
            debug_assert_eq!(root, self.functions.len() - 1);
            self.tag_parts(&items);
            waiting.extend(items.into_iter().rev());
        }
    }

    pub(super) fn tagged(&mut self, items: &[NodeId], span: Span) -> Ir {
        if self.is_network() {
            self.error(
                "network-effect",
                span,
                "a task cannot be started in a fluent network",
                "a network may only look",
            );
            return self.nil(span);
        }
        let Some((name, variable, body)) = self.tag_parts(items) else {
            return self.malformed(span, "`(:tag NAME FORM...)` or `(process NAME FORM...)`");
        };
        let text = self.symbols.name(name).to_string();
        let body = self.thunk(&text, CodeKind::Task, &body, span);
        self.capture(variable);
        let child = ChildIr { body, tag: Some(variable), name: Some(name) };
        self.single(Rule::Single, &text, child, None, span)
    }

    fn children(&mut self, rule: Rule, nodes: &[NodeId], span: Span) -> Ir {
        let children: Vec<ChildIr> = nodes.iter().map(|&node| self.child(node)).collect();
        if children.len() > 10_000 {
            self.error("too-many-children", span, "a construct can have 10000 children at most", "too many");
        }
        self.construct(rule, children, Vec::new(), span)
    }

    fn construct(&mut self, rule: Rule, children: Vec<ChildIr>, order: Vec<(u16, u16)>, span: Span) -> Ir {
        let name = self.symbols.intern(rule.name());
        let construct =
            ConstructIr { rule, name, children, order, argument: None, with_priority: false, active: false };
        Ir { span, kind: IrKind::Construct(Box::new(construct)) }
    }

    /// `(plan (STEP...) (:order A B)...)`
    fn partial_order(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let steps = rest.first().and_then(|&list| self.list_items(list));
        let Some(steps) = steps else {
            return self.malformed(span, "`(plan (STEP...) (:order A B)...)`");
        };
        let children: Vec<ChildIr> = steps.iter().map(|&step| self.child(step)).collect();
        let mut order = Vec::new();
        for &constraint in &rest[1..] {
            let place = self.tree.span(constraint);
            let items = self.tree.items(constraint).to_vec();
            let is_order = items.first().is_some_and(
                |&head| matches!(self.tree.get(head).kind, Kind::Keyword(word) if self.symbols.name(word) == "order"),
            );
            let names: Vec<Symbol> = items.iter().skip(1).filter_map(|&name| self.tree.symbol(name)).collect();
            let (true, [before, after]) = (is_order, names.as_slice()) else {
                self.malformed(place, "`(:order A B)`");
                continue;
            };
            let position = |name: Symbol| children.iter().position(|child| child.name == Some(name));
            match (position(*before), position(*after)) {
                (Some(before), Some(after)) => order.push((before as u16, after as u16)),
                (before, _) => {
                    let missing = if before.is_none() { names[0] } else { names[1] };
                    let text = self.symbols.name(missing).to_string();
                    self.error(
                        "unknown-step",
                        place,
                        format!("no step of this plan has the tag `{text}`"),
                        "unknown step",
                    )
                    .help = Some(format!("name a step: `(:tag {text} …)`"));
                }
            }
        }
        if let Some(step) = cycle_in(children.len(), &order) {
            let name = children[step].name.map_or("a step", |name| self.symbols.name(name)).to_string();
            self.error(
                "order-cycle",
                span,
                format!("the order of these steps is a circle through `{name}`"),
                "can never start",
            );
        }
        self.construct(Rule::Plan, children, order, span)
    }

    /// `(par-map (V LIST) FORM...)`: one child for each element.
    fn map_children(&mut self, rule: Rule, name: &str, rest: &[NodeId], span: Span) -> Ir {
        let header = rest.first().map(|&header| self.tree.items(header).to_vec()).unwrap_or_default();
        let variable = header.first().and_then(|&name| self.tree.symbol(name));
        let (Some(variable), [_, list]) = (variable.filter(|&name| self.is_bindable(name)), header.as_slice()) else {
            return self.malformed(span, &format!("`({name} (NAME LIST) FORM...)`"));
        };
        let place = self.tree.span(header[0]);
        let list = self.resolve(*list);
        let body_name = self.symbols.intern(name);
        let ((element, body), scope) = self.in_function(CodeKind::Task, false, |compiler| {
            let element = compiler.bind(variable, place);
            (element, compiler.body(&rest[1..], span))
        });
        let mut body = thunk(body_name, CodeKind::Task, body, scope, span);
        body.parameters = Parameters { required: 1, ..Parameters::default() };
        body.bindings = vec![ParameterBinding { variable: element, default: None, given: None, omissible: false }];
        let construct = ConstructIr {
            rule,
            name: body_name,
            children: vec![ChildIr { body, tag: None, name: None }],
            order: Vec::new(),
            argument: None,
            with_priority: false,
            active: false,
        };
        Ir { span, kind: IrKind::ConstructMap(Box::new(construct), Box::new(list)) }
    }

    fn with_policy(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let Some((&policy, body)) = rest.split_first() else {
            return self.malformed(span, "`(with-policy POLICY FORM...)`");
        };
        let policy = self.child(policy);
        let primary = match body {
            [one] => self.child(*one),
            many => ChildIr { body: self.thunk("body", CodeKind::Task, many, span), tag: None, name: None },
        };
        self.construct(Rule::Policy, vec![policy, primary], Vec::new(), span)
    }

    /// `(with-timeout SECONDS [:active] FORM...)`, `(with-priority NUMBER FORM...)`
    fn with_argument(&mut self, rule: Rule, name: &str, rest: &[NodeId], span: Span) -> Ir {
        let Some((&argument, mut body)) = rest.split_first() else {
            return self.malformed(span, &format!("`({name} NUMBER FORM...)`"));
        };
        let is_active = rule == Rule::Timeout && body.first().is_some_and(|&first| self.is_keyword(first, "active"));
        if is_active {
            body = &body[1..];
        }
        // What else is a unit may be a name of the plan, and the body.
        self.refuse_unit_apart(rest, &["min"]);
        let argument = self.resolve(argument);
        let body = self.thunk(name, CodeKind::Task, body, span);
        let child = ChildIr { body, tag: None, name: None };
        let mut ir = self.single(rule, name, child, Some(argument), span);
        if let IrKind::Construct(construct) = &mut ir.kind {
            construct.with_priority = rule == Rule::Single;
            construct.active = is_active;
        }
        ir
    }

    fn spawn(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let child = match rest {
            [one] => self.child(*one),
            many => ChildIr { body: self.thunk("spawn", CodeKind::Task, many, span), tag: None, name: None },
        };
        let name = self.symbols.intern("spawn");
        let construct = ConstructIr {
            rule: Rule::Single,
            name,
            children: vec![child],
            order: Vec::new(),
            argument: None,
            with_priority: false,
            active: false,
        };
        Ir { span, kind: IrKind::Spawn(Box::new(construct)) }
    }

    fn protect(&mut self, always: bool, rest: &[NodeId], span: Span) -> Ir {
        let Some((&body, cleanup)) = rest.split_first() else {
            return self.malformed(span, "`(evap-protect FORM CLEAN-UP...)`");
        };
        let body = Box::new(self.resolve(body));
        self.clean_ups += 1;
        let cleanup = Box::new(self.body(cleanup, span));
        self.clean_ups -= 1;
        Ir { span, kind: IrKind::Cleanup { always, body, cleanup } }
    }

    fn with_value_scope(
        &mut self,
        scope: impl FnOnce(Box<Ir>) -> ScopeIr,
        form: &str,
        rest: &[NodeId],
        span: Span,
    ) -> Ir {
        let Some((&value, body)) = rest.split_first() else { return self.malformed(span, form) };
        let value = Box::new(self.resolve(value));
        let body = Box::new(self.body(body, span));
        Ir { span, kind: IrKind::Scope(scope(value), body) }
    }

    /// `(with-task-suspended (TASK) FORM...)`
    fn with_task_suspended(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let form = "`(with-task-suspended (TASK) FORM...)`";
        let Some((&header, body)) = rest.split_first() else { return self.malformed(span, form) };
        let [task] = *self.tree.items(header) else { return self.malformed(span, form) };
        let mut forms = vec![task];
        forms.extend(body);
        self.with_value_scope(ScopeIr::Suspended, form, &forms, span)
    }

    /// `(on-interrupt HOOK FORM...)`
    fn with_hook(
        &mut self,
        scope: impl FnOnce(Box<Function>) -> ScopeIr,
        name: &str,
        rest: &[NodeId],
        span: Span,
    ) -> Ir {
        let Some((&hook, body)) = rest.split_first() else {
            return self.malformed(span, &format!("`({name} HOOK FORM...)`"));
        };
        let place = self.tree.span(hook);
        let hook = Box::new(self.thunk(name, CodeKind::Function, &[hook], place));
        let body = Box::new(self.body(body, span));
        Ir { span, kind: IrKind::Scope(scope(hook), body) }
    }

    fn with_failure_handling(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let clauses = rest.first().and_then(|&list| self.list_items(list));
        let Some(clauses) = clauses else {
            return self.malformed(span, "`(with-failure-handling ((CLASS (F) FORM...)...) FORM...)`");
        };
        let body_forms = rest[1..].to_vec();
        // Leaving the inner block starts the body again; leaving the outer one gives the value.
        self.in_block(None, span, |compiler, _| {
            let done = compiler.blocks.len() - 1;
            let mut retried = false;
            let attempt = compiler.in_block(None, span, |compiler, retry| {
                let failure_name = compiler.symbols.uninterned("failure");
                let failure = compiler.new_variable(failure_name, span);
                let body = Box::new(compiler.body(&body_forms, span));
                compiler.handlers.push(HandlerScope { retry, failure });
                let clauses = clauses.iter().filter_map(|&clause| compiler.clause(clause, failure)).collect();
                compiler.handlers.pop();
                retried = compiler.blocks.last().is_some_and(|block| block.used);
                let handler = Ir { span, kind: IrKind::Handler { body, failure, clauses } };
                if retried { compiler.leave(done, handler, span) } else { handler }
            });
            if retried { Ir { span, kind: IrKind::Loop(Box::new(attempt)) } } else { attempt }
        })
    }

    /// `(CLASS (F) FORM...)`; CLASS may be a list of classes, F may be left out.
    fn clause(&mut self, node: NodeId, failure: VarId) -> Option<ClauseIr> {
        let span = self.tree.span(node);
        let items = self.tree.items(node).to_vec();
        let form = "`(CLASS (F) FORM...)`";
        if items.len() < 2 {
            self.malformed(span, form);
            return None;
        }
        let class_nodes = match self.tree.proper_list(items[0]) {
            Some(list) => list.to_vec(),
            None => vec![items[0]],
        };
        let classes: Vec<Symbol> = class_nodes.into_iter().filter_map(|class| self.handled_class(class)).collect();
        let parameter = self.list_items(items[1]);
        let name = match parameter.as_deref() {
            Some([]) => None,
            Some([name]) if self.tree.symbol(*name).is_some() => self.tree.symbol(*name),
            _ => {
                self.malformed(span, form);
                return None;
            }
        };
        let before = self.bindings.len();
        if let Some(name) = name {
            self.bindings.push((name, failure));
        }
        let body = self.body(&items[2..], span);
        self.bindings.truncate(before);
        Some(ClauseIr { span, classes, body })
    }

    /// The name of a failure class; whether there is one is checked when all definitions are known.
    fn handled_class(&mut self, node: NodeId) -> Option<Symbol> {
        let span = self.tree.span(node);
        let Some(name) = self.tree.symbol(node) else {
            self.malformed(span, "the name of a failure class");
            return None;
        };
        self.note_class(name, span);
        Some(name)
    }

    fn wait_for(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let (condition, timeout) = match rest {
            [condition] => (*condition, None),
            [condition, word, seconds] if self.is_keyword(*word, "timeout") => (*condition, Some(*seconds)),
            _ => return self.malformed(span, "`(wait-for CONDITION)` or `(wait-for CONDITION :timeout SECONDS)`"),
        };
        let (fluent, owned) = self.condition(condition);
        let timeout = timeout.map(|seconds| Box::new(self.resolve(seconds)));
        Ir { span, kind: IrKind::WaitFor { fluent: Box::new(fluent), timeout, owned } }
    }

    fn is_keyword(&self, node: NodeId, name: &str) -> bool {
        matches!(self.tree.get(node).kind, Kind::Keyword(word) if self.symbols.name(word) == name)
    }

    /// `(whenever CONDITION [:missed MODE] FORM...)`
    fn whenever(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let Some((&condition, mut body)) = rest.split_first() else {
            return self.malformed(span, "`(whenever CONDITION FORM...)`");
        };
        let mut missed = Missed::Once;
        if let [word, mode, forms @ ..] = body
            && self.is_keyword(*word, "missed")
        {
            let place = self.tree.span(*mode);
            match self.tree.get(*mode).kind {
                Kind::Keyword(mode) => match self.symbols.name(mode) {
                    "once" => missed = Missed::Once,
                    "always" => missed = Missed::Always,
                    "never" => missed = Missed::Never,
                    _ => drop(self.malformed(place, "`:missed :once`, `:missed :always` or `:missed :never`")),
                },
                _ => drop(self.malformed(place, "`:missed :once`, `:missed :always` or `:missed :never`")),
            }
            body = forms;
        }
        let (fluent, owned) = self.condition(condition);
        let nil = self.symbols.intern("nil");
        let body = body.to_vec();
        self.in_block(Some(nil), span, |compiler, _| {
            let body = Box::new(compiler.body(&body, span));
            Ir { span, kind: IrKind::Whenever { fluent: Box::new(fluent), missed, owned, body } }
        })
    }

    /// A condition in fluent position: a name is waited for directly, and so is what gives a
    /// fluent by itself; anything else becomes a network that dies with its wait.
    fn condition(&mut self, node: NodeId) -> (Ir, bool) {
        let is_name = self.tree.symbol(node).is_some_and(|name| !matches!(self.symbols.name(name), "nil" | "t"));
        if is_name {
            return (self.resolve(node), false);
        }
        let gives_fluent = self.tree.head(node).is_some_and(|head| {
            matches!(
                self.symbols.name(head),
                "status" | "result" | "begin-task" | "end-task" | "pulsed" | "changed" | "fluent"
            )
        });
        if gives_fluent {
            return (self.resolve(node), true);
        }
        (self.network(node, self.tree.span(node)), true)
    }

    fn network(&mut self, node: NodeId, span: Span) -> Ir {
        let name = self.symbols.intern("network");
        let before = self.variables.len();
        let (body, scope) = self.in_function(CodeKind::Network, false, |compiler| compiler.resolve(node));
        if is_constant(&body) {
            self.error(
                "constant-network",
                span,
                "this condition reads no fluent and can never change",
                "always the same",
            )
            .help = Some("to wait for a time, use `(wait-time SECONDS)`".into());
        }
        debug_assert!(self.variables.len() >= before);
        let hoisted = scope.hoisted.clone();
        let network = thunk(name, CodeKind::Network, body, scope, span);
        let network = Ir { span, kind: IrKind::Network(Box::new(network)) };
        if hoisted.is_empty() { network } else { Ir { span, kind: IrKind::Let(hoisted, Box::new(network)) } }
    }
}

/// Whether an expression reads nothing that can change.
fn is_constant(ir: &Ir) -> bool {
    deep(|| match &ir.kind {
        IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_) => true,
        IrKind::If(a, b, c) => is_constant(a) && is_constant(b) && is_constant(c),
        IrKind::And(all) | IrKind::Or(all) | IrKind::Seq(all) => all.iter().all(is_constant),
        IrKind::Binary(_, a, b) => is_constant(a) && is_constant(b),
        IrKind::Unary(_, a) => is_constant(a),
        _ => false,
    })
}

/// A step on a circle of the order, if there is one (Kahn's algorithm leaves exactly those and
/// what depends on them).
fn cycle_in(steps: usize, order: &[(u16, u16)]) -> Option<usize> {
    let mut open: Vec<usize> =
        (0..steps).map(|step| order.iter().filter(|&&(_, after)| usize::from(after) == step).count()).collect();
    let mut ready: Vec<usize> = (0..steps).filter(|&step| open[step] == 0).collect();
    let mut done = vec![false; steps];
    while let Some(step) = ready.pop() {
        done[step] = true;
        for &(before, after) in order {
            if usize::from(before) == step {
                open[usize::from(after)] -= 1;
                if open[usize::from(after)] == 0 {
                    ready.push(usize::from(after));
                }
            }
        }
    }
    done.iter().position(|&done| !done)
}
