//! What names mean where they stand: variables, tags of the plan, globals, natives.

use super::compiler::{Compiler, Unknown};
use super::ir::{Ir, IrKind, VarId};
use crate::code::{Atom, Global, GlobalKind};
use crate::source::Span;
use crate::symbol::Symbol;

/// What a name means where it stands.
pub(super) enum Meaning {
    Local(VarId),
    Global(u32),
    Native(u16),
}

impl Compiler<'_> {
    /// Looks a name up: lexical variables, tags of the plan, globals, natives. An unknown name
    /// becomes a global that must be defined before the text ends.
    pub(super) fn meaning(&mut self, name: Symbol, span: Span) -> Meaning {
        if let Some(variable) = self.lexical(name) {
            return Meaning::Local(variable);
        }
        if let Some(&global) = self.program.names.get(&name) {
            return Meaning::Global(global);
        }
        if let Some(&native) = self.native_numbers.get(&name) {
            return Meaning::Native(native);
        }
        if self.specials.contains_key(&name) || self.program.macros.contains_key(&name) {
            let text = self.symbols.name(name).to_string();
            self.error(
                "form-as-value",
                span,
                format!("`{text}` is a form, not a function"),
                "it has no value of its own",
            )
            .help = Some(format!("wrap it: `(lambda (x) ({text} x))`"));
        }
        self.program.globals.push(Global { name, kind: GlobalKind::Variable, doc: None, span: None, initial: None });
        let global = self.program.globals.len() as u32 - 1;
        self.program.names.insert(name, global);
        self.undefined.insert(global, Unknown { span, around: self.locals.surrounding() });
        Meaning::Global(global)
    }

    pub(super) fn name(&mut self, name: Symbol, span: Span) -> Ir {
        match self.symbols.name(name) {
            "nil" => return self.nil(span),
            "t" => return Ir { span, kind: IrKind::True },
            _ => {}
        }
        let kind = match self.meaning(name, span) {
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

    pub(super) fn is_lexically_bound(&self, name: Symbol) -> bool {
        self.locals.find(name).is_some()
    }
}
