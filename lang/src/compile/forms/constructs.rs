//! Constructs of concurrent children.

use super::special_form::{Role, SpecialForm, Written};
use crate::code::{CodeKind, Parameters, Quorum};
use crate::compile::compiler::{Compiler, thunk};
use crate::compile::ir::{ArgumentIr, ChildIr, ConstructIr, Ir, IrKind, ParameterBinding};
use crate::layout::ItemShape::{Binding, Clause};
use crate::layout::Layout;
use crate::layout::Style::{Body, Forms};
use crate::source::Span;
use crate::syntax::NodeId;

pub(super) const FORMS: &[SpecialForm] = &[
    SpecialForm {
        names: &["par"],
        form: "(par FORM...)",
        doc: "Runs the forms concurrently. Succeeds if all did; fails at the first failure, and the others are evaporated. The value is the last child's.",
        example: "(par (wait-time 2)\n     (print \"meanwhile\"))",
        layout: Some(Layout::plain(Forms)),
        role: Role::Effect(|compiler, written| compiler.children(Quorum::PAR, written)),
    },
    SpecialForm {
        names: &["pursue"],
        form: "(pursue FORM...)",
        doc: "Runs the forms concurrently. Ends as the first of them ends, and the others are evaporated.",
        example: "(pursue (wait-time 10)\n        (seq (wait-time 2) (print \"first\")))",
        layout: Some(Layout::plain(Forms)),
        role: Role::Effect(|compiler, written| compiler.children(Quorum::PURSUE, written)),
    },
    SpecialForm {
        names: &["try-all"],
        form: "(try-all FORM...)",
        doc: "Runs the forms concurrently. Succeeds at the first success, and the others are evaporated; fails with a composite-failure when all failed.",
        example: "(try-all (fail \"no\")\n         (seq (wait-time 1) 'yes))",
        layout: Some(Layout::plain(Forms)),
        role: Role::Effect(|compiler, written| compiler.children(Quorum::TRY_ALL, written)),
    },
    SpecialForm {
        names: &["quorum"],
        form: "(quorum SUCCESSES FAILURES FORM...)",
        doc: "Runs the forms concurrently. Succeeds when so many have succeeded; fails when so many have failed, or too few are left that could succeed; the others are evaporated. Each number is an integer from 1 on, or `:all`. The value is the list of the values, in the order in which they came.",
        example: "(print (quorum 2 :all\n         (seq (wait-time 3) 'slow)\n         (seq (wait-time 1) 'quick)\n         (seq (wait-time 2) 'middling)))",
        layout: Some(Layout::plain(Body(2))),
        role: Role::Effect(|compiler, written| compiler.quorum(written)),
    },
    SpecialForm {
        names: &["gather"],
        form: "(gather FORM...)",
        doc: "Runs the forms concurrently. Succeeds if all did, with the list of all values in the order of the forms; fails at the first failure, and the others are evaporated.",
        example: "(print (gather (seq (wait-time 2) 'slow)\n               (seq (wait-time 1) 'quick)))",
        layout: Some(Layout::plain(Forms)),
        role: Role::Effect(|compiler, written| compiler.children(Quorum::GATHER, written)),
    },
    SpecialForm {
        names: &["settle"],
        form: "(settle FORM...)",
        doc: "Runs the forms concurrently until all have ended, and succeeds. The value is the list of all values in the order of the forms; that of a form that failed is its failure.",
        example: "(print (map failurep (settle 'here (fail \"gone\"))))",
        layout: Some(Layout::plain(Forms)),
        role: Role::Effect(|compiler, written| compiler.children(Quorum::SETTLE, written)),
    },
    SpecialForm {
        names: &["plan", "partial-order"],
        form: "(plan (STEP...) (:order A B)...)",
        doc: "Runs the steps concurrently, B only when A is dead. Succeeds if all did; fails at the first failure.",
        example: "(plan ((:tag paint (print \"paint\"))\n       (:tag clean (print \"clean\")))\n  (:order clean paint))",
        layout: Some(Layout::with(Body(1), &[Clause])),
        role: Role::Effect(|compiler, written| compiler.partial_order(written)),
    },
    SpecialForm {
        names: &["par-map"],
        form: "(par-map (NAME LIST [:most N]) FORM...)",
        doc: "As `par`, one child for each element; with `:most`, so many at a time.",
        example: "(par-map (seconds '(3 1 2))\n  (wait-time seconds)\n  (print seconds))",
        layout: Some(Layout::with(Body(1), &[Binding])),
        role: Role::Effect(|compiler, written| compiler.map_children(Quorum::PAR, written)),
    },
    SpecialForm {
        names: &["pursue-map"],
        form: "(pursue-map (NAME LIST) FORM...)",
        doc: "As `pursue`, one child for each element.",
        example: "",
        layout: Some(Layout::with(Body(1), &[Binding])),
        role: Role::Effect(|compiler, written| compiler.map_children(Quorum::PURSUE, written)),
    },
    SpecialForm {
        names: &["try-all-map"],
        form: "(try-all-map (NAME LIST [:most N]) FORM...)",
        doc: "As `try-all`, one child for each element; with `:most`, so many at a time.",
        example: "",
        layout: Some(Layout::with(Body(1), &[Binding])),
        role: Role::Effect(|compiler, written| compiler.map_children(Quorum::TRY_ALL, written)),
    },
    SpecialForm {
        names: &["gather-map"],
        form: "(gather-map (NAME LIST [:most N]) FORM...)",
        doc: "As `gather`, one child for each element; with `:most`, so many at a time.",
        example: "(print (gather-map (seconds '(3 1 2) :most 2)\n         (wait-time seconds)\n         (* 10 seconds)))",
        layout: Some(Layout::with(Body(1), &[Binding])),
        role: Role::Effect(|compiler, written| compiler.map_children(Quorum::GATHER, written)),
    },
    SpecialForm {
        names: &["settle-map"],
        form: "(settle-map (NAME LIST [:most N]) FORM...)",
        doc: "As `settle`, one child for each element; with `:most`, so many at a time.",
        example: "",
        layout: Some(Layout::with(Body(1), &[Binding])),
        role: Role::Effect(|compiler, written| compiler.map_children(Quorum::SETTLE, written)),
    },
    SpecialForm {
        names: &["with-policy"],
        form: "(with-policy POLICY FORM...)",
        doc: "Runs the forms such that the policy, a concurrent task of higher priority, is kept. Ends as the forms end; fails if the policy fails.",
        example: "(def-fluent battery 20)\n(with-policy (whenever (< battery 30) (setf (value battery) 100))\n  (wait-time 5))",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Effect(|compiler, written| compiler.with_policy(written)),
    },
    SpecialForm {
        names: &["with-priority"],
        form: "(with-priority N FORM...)",
        doc: "Runs the forms as a task with another priority.",
        example: "",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Effect(|compiler, written| compiler.with_priority(written)),
    },
    SpecialForm {
        names: &["with-timeout"],
        form: "(with-timeout SECONDS [:active] FORM...)",
        doc: "Succeeds if the forms do in time; fails with `timeout` at the deadline, and they are evaporated. With `:active` only the time counts in which they are not suspended.",
        example: "(with-failure-handling ((timeout (f) 'late))\n  (with-timeout 3 (wait-time 10)))",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Effect(|compiler, written| compiler.with_timeout(written)),
    },
];

