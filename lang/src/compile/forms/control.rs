//! What runs one after the other, again and again, or is left.

use super::special_form::{Role, SpecialForm};
use crate::compile::compiler::Compiler;
use crate::compile::ir::{Ir, IrKind};
use crate::layout::Layout;
use crate::layout::Style::{Body, Forms};
use crate::source::Span;
use crate::symbol::Symbol;
use crate::syntax::NodeId;

pub(super) const FORMS: &[SpecialForm] = &[
    SpecialForm {
        names: &["progn", "seq"],
        form: "(seq FORM...)",
        doc: "Succeeds if all forms did, in order; fails at the first failure. The value is the last.",
        example: "",
        layout: Some(Layout::plain(Forms)),
        role: Role::Sequence(|compiler, written| compiler.body(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["block"],
        form: "(block NAME FORM...)",
        doc: "Runs the forms; `(return-from NAME VALUE)` leaves them.",
        example: "",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Plain(|compiler, written| compiler.block(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["return-from"],
        form: "(return-from NAME [VALUE])",
        doc: "Leaves the block of that name with a value; clean-ups run.",
        example: "",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.return_from(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["return"],
        form: "(return [VALUE])",
        doc: "Leaves the nearest loop with a value; clean-ups run.",
        example: "",
        layout: None,
        role: Role::Plain(|compiler, written| compiler.return_nil_block(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["loop"],
        form: "(loop FORM... [until E] [while E] FORM...)",
        doc: "Runs the forms again and again until E is true, or while it is. The value is nil.",
        example: "(let ((n 0))\n  (loop (incf n)\n    until (= n 3)\n    (print n)))",
        layout: Some(Layout::plain(Body(0))),
        role: Role::Plain(|compiler, written| compiler.loop_form(written.rest(), written.span)),
    },
];

impl Compiler<'_> {
    fn block(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let Some(name) = rest.first().and_then(|&name| self.tree.symbol(name)) else {
            return self.malformed(span, "`(block NAME FORM...)`");
        };
        self.in_block(Some(name), span, |compiler, _| compiler.body(&rest[1..], span))
    }

    fn return_from(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let (Some(name), true) = (rest.first().and_then(|&name| self.tree.symbol(name)), rest.len() <= 2) else {
            return self.malformed(span, "`(return-from NAME VALUE)`");
        };
        self.leave_named(name, rest.get(1).copied(), span)
    }

    fn return_nil_block(&mut self, rest: &[NodeId], span: Span) -> Ir {
        if rest.len() > 1 {
            return self.malformed(span, "`(return VALUE)`");
        }
        let name = self.symbols.intern("nil");
        self.leave_named(name, rest.first().copied(), span)
    }

    fn leave_named(&mut self, name: Symbol, value: Option<NodeId>, span: Span) -> Ir {
        let value = match value {
            Some(value) => self.resolve(value),
            None => self.nil(span),
        };
        match self.blocks.iter().rposition(|block| block.name == Some(name)) {
            Some(block) => self.leave(block, value, span),
            None => {
                let text = self.symbols.name(name).to_string();
                let message = match text.as_str() {
                    "nil" => "`return` stands in no loop".to_string(),
                    _ => format!("no block `{text}` is around this"),
                };
                self.error("no-block", span, message, "nothing to leave").help =
                    Some("`loop`, `dolist`, `dotimes` and `whenever` can be left by `(return V)`, `(block NAME …)` by `(return-from NAME V)`".into());
                value
            }
        }
    }

    /// RPL's loop: forms, with the bare words `until` and `while` between them.
    fn loop_form(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let nil = self.symbols.intern("nil");
        let rest = rest.to_vec();
        self.in_block(Some(nil), span, |compiler, _| {
            let block = compiler.blocks.len() - 1;
            let mut forms = Vec::new();
            let mut items = rest.into_iter();
            while let Some(item) = items.next() {
                let word = compiler.tree.symbol(item).map(|word| compiler.symbols.name(word).to_string());
                let until = match word.as_deref() {
                    Some("until") => true,
                    Some("while") => false,
                    _ => {
                        forms.push(compiler.resolve(item));
                        continue;
                    }
                };
                let place = compiler.tree.span(item);
                let Some(condition) = items.next() else {
                    compiler.malformed(place, "`until CONDITION` or `while CONDITION`");
                    break;
                };
                let condition = Box::new(compiler.resolve(condition));
                let nothing = compiler.nil(place);
                let leave = Box::new(compiler.leave(block, nothing, place));
                let stay = Box::new(compiler.nil(place));
                let (then, otherwise) = if until { (leave, stay) } else { (stay, leave) };
                forms.push(Ir { span: place, kind: IrKind::If(condition, then, otherwise) });
            }
            Ir { span, kind: IrKind::Loop(Box::new(Ir { span, kind: IrKind::Seq(forms) })) }
        })
    }
}
