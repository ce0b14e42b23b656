//! The special forms. Each is one row of the table of its topic, with the function that compiles it in
//! the same file.
//!
//! A row has the names, the documentation, the layout, where the form may stand (networks and checks go by it), and the
//! function.

mod assignment;
mod bindings;
mod conditions;
mod constructs;
mod control;
mod definitions;
mod goal;
mod handling;
mod partial_order;
mod quotation;
mod scopes;
mod special_form;
mod tasks;
mod test_form;
mod waiting;

use super::compiler::{Compiler, FormPlace};
use super::ir::Ir;
use crate::source::Span;
use crate::symbol::Symbol;
use crate::syntax::NodeId;
pub use special_form::SpecialForm;
pub(super) use special_form::{Role, Written};

/// The tables of all topics.
const TABLES: &[&[SpecialForm]] = &[
    quotation::FORMS,
    conditions::FORMS,
    bindings::FORMS,
    assignment::FORMS,
    control::FORMS,
    definitions::FORMS,
    goal::FORMS,
    constructs::FORMS,
    tasks::FORMS,
    handling::FORMS,
    scopes::FORMS,
    waiting::FORMS,
];

/// All special forms.
pub fn special_forms() -> impl Iterator<Item = &'static SpecialForm> {
    TABLES.iter().copied().flatten()
}

/// Every name of a special form, with the form's place.
pub(super) fn special_names() -> impl Iterator<Item = (&'static str, FormPlace)> {
    let rows = |(table, forms): (usize, &'static &'static [SpecialForm])| {
        forms.iter().enumerate().map(move |(row, form)| (form, FormPlace { table, row }))
    };
    let places = TABLES.iter().enumerate().flat_map(rows);
    places.flat_map(|(form, place)| form.names.iter().map(move |&name| (name, place)))
}

impl Compiler<'_> {
    /// The special form of this name.
    pub(super) fn special_form(&self, name: Symbol) -> Option<&'static SpecialForm> {
        self.specials.get(&name).map(|place| &TABLES[place.table][place.row])
    }

    /// Resolves a special form that stands among other forms.
    pub(super) fn special(&mut self, form: &'static SpecialForm, items: &[NodeId], span: Span) -> Ir {
        let written = Written { form, items, span };
        match form.role {
            Role::Plain(resolve) | Role::Sequence(resolve) => resolve(self, &written),
            Role::Effect(_) if self.is_network() => self.refuse_in_network(&written),
            Role::Effect(resolve) => resolve(self, &written),
            Role::Naming(_) | Role::Definition(_) => self.refuse_inside(&written),
        }
    }

    fn refuse_inside(&mut self, written: &Written<'_>) -> Ir {
        let name = self.head_name(written);
        self.error(
            "definition-inside",
            written.span,
            format!("`{name}` can only stand at top level"),
            "inside another form",
        )
        .help = Some("move it out; inside, use `let` or a `lambda`".into());
        self.nil(written.span)
    }

    fn refuse_in_network(&mut self, written: &Written<'_>) -> Ir {
        let name = self.head_name(written);
        self.error(
            "network-effect",
            written.span,
            format!("`{name}` cannot stand in a fluent network"),
            "a network may only look, not wait or act",
        );
        self.nil(written.span)
    }

    /// The name by which the text calls the form.
    fn head_name(&self, written: &Written<'_>) -> String {
        let head = written.items.first().and_then(|&head| self.tree.symbol(head));
        head.map_or(written.form.name(), |name| self.symbols.name(name)).to_string()
    }
}