impl Compiler<'_> {
    /// A construct with one child.
    pub(super) fn single(&mut self, name: &str, child: ChildIr, argument: Option<ArgumentIr>, span: Span) -> Ir {
        let name = self.symbols.intern(name);
        let construct = ConstructIr { quorum: Quorum::LAST, name, children: vec![child], order: Vec::new(), argument };
        Ir { span, kind: IrKind::Construct(Box::new(construct)) }
    }

    /// A child: a tag or process *is* the child, anything else is its body.
    pub(super) fn child(&mut self, node: NodeId) -> ChildIr {
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

    /// A construct with one child for each form.
    fn children(&mut self, quorum: Quorum, written: &Written<'_>) -> Ir {
        let children = self.children_of(written.rest(), written.span);
        self.construct(quorum, written, children, Vec::new(), None)
    }

    /// `(quorum SUCCESSES FAILURES FORM...)`
    fn quorum(&mut self, written: &Written<'_>) -> Ir {
        let [successes, failures, forms @ ..] = written.rest() else {
            return self.malformed(written.span, "`(quorum SUCCESSES FAILURES FORM...)`");
        };
        let successes = Box::new(self.resolve(*successes));
        let failures = Box::new(self.resolve(*failures));
        let children = self.children_of(forms, written.span);
        let argument = Some(ArgumentIr::Quorum { successes, failures });
        self.construct(Quorum::ASKED, written, children, Vec::new(), argument)
    }

    fn children_of(&mut self, forms: &[NodeId], span: Span) -> Vec<ChildIr> {
        let children: Vec<ChildIr> = forms.iter().map(|&node| self.child(node)).collect();
        if children.len() > 10_000 {
            self.error("too-many-children", span, "a construct can have 10000 children at most", "too many");
        }
        children
    }

    pub(super) fn construct(
        &mut self,
        quorum: Quorum,
        written: &Written<'_>,
        children: Vec<ChildIr>,
        order: Vec<(u16, u16)>,
        argument: Option<ArgumentIr>,
    ) -> Ir {
        let name = self.symbols.intern(written.form.name());
        let construct = ConstructIr { quorum, name, children, order, argument };
        Ir { span: written.span, kind: IrKind::Construct(Box::new(construct)) }
    }

    /// `(par-map (V LIST [:most N]) FORM...)`: one child for each element.
    fn map_children(&mut self, quorum: Quorum, written: &Written<'_>) -> Ir {
        let (name, rest, span) = (written.form.name(), written.rest(), written.span);
        let header = rest.first().map(|&header| self.tree.items(header).to_vec()).unwrap_or_default();
        if header.first().is_some_and(|&name| self.refuses_to_bind(name)) {
            return self.nil(span);
        }
        let variable = header.first().and_then(|&name| self.tree.symbol(name));
        let most = match header.as_slice() {
            [_, _] => None,
            &[_, _, word, most] if self.is_keyword(word, "most") => Some(most),
            _ => return self.malformed_map(written),
        };
        let Some(variable) = variable.filter(|&name| self.is_bindable(name)) else {
            return self.malformed_map(written);
        };
        if most.is_some() && quorum == Quorum::PURSUE {
            let message =
                "`pursue-map` ends as the first child ends, so those that wait for their turn would never begin";
            self.error("most-of-pursue", span, message, "no `:most` here").help =
                Some("cut the list short, or write `try-all-map`, which goes on after a failure".into());
        }
        let place = self.tree.span(header[0]);
        let list = self.resolve(header[1]);
        let argument = most.map(|most| ArgumentIr::Most(Box::new(self.resolve(most))));
        let body_name = self.symbols.intern(name);
        let ((element, body), scope) = self.in_function(CodeKind::Task, false, |compiler| {
            let element = compiler.bind(variable, place);
            (element, compiler.body(&rest[1..], span))
        });
        let mut body = thunk(body_name, CodeKind::Task, body, scope, span);
        body.parameters = Parameters { required: 1, ..Parameters::default() };
        body.bindings = vec![ParameterBinding {
            variable: element,
            default: None,
            given: None,
            omissible: false,
            parts: Vec::new(),
        }];
        let children = vec![ChildIr { body, tag: None, name: None }];
        let construct = ConstructIr { quorum, name: body_name, children, order: Vec::new(), argument };
        Ir { span, kind: IrKind::ConstructMap(Box::new(construct), Box::new(list)) }
    }

    fn malformed_map(&mut self, written: &Written<'_>) -> Ir {
        self.malformed(written.span, &format!("`{}`", written.form.form))
    }

    fn with_policy(&mut self, written: &Written<'_>) -> Ir {
        let Some((&policy, body)) = written.rest().split_first() else {
            return self.malformed(written.span, "`(with-policy POLICY FORM...)`");
        };
        let policy = self.child(policy);
        let primary = match body {
            [one] => self.child(*one),
            many => ChildIr { body: self.thunk("body", CodeKind::Task, many, written.span), tag: None, name: None },
        };
        self.construct(Quorum::LAST, written, vec![policy, primary], Vec::new(), None)
    }

    /// `(with-priority NUMBER FORM...)`
    fn with_priority(&mut self, written: &Written<'_>) -> Ir {
        let Some((&number, body)) = written.rest().split_first() else { return self.no_number(written) };
        self.with_argument(written, number, body, ArgumentIr::Priority)
    }

    /// `(with-timeout SECONDS [:active] FORM...)`
    fn with_timeout(&mut self, written: &Written<'_>) -> Ir {
        let Some((&seconds, mut body)) = written.rest().split_first() else { return self.no_number(written) };
        let active = body.first().is_some_and(|&first| self.is_keyword(first, "active"));
        if active {
            body = &body[1..];
        }
        self.with_argument(written, seconds, body, |seconds| ArgumentIr::Deadline { seconds, active })
    }

    fn no_number(&mut self, written: &Written<'_>) -> Ir {
        self.malformed(written.span, &format!("`({} NUMBER FORM...)`", written.form.name()))
    }

    fn with_argument(
        &mut self,
        written: &Written<'_>,
        argument: NodeId,
        body: &[NodeId],
        as_argument: impl FnOnce(Box<Ir>) -> ArgumentIr,
    ) -> Ir {
        // What else is a unit may be a name of the plan, and the body.
        self.refuse_unit_apart(written.rest(), &["min"]);
        let argument = as_argument(Box::new(self.resolve(argument)));
        let name = written.form.name();
        let body = self.thunk(name, CodeKind::Task, body, written.span);
        self.single(name, ChildIr { body, tag: None, name: None }, Some(argument), written.span)
    }
}
