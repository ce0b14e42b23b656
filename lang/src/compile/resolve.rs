//! Expressions: names become variables, globals and natives; macros are expanded; operations with
//! an instruction of their own are recognised.

use super::ir::{Binary, Callee, Ir, IrKind, Unary, VarId};
use super::{BlockScope, Compiler, MAX_EXPANSIONS_IN_A_ROW, MAX_FORMS_DEEP, Unknown};
use crate::code::{Atom, CodeKind, Constant, Global, GlobalKind, Part};
use crate::kind::Kind as ArgumentKind;
use crate::source::Span;
use crate::stack::deep;
use crate::symbol::Symbol;
use crate::syntax::{Kind, NodeId};

/// Natives whose arguments are fluents themselves, also in fluent position.
const TAKES_FLUENTS: &[&str] =
    &["value", "pulsed", "changed", "count-pulses", "status", "result", "begin-task", "end-task"];

/// What is left to do of a datum on its way to a constant.
enum Step {
    Datum(NodeId),
    End { length: u32, dotted: bool },
}

/// What a name means where it stands.
pub(super) enum Meaning {
    Local(VarId),
    Global(u32),
    Native(u16),
}

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
            Kind::Int(value) => Ir { span, kind: IrKind::Int(value) },
            Kind::Symbol(name) => self.name(name, span),
            Kind::List { len: 0, .. } => self.nil(span),
            Kind::List { dotted: true, .. } => {
                self.error("dotted-call", span, "a form cannot have a dot", "this is data: quote it").help =
                    Some("write `'(…)`".into());
                self.nil(span)
            }
            Kind::List { .. } => self.form(node, span),
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

    /// A datum as a constant.
    pub(super) fn datum(&self, node: NodeId) -> Constant {
        let mut parts = Vec::new();
        let mut steps = vec![Step::Datum(node)];
        while let Some(step) = steps.pop() {
            let node = match step {
                Step::Datum(node) => node,
                Step::End { length, dotted } => {
                    parts.push(Part::List { length, dotted });
                    continue;
                }
            };
            match self.tree.get(node).kind {
                Kind::List { dotted, .. } => {
                    let items = self.tree.items(node);
                    let length = items.len() - usize::from(dotted);
                    if length > 0 {
                        steps.push(Step::End { length: length as u32, dotted });
                        steps.extend(items.iter().rev().map(|&item| Step::Datum(item)));
                    } else {
                        // A list of nothing but its tail is that tail.
                        steps.extend(items.last().map(|&item| Step::Datum(item)));
                        parts.extend(items.is_empty().then_some(Part::Atom(Atom::Nil)));
                    }
                }
                ref atom => parts.push(Part::Atom(self.atom(atom))),
            }
        }
        match (parts.pop(), parts.is_empty()) {
            (Some(Part::Atom(atom)), true) => Constant::Atom(atom),
            (last, _) => {
                parts.extend(last);
                Constant::List(parts)
            }
        }
    }

    fn atom(&self, kind: &Kind) -> Atom {
        match kind {
            Kind::Symbol(name) => match self.symbols.name(*name) {
                "nil" => Atom::Nil,
                "t" => Atom::True,
                _ => Atom::Symbol(*name),
            },
            Kind::Keyword(name) => Atom::Keyword(*name),
            Kind::Int(value) => Atom::Int(*value),
            Kind::Float(value) => Atom::Float(*value),
            Kind::Str(text) => Atom::Str(text.clone()),
            Kind::Object(index) => Atom::Object(*index),
            Kind::Hole | Kind::List { .. } => Atom::Nil,
        }
    }

    pub(super) fn is_network(&self) -> bool {
        self.functions.last().is_some_and(|function| function.network)
    }

    /// Wraps an expression that may give a fluent, in fluent position.
    fn dereferenced(&self, ir: Ir) -> Ir {
        if self.is_network() { Ir { span: ir.span, kind: IrKind::Unary(Unary::Deref, Box::new(ir)) } } else { ir }
    }

    /// Whether a name can be bound or assigned: constants and keywords cannot.
    pub(super) fn is_bindable(&self, name: Symbol) -> bool {
        !matches!(self.symbols.name(name), "nil" | "t") && !self.symbols.name(name).starts_with('&')
    }

    fn name(&mut self, name: Symbol, span: Span) -> Ir {
        match self.symbols.name(name) {
            "nil" => return self.nil(span),
            "t" => return Ir { span, kind: IrKind::True },
            _ => {}
        }
        let kind = match self.meaning(name, span) {
            Meaning::Local(variable) => IrKind::Local(variable),
            Meaning::Global(global) => IrKind::Global(global),
            Meaning::Native(native) => IrKind::Const(self.constant(Atom::Native(native))),
        };
        self.dereferenced(Ir { span, kind })
    }

    /// Looks a name up: lexical variables, tags of the plan, globals, natives. An unknown name
    /// becomes a global that must be defined before the text ends.
    pub(super) fn meaning(&mut self, name: Symbol, span: Span) -> Meaning {
        if let Some(variable) = self.lexical(name) {
            return Meaning::Local(variable);
        }
        if let Some(&global) = self.program.names.get(&name) {
            return Meaning::Global(global);
        }
        if let Some(&native) = self.native_numbers.get(&name) {
            return Meaning::Native(native);
        }
        if self.specials.contains_key(&name) || self.program.macros.contains_key(&name) {
            let text = self.symbols.name(name).to_string();
            self.error(
                "form-as-value",
                span,
                format!("`{text}` is a form, not a function"),
                "it has no value of its own",
            )
            .help = Some(format!("wrap it: `(lambda (x) ({text} x))`"));
        }
        self.program.globals.push(Global { name, kind: GlobalKind::Variable, doc: None, span: None });
        let global = self.program.globals.len() as u32 - 1;
        self.program.names.insert(name, global);
        let locals = self.bindings.iter().map(|&(local, _)| local).collect();
        self.undefined.insert(global, Unknown { span, locals });
        Meaning::Global(global)
    }

    /// The variable or tag of this name, noted as captured if an outer function binds it.
    pub(super) fn lexical(&mut self, name: Symbol) -> Option<VarId> {
        let bound = self.bindings.iter().rev().find(|(bound, _)| *bound == name).map(|&(_, variable)| variable);
        let variable = bound.or_else(|| {
            let root = self.functions.iter().rev().find_map(|function| function.tags.as_ref())?;
            root.iter().find(|(tag, _)| *tag == name).map(|&(_, variable)| variable)
        })?;
        self.capture(variable);
        Some(variable)
    }

    /// Notes that the current function uses a variable of an outer one.
    pub(super) fn capture(&mut self, variable: VarId) {
        let owner = self.variables[variable.0 as usize].function;
        for function in &mut self.functions[owner + 1..] {
            self.variables[variable.0 as usize].captured = true;
            if !function.captures.contains(&variable) {
                function.captures.push(variable);
            }
        }
    }

    fn form(&mut self, node: NodeId, span: Span) -> Ir {
        let items = self.tree.items(node).to_vec();
        let head = items[0];
        match self.tree.get(head).kind.clone() {
            Kind::Symbol(name) => {
                if self.is_lexically_bound(name) {
                    return self.call_value(head, &items[1..], span);
                }
                if let Some(&special) = self.specials.get(&name) {
                    return self.special(special, node, &items, span);
                }
                if let Some(&code) = self.program.macros.get(&name) {
                    return self.expand_and_resolve(code, node, span);
                }
                self.named_call(name, head, &items[1..], span)
            }
            Kind::Keyword(name) if self.symbols.name(name) == "tag" => self.tagged(&items, span),
            Kind::List { .. } | Kind::Object(_) | Kind::Hole => self.call_value(head, &items[1..], span),
            _ => {
                let place = self.tree.span(head);
                self.error("not-callable", place, "this cannot be called", "expected the name of a function").help =
                    Some("quote the list if it is data: `'(…)`".into());
                self.nil(span)
            }
        }
    }

    fn is_lexically_bound(&self, name: Symbol) -> bool {
        self.bindings.iter().any(|(bound, _)| *bound == name)
    }

    fn expand_and_resolve(&mut self, code: u32, node: NodeId, span: Span) -> Ir {
        match self.expand(code, node) {
            Some(expansion) => {
                let ir = self.resolve(expansion);
                self.expansions -= 1;
                ir
            }
            None => self.nil(span),
        }
    }

    /// One expansion; the caller gives `expansions` back when its result is resolved.
    pub(super) fn expand(&mut self, code: u32, node: NodeId) -> Option<NodeId> {
        let span = self.tree.span(node);
        if self.expansions >= MAX_EXPANSIONS_IN_A_ROW {
            let message = format!("this macro expands into macros more than {MAX_EXPANSIONS_IN_A_ROW} deep");
            self.error("endless-macro", span, message, "the expansion has no end");
            return None;
        }
        self.expansions += 1;
        match self.macros.expand(self.program, self.symbols, &mut self.tree, code, node) {
            Ok(expansion) => Some(expansion),
            Err(diagnostic) => {
                self.expansions -= 1;
                self.diagnostics.push(*diagnostic);
                None
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

    pub(super) fn outside_fluent_position<T>(&mut self, inside: impl FnOnce(&mut Self) -> T) -> T {
        let Some(function) = self.functions.last_mut() else { return inside(self) };
        let before = std::mem::replace(&mut function.network, false);
        let result = inside(self);
        if let Some(function) = self.functions.last_mut() {
            function.network = before;
        }
        result
    }

    fn named_call(&mut self, name: Symbol, head: NodeId, nodes: &[NodeId], span: Span) -> Ir {
        match self.meaning(name, span) {
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

    fn native_call(&mut self, native: u16, nodes: &[NodeId], span: Span) -> Ir {
        let natives = self.natives;
        let signature = &natives[usize::from(native)];
        let count = nodes.len();
        let takes_time = signature.kinds.first() == Some(&ArgumentKind::Seconds);
        if takes_time && self.refuse_unit_apart(nodes, &["ms", "s", "min", "h"]) {
            return self.nil(span);
        }
        if count < usize::from(signature.min) || signature.max.is_some_and(|max| count > usize::from(max)) {
            let expected = describe_arity(signature.min, signature.max);
            let is_format = signature.name == "print"
                && matches!(nodes.first().map(|&first| &self.tree.get(first).kind), Some(Kind::Str(_)));
            let error = self.arity_error(&signature.name, count, &expected, span);
            if is_format {
                error.help = Some("`print` shows one value: write `(print (format \"…\" VALUE...))`".into());
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

    /// `value`, `pulsed`, …: their arguments are taken as they are. Inside a network, `pulsed` and
    /// `changed` ask for the propagation under way, and a counter is made once, with the network.
    fn fluent_native(&mut self, native: u16, nodes: &[NodeId], span: Span) -> Ir {
        let natives = self.natives;
        let name = natives[usize::from(native)].name.as_str();
        if !self.is_network() {
            let arguments = self.arguments(nodes);
            return Ir { span, kind: IrKind::Call(Callee::Native(native), arguments) };
        }
        if name == "count-pulses" {
            return self.hoisted_counter(native, nodes, span);
        }
        let arguments = self.outside_fluent_position(|compiler| compiler.arguments(nodes));
        let direct = match name {
            "pulsed" => Some("%pulsed-now"),
            "changed" => Some("%changed-now"),
            _ => None,
        };
        if let Some(number) = direct.and_then(|direct| natives.iter().position(|native| native.name == direct)) {
            return Ir { span, kind: IrKind::Call(Callee::Native(number as u16), arguments) };
        }
        self.dereferenced(Ir { span, kind: IrKind::Call(Callee::Native(native), arguments) })
    }

    fn hoisted_counter(&mut self, native: u16, nodes: &[NodeId], span: Span) -> Ir {
        let Some(network) = self.functions.iter().rposition(|function| function.kind == CodeKind::Network) else {
            return self.nil(span);
        };
        // The counter belongs to the function around the network: resolve it there.
        let inner: Vec<_> = self.functions.drain(network..).collect();
        let arguments = self.arguments(nodes);
        let name = self.symbols.uninterned("count");
        let variable = self.new_variable(name, span);
        self.functions.extend(inner);
        let counter = Ir { span, kind: IrKind::Call(Callee::Native(native), arguments) };
        self.functions[network].hoisted.push((variable, counter));
        self.capture(variable);
        Ir { span, kind: IrKind::Unary(Unary::Deref, Box::new(Ir { span, kind: IrKind::Local(variable) })) }
    }

    /// Enters a block and resolves what is inside it.
    pub(super) fn in_block(
        &mut self,
        name: Option<Symbol>,
        span: Span,
        inside: impl FnOnce(&mut Self, super::BlockId) -> Ir,
    ) -> Ir {
        let id = super::BlockId(self.next_block);
        self.next_block += 1;
        let function = self.functions.len() - 1;
        let clean_ups = self.clean_ups;
        self.blocks.push(BlockScope { name, id, function, span, token: None, used: false, clean_ups });
        let body = inside(self, id);
        let block = self.blocks.pop().unwrap_or_else(|| unreachable!("the block was pushed above"));
        if block.used {
            Ir { span, kind: IrKind::Block { id, token: block.token, body: Box::new(body) } }
        } else {
            body
        }
    }

    /// Leaves the block at this index of the block list.
    pub(super) fn leave(&mut self, block: usize, value: Ir, span: Span) -> Ir {
        self.blocks[block].used = true;
        let (id, function) = (self.blocks[block].id, self.blocks[block].function);
        // An exit from a clean-up may come too late: it must not touch the block's value before it
        // is known to arrive.
        let is_static = self.blocks[block].clean_ups == self.clean_ups || self.blocks[block].name.is_none();
        if function == self.functions.len() - 1 && is_static {
            return Ir { span, kind: IrKind::Leave(id, Box::new(value)) };
        }
        let crossed = &self.functions[function + 1..];
        if crossed.iter().any(|scope| matches!(scope.kind, CodeKind::Task | CodeKind::Network)) {
            let (from, message) = (self.blocks[block].span, "this would leave a task from inside another");
            self.error("leaves-task", span, message, "the block belongs to the task around it")
                .related
                .push((from, "the block".into()));
            return self.nil(span);
        }
        let token = match self.blocks[block].token {
            Some(token) => token,
            None => {
                let name = self.symbols.uninterned("block");
                self.variables.push(super::Variable { name, span, function, captured: false, assigned: false });
                let token = VarId(self.variables.len() as u32 - 1);
                self.blocks[block].token = Some(token);
                token
            }
        };
        self.capture(token);
        Ir { span, kind: IrKind::LeaveDynamic(token, Box::new(value)) }
    }
}

pub(super) fn describe_arity(min: u8, max: Option<u8>) -> String {
    let plural = |count: u8| if count == 1 { "1 argument".to_string() } else { format!("{count} arguments") };
    match max {
        Some(max) if max == min => plural(min),
        Some(max) => format!("{min} to {}", plural(max)),
        None => format!("at least {}", plural(min)),
    }
}

/// The instruction for a library function, if it has one for these arguments.
fn intrinsic(name: &str, mut arguments: Vec<Ir>, span: Span) -> Result<Ir, Vec<Ir>> {
    let binary = match name {
        "+" => Some((Binary::Add, false)),
        "-" => Some((Binary::Sub, false)),
        "*" => Some((Binary::Mul, false)),
        "<" => Some((Binary::Less, false)),
        "<=" => Some((Binary::LessEq, false)),
        ">" => Some((Binary::Less, true)),
        ">=" => Some((Binary::LessEq, true)),
        "=" => Some((Binary::NumEq, false)),
        "eq" => Some((Binary::Eq, false)),
        "cons" => Some((Binary::Cons, false)),
        _ => None,
    };
    let unary = match name {
        "not" | "null" => Some(Unary::Not),
        "car" | "first" => Some(Unary::Car),
        "cdr" | "rest" => Some(Unary::Cdr),
        _ => None,
    };
    let one = |value| Box::new(Ir { span, kind: IrKind::Int(value) });
    match (name, binary, unary, arguments.len()) {
        ("1+", _, _, 1) => {
            let operand = Box::new(arguments.remove(0));
            Ok(Ir { span, kind: IrKind::Binary(Binary::Add, operand, one(1)) })
        }
        ("1-", _, _, 1) => {
            let operand = Box::new(arguments.remove(0));
            Ok(Ir { span, kind: IrKind::Binary(Binary::Sub, operand, one(1)) })
        }
        (_, Some((operation, swapped)), _, 2) => {
            let first = Box::new(arguments.remove(0));
            let second = Box::new(arguments.remove(0));
            // `a > b` is `b < a`; the operands keep their order of evaluation unless one of them
            // can be seen to have no effect.
            if swapped && !(is_plain(&first) || is_plain(&second)) {
                return Err(vec![*first, *second]);
            }
            let (left, right) = if swapped { (second, first) } else { (first, second) };
            Ok(Ir { span, kind: IrKind::Binary(operation, left, right) })
        }
        ("+" | "*", Some((operation, _)), _, count) if count > 2 => {
            let mut arguments = arguments.into_iter();
            let first = arguments.next().unwrap_or_else(|| unreachable!("there are more than two"));
            Ok(arguments.fold(first, |left, right| Ir {
                span,
                kind: IrKind::Binary(operation, Box::new(left), Box::new(right)),
            }))
        }
        (_, _, Some(operation), 1) => Ok(Ir { span, kind: IrKind::Unary(operation, Box::new(arguments.remove(0))) }),
        _ => Err(arguments),
    }
}

fn is_plain(ir: &Ir) -> bool {
    match &ir.kind {
        IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_) => true,
        IrKind::Local(_) | IrKind::Global(_) => false,
        IrKind::Unary(Unary::Deref, inner) => matches!(inner.kind, IrKind::Local(_) | IrKind::Global(_)),
        _ => false,
    }
}
