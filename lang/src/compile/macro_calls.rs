//! Calls of macros: expanded, and what comes out is resolved.

use super::compilation::Unexpanded;
use super::compiler::Compiler;
use super::ir::Ir;
use crate::diagnostic::NOT_OF_THE_FORM;
use crate::source::Span;
use crate::syntax::NodeId;

/// Macros that expand into macros without end are cut here.
const MAX_EXPANSIONS_IN_A_ROW: u32 = 1_000;

impl Compiler<'_> {
    /// Resolves what a call of a macro expands into.
    pub(super) fn expand_and_resolve(&mut self, code: u32, node: NodeId) -> Ir {
        let span = self.tree.span(node);
        self.expanded(code, node, |compiler, expansion| compiler.resolve(expansion)).unwrap_or_else(|| self.nil(span))
    }

    /// Expands a call of a macro and does something with what comes out; none if that is an error.
    pub(super) fn expanded<T>(
        &mut self,
        code: u32,
        node: NodeId,
        then: impl FnOnce(&mut Self, NodeId) -> T,
    ) -> Option<T> {
        if self.expansion.is_over {
            return None;
        }
        if self.expansion.in_a_row >= MAX_EXPANSIONS_IN_A_ROW {
            let message = format!("this macro expands into macros more than {MAX_EXPANSIONS_IN_A_ROW} deep");
            self.error("endless-macro", self.tree.span(node), message, "the expansion has no end");
            // One that uses itself twice would be told at the end of every branch.
            self.expansion.is_over = true;
            return None;
        }
        let before = self.tree.nodes.len();
        let room = self.expansion.most.saturating_sub(self.expansion.made);
        let result = self.macros.expand(self.program, self.symbols, &mut self.tree, code, node, room);
        self.expansion.made += self.tree.nodes.len() - before;
        match result {
            Ok(expansion) => {
                self.expansion.in_a_row += 1;
                let result = then(self, expansion);
                self.expansion.in_a_row -= 1;
                Some(result)
            }
            Err(Unexpanded::Failed(mut diagnostic)) => {
                let form = diagnostic.message.strip_prefix(NOT_OF_THE_FORM);
                if form.is_some() && self.has_hole(diagnostic.span) {
                    return None;
                }
                if let (Some(form), None) = (form, &diagnostic.help) {
                    diagnostic.help = self.shape_advice(diagnostic.span, form);
                }
                self.diagnostics.push(*diagnostic);
                None
            }
            Err(Unexpanded::TooLarge) => {
                let most = self.expansion.most;
                self.expansion.lacks_room = true;
                self.too_much_expanded(node, &format!("what all macros here expand into has more than {most} parts"));
                None
            }
            Err(Unexpanded::TooLong { steps }) => {
                self.too_much_expanded(node, &format!("all macros here have taken {steps} steps"));
                None
            }
        }
    }

    fn too_much_expanded(&mut self, node: NodeId, what: &str) {
        let span = self.tree.span(node);
        let name = self.tree.head(node).map_or_else(String::new, |head| self.symbols.name(head).to_string());
        let message = format!("with this call of `{name}`, {what}");
        let help = format!("let `{name}` expand into a call of a function that does the rest when it runs");
        self.no_more(span, message, help);
    }

    /// Tells that this is too much, once; nothing is expanded or loaded any more.
    pub(super) fn no_more(&mut self, span: Span, message: String, help: String) {
        self.expansion.is_over = true;
        self.error("too-much-expanded", span, message, "no more is expanded").help = Some(help);
    }
}
