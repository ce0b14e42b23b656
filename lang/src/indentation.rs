//! How each construct is indented: one table, for the formatter and for printed data.
//!
//! A macro that is not in the table and takes a body is indented by its parameter list, if the
//! text defines it; a name that begins with `with-` or `def` has a body, too.

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
    /// So many items belong to the head's line, and are four columns in if they do not stand
    /// there; the body follows two columns in.
    Body(usize),
    /// Below the first item: data, bindings, clauses.
    Data,
}

/// What an item of a form is, if it is a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
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
pub struct Rule {
    /// Where its items go.
    pub style: Style,
    /// What its first items are, the head not counted.
    pub leading: &'static [Shape],
    /// What the others are.
    pub rest: Shape,
}

impl Rule {
    /// A form without parts of its own.
    pub const fn plain(style: Style) -> Self {
        Rule { style, leading: &[], rest: Shape::Form }
    }

    /// What the item at a position is; the head, which data have not, is at 0.
    pub fn shape(&self, at: usize) -> Shape {
        match (self.style, at.checked_sub(1)) {
            (Style::Data, _) => self.rest,
            (_, None) => Shape::Form,
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

use Shape::{Binding, Bindings, Clause, Data, Form, Handlers};
use Style::{Body, Call, Forms};

const fn with(style: Style, leading: &'static [Shape]) -> Rule {
    Rule { style, leading, rest: Form }
}

/// In the order of the names.
const RULES: &[(&str, Rule)] = &[
    (":tag", Rule::plain(Body(1))),
    ("assert-fails", Rule::plain(Body(1))),
    ("block", Rule::plain(Body(1))),
    ("case", Rule { style: Body(1), leading: &[Form], rest: Clause }),
    ("cond", Rule { style: Call, leading: &[], rest: Clause }),
    ("def-failure", with(Body(2), &[Form, Data, Data])),
    ("def-fluent", Rule::plain(Body(1))),
    ("def-goal", Rule::plain(Body(1))),
    ("def-interp-proc", with(Body(2), &[Form, Data])),
    ("def-plan", with(Body(2), &[Form, Data])),
    ("defconstant", Rule::plain(Body(1))),
    ("defmacro", with(Body(2), &[Form, Data])),
    ("deftest", Rule::plain(Body(1))),
    ("defun", with(Body(2), &[Form, Data])),
    ("defvar", Rule::plain(Body(1))),
    ("destructuring-bind", with(Body(2), &[Data])),
    ("do", with(Body(2), &[Bindings, Clause])),
    ("do-retry", Rule::plain(Body(1))),
    ("dolist", with(Body(1), &[Binding])),
    ("dotimes", with(Body(1), &[Binding])),
    ("evap-protect", Rule::plain(Body(0))),
    ("flet", with(Body(1), &[Handlers])),
    ("fn", with(Body(1), &[Data])),
    ("global-fluent", Rule::plain(Body(1))),
    ("ignore-failures", with(Body(1), &[Data])),
    ("labels", with(Body(1), &[Handlers])),
    ("lambda", with(Body(1), &[Data])),
    ("let", with(Body(1), &[Bindings])),
    ("let*", with(Body(1), &[Bindings])),
    ("letrec", with(Body(1), &[Bindings])),
    ("loop", Rule::plain(Body(0))),
    ("n-times", Rule::plain(Body(1))),
    ("on-interrupt", Rule::plain(Body(1))),
    ("on-resume", Rule::plain(Body(1))),
    ("par", Rule::plain(Forms)),
    ("par-map", with(Body(1), &[Binding])),
    ("partial-order", with(Body(1), &[Clause])),
    ("plan", with(Body(1), &[Clause])),
    ("process", Rule::plain(Body(1))),
    ("prog1", Rule::plain(Body(1))),
    ("progn", Rule::plain(Forms)),
    ("pursue", Rule::plain(Forms)),
    ("pursue-map", with(Body(1), &[Binding])),
    ("seq", Rule::plain(Forms)),
    ("spawn", Rule::plain(Body(0))),
    ("try-all", Rule::plain(Forms)),
    ("try-all-map", with(Body(1), &[Binding])),
    ("try-each-in-order", with(Body(1), &[Binding])),
    ("try-in-order", Rule::plain(Forms)),
    ("unless", Rule::plain(Body(1))),
    ("unwind-protect", Rule::plain(Body(0))),
    ("when", Rule::plain(Body(1))),
    ("whenever", Rule::plain(Body(1))),
    ("while", Rule::plain(Body(1))),
    ("with-failure-handling", with(Body(1), &[Handlers])),
    ("with-policies", with(Body(1), &[Clause])),
    ("with-retry-counters", with(Body(1), &[Bindings])),
    ("with-task-suspended", with(Body(1), &[Data])),
];

/// The rule of a form that begins with this name, in lower case; none for a call.
pub fn rule(head: &str) -> Option<Rule> {
    match RULES.binary_search_by_key(&head, |&(name, _)| name) {
        Ok(index) => Some(RULES[index].1),
        Err(_) if head.starts_with("with-") || head.starts_with("def") => Some(Rule::plain(Body(1))),
        Err(_) => None,
    }
}

/// The rule of a list by what it is and what it begins with, in lower case; `body_of` tells of a
/// macro of the text how many parameters stand before its body, if it takes one.
pub fn rule_of(head: Option<&str>, shape: Shape, body_of: impl Fn(&str) -> Option<usize>) -> Rule {
    const DATA: Rule = Rule::plain(Style::Data);
    let known = || {
        let head = head?;
        body_of(head).map(|before| Rule::plain(Style::Body(before))).or_else(|| rule(head))
    };
    match shape {
        Shape::Data => Rule { rest: Shape::Data, ..DATA },
        Shape::Quoted => known().unwrap_or(Rule { rest: Shape::Quoted, ..DATA }),
        Shape::Clause => DATA,
        Shape::Bindings => Rule { leading: &[], rest: Shape::Binding, style: Style::Data },
        Shape::Binding => Rule::plain(Style::Call),
        Shape::Handlers => Rule { leading: &[], rest: Shape::Handler, style: Style::Data },
        Shape::Handler => Rule { leading: &[Shape::Data], rest: Shape::Form, style: Style::Body(1) },
        Shape::Form => known().unwrap_or(match head {
            Some(head) if !head.starts_with(':') => Rule::plain(Style::Call),
            _ => DATA,
        }),
    }
}

/// Whether the word makes the item after it part of itself: a keyword, or the `until` and `while`
/// of these loops.
pub fn is_label(head: Option<&str>, word: &str) -> bool {
    word.starts_with(':') && word.len() > 1 && !(head == Some("with-timeout") && word == ":active")
        || matches!(head, Some("loop" | "n-times")) && matches!(word, "until" | "while")
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
    fn the_table_is_in_order_so_that_every_rule_is_found() {
        assert!(RULES.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert!(RULES.iter().all(|&(name, found)| rule(name) == Some(found)));
    }
}
