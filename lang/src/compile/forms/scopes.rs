//! Forms around a body that runs in the same task: clean-ups, valves, hooks, suspension, fences.

use super::special_form::{Role, SpecialForm, Written};
use crate::code::CodeKind;
use crate::compile::compiler::Compiler;
use crate::compile::ir::{Function, Ir, IrKind, ScopeIr};
use crate::layout::ItemShape::Data;
use crate::layout::Layout;
use crate::layout::Style::Body;
use crate::source::Span;
use crate::syntax::NodeId;

pub(super) const FORMS: &[SpecialForm] = &[
    SpecialForm {
        names: &["evap-protect"],
        form: "(evap-protect FORM CLEAN-UP...)",
        doc: "Runs the form; if it is cut short, the clean-up runs before the task dies.",
        example: "(evap-protect (wait-time 5)\n  (print \"cut short\"))",
        layout: Some(Layout::plain(Body(0))),
        role: Role::Plain(|compiler, written| compiler.protect(false, written.rest(), written.span)),
    },
    SpecialForm {
        names: &["unwind-protect"],
        form: "(unwind-protect FORM CLEAN-UP...)",
        doc: "Runs the form, and the clean-up however it ends. The value is the form's.",
        example: "(unwind-protect (print \"work\")\n  (print \"clean up\"))",
        layout: Some(Layout::plain(Body(0))),
        role: Role::Plain(|compiler, written| compiler.protect(true, written.rest(), written.span)),
    },
    SpecialForm {
        names: &["with-valve"],
        form: "(with-valve VALVE [:timeout SECONDS] FORM...)",
        doc: "Runs the forms holding the valve; it is given back however they end. With `:timeout`, fails with `timeout` if the valve is not given within that time; the forms take as long as they take.",
        example: "(def-valve arm-1)\n(with-valve arm-1\n  (wait-time 1))",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Effect(|compiler, written| compiler.with_valve(written)),
    },
    SpecialForm {
        names: &["on-interrupt"],
        form: "(on-interrupt HOOK FORM...)",
        doc: "Runs the forms; the hook runs when their valve is taken away.",
        example: "",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Effect(|compiler, written| {
            compiler.with_hook(ScopeIr::OnInterrupt, "on-interrupt", written.rest(), written.span)
        }),
    },
    SpecialForm {
        names: &["on-resume"],
        form: "(on-resume HOOK FORM...)",
        doc: "Runs the forms; the hook runs when their valve comes back.",
        example: "",
        layout: Some(Layout::plain(Body(1))),
        role: Role::Effect(|compiler, written| {
            compiler.with_hook(ScopeIr::OnResume, "on-resume", written.rest(), written.span)
        }),
    },
    SpecialForm {
        names: &["with-task-suspended"],
        form: "(with-task-suspended (TASK) FORM...)",
        doc: "Runs the forms while a task rests.",
        example: "",
        layout: Some(Layout::with(Body(1), &[Data])),
        role: Role::Effect(|compiler, written| compiler.with_task_suspended(written.rest(), written.span)),
    },
    SpecialForm {
        names: &["no-revision"],
        form: "(no-revision FORM...)",
        doc: "Runs the forms; until they have ended, `swap-plan` of the task or of one above it waits.",
        example: "(no-revision\n  (print \"picks up\")\n  (print \"sets down\"))",
        layout: Some(Layout::plain(Body(0))),
        role: Role::Effect(|compiler, written| {
            let body = Box::new(compiler.body(written.rest(), written.span));
            Ir { span: written.span, kind: IrKind::Scope(ScopeIr::Fence, body) }
        }),
    },
];

impl Compiler<'_> {
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

    /// `(with-valve VALVE [:timeout SECONDS] FORM...)`
    fn with_valve(&mut self, written: &Written<'_>) -> Ir {
        let (seconds, valve, body) = match *written.rest() {
            [valve, word, seconds, ref body @ ..] if self.is_keyword(word, "timeout") => (Some(seconds), valve, body),
            [_, word] if self.is_keyword(word, "timeout") => {
                return self.malformed(written.span, &format!("`{}`", written.form.form));
            }
            [valve, ref body @ ..] => (None, valve, body),
            [] => return self.malformed(written.span, &format!("`{}`", written.form.form)),
        };
        let valve = Box::new(self.resolve(valve));
        let seconds = seconds.map(|seconds| Box::new(self.resolve(seconds)));
        let body = Box::new(self.body(body, written.span));
        Ir { span: written.span, kind: IrKind::Scope(ScopeIr::Valve { valve, seconds }, body) }
    }

    /// `(with-task-suspended (TASK) FORM...)`
    fn with_task_suspended(&mut self, rest: &[NodeId], span: Span) -> Ir {
        let form = "`(with-task-suspended (TASK) FORM...)`";
        let Some((&header, body)) = rest.split_first() else { return self.malformed(span, form) };
        let [task] = *self.tree.items(header) else { return self.malformed(span, form) };
        let task = Box::new(self.resolve(task));
        let body = Box::new(self.body(body, span));
        Ir { span, kind: IrKind::Scope(ScopeIr::Suspended(task), body) }
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
}
