//! Waiting for fluents, and fluents made of others.

use super::special_form::{Role, SpecialForm};
use crate::code::{CodeKind, Missed};
use crate::compile::compiler::{Compiler, thunk};
use crate::compile::ir::{Ir, IrKind};
use crate::layout::Layout;
use crate::layout::Style::Body;
use crate::source::Span;
use crate::stack::deep;
use crate::suggest::suggest;
use crate::syntax::{NodeId, NodeKind};

pub(super) const FORMS: &[SpecialForm] = &[
    SpecialForm {
        names: &["wait-for"],
        form: "(wait-for CONDITION [:timeout SECONDS])",
        doc: "Waits until the condition, a fluent or an expression over fluents, is true; gives its value, or nil when the time is over before.",
        example: "(def-fluent level 0)\n(par (wait-for (> level 2))\n     (setf (value level) 3))",
        layout: None,
        role: Role::Effect(|compiler, written| compiler.wait_for(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["whenever"],
        form: "(whenever CONDITION [:missed :once|:always|:never] FORM...)",
        doc: "Runs the forms each time the condition becomes true; ends by `(return)` only. What becomes true during the forms counts once by default.",
        example: "(def-fluent level 0)\n(pursue (whenever (> level 2) (print \"high\"))\n        (seq (setf (value level) 3) (wait-time 1)))",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Effect(|compiler, written| compiler.whenever(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["fluent"],
        form: "(fluent EXPR)",
        doc: "A fluent whose value is that of the expression over other fluents.",
        example: "(def-fluent level 0)\n(let ((high (fluent (> level 2))))\n  (value high))",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.fluent(written.rest(), written.span)),
    },
];

impl Compiler<'_> {
    fn wait_for(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let (condition, timeout) = match rest {
            [condition] => (*condition, None),
            [condition, word, seconds] if self.is_keyword(*word, "timeout") => (*condition, Some(*seconds)),
            [_, word, _] if self.is_near_keyword(*word, "timeout") => {
                let place = self.tree.span(*word);
                self.error("malformed", place, "`wait-for` has no such option", "unknown option").help =
                    Some("did you mean `:timeout`?".into());
                return self.nil(span);
            }
            _ => return self.malformed(span, "`(wait-for CONDITION)` or `(wait-for CONDITION :timeout SECONDS)`"),
        };
        let (fluent, owned) = self.condition(condition);
        let timeout = timeout.map(|seconds| Box::new(self.resolve(seconds)));
        Ir { span, kind: IrKind::WaitFor { fluent: Box::new(fluent), timeout, owned } }
    }

    pub(super) fn is_keyword(&self, node: NodeId, name: &str) -> bool {
        matches!(self.tree.get(node).kind, NodeKind::Keyword(word) if self.symbols.name(word) == name)
    }

    fn is_near_keyword(&self, node: NodeId, name: &str) -> bool {
        matches!(self.tree.get(node).kind, NodeKind::Keyword(word) if suggest(self.symbols.name(word), [name].into_iter()).is_some())
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
                NodeKind::Keyword(mode) => match self.symbols.name(mode) {
                    "once" => missed = Missed::Once,
                    "always" => missed = Missed::Always,
                    "never" => missed = Missed::Never,
                    _ => drop(self.malformed(place, "`:missed :once`, `:missed :always` or `:missed :never`")),
                },
                _ => drop(self.malformed(place, "`:missed :once`, `:missed :always` or `:missed :never`")),
            }
            body = forms;
        } else if let [word, _, ..] = body
            && self.is_near_keyword(*word, "missed")
        {
            let place = self.tree.span(*word);
            self.error("malformed", place, "`whenever` has no such option", "unknown option").help =
                Some("did you mean `:missed`?".into());
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
        let gives_fluent = matches!(
            self.head_of_language(node),
            Some("status" | "result" | "begin-task" | "end-task" | "pulsed" | "changed" | "fluent")
        );
        if gives_fluent {
            return (self.resolve(node), true);
        }
        (self.network(node, self.tree.span(node)), true)
    }

    fn fluent(&mut self, rest: &[NodeId], span: Span) -> Ir {
        match rest {
            [expression] => self.network(*expression, span),
            _ => self.malformed(span, "`(fluent EXPRESSION)`"),
        }
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
