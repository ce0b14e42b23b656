//! What is known of variables: how often they are read and assigned, and what they are bound to.

use super::walk::each_function_form;
use crate::compile::Resolved;
use crate::compile::ir::{Function, Ir, IrKind, VarId};
use crate::compile::resolved::Defined;
use crate::stack::deep;

/// Where a variable is bound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum BoundBy {
    /// By a form such as `par-map`, a handler or a tag.
    #[default]
    Elsewhere,
    /// By `let` and its kind.
    Let,
    /// A parameter of a definition that callers give by position.
    Parameter,
}

/// What is known of one variable.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Binding<'a> {
    pub(super) place: BoundBy,
    pub(super) reads: u32,
    /// Assignments, that of `letrec` not counted.
    pub(super) assignments: i32,
    /// What it is bound to at first.
    pub(super) value: Option<&'a Ir>,
}

/// All variables of one text, by number.
pub(super) struct Bindings<'a> {
    list: Vec<Binding<'a>>,
}

impl<'a> Bindings<'a> {
    pub(super) fn of(resolved: &'a Resolved) -> Self {
        let mut bindings = Self { list: vec![Binding::default(); resolved.variables.len()] };
        for definition in &resolved.definitions {
            if let Defined::Function(_, function) | Defined::Macro(function) = &definition.defined {
                bindings.note_parameters(function);
                bindings.note_forms(function);
            }
        }
        resolved.forms.iter().chain(&resolved.tests).for_each(|form| bindings.note_forms(form));
        bindings
    }

    pub(super) fn get(&self, variable: VarId) -> &Binding<'a> {
        &self.list[variable.0 as usize]
    }

    /// The value a variable always has, if it is bound by `let` and never assigned.
    pub(super) fn constant(&self, variable: VarId) -> Option<&'a Ir> {
        let binding = self.get(variable);
        binding.value.filter(|_| binding.assignments == 0)
    }

    /// The function a variable always is.
    pub(super) fn function(&self, variable: VarId) -> Option<&'a Function> {
        match &self.constant(variable)?.kind {
            IrKind::Lambda(function) => Some(function),
            _ => None,
        }
    }

    fn at(&mut self, variable: VarId) -> &mut Binding<'a> {
        &mut self.list[variable.0 as usize]
    }

    /// Keywords belong to the callers too and cannot be marked as unused.
    fn note_parameters(&mut self, function: &'a Function) {
        let by_position = function.bindings.len() - function.parameters.keys.len();
        for binding in &function.bindings[..by_position] {
            self.at(binding.variable).place = BoundBy::Parameter;
        }
    }

    fn note_forms(&mut self, function: &'a Function) {
        each_function_form(function, &mut |_, ir| match &ir.kind {
            IrKind::Local(variable) | IrKind::Refail(variable) => self.at(*variable).reads += 1,
            IrKind::SetLocal(variable, _) => self.at(*variable).assignments += 1,
            IrKind::Let(bound, body) => self.note_let(bound, body),
            _ => {}
        });
    }

    fn note_let(&mut self, bound: &'a [(VarId, Ir)], body: &'a Ir) {
        for (variable, value) in bound {
            let at = self.at(*variable);
            (at.place, at.value) = (BoundBy::Let, Some(value));
        }
        // `letrec` binds to nil and assigns in the order of binding; the walk counts these
        // assignments when it comes to them, so they are taken off in advance.
        let IrKind::Seq(forms) = &body.kind else { return };
        for ((variable, value), form) in bound.iter().zip(forms) {
            match &form.kind {
                IrKind::SetLocal(assigned, function) if assigned == variable && is_letrec(value, function) => {
                    let at = self.at(*variable);
                    at.value = Some(function);
                    at.assignments -= 1;
                }
                _ => return,
            }
        }
    }
}

/// A value that stands behind its assignment in the text was put there by the compiler.
fn is_letrec(nothing: &Ir, function: &Ir) -> bool {
    let binding = nothing.span;
    matches!(nothing.kind, IrKind::Nil)
        && binding.source == function.span.source
        && binding.start < function.span.start
        && function.span.end <= binding.end
}

/// Whether a form's value is visibly no fluent: a constant, or computed by an operation that gives
/// none.
pub(super) fn is_plain(bindings: &Bindings<'_>, ir: &Ir) -> bool {
    deep(|| match &ir.kind {
        IrKind::Nil | IrKind::True | IrKind::Int(_) | IrKind::Const(_) | IrKind::Binary(..) => true,
        IrKind::If(_, then, otherwise) => is_plain(bindings, then) && is_plain(bindings, otherwise),
        IrKind::Local(variable) => bindings.constant(*variable).is_some_and(|value| is_plain(bindings, value)),
        _ => false,
    })
}
