//! Forms that choose what runs.

use super::special_form::{Role, SpecialForm, Written};
use crate::compile::compiler::Compiler;
use crate::compile::ir::{Ir, IrKind};
use crate::source::Span;
use crate::syntax::NodeId;

pub(super) const FORMS: &[SpecialForm] = &[
    SpecialForm {
        names: &["if"],
        form: "(if TEST THEN [ELSE])",
        doc: "The value of THEN if the test is true, else that of ELSE, or nil.",
        example: "",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.if_form(written)),
    },
    SpecialForm {
        names: &["and"],
        form: "(and FORM...)",
        doc: "Nil at the first form that is nil, else the last value.",
        example: "",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.and_form(written)),
    },
    SpecialForm {
        names: &["or"],
        form: "(or FORM...)",
        doc: "The first value that is not nil, else nil.",
        example: "",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.or_form(written)),
    },
];

impl Compiler<'_> {
    fn if_form(&mut self, written: &Written<'_>) -> Ir {
        match written.rest() {
            [condition, then] => self.conditional(*condition, *then, None, written.span),
            [condition, then, otherwise] => self.conditional(*condition, *then, Some(*otherwise), written.span),
            _ => self.malformed(written.span, "`(if CONDITION THEN ELSE)`"),
        }
    }

    fn conditional(&mut self, condition: NodeId, then: NodeId, otherwise: Option<NodeId>, span: Span) -> Ir {
        let condition = Box::new(self.resolve(condition));
        let then = Box::new(self.resolve(then));
        let otherwise = Box::new(match otherwise {
            Some(otherwise) => self.resolve(otherwise),
            None => self.nil(span),
        });
        Ir { span, kind: IrKind::If(condition, then, otherwise) }
    }

    fn and_form(&mut self, written: &Written<'_>) -> Ir {
        let kind = match written.rest() {
            [] => IrKind::True,
            forms => IrKind::And(self.arguments(forms)),
        };
        Ir { span: written.span, kind }
    }

    fn or_form(&mut self, written: &Written<'_>) -> Ir {
        let kind = match written.rest() {
            [] => IrKind::Nil,
            forms => IrKind::Or(self.arguments(forms)),
        };
        Ir { span: written.span, kind }
    }
}
