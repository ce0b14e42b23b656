//! What names mean where they stand: variables, tags of the plan, globals, natives.

use super::compiler::{Compiler, Unknown};
use super::ir::{Ir, IrKind, VarId};
use super::locals::Surrounding;
use crate::code::{Atom, Global, GlobalKind, Program};
use crate::infix::infix_of_name;
use crate::source::Span;
use crate::symbol::{Qualifier, Symbol};
use crate::syntax::NodeId;

/// What a name means where it stands.
pub(super) enum Meaning {
    Local(VarId),
    Global(u32),
    Native(u16),
}

impl Compiler<'_> {
    /// Looks a name up: lexical variables, tags of the plan, globals, natives; where a qualifier says so, only those
    /// of the program or of the library. An unknown name becomes a global that must be defined before the text ends.
    pub(super) fn meaning(&mut self, qualifier: Option<Qualifier>, name: Symbol, span: Span) -> Meaning {
        if qualifier.is_none()
            && let Some(variable) = self.lexical(name)
        {
            return Meaning::Local(variable);
        }
        let program = self.program_of(qualifier);
        if let Some(&global) = program.names.get(&name) {
            return Meaning::Global(global);
        }
        if let Some(&native) = self.native_numbers.get(&name) {
            return Meaning::Native(native);
        }
        let is_form = self.specials.contains_key(&name) || program.macros.contains_key(&name);
        if is_form {
            let text = self.symbols.name(name).to_string();
            let help = match infix_of_name(&self.program.sources, span) {
                Some(infix) => infix.advice(),
                None => {
                    format!("call it in parentheses, `({text} …)`; as an argument wrap it: `(lambda (x) ({text} x))`")
                }
            };
            self.error(
                "form-as-value",
                span,
                format!("`{text}` is a form, not a function"),
                "it has no value of its own",
            )
            .help = Some(help);
        }
        // What the library lacks a definition of the text does not give it.
        let name = match (qualifier, self.library) {
            (Some(Qualifier::Library), Some(_)) => self.symbols.qualified(Qualifier::Library, name),
            (Some(Qualifier::Library), None) | (Some(Qualifier::Global) | None, _) => name,
        };
        if let Some(&global) = self.program.names.get(&name) {
            return Meaning::Global(global);
        }
        self.program.globals.push(Global { name, kind: GlobalKind::Variable, doc: None, span: None, initial: None });
        let global = self.program.globals.len() as u32 - 1;
        self.program.names.insert(name, global);
        let around = match qualifier {
            Some(_) => Surrounding::NOTHING,
            None => self.locals.surrounding(),
        };
        self.undefined.insert(global, Unknown { span, around, is_told: is_form });
        Meaning::Global(global)
    }

    /// The program in which a name is looked up.
    fn program_of(&self, qualifier: Option<Qualifier>) -> &Program {
        match (qualifier, self.library) {
            (Some(Qualifier::Library), Some(library)) => library,
            (Some(Qualifier::Library), None) | (Some(Qualifier::Global) | None, _) => self.program,
        }
    }

    /// The code of the macro that a name means.
    pub(super) fn macro_code(&self, qualifier: Option<Qualifier>, name: Symbol) -> Option<u32> {
        self.program_of(qualifier).macros.get(&name).copied()
    }

    /// Whether a name means a macro whose definition has an error.
    pub(super) fn is_broken_macro(&self, qualifier: Option<Qualifier>, name: Symbol) -> bool {
        qualifier != Some(Qualifier::Library) && self.broken_macros.contains(&name)
    }

    pub(super) fn name(&mut self, qualifier: Option<Qualifier>, name: Symbol, span: Span) -> Ir {
        match (qualifier, self.symbols.name(name)) {
            (None, "nil") => return self.nil(span),
            (None, "t") => return Ir { span, kind: IrKind::True },
            _ => {}
        }
        let kind = match self.meaning(qualifier, name, span) {
            Meaning::Local(variable) => IrKind::Local(variable),
            Meaning::Global(global) => IrKind::Global(global),
            Meaning::Native(native) => IrKind::Const(self.constant(Atom::Native(native))),
        };
        self.dereferenced(Ir { span, kind })
    }

    /// The variable or tag of this name, noted as captured if an outer function binds it.
    pub(super) fn lexical(&mut self, name: Symbol) -> Option<VarId> {
        let variable = self.locals.find(name).or_else(|| {
            let root = self.functions.iter().rev().find_map(|function| function.tags.as_ref())?;
            root.get(&name).copied()
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

    /// The name that a list begins with, if no variable and no definition of the text gives it a meaning of its own.
    pub(super) fn head_of_language(&self, node: NodeId) -> Option<&str> {
        let (qualifier, name) = self.tree.name(*self.tree.proper_list(node)?.first()?)?;
        let program = self.program_of(qualifier);
        let is_own = self.is_lexically_bound(qualifier, name)
            || program.names.contains_key(&name)
            || program.macros.contains_key(&name);
        (!is_own).then(|| self.symbols.name(name))
    }

    pub(super) fn is_lexically_bound(&self, qualifier: Option<Qualifier>, name: Symbol) -> bool {
        qualifier.is_none() && self.locals.find(name).is_some()
    }
}
