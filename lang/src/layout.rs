//! How a list is laid out: where its items go, and what they are.

/// Lines are broken to have at most as many characters, where that can be had.
pub const WIDTH: usize = 100;

/// Where the items of a list go when they do not stand on its first line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Below the first argument if that stands on the head's line, else two columns in.
    Call,
    /// As `Call`, but without an author's breaks each item begins a line of its own: what runs in
    /// a row or side by side.
    Forms,
    /// This many items belong to the head's line, and are four columns in if they do not stand there; the body follows
    /// two columns in.
    Body(usize),
    /// Below the first item: data, bindings, clauses.
    Data,
}

/// What an item of a form is, if it is a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemShape {
    /// A form, laid out by its head.
    Form,
    /// Data or parameters, whatever it begins with.
    Data,
    /// Quoted data: a form if it begins with a construct, for plans are data; else data.
    Quoted,
    /// A name and its value.
    Binding,
    /// A list of them.
    Bindings,
    /// A list of forms, or a clause with a test and forms.
    Clause,
    /// A list of clauses that handle failures.
    Handlers,
    /// A class, a parameter list, and forms.
    Handler,
}

/// How a construct is laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Where its items go.
    pub style: Style,
    /// What its first items are, the head not counted.
    pub leading: &'static [ItemShape],
    /// What the others are.
    pub rest: ItemShape,
}

impl Layout {
    /// A form without parts of its own.
    pub const fn plain(style: Style) -> Self {
        Layout { style, leading: &[], rest: ItemShape::Form }
    }

    /// A form whose first items are of these shapes, and the others forms.
    pub const fn with(style: Style, leading: &'static [ItemShape]) -> Self {
        Layout { style, leading, rest: ItemShape::Form }
    }

    /// What the item at a position is; the head, which data have not, is at 0.
    pub fn shape(&self, at: usize) -> ItemShape {
        match (self.style, at.checked_sub(1)) {
            (Style::Data, _) => self.rest,
            (_, None) => ItemShape::Form,
            (_, Some(at)) => self.leading.get(at).copied().unwrap_or(self.rest),
        }
    }

    /// The column of the item at a position that begins a line, in a list whose `(` stands in the
    /// column `open`; `argument` is that of the first argument, if it stands on the head's line.
    pub fn column(&self, at: usize, open: usize, argument: Option<usize>) -> usize {
        match (self.style, argument) {
            (Style::Data, _) => open + 1,
            _ if at == 0 => open + 1,
            (Style::Body(distinguished), _) if at <= distinguished => open + 4,
            (Style::Call | Style::Forms, Some(argument)) => argument,
            (Style::Body(_) | Style::Call | Style::Forms, _) => open + 2,
        }
    }
}
