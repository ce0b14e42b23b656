//! How each form is laid out, for the formatter and for printed data: special forms say it in their own
//! rows, the library's macros in a table here.
//!
//! A macro that is not in the table and takes a body is laid out by its parameter list, if the text
//! defines it; a name that begins with `with-` or `def` has a body, too.

use crate::compile::special_forms;
use crate::layout::ItemShape::{self, Binding, Bindings, Clause, Data, Form, Handlers};
use crate::layout::Layout;
use crate::layout::Style::{self, Body, Call, Forms};
use crate::symbol::{Qualifier, base_name};

/// The macros of the library that are not laid out like a call, in the order of their names.
const MACROS: &[(&str, Layout)] = &[
    ("assert-fails", Layout::plain(Body(1))),
    ("at-place", Layout::plain(Body(1))),
    ("case", Layout { style: Body(1), leading: &[Form], rest: Clause }),
    ("cond", Layout { style: Call, leading: &[], rest: Clause }),
    ("def-revision", Layout::with(Body(2), &[Data, Data])),
    ("do", Layout::with(Body(2), &[Bindings, Clause])),
    ("do-retry", Layout::plain(Body(1))),
    ("dolist", Layout::with(Body(1), &[Binding])),
    ("dotimes", Layout::with(Body(1), &[Binding])),
    ("flet", Layout::with(Body(1), &[Handlers])),
    ("ignore-failures", Layout::with(Body(1), &[Data])),
    ("labels", Layout::with(Body(1), &[Handlers])),
    ("n-times", Layout::plain(Body(1))),
    ("persist", Layout::with(Body(2), &[Form, Data])),
    ("prog1", Layout::plain(Body(1))),
    ("pursue-first-n", Layout::plain(Body(1))),
    ("try-each-in-order", Layout::with(Body(1), &[Binding])),
    ("try-in-order", Layout::plain(Forms)),
    ("unless", Layout::plain(Body(1))),
    ("when", Layout::plain(Body(1))),
    ("while", Layout::plain(Body(1))),
    ("with-parts-handled", Layout::with(Body(1), &[Handlers])),
    ("with-policies", Layout::with(Body(1), &[Clause])),
    ("with-retry-counters", Layout::with(Body(1), &[Bindings])),
];

/// The layout of a form that begins with this name, in lower case, with or without a qualifier; none for a call.
pub fn layout(head: &str) -> Option<Layout> {
    let head = base_name(head);
    if let Some(form) = special_forms().find(|form| form.names.contains(&head)) {
        return form.layout;
    }
    match MACROS.binary_search_by_key(&head, |&(name, _)| name) {
        Ok(index) => Some(MACROS[index].1),
        Err(_) if head.starts_with("with-") || head.starts_with("def") => Some(Layout::plain(Body(1))),
        Err(_) => None,
    }
}

/// The layout of a list by what it is and what it begins with, in lower case; `body_of` tells of a
/// macro of the text how many parameters stand before its body, if it takes one.
pub fn layout_of(head: Option<&str>, shape: ItemShape, body_of: impl Fn(&str) -> Option<usize>) -> Layout {
    const DATA: Layout = Layout::plain(Style::Data);
    let known = || {
        let head = head?;
        let own = match Qualifier::split(head) {
            Some((Qualifier::Library, _)) => None,
            Some((Qualifier::Global, name)) => body_of(name),
            None => body_of(head),
        };
        own.map(|before| Layout::plain(Style::Body(before))).or_else(|| layout(head))
    };
    match shape {
        ItemShape::Data => Layout { rest: ItemShape::Data, ..DATA },
        ItemShape::Quoted => known().unwrap_or(Layout { rest: ItemShape::Quoted, ..DATA }),
        ItemShape::Clause => DATA,
        ItemShape::Bindings => Layout { leading: &[], rest: ItemShape::Binding, style: Style::Data },
        ItemShape::Binding => Layout::plain(Style::Call),
        ItemShape::Handlers => Layout { leading: &[], rest: ItemShape::Handler, style: Style::Data },
        ItemShape::Handler => Layout { leading: &[ItemShape::Data], rest: ItemShape::Form, style: Style::Body(1) },
        ItemShape::Form => known().unwrap_or(match head {
            Some(head) if !head.starts_with(':') => Layout::plain(Style::Call),
            _ => DATA,
        }),
    }
}

/// Whether the word makes the item after it part of itself: a keyword, or the `until` and `while`
/// of these loops.
pub fn is_label(head: Option<&str>, word: &str) -> bool {
    word.starts_with(':') && word.len() > 1 && !(head.map(base_name) == Some("with-timeout") && word == ":active")
        || matches!(head.map(base_name), Some("loop" | "n-times")) && matches!(word, "until" | "while")
}

/// Whether arguments go below the first one, where they would begin in this column: not if that is
/// beyond the middle of the line.
pub fn aligns(column: usize, width: usize) -> bool {
    column <= width / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_in_order_so_that_every_layout_is_found() {
        assert!(MACROS.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert!(MACROS.iter().all(|&(name, found)| layout(name) == Some(found)));
    }
}
