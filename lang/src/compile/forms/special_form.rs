//! What is known of a special form, in one row: how it is written, laid out and compiled.

use crate::compile::compiler::Compiler;
use crate::compile::ir::Ir;
use crate::compile::resolved::TopLevel;
use crate::layout::Layout;
use crate::source::Span;
use crate::syntax::NodeId;

/// A form the compiler itself understands; everything else is a macro or a function.
#[derive(Clone, Copy, Debug)]
pub struct SpecialForm {
    /// Its name and its other names.
    pub names: &'static [&'static str],
    /// How it is written.
    pub form: &'static str,
    /// When it succeeds, when it fails, what its value is.
    pub doc: &'static str,
    /// Plan text that shows it; empty where the form says it all.
    pub example: &'static str,
    /// How it is laid out; none for what is laid out like a call.
    pub layout: Option<Layout>,
    /// Where it may stand, and what compiles it.
    pub(crate) role: Role,
}

impl SpecialForm {
    /// The name that paths and messages use.
    pub(crate) fn name(&self) -> &'static str {
        self.names[0]
    }
}

/// A special form as it stands in a text.
pub(crate) struct Written<'t> {
    /// Its row.
    pub(crate) form: &'static SpecialForm,
    /// Its items, the head included.
    pub(crate) items: &'t [NodeId],
    /// Its place.
    pub(crate) span: Span,
}

impl<'t> Written<'t> {
    /// The items behind the head.
    pub(crate) fn rest(&self) -> &'t [NodeId] {
        &self.items[1..]
    }
}

/// Resolves a form that stands among others.
pub(crate) type Resolve = fn(&mut Compiler<'_>, &Written<'_>) -> Ir;

/// Takes up a definition, and adds what there is to run for it.
pub(crate) type Define = fn(&mut Compiler<'_>, &Written<'_>, &mut Vec<TopLevel>);

/// Where a special form may stand, and what compiles it.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Role {
    /// Anywhere.
    Plain(Resolve),
    /// Anywhere; at top level it may hold definitions, so that a macro can make several.
    Sequence(Resolve),
    /// Not in a network: it waits, assigns or starts tasks.
    Effect(Resolve),
    /// At top level only: it defines a name that is called or read.
    Naming(Define),
    /// At top level only: it defines something else.
    Definition(Define),
}

impl Role {
    /// Whether it may only stand at top level.
    pub(crate) fn is_definition(self) -> bool {
        match self {
            Role::Naming(_) | Role::Definition(_) => true,
            Role::Plain(_) | Role::Sequence(_) | Role::Effect(_) => false,
        }
    }
}
