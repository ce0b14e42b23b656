//! Parameter lists: required, `&optional`, `&rest`, `&key`.

use super::compiler::Compiler;
use super::ir::{ParameterBinding, VarId};
use crate::code::Parameters;
use crate::syntax::{NodeId, NodeKind};

#[derive(Clone, Copy, PartialEq)]
enum Section {
    Required,
    Optional,
    Rest,
    Key,
    Done,
}

impl Compiler<'_> {
    /// Binds the parameters of a list in the current function. Defaults may use the parameters
    /// before them.
    pub(super) fn lambda_list(&mut self, node: NodeId) -> (Parameters, Vec<ParameterBinding>) {
        let mut parameters = Parameters::default();
        let mut bindings = Vec::new();
        let Some(items) = self.list_items(node) else {
            let span = self.tree.span(node);
            self.error("parameter-list", span, "a parameter list is missing", "expected a list such as `(a b)`");
            return (parameters, bindings);
        };
        let mut section = Section::Required;
        for item in items {
            let span = self.tree.span(item);
            if let Some(symbol) = self.tree.symbol(item)
                && self.symbols.name(symbol).starts_with('&')
            {
                section = match self.symbols.name(symbol) {
                    "&optional" if section == Section::Required => Section::Optional,
                    "&rest" | "&body" if matches!(section, Section::Required | Section::Optional) => Section::Rest,
                    "&key" if section != Section::Key => Section::Key,
                    other => {
                        let message = format!("`{other}` cannot stand here in a parameter list");
                        self.error("parameter-list", span, message, "the order is `a &optional b &rest c &key d`");
                        section
                    }
                };
                continue;
            }
            if bindings.len() >= 200 {
                self.error("parameter-list", span, "a function can have 200 parameters at most", "one too many");
                break;
            }
            match section {
                Section::Required => {
                    parameters.required += 1;
                    bindings.extend(self.required_parameter(item));
                }
                Section::Rest => {
                    parameters.rest = true;
                    section = Section::Done;
                    bindings.extend(self.required_parameter(item));
                }
                Section::Optional => {
                    parameters.optional += 1;
                    bindings.extend(self.omissible_parameter(item));
                }
                Section::Key => {
                    if let Some(binding) = self.omissible_parameter(item) {
                        parameters.keys.push(self.variables[binding.variable.0 as usize].name);
                        bindings.push(binding);
                    }
                }
                Section::Done => {
                    self.error("parameter-list", span, "`&rest` takes one name", "unexpected parameter");
                }
            }
        }
        (parameters, bindings)
    }

    fn parameter_name(&mut self, node: NodeId) -> Option<VarId> {
        let span = self.tree.span(node);
        match self.tree.get(node).kind {
            NodeKind::Symbol(name) if self.is_bindable(name) => Some(self.bind(name, span)),
            _ => {
                self.error("parameter-list", span, "a parameter must be a name", "expected a name");
                None
            }
        }
    }

    fn required_parameter(&mut self, node: NodeId) -> Option<ParameterBinding> {
        let variable = self.parameter_name(node)?;
        Some(ParameterBinding { variable, default: None, given: None, omissible: false })
    }

    /// `name`, `(name)`, `(name default)` or `(name default given?)`.
    fn omissible_parameter(&mut self, node: NodeId) -> Option<ParameterBinding> {
        let items = match self.tree.proper_list(node) {
            Some(items) => items.to_vec(),
            None => vec![node],
        };
        if items.is_empty() || items.len() > 3 {
            let span = self.tree.span(node);
            self.error(
                "parameter-list",
                span,
                "an optional parameter is `name` or `(name default)`",
                "not of that form",
            );
            return None;
        }
        // The default is resolved before the name is bound: it must not see the parameter itself.
        let default = items.get(1).map(|&default| self.resolve(default));
        let variable = self.parameter_name(items[0])?;
        let given = match items.get(2) {
            Some(&given) => Some(self.parameter_name(given)?),
            None => None,
        };
        Some(ParameterBinding { variable, default, given, omissible: true })
    }
}
