//! Parameter lists: required, `&optional`, `&rest`, `&key`.

use super::compiler::Compiler;
use super::ir::{Ir, ParameterBinding, VarId};
use crate::bars::read_name;
use crate::code::Parameters;
use crate::lexer::{Token, lex};
use crate::source::Span;
use crate::symbol::Symbol;
use crate::syntax::{NodeId, NodeKind};

/// More parameters a list cannot have.
const MAX_PARAMETERS: usize = 200;

/// What is in front of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Section {
    Required,
    Optional,
    Rest,
    Key,
}

/// Whether a parameter may be a list that is taken apart.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Lists {
    Refused,
    Taken,
}

impl Compiler<'_> {
    /// Binds the parameters of a list in the current function. Defaults may use the parameters
    /// before them.
    pub(super) fn lambda_list(&mut self, node: NodeId, lists: Lists) -> (Parameters, Vec<ParameterBinding>) {
        let mut parameters = Parameters::default();
        let mut bindings = Vec::new();
        for (section, item) in self.parameter_sections(node) {
            match section {
                Section::Required => {
                    parameters.required += 1;
                    bindings.extend(self.required_parameter(item, lists));
                }
                Section::Rest => {
                    parameters.rest = true;
                    bindings.extend(self.required_parameter(item, lists));
                }
                Section::Optional => {
                    parameters.optional += 1;
                    bindings.extend(self.omissible_parameter(item, lists));
                }
                Section::Key => {
                    if let Some(binding) = self.omissible_parameter(item, Lists::Refused) {
                        parameters.keys.push(self.variables[binding.variable.0 as usize].name);
                        bindings.push(binding);
                    }
                }
            }
        }
        (parameters, bindings)
    }

    /// The parameters of a list as they are written, each with its section.
    pub(super) fn parameter_sections(&mut self, node: NodeId) -> Vec<(Section, NodeId)> {
        let Some(items) = self.list_items(node) else {
            let span = self.tree.span(node);
            if self.tree.get(node).kind == NodeKind::Hole {
                // `[x y]`: the names in it are meant.
                let (tokens, _) = lex(self.program.sources.text_of(span), span.source);
                for (_, word) in tokens.into_iter().filter(|(token, _)| *token == Token::Symbol) {
                    let word = Span { start: span.start + word.start, end: span.start + word.end, ..span };
                    let name = read_name(self.program.sources.text_of(word)).into_owned();
                    let name = self.symbols.intern(&name);
                    self.bind(name, word);
                }
                return Vec::new();
            }
            let is_text = matches!(self.tree.get(node).kind, NodeKind::Str(_));
            let error =
                self.error("parameter-list", span, "a parameter list is missing", "expected a list such as `(a b)`");
            if is_text {
                error.help =
                    Some("the text stands behind the parameters: `(NAME (PARAMETER...) \"text\" FORM...)`".into());
            }
            return Vec::new();
        };
        let mut found = Vec::new();
        let mut section = Section::Required;
        let mut is_full = false;
        for item in items {
            let span = self.tree.span(item);
            if let Some(symbol) = self.tree.plain_symbol(item)
                && self.symbols.name(symbol).starts_with('&')
            {
                let next = match self.symbols.name(symbol) {
                    "&optional" if section == Section::Required => Ok(Section::Optional),
                    "&rest" | "&body" if matches!(section, Section::Required | Section::Optional) => Ok(Section::Rest),
                    "&key" if section != Section::Key => Ok(Section::Key),
                    other => Err(format!("`{other}` cannot stand here in a parameter list")),
                };
                match next {
                    Ok(next) => (section, is_full) = (next, false),
                    Err(message) => {
                        self.error("parameter-list", span, message, "the order is `a &optional b &rest c &key d`");
                    }
                }
            } else if found.len() >= MAX_PARAMETERS {
                let message = format!("a function can have {MAX_PARAMETERS} parameters at most");
                self.error("parameter-list", span, message, "one too many");
                break;
            } else if is_full {
                self.error("parameter-list", span, "`&rest` takes one name", "unexpected parameter");
                self.bind_all(item);
            } else {
                found.push((section, item));
                is_full = section == Section::Rest;
            }
        }
        found
    }

    /// A name, or a list that is taken apart: the variable that holds it, and what is bound to its parts.
    pub(super) fn parameter(&mut self, node: NodeId, lists: Lists) -> Option<(VarId, Vec<(VarId, Ir)>)> {
        let span = self.tree.span(node);
        if lists == Lists::Taken && self.tree.proper_list(node).is_some() {
            let list = self.new_list(span);
            return Some((list, self.taken_apart(node, list)));
        }
        if !self.refuses_to_bind(node) {
            if let Some(name) = self.tree.plain_symbol(node).filter(|&name| self.is_bindable(name)) {
                return Some((self.bind(name, span), Vec::new()));
            }
            let written = self.program.sources.text_of(span);
            let help = match written {
                "t" | "nil" => {
                    format!("`{written}` is a value and cannot be a name; take another one, such as `{written}-1`")
                }
                "," | "=" => "parameters are separated by spaces: `(x y)`".to_string(),
                _ if written.starts_with('(') => {
                    format!("a parameter with a default stands behind `&optional` or `&key`: `(&optional {written})`")
                }
                _ => "the list of parameters stands before the forms; without parameters it is `()`".to_string(),
            };
            self.error("parameter-list", span, "a parameter must be a name", "expected a name").help = Some(help);
        }
        self.bind_all(node);
        None
    }

    /// Binds all names in what is no parameter, so that nothing more is said of them.
    fn bind_all(&mut self, node: NodeId) {
        let mut waiting = vec![node];
        while let Some(node) = waiting.pop() {
            if let Some(name) = self.tree.symbol(node) {
                self.bind(name, self.tree.span(node));
            }
            waiting.extend(self.tree.items(node));
        }
    }

    fn required_parameter(&mut self, node: NodeId, lists: Lists) -> Option<ParameterBinding> {
        let (variable, parts) = self.parameter(node, lists)?;
        Some(ParameterBinding { variable, default: None, given: None, omissible: false, parts })
    }

    /// `name`, `(name)`, `(name default)` or `(name default given?)`.
    fn omissible_parameter(&mut self, node: NodeId, lists: Lists) -> Option<ParameterBinding> {
        let items = self.omissible_items(node)?;
        // The default is resolved before the name is bound: it must not see the parameter itself.
        let default = items.get(1).map(|&default| self.resolve(default));
        let (variable, parts) = self.parameter(items[0], lists)?;
        let given = match items.get(2) {
            Some(&given) => Some(self.parameter(given, Lists::Refused)?.0),
            None => None,
        };
        Some(ParameterBinding { variable, default, given, omissible: true, parts })
    }

    /// The parts of `name` or `(name default given?)`.
    pub(super) fn omissible_items(&mut self, node: NodeId) -> Option<Vec<NodeId>> {
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
            self.bind_all(node);
            return None;
        }
        Some(items)
    }

    /// The name of a parameter that may be left out.
    pub(super) fn omissible_name(&self, node: NodeId) -> Option<Symbol> {
        let named = self.tree.proper_list(node).and_then(|items| items.first().copied()).unwrap_or(node);
        self.tree.plain_symbol(named)
    }
}
